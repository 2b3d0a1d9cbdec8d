// Readers and checks that all device files share.
#pragma once

#include <functional>
#include <string>

#include "core/toml.hpp"
#include "enamel/device/device_file.hpp"

namespace enamel {

/// Reject a key: with its line in a file, or as a value without a file.
using Fail = std::function<void(const std::string& key, const std::string& problem)>;

std::string formatVector(const Vec3& v);
void requirePositive(double value, const std::string& key, const std::string& unit, const Fail& fail);
void requireNotNegative(double value, const std::string& key, const std::string& unit, const Fail& fail);

/// Check an inertia tensor about the centre of mass. It must be symmetric, without negative principal moments, and no
/// moment may exceed the sum of the other two. The tolerance covers decimal rounding in a file.
void checkInertia(const Mat3& inertia, const std::string& key, const Fail& fail);
void checkPlatform(const PlatformParameters& platform, const Fail& fail);
void checkMotor(const MotorParameters& motor, const Fail& fail);

/// Words of the messages about imperfections: the units of efforts and coordinates, and the key of the rotor.
struct DriveWords {
  const char* effort;
  const char* coordinate;
  const char* rotorKey;
  double rotorInertia;
};
void checkImperfections(const Imperfections& imperfections, const DriveWords& words, const Fail& fail);

/// Return the `kind` of a device file, "tau" if it has none.
std::string kindOf(TomlTable& root);
/// Reject a file of another kind.
void requireKind(TomlTable& root, const std::string& kind);

/// Read the tables [platform] and [motor], and the optional table [imperfections].
PlatformParameters readPlatform(TomlTable& root);
MotorParameters readMotor(TomlTable& root);
Imperfections readImperfections(TomlTable& root);

/// Read the optional table [handpiece]; without it the mass is 0.
Handpiece readHandpiece(TomlTable& root);

/// Read and check a whole file of each kind.
TauParameters readTau(TomlTable& root);
DeltaParameters readDelta(TomlTable& root);
CartesianParameters readCartesian(TomlTable& root);

}  // namespace enamel
