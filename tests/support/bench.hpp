// A device, its loop, and an obstacle under the tool.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test {

inline constexpr double kTick = 1e-3;  // s

struct Bench {
  struct Setting {
    std::string device = "cartesian-3.toml", plant = kClosedForm;
    Obstacle obstacle;
    int delay = 0;
    bool spring = false;  // the impedance renderer
    bool encoders = false;
    Vec3 start{0.0, 0.0, 2e-3};
    Tool tool = {};
    std::vector<Guide> guides = {};
    Handpiece handpiece = {};
  };

  explicit Bench(const Setting& s) {
    DeviceParameters device = loadDevice(deviceFile(s.device));
    if (s.handpiece.mass > 0.0) addHandpiece(device, s.handpiece);
    mechanism = makeMechanism(modelFor(s.plant, device));
    setup.start.position = s.start;
    if (s.encoders) setup.encoders = {true, RateSource::lowPass};
    setup.delay = {s.delay, s.delay};
    const MakePlant plant = plantMaker(s.plant, device, {}, setup);
    virtualDevice =
        plant ? std::make_unique<VirtualDevice>(plant(0), setup) : std::make_unique<VirtualDevice>(*mechanism, setup);
    if (s.spring)
      renderer = std::make_unique<ImpedanceRenderer>(ImpedanceOptions{1500.0, 2.0});
    else
      renderer = std::make_unique<PositionControlRenderer>(positionControlFor(*mechanism, kTick, s.delay, s.delay));
    scene.add(s.obstacle);
    scene.setGuides(s.guides);
    haptics = std::make_unique<HapticTick>(*mechanism, scene, s.tool, *renderer, kTick, setup.start);
    loop = std::make_unique<LoopBody>(*virtualDevice, *haptics, HapticLoopOptions{});
  }

  // Run a tick under the hand's force, N.
  bool step(const std::function<Vec3(double time, const Pose& pose, const Vec6& twist)>& hand) {
    loop->step();
    return virtualDevice->advance([&](double time, const Pose& pose, const Vec6& twist) {
      Vec6 wrench = Vec6::Zero();
      wrench.head<3>() = hand(time, pose, twist);
      wrench.tail<3>() = holdingMoment(pose.rotation, setup.start.rotation, twist.tail<3>());
      return wrench;
    }) == Status::ok;
  }
  bool press(double force) {
    return step([&](double time, const Pose& pose, const Vec6& twist) {
      Vec3 f = guidingWrench(pose, twist, setup.start, Vec3::UnitZ()).head<3>();
      f.z() -= (time < 0.05 ? 0.3 : force) + 3.0 * twist[2];
      return f;
    });
  }
  const SuspendedState& state() const { return *haptics->scene().motion().suspended(0); }
  const DeviceState& tool() const { return virtualDevice->state(); }
  double force() const {  // of the command on the tool, along z
    const Kinematics& k = haptics->frame().kinematics;
    return wrenchOf(k, haptics->frame().command - k.gravity).z();
  }
  // Depth of the tool in the block, m.
  double depth() const {
    return haptics->scene().scene().obstacles()[0].pose.position.z() + 0.01 - tool().position.z();
  }

  std::shared_ptr<const Mechanism> mechanism;
  VirtualDeviceSetup setup;
  std::unique_ptr<VirtualDevice> virtualDevice;
  std::unique_ptr<Renderer> renderer;
  Scene scene;
  std::unique_ptr<HapticTick> haptics;
  std::unique_ptr<LoopBody> loop;
};

// A second tick of the bench, with position control of its own, that continues from the saved state of the first.
class ContinuedTick {
 public:
  explicit ContinuedTick(Bench& bench)
      : bench_(bench),
        renderer_(positionControlFor(*bench.mechanism, kTick, 0, 0)),
        tick_(*bench.mechanism, bench.scene, Tool{}, renderer_, kTick, bench.setup.start) {
    std::vector<double> state(bench.haptics->stateSize() / sizeof(double) + 1);
    bench.haptics->saveState(state.data());
    tick_.loadState(state.data());
  }

  // Run both with the pose of the last tick, each joint moved by `way`, and require the same bits.
  void stepBoth(double way = 0.0) {
    const TickFrame& last = bench_.haptics->frame();
    Measurement measured;
    measured.time = last.time + kTick;
    measured.q = last.kinematics.q.array() + way;
    measured.rates = last.kinematics.rates;
    Command a, b;
    REQUIRE((*bench_.haptics)(measured, a) == tick_(measured, b));
    REQUIRE(a.effort == b.effort);
  }

  const HapticTick& tick() const { return tick_; }

 private:
  Bench& bench_;
  PositionControlRenderer renderer_;
  HapticTick tick_;
};

// Two devices with imperfections, and a light one. `force`: of a hand, N.
struct BenchDevice {
  const char *file, *plant;
  double force;
};
inline constexpr BenchDevice kBenchDevices[] = {
    {"tau-detailed.toml", kImperfect, 5.0}, {"delta.toml", kImperfect, 5.0}, {"cartesian-3.toml", kClosedForm, 1.5}};

// Press with the force of a device, and with half of it from tick 300 on. Returns means over the last 200 ticks.
struct HeldForce {
  double change = 0.0, force = 0.0;  // of the renderer in a tick, and its force, N
};
inline HeldForce holdAfterPress(const BenchDevice& device, const Obstacle& obstacle, int delay, int ticks,
                                const std::vector<Guide>& guides = {}) {
  Bench bench({device.file, device.plant, obstacle, delay, false, true, {0.0, 0.0, 2e-3}, {}, guides});
  double before = 0.0;
  HeldForce result;
  for (int i = 0; i < ticks; ++i) {
    REQUIRE(bench.press(i < 300 ? device.force : 0.5 * device.force));
    REQUIRE(bench.haptics->guard().fault() == GuardReason::none);
    const double force = bench.force();
    if (i >= ticks - 200) result.change += std::abs(force - before) / 200.0;
    if (i >= ticks - 200) result.force += force / 200.0;
    before = force;
  }
  return result;
}

}  // namespace enamel::test
