#include "plant_unit.hpp"

#include <cmath>

#include "enamel/core/error.hpp"
#include "enamel/sim/hand.hpp"
#include "unit_plants.hpp"

namespace enamel::fmi {

struct PlantUnit::Saved final : UnitState {
  std::unique_ptr<const Plant> plant;  // null before the unit begins
  Pose start;
  Vec3 normal;

  explicit Saved(const PlantUnit& unit)
      : UnitState(unit.now_),
        plant(unit.plant_ ? unit.plant_->clone() : nullptr),
        start(unit.start_),
        normal(unit.normal_) {}
};

PlantUnit::PlantUnit(const UnitConfiguration& configuration, const DeviceParameters& parameters)
    : Unit(configuration, makeMechanism(parameters)) {
  VirtualDeviceSetup setup;
  setup.seed = configuration.seed;
  make_ = plantMaker(configuration.plant, parameters, otherPlants(), setup);
}

void PlantUnit::begin() {
  plant_ =
      make_ ? make_(0) : std::make_unique<ClosedFormPlant>(*device_, Integrator::rungeKutta4, configuration_.substeps);
  start_ = startPose();
  normal_ = vec3("guide_normal");
  if (!(std::abs(normal_.norm() - 1.0) < 1e-6)) throw Error("guide_normal must have the length 1 to 1e-6");
  if (const enamel::Status status = plant_->start(start_); status != enamel::Status::ok)
    throw Error(std::string("the start pose is ") + toString(status));
  Kinematics k;
  if (device_->reach(start_, Vec6::Zero(), false, k) == enamel::Status::ok) put("applied", k.gravity);
  show();
}

void PlantUnit::step(double step) {
  Vec6 held;
  held << vec3("force"), vec3("moment");
  const bool guided = value("guide")[0] != 0.0;
  const auto load = [&](double, const Pose& pose, const Vec6& twist) -> Vec6 {
    if (!guided) return held;
    return guidingWrench(pose, twist, start_, normal_) + held;
  };
  const JointVector torque = joints("torque");
  const enamel::Status status = plant_->advance(now_.last, step, torque, load);
  if (status != enamel::Status::ok)
    throw Error("the device cannot perform the step at " + std::to_string(now_.last) + " s: its pose is " +
                toString(status));
  put("applied", torque);
  show();
}

std::unique_ptr<UnitState> PlantUnit::copyState() const { return std::make_unique<Saved>(*this); }

void PlantUnit::putState(const UnitState& state) {
  const auto& saved = static_cast<const Saved&>(state);
  plant_ = saved.plant ? saved.plant->clone() : nullptr;
  now_ = saved.now;
  start_ = saved.start;
  normal_ = saved.normal;
}

void PlantUnit::show() {
  const DeviceState& state = plant_->state();
  Kinematics k;
  if (const auto status = plant_->mechanism().reach(state.pose(), state.twist, false, k); status != enamel::Status::ok)
    throw Error("the device left its workspace at " + std::to_string(now_.last) + " s: its pose is " +
                toString(status));
  JointVector q, rates;
  plant_->read(k, q, rates);
  put("position", state.position);
  const auto& o = state.orientation;
  put("orientation", Eigen::Vector4d(o.w(), o.x(), o.y(), o.z()));
  put("velocity", state.twist.head<3>());
  put("angular_velocity", state.twist.tail<3>());
  put("q", q);
  put("rates", rates);
}

}  // namespace enamel::fmi
