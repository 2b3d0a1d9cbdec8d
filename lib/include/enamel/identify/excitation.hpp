// A motion that shows the numbers of a device: design, file, and its run on a device.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "enamel/render/tick.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/sim/virtual_device.hpp"

namespace enamel {

/// amplitude sin(2 pi frequency t + phase).
struct Sine {
  double frequency = 0.0;  ///< Hz
  double amplitude = 0.0;  ///< of a motion: m or rad; of a force: N or N m
  double phase = 0.0;      ///< rad
};

/// Excitation of one direction of the platform: f = M r'' + K (r - x) + B (r' - x') + h. r is the sum of `motion`, h
/// that of `force`.
struct ExcitationAxis {
  double inertia = 0.0;                   ///< M, kg or kg m^2
  double stiffness = 0.0, damping = 0.0;  ///< K and B, N/m and N s/m, or N m/rad and N m s/rad
  std::vector<Sine> motion, force;
};

/// An excitation: multisines in the platform's directions x, y, z and, with 6 joints, the rotations about them.
struct Excitation {
  double duration = 30.0;            ///< s
  double period = 1e-3;              ///< of the ticks, s
  std::vector<ExcitationAxis> axes;  ///< one per direction
  double force = 0.0, moment = 0.0;  ///< largest rendered force and moment, N and N m: limits of the guard
  Vec3 workspace = Vec3::Zero();     ///< half widths of the box that the tool must not leave, m
  double speed = 0.8, turn = 16.0;   ///< speeds at which the guard brakes, m/s and rad/s; it stops at three times these
};

struct ExcitationOptions {
  double duration = 30.0;  ///< s, 5 to 600
  double period = 1e-3;    ///< s
  double share = 0.35;     ///< largest share of the motors' torque for the fast part, 0.05 to 0.8
  double width = 0.5;      ///< largest share of the workspace, 0.05 to 0.9
  double speed = 0.35;     ///< largest speed of the slow part, m/s
  std::uint64_t seed = 1;  ///< of the phases
};

/// Design an excitation for a device at home. The slow part (0.15 to 3 Hz) follows a path within the workspace. The
/// fast part (4 Hz to 0.4 of the tick rate) is a force. Throws Error if an option is out of its range. Realtime: no.
Excitation designExcitation(const Mechanism& mechanism, const ExcitationOptions& options = {});

/// Read an excitation from its TOML file, and write its text. Throws ConfigurationError with file, line and key for a
/// key that is unknown or missing, or a value out of range. Realtime: no.
Excitation loadExcitation(const std::string& path);
Excitation parseExcitation(std::string_view text, const std::string& file);
std::string textOf(const Excitation& excitation);

/// Return the wrench at `time` s after the beginning, W at the TCP, N and N m. It begins and ends smoothly, and is zero
/// outside the duration. Realtime: yes.
Vec6 wrenchAt(const Excitation& excitation, double time, const Pose& pose, const Vec6& twist) noexcept;

/// Smooth the twist for wrenchAt(), once a tick: damping that is fast and late excites the resonance of cables.
/// Realtime: yes.
void smoothTwist(const Excitation& excitation, const Vec6& twist, Vec6& smoothed) noexcept;

/// Return options of the guard for an excitation on a device: its force, moment, box and speeds. The energy may be that
/// of the motion, because nobody touches a wall. Throws Error as guardFor(). Realtime: no.
GuardOptions guardFor(const Mechanism& mechanism, const Excitation& excitation);

/// Plays an excitation in a HapticLoop, as HapticLoopOptions::sink. It sets the effect of each tick of `haptics`, which
/// must be those of the loop, with the guard options guardFor(mechanism, excitation). It stops for good at the end,
/// when the user lets go of the enable switch, and at a fault of the guard.
class ExcitationPlayer final : public TickSink {
 public:
  /// `next` receives every tick too, for example a Recorder; null: nothing does.
  ExcitationPlayer(Excitation excitation, HapticTick& haptics, TickSink* next) noexcept
      : excitation_(std::move(excitation)), haptics_(haptics), next_(next) {}

  /// Realtime: yes.
  void before(Measurement& measurement) noexcept override;
  void tick(const LoopTick& tick, const HapticTick& haptics) noexcept override;

  /// Return whether it has stopped. Threads: any.
  bool isOver() const noexcept { return isOver_.load(); }

 private:
  Excitation excitation_;
  HapticTick& haptics_;
  TickSink* next_;
  double begin_ = -1.0;        // s, of the first tick; negative: none yet
  Vec6 twist_ = Vec6::Zero();  // smoothed, m/s and rad/s
  std::atomic<bool> isOver_{false};
};

/// Receives each tick of runExcitation(). The number is counted from 0.
using ExcitationTick = std::function<void(std::uint64_t number, const Measurement& measurement,
                                          const HapticTick& haptics, const Command& command, Status status)>;

/// Run an excitation on a virtual device with the guard on, as fast as possible. `mechanism` is the device file's. A
/// load acts on the platform. Returns the guard's fault, or none. Throws Error if the device leaves its workspace.
/// Realtime: no.
GuardReason runExcitation(const Excitation& excitation, const Mechanism& mechanism, VirtualDevice& device,
                          const ExternalWrench& load, const ExcitationTick& each);

}  // namespace enamel
