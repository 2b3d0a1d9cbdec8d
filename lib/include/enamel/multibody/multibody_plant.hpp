// A plant in a second engine: the device as bodies, joints and loop closures in Simbody, integrated with error control.
// Nothing of this library's dynamics goes in, only the parameters of the device file; where it agrees with the closed
// form, both are right. M. Sherman, A. Seth, S. Delp, "Simbody: multibody dynamics for biomedical research", 2011.
#pragma once

#include <memory>

#include "enamel/device/device_file.hpp"
#include "enamel/sim/plant_maker.hpp"

namespace enamel {

/// A TAU: yaw, lift and elbow joints, a platform on three balls. A delta: the two bars of a leg as one with their
/// mass; an end of it carries a sixth of its mass, so that the far crossbar is no body without mass. A Cartesian
/// device: one body. Rotors turn with their joints. Joint friction and platform damping as in the file. Realtime: no.
class MultibodyPlant final : public Plant {
 public:
  /// `accuracy` of the integration, relative, per step. Throws ConfigurationError: as makeMechanism(); Error: an
  /// accuracy outside 1e-13 to 1e-2.
  explicit MultibodyPlant(const DeviceParameters& parameters, double accuracy = 1e-9);
  ~MultibodyPlant() override;

  /// Build the bodies again, in the state and with the step size of this plant.
  [[nodiscard]] std::unique_ptr<Plant> clone() const override;
  /// Joint angles and passive joints are those of the pose (inverse kinematics).
  [[nodiscard]] Status start(const Pose& pose) override;
  /// notConverged where Simbody gives up.
  [[nodiscard]] Status advance(double time, double duration, const JointVector& torque,
                               const ExternalWrench& load) noexcept override;
  void read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept override;

  /// Forward dynamics of Simbody at a state, as Mechanism::accelerate(). The plant is there afterwards.
  [[nodiscard]] Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                                  Vec6& acceleration);

  /// Largest error of a loop closure now, m or rad.
  double closureError() const;

 private:
  struct Model;
  explicit MultibodyPlant(std::unique_ptr<Model> model);

  std::unique_ptr<Model> model_;
};

/// Return a maker of such plants, every one the same: OtherPlants::multibody. What it makes throws as MultibodyPlant().
MakePlant multibodyPlants(const DeviceParameters& parameters);

}  // namespace enamel
