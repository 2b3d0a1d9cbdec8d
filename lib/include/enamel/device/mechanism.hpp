// The interface to the geometry and mass of a device, for the haptic tick and for simulations.
//
// Joints have the numbers 0 to n - 1, with n <= kMaxJoints. The platform P carries the tool. If n < 6, the platform
// moves only in the first n of these directions: x, y, z, rotation about x, about y, about z.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enamel/core/status.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// State and model of a mechanism at one tick, computed once a tick. Plain data of fixed size, in W.
struct Kinematics {
  JointVector q;               ///< joint coordinates, rad or m
  JointVector rates;           ///< q', rad/s or m/s
  Pose pose;                   ///< pose of the platform
  Vec6 twist = Vec6::Zero();   ///< V = J q', m/s, rad/s
  Jacobian jacobian;           ///< J, 6 x n
  Jacobian inverseTransposed;  ///< 6 x n: F = this tau (wrench on the platform from joint torques), q' = this^T V
  JointVector gravity;         ///< torque that balances gravity at rest, N m or N
  JointMatrix inertia;         ///< M(q), n x n, kg m^2 or kg; 0 x 0 if not requested
};

/// Return the twist V = J q'. Realtime: yes.
Vec6 twistOf(const Jacobian& jacobian, const JointVector& rates) noexcept;

/// Return the joint torque tau = J^T F ("A Position-Control Based Approach ...", eq. 3). Realtime: yes.
JointVector torqueOf(const Jacobian& jacobian, const Vec6& wrench) noexcept;

/// Return the joint torque g + J^T F. At rest it balances gravity and applies the wrench F to the platform.
/// Realtime: yes.
JointVector staticTorque(const Kinematics& kinematics, const Vec6& wrench) noexcept;

/// Return the wrench on the platform at the TCP, [N; N m], from joint torques: F = J^-T tau. Realtime: yes.
Vec6 wrenchOf(const Kinematics& kinematics, const JointVector& torque) noexcept;

/// Return the effective mass, kg, of the platform at `point` (W, m) along the unit vector `direction` (Khatib 1995).
/// It is 1 / (n^T J M^-1 J^T n) with the unit push n = [direction; (point - p) x direction]. `kinematics` must contain
/// the inertia. The result is NaN if the inertia is not positive definite. Realtime: yes.
double effectiveMass(const Kinematics& kinematics, const Vec3& point, const Vec3& direction) noexcept;

/// Return the largest force, N, that the motors can apply at `point` (W, m) of the platform along the unit vector
/// `direction`, in addition to gravity balance. It is the minimum of (limit -+ gravity) / |(J^T n)_i| over the driven
/// joints. n is the unit push of effectiveMass(). Realtime: yes.
double largestForce(const Kinematics& kinematics, const JointVector& maxTorque, const Vec3& point,
                    const Vec3& direction) noexcept;

/// The transmission between a motor's command and its joint, the same for all driven joints. Zero means ideal.
struct Drive {
  double bandwidth = 0.0;     ///< bandwidth f of the current loop, Hz: torque' = 2 pi f (command - torque); 0: no lag
  double rotorInertia = 0.0;  ///< reflected, on the motor side of the cable, kg m^2 or kg; 0 if rigid
  double stiffness = 0.0;     ///< stiffness of the cable between rotor and link, N m/rad or N/m; 0: rigid
  double damping = 0.0;       ///< damping of the cable, N m s/rad or N s/m
  double disturbance = 0.0;   ///< standard deviation of the disturbance from friction and cogging at a rotor, N m or N
  bool encoderOnLink = false;

  /// Return the same drive with a rigid transmission. Realtime: yes.
  Drive rigid() const noexcept {
    Drive drive = *this;
    drive.rotorInertia = drive.stiffness = drive.damping = 0.0;
    return drive;
  }
};

/// Limits of each joint's motor and encoder.
struct JointLimits {
  JointVector effort;       ///< largest effort of the motor, N m or N; 0: the joint has an encoder and no motor
  JointVector encoderStep;  ///< encoder step, rad or m
  Drive drive = {};         ///< drive of the driven joints
};

/// A straight part of a mechanism, for drawing.
struct Bar {
  Vec3 from, to;  ///< ends, W, m
  int chain;      ///< its chain, counted from 0; -1: the platform
};

/// Geometry and mass of a device. Immutable; threads may share it.
class Mechanism {
 public:
  virtual ~Mechanism() = default;

  const std::string& name() const noexcept { return name_; }
  int joints() const noexcept { return static_cast<int>(home_.q.size()); }
  const JointLimits& limits() const noexcept { return limits_; }

  /// Return how many metres P moves in W per metre of the device; 1 except for a MappedMechanism. A force F of the
  /// frame is then F times this number at the hand, so that force times speed is the same in both.
  double scale() const noexcept { return scale_; }

  /// Return the state at rest at the home pose (P = W, or as the map of a MappedMechanism has it), with inertia.
  const Kinematics& home() const noexcept { return home_; }

  /// Forward kinematics: compute everything from joint coordinates and rates. The search starts at the content of
  /// `kinematics`: the previous tick's result, or home().
  /// Statuses: notFinite; outOfRange (a vector without joints() numbers); unreachable; singular; notConverged. After an
  /// error `kinematics` is unchanged. Realtime: yes.
  [[nodiscard]] virtual Status track(const JointVector& q, const JointVector& rates, bool withInertia,
                                     Kinematics& kinematics) const noexcept = 0;

  /// Inverse kinematics: compute everything from pose and twist.
  /// Statuses: notFinite; unreachable (also a rotation that the platform cannot make); singular. After an error
  /// `kinematics` is unchanged. Realtime: yes.
  [[nodiscard]] virtual Status reach(const Pose& pose, const Vec6& twist, bool withInertia,
                                     Kinematics& kinematics) const noexcept = 0;

  /// Forward dynamics: compute V' = [v'; w'] from pose, twist, joint torques and the wrench on the platform at the TCP
  /// (N, N m), with gravity, friction and damping.
  /// Statuses: as reach(); outOfRange for a torque vector without joints() numbers. Realtime: yes.
  [[nodiscard]] virtual Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque,
                                          const Vec6& wrench, Vec6& acceleration) const noexcept = 0;

  /// Return the bars to draw at a pose; empty if the pose is unreachable. Realtime: no.
  virtual std::vector<Bar> bars(const Pose& pose) const = 0;

 protected:
  Mechanism(std::string name, JointLimits limits, double scale = 1.0)
      : name_(std::move(name)), limits_(std::move(limits)), scale_(scale) {}

  /// Set home() with reach(). A mechanism's constructor must call it last. Throws ConfigurationError if home is
  /// unreachable or its mass matrix is not positive definite.
  void setHome(const Pose& home = Pose{});

 private:
  std::string name_;
  JointLimits limits_;
  double scale_;
  Kinematics home_;
};

/// Check a mechanism of your own at the pose where its ticks begin. Throws Error with the function and the wrong
/// quantity if
/// - reach() or track() fails there, or gives an array of the wrong size or a number that is not finite;
/// - the Jacobian is zero, or the inverse does not belong to it: J (inverseTransposed)^T J must be J;
/// - the mass matrix is not positive definite;
/// - track() of the joints that reach() gives leads to another pose, or its twist is not J q'.
/// Realtime: no.
void checkMechanism(const Mechanism& mechanism, const Pose& start);

}  // namespace enamel
