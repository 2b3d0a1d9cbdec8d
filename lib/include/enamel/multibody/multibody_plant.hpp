// A plant in a second engine: Simbody integrates the device as bodies, joints and loop closures, with error control. It
// uses only the parameters of the device file and none of this library's dynamics. Agreement with the closed form
// therefore confirms both. Source of the engine: M. Sherman, A. Seth, S. Delp, "Simbody: multibody dynamics for
// biomedical research", 2011.
#pragma once

#include <memory>

#include "enamel/device/device_file.hpp"
#include "enamel/sim/plant_maker.hpp"

namespace enamel {

/// The device in Simbody. Realtime: no.
///
/// - TAU: yaw, lift and elbow joints, and a platform on three balls.
/// - Delta: one body for the two bars of a leg, with their mass. One end of it carries a sixth of this mass, so that
///   the far crossbar has a mass.
/// - Cartesian device: one body.
///
/// Rotors turn with their joints. Joint friction and platform damping are those of the file.
class MultibodyPlant final : public Plant {
 public:
  /// `accuracy` is the relative accuracy of the integration per step. Throws ConfigurationError as makeMechanism().
  /// Throws Error if the accuracy is outside 1e-13 to 1e-2.
  explicit MultibodyPlant(const DeviceParameters& parameters, double accuracy = 1e-9);
  ~MultibodyPlant() override;

  /// Build the bodies again, with the state and step size of this plant.
  [[nodiscard]] std::unique_ptr<Plant> clone() const override;
  /// Put the plant at rest at a pose. Inverse kinematics gives joint angles and passive joints.
  [[nodiscard]] Status start(const Pose& pose) override;
  /// Move on as Plant::advance(). Status notConverged: Simbody failed to converge.
  [[nodiscard]] Status advance(double time, double duration, const JointVector& torque,
                               const ExternalWrench& load) noexcept override;
  void read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept override;

  /// Compute Simbody's forward dynamics at a state, as Mechanism::accelerate(). The plant is at this state afterwards.
  [[nodiscard]] Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                                  Vec6& acceleration);

  /// Return the largest error of a loop closure now, m or rad.
  double closureError() const;

 private:
  struct Model;
  explicit MultibodyPlant(std::unique_ptr<Model> model);

  std::unique_ptr<Model> model_;
};

/// Return a maker of identical plants, for OtherPlants::multibody. Its plants throw as MultibodyPlant().
MakePlant multibodyPlants(const DeviceParameters& parameters);

}  // namespace enamel
