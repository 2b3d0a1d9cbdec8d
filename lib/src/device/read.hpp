// What the readers and checks of all device files share.
#pragma once

#include <functional>
#include <string>

#include "core/toml.hpp"
#include "enamel/device/device_file.hpp"

namespace enamel {

/// Refuses a key: a file's with its line, or a value that came from nowhere.
using Fail = std::function<void(const std::string& key, const std::string& problem)>;

std::string formatVector(const Vec3& v);
void requirePositive(double value, const std::string& key, const std::string& unit, const Fail& fail);
void requireNotNegative(double value, const std::string& key, const std::string& unit, const Fail& fail);

/// A tensor of inertia about the centre of mass is symmetric, has no negative principal moment, and none is larger than
/// the sum of the other two. The tolerance covers decimal rounding in a file.
void checkInertia(const Mat3& inertia, const std::string& key, const Fail& fail);
void checkPlatform(const PlatformParameters& platform, const Fail& fail);
void checkMotor(const MotorParameters& motor, const Fail& fail);
void checkImperfections(const Imperfections& imperfections, const MotorParameters& motor, const Fail& fail);

/// `kind` of a device file, "tau" where it has none.
std::string kindOf(TomlTable& root);
/// Refuses a file of another kind.
void requireKind(TomlTable& root, const std::string& kind);

/// The tables [platform] and [motor], and [imperfections], which may be absent.
PlatformParameters readPlatform(TomlTable& root);
MotorParameters readMotor(TomlTable& root);
Imperfections readImperfections(TomlTable& root);

/// A whole file of each kind, checked.
TauParameters readTau(TomlTable& root);
DeltaParameters readDelta(TomlTable& root);
CartesianParameters readCartesian(TomlTable& root);

}  // namespace enamel
