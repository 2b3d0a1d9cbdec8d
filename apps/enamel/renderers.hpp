// The renderers by name, and what the commands that push share about them.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "enamel/control/device_plant.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/passivity.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/render/surface_servo.hpp"
#include "enamel/study/metrics.hpp"

namespace enamel::app {

inline constexpr const char* kPositionControl = "position-control";  // SurfaceServoRenderer
inline constexpr const char* kHold = "hold";                         // PositionControlRenderer, the paper's law
inline constexpr const char* kImpedance = "impedance";
inline constexpr const char* kPassivity = "passivity";  // PassivityRenderer around the impedance wall

/// "none", "constant:D" or "random:A..B", in ticks, whole numbers in decimal digits. Throws Error.
Delay parseDelay(const std::string& text);

/// A renderer that a user asked for: a linked one by its name, or a plugin by its path or by its name in
/// pluginFolder().
struct RendererSource {
  std::string name;                             ///< of the linked one, or as the plugin describes itself
  std::shared_ptr<const PluginLibrary> plugin;  ///< nullptr: linked
};

/// Throws PluginError: as findPlugin().
RendererSource findRenderer(const std::string& nameOrPath);

/// Which of the linked renderers a servo file (--gain) is for: kPositionControl where it is a surface servo, kHold
/// where it is an LQR design. Throws Error: as loadServo(), where it is neither.
std::string rendererOf(const std::string& gain);

/// Throws Error: a servo file (or "": none) for a renderer that is not among the `linked` ones of `option`.
void checkGain(const std::string& gain, const std::vector<std::string>& linked, const std::string& option);

/// The gain of an LQR design for ticks of `period` s on a device with `joints` joints.
/// Throws Error: as loadServo(); it was designed for another period or number of joints.
ServoGain loadGain(const std::string& path, int joints, double period);

/// The surface servo for a device, ticks of `period` s and a delay of the command: of a file (--gain), or where that is
/// "", as surfaceServoFor() has it. Throws Error: as loadSurfaceServo() and SurfaceServoRenderer; the file is for
/// another period, number of joints or delay.
SurfaceServoOptions surfaceServo(const std::string& gain, const Mechanism& mechanism, double period,
                                 const Delay& delay);

/// A linked renderer from parameters under the names that the plugins give them, the others at their defaults: gain,
/// delay and delay-high of position-control; gain, release and anti-windup of hold; stiffness and damping of impedance
/// and passivity. Parameters of others are left aside. Throws Error: a value that cannot be read, and as
/// surfaceServo(), loadGain() and the renderers.
std::unique_ptr<Renderer> makeLinked(const std::string& name, const std::map<std::string, std::string>& parameters,
                                     const std::shared_ptr<const Mechanism>& device, double period);

/// Mechanical damping of a plant along `normal` (unit, W) at a pose, N s/m: of the TCP and of the joints.
/// Throws Error: the pose cannot be reached.
double dampingAlong(const Mechanism& plant, const Pose& pose, const Vec3& normal);

/// What to print where eq. 16 is not met; empty where it is.
std::string dampingWarning(const ImpedanceOptions& wall, double period, double available);

}  // namespace enamel::app
