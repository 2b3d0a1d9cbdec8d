// A device whose workspace is placed in a scene, larger or smaller.
#pragma once

#include <memory>

#include "enamel/device/mechanism.hpp"

namespace enamel {

/// Place of a device's workspace in a scene: p_scene = base.position + scale * base.rotation * p_device.
struct WorkspaceMap {
  Pose base;           ///< of the device's origin, in the scene; within kFarthestBase of its origin
  double scale = 1.0;  ///< metres of the tool per metre of the device, kSmallestScale to kLargestScale
};

inline constexpr double kFarthestBase = 5.0;                          ///< m, along each axis
inline constexpr double kSmallestScale = 0.01, kLargestScale = 10.0;  // a hand of 10 cm covers 1 mm to 1 m

/// A mechanism in the frame of a scene. Poses, twists, wrenches and Jacobians are those of the tool in the scene; joint
/// coordinates and torques are the device's. Rotations are not scaled. Force times speed is the same for hand and tool:
/// a force F in the frame is scale() F at the hand.
class MappedMechanism final : public Mechanism {
 public:
  /// Throws Error if the device is null, a number is not finite or outside its range, or the base is not a rotation.
  /// Realtime: no.
  MappedMechanism(std::shared_ptr<const Mechanism> device, const WorkspaceMap& map);

  const Mechanism& device() const noexcept { return *device_; }
  const WorkspaceMap& map() const noexcept { return map_; }

  /// Move the base, within kFarthestBase: a clutch. home() remains. Call it between ticks only, on their thread.
  /// Realtime: yes.
  void moveBase(const Vec3& position) noexcept;

  [[nodiscard]] Status track(const JointVector& q, const JointVector& rates, bool withInertia,
                             Kinematics& kinematics) const noexcept override;
  [[nodiscard]] Status reach(const Pose& pose, const Vec6& twist, bool withInertia,
                             Kinematics& kinematics) const noexcept override;
  [[nodiscard]] Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                                  Vec6& acceleration) const noexcept override;
  std::vector<Bar> bars(const Pose& pose) const override;

  /// Return a pose of the device in the scene, and back. Realtime: yes.
  Pose toScene(const Pose& pose) const noexcept;
  Pose toDevice(const Pose& pose) const noexcept;

 private:
  Vec6 motionToScene(const Vec6& twist) const noexcept;
  Vec6 motionToDevice(const Vec6& twist) const noexcept;
  Kinematics toDevice(const Kinematics& kinematics) const noexcept;
  void toScene(const Kinematics& device, Kinematics& kinematics) const noexcept;

  std::shared_ptr<const Mechanism> device_;
  WorkspaceMap map_;
};

}  // namespace enamel
