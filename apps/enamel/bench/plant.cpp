// Measures the time that each plant needs for one simulated second.
#include <stdexcept>

#include "bench/measurement.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/sim/imperfect_plant.hpp"
#ifdef ENAMEL_SIMBODY
#include "enamel/multibody/multibody_plant.hpp"
#endif

namespace enamel::bench {
namespace {

constexpr double kPlantPeriod = 1e-3;  // s

// Simulate one second of 1 kHz ticks on a spring inside the workspace and return the final state.
DeviceState secondOf(Plant& plant) {
  const auto spring = [](double, const Pose& pose, const Vec6& twist) {
    Vec6 wrench = Vec6::Zero();
    wrench.head<3>() = -300.0 * (pose.position - Vec3(0.003, -0.002, 0.004)) - 3.0 * twist.head<3>();
    wrench.tail<3>() = -0.5 * rotationVector(pose.rotation) - 0.01 * twist.tail<3>();
    return wrench;
  };
  Status status = plant.start(Pose());
  for (int tick = 0; tick < 1000 && status == Status::ok; ++tick)
    status = plant.advance(tick * kPlantPeriod, kPlantPeriod, plant.mechanism().home().gravity, spring);
  if (status != Status::ok) throw std::logic_error("the plant left its workspace");
  return plant.state();
}

// The nominal TAU with cables and the friction of data/devices/tau-detailed.toml.
ImperfectDevice withCables(const DeviceParameters& nominal) {
  DeviceParameters device = nominal;
  Imperfections& e = imperfectionsOf(device);
  e.currentBandwidth = 1000.0;
  e.torqueStep = 0.001;
  e.coulombFriction = 0.006;
  e.cableStiffness = 1000.0;
  e.cableDamping = 0.037;
  return makeImperfectDevice(device, 1);
}

}  // namespace

std::vector<Measurement> measurePlant(double scale) {
  const DeviceParameters device = nominalDevice();
  const std::shared_ptr<const Mechanism> mechanism = makeMechanism(device);
  ClosedFormPlant closed(*mechanism), fine(*mechanism, Integrator::rungeKutta4, 16);
  ImperfectPlant fineCables(withCables(device), 1e-5);
  const Vec3 ideal = secondOf(fine).position, imperfect = secondOf(fineCables).position;
  std::vector<Measurement> rows;
  const auto add = [&](const std::string& name, Plant& plant, int calls, const Vec3& end) {
    Measurement row;
    row.name = name;
    row.error = (secondOf(plant).position - end).norm();
    row.errorOf = "last position, m, against fine steps";
    const Timing timing = timeEachCall(std::max(3, static_cast<int>(calls * scale)), 1, [&](int) { secondOf(plant); });
    row.median_us = timing.median_us;
    row.p99_us = timing.p99_us;
    rows.push_back(row);
  };
  add("a second, closed form", closed, 100, ideal);
  ImperfectPlant rigid(makeImperfectDevice(device, 1)), cables(withCables(device));
  add("a second, imperfect plant without imperfections", rigid, 50, ideal);
  add("a second, imperfect plant with cables and friction", cables, 20, imperfect);
#ifdef ENAMEL_SIMBODY
  MultibodyPlant multibody(device);
  add("a second, multibody", multibody, 3, ideal);
#endif
  return rows;
}

}  // namespace enamel::bench
