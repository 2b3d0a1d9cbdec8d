// What a haptic tick and a simulation need of a device's geometry and mass, whatever the mechanism.
//
// Joints are numbered 0 to n - 1, n <= kMaxJoints; the platform P carries the tool. A mechanism with n < 6 moves its
// platform in the first n of (x, y, z, turns about x, y, z) only.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enamel/core/status.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// Everything about a mechanism in motion that one tick computes once. Plain data of fixed size; in W.
struct Kinematics {
  JointVector q;               ///< joint coordinates, rad or m
  JointVector rates;           ///< q', rad/s or m/s
  Pose pose;                   ///< of the platform
  Vec6 twist = Vec6::Zero();   ///< V = J q', m/s, rad/s
  Jacobian jacobian;           ///< J, 6 x n
  Jacobian inverseTransposed;  ///< 6 x n: F = this tau is the wrench on the platform of torques tau, q' = this^T V
  JointVector gravity;         ///< torque that balances gravity at rest, N m or N
  JointMatrix inertia;         ///< M(q), n x n, kg m^2 or kg; 0 x 0 where nobody asked for it
};

/// V = J q'. Realtime: yes.
Vec6 twistOf(const Jacobian& jacobian, const JointVector& rates) noexcept;

/// tau = J^T F ("A Position-Control Based Approach ...", eq. 3). Realtime: yes.
JointVector torqueOf(const Jacobian& jacobian, const Vec6& wrench) noexcept;

/// Joint torque that balances gravity and puts the wrench F on the platform at rest: g + J^T F. Realtime: yes.
JointVector staticTorque(const Kinematics& kinematics, const Vec6& wrench) noexcept;

/// Wrench on the platform at the TCP, [N; N m], that joint torques put there: F = J^-T tau. Realtime: yes.
Vec6 wrenchOf(const Kinematics& kinematics, const JointVector& torque) noexcept;

/// Effective mass, kg, felt when the platform is pushed at `point` (W, m) along the unit vector `direction`:
/// 1 / (n^T J M^-1 J^T n) with the unit push n = [direction; (point - p) x direction] (Khatib 1995). `kinematics` must
/// have its inertia. Realtime: yes.
double effectiveMass(const Kinematics& kinematics, const Vec3& point, const Vec3& direction) noexcept;

/// Largest force, N, that the motors can put on the platform at `point` (W, m) along the unit vector `direction` beyond
/// gravity: min over the joints of (limit -+ gravity) / |(J^T n)_i|, n as in effectiveMass(). Realtime: yes.
double largestForce(const Kinematics& kinematics, const JointVector& maxTorque, const Vec3& point,
                    const Vec3& direction) noexcept;

/// What lies between a motor's command and its joint, the same at every driven joint. Zero: ideal.
struct Drive {
  double bandwidth = 0.0;     ///< f of the current loop: torque' = 2 pi f (command - torque), Hz; 0: no lag
  double rotorInertia = 0.0;  ///< reflected, behind the cable, kg m^2 or kg; 0 with a rigid transmission
  double stiffness = 0.0;     ///< of the cable between rotor and link, N m/rad or N/m; 0: rigid
  double damping = 0.0;       ///< of the cable, N m s/rad or N s/m
  double disturbance = 0.0;   ///< deviation of what friction and cogging do to a rotor, N m or N
  bool encoderOnLink = false;

  /// Return the same drive with a rigid transmission. Realtime: yes.
  Drive rigid() const noexcept {
    Drive drive = *this;
    drive.rotorInertia = drive.stiffness = drive.damping = 0.0;
    return drive;
  }
};

/// What the motors and encoders of each joint can do.
struct JointLimits {
  JointVector effort;       ///< largest of the motor, N m or N; 0: the joint is sensed and has no motor
  JointVector encoderStep;  ///< step of the encoder, rad or m
  Drive drive = {};         ///< of the driven joints
};

/// A straight part of a mechanism, for pictures.
struct Bar {
  Vec3 from, to;  ///< W, m
  int chain;      ///< that it belongs to, counted from 0; -1: the platform
};

/// A mechanism: geometry and mass of a device. Immutable; may be shared between threads.
class Mechanism {
 public:
  virtual ~Mechanism() = default;

  const std::string& name() const noexcept { return name_; }
  int joints() const noexcept { return static_cast<int>(home_.q.size()); }
  const JointLimits& limits() const noexcept { return limits_; }

  /// At rest at the home pose (P = W), with inertia.
  const Kinematics& home() const noexcept { return home_; }

  /// Forward kinematics: everything from joint coordinates and rates. The search begins at what `kinematics` holds: the
  /// previous tick's answer, or home().
  /// Statuses: notFinite; outOfRange (not joints() numbers); unreachable, singular, notConverged; `kinematics` is then
  /// unchanged. Realtime: yes.
  [[nodiscard]] virtual Status track(const JointVector& q, const JointVector& rates, bool withInertia,
                                     Kinematics& kinematics) const noexcept = 0;

  /// Inverse kinematics: everything from pose and twist. Statuses: notFinite, unreachable (also: a turn that the
  /// platform cannot make), singular; `kinematics` is then unchanged. Realtime: yes.
  [[nodiscard]] virtual Status reach(const Pose& pose, const Vec6& twist, bool withInertia,
                                     Kinematics& kinematics) const noexcept = 0;

  /// Forward dynamics: V' = [v'; w'] at a pose and twist under joint torques and a wrench on the platform at the TCP
  /// (N, N m), with gravity, friction and damping. Statuses as of reach(). Realtime: yes.
  [[nodiscard]] virtual Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque,
                                          const Vec6& wrench, Vec6& acceleration) const noexcept = 0;

  /// What a picture shows at a pose; empty where it cannot be reached. Realtime: no.
  virtual std::vector<Bar> bars(const Pose& pose) const = 0;

 protected:
  Mechanism(std::string name, JointLimits limits) : name_(std::move(name)), limits_(std::move(limits)) {}

  /// Sets home() by reach(): the last that a mechanism's constructor does. Throws ConfigurationError: home cannot be
  /// reached, or its mass matrix is not positive definite.
  void setHome();

 private:
  std::string name_;
  JointLimits limits_;
  Kinematics home_;
};

}  // namespace enamel
