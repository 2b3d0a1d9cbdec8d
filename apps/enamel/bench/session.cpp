// Measures whole sessions of position control: a simulated person slides over a tooth, drills a cavity, and turns a
// probe in a fissure. The session is recorded in a closed loop; then its measurements are replayed and each tick is
// timed. The slowest ticks depend on the path of the tool, so they have rows of their own here.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>

#include "bench/measurement.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "mesh_generator.hpp"

namespace enamel::bench {
namespace {

constexpr double kSessionPeriod = 1e-3;  // s

constexpr double kDepth = 2.5e-3;  // m: where the person stops to press
constexpr Grip kPress{2000.0, 3.0};

// Where the person moves the tool across z and how the tool is turned; it is pressed down.
struct Hand {
  double force;                             // N
  std::function<Pose(double time)> follow;  // the height does not matter
};

struct Setting {
  std::string name;
  Shape shape;
  Tool tool;
  Bur bur;  // of part 0; turns = 0: it does not cut
  Hand hand;
};

ToolPart partOf(double radius, double from, double to) {
  ToolPart part;
  part.a.z() = from;
  part.b.z() = to;
  part.radius = radius;
  return part;
}

// Height of the tool's tip where it touches the tooth while it moves down the z axis.
double touchingHeight(const MeshModel& tooth, const Tool& tool) {
  const double radius = tool.parts[0].radius;
  double z = 8e-3;
  for (double gap = z; gap > 1e-6; z -= gap) gap = signedDistance(tooth, {0.0, 0.0, z}).distance - radius;
  return z;
}

struct Run {
  Scene scene;
  std::unique_ptr<Drill> drill;

  Run(const Setting& setting, double height) {
    Obstacle tooth{"tooth", setting.shape, Pose(), Vec6::Zero(), {}};
    tooth.pose.position.z() = -height;
    std::vector<std::shared_ptr<Solid>> solids(1);
    if (const auto* solid = std::get_if<std::shared_ptr<const Solid>>(&setting.shape)) {
      solids[0] = std::make_shared<Solid>(**solid);  // each run cuts its own
      tooth.shape = std::shared_ptr<const Solid>(solids[0]);
    }
    scene.add(tooth);
    if (setting.bur.turns == 0.0) return;
    drill = std::make_unique<Drill>(setting.tool, solids, setting.bur);
    drill->spin(true);
  }
};

Measurement measure(const Setting& setting, double height, int ticks) {
  const TauMechanism mechanism(nominalDevice());
  PositionControlRenderer control(positionControlFor(mechanism, kSessionPeriod, 1, 1));
  Run first(setting, height);
  LoopSetup setup;
  setup.scene = first.scene;
  setup.tool = setting.tool;
  setup.encoders = {true, RateSource::difference};
  setup.delay.low = setup.delay.high = 1;
  setup.start.position.z() = 1e-4;
  VirtualLoop loop(mechanism, control, setup);
  loop.attach(first.drill.get());
  std::vector<enamel::Measurement> measured;
  std::vector<Command> commands;
  int faults = 0;
  for (int i = 0; i < ticks; ++i) {
    const auto hand = [&](double time, const Pose& pose, const Vec6& twist) {
      const Pose goal = setting.hand.follow(time);
      Vec6 wrench = guidingWrench(pose, twist, goal, Vec3::UnitZ());
      const double force = std::clamp(kPress.stiffness * (pose.position.z() + kDepth), 0.0, setting.hand.force);
      wrench[2] -= force * std::min(10.0 * time, 1.0) + kPress.damping * twist[2];
      return wrench;
    };
    TickRecord record;
    faults += loop.tick(hand, record) != Status::ok || record.guard != GuardReason::none;
    measured.push_back(loop.measurement());
    commands.push_back(loop.command());
  }

  Run again(setting, height);
  PositionControlRenderer other(positionControlFor(mechanism, kSessionPeriod, 1, 1));
  HapticTick tick(mechanism, again.scene, setting.tool, other, kSessionPeriod, setup.start);
  tick.attach(again.drill.get());
  std::vector<double> times_us;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    Command command;
    times_us.push_back(timeOnce([&] { keep(tick(measured[i], command)); }));
    faults += command.effort != commands[i].effort;
  }
  return rowOf(setting.name, times_us, faults, "ticks with a fault, or with another torque than recorded");
}

}  // namespace

std::vector<Measurement> measureSession(double scale) {
  const auto tooth = std::make_shared<const MeshModel>(app::makeMolar(6));
  const auto solid = std::make_shared<const Solid>(
      *tooth, std::vector<SolidLayer>{{"enamel", {}, 3.4e9, 0.0, nullptr}, {"dentine", {}, 0.6e9, 1e-3, nullptr}});
  Tool ball, probe;  // each with its shaft
  ball.count = probe.count = 2;
  ball.parts[0] = partOf(0.5e-3, 0.0, 0.0);
  ball.parts[1] = partOf(0.3e-3, 0.0, 15e-3);
  probe.parts[0] = partOf(0.15e-3, 0.0, 2e-3);
  probe.parts[1] = partOf(0.5e-3, 2e-3, 15e-3);
  const auto wander = [](double x, double y) {
    return [=](double time) {
      Pose pose;
      pose.position = {x * std::sin(3.0 * time), y * std::sin(1.9 * time), 0.0};
      return pose;
    };
  };
  const auto turn = [](double time) {
    Pose pose;
    pose.rotation = (Eigen::AngleAxisd(0.5 * std::sin(4.0 * time), Vec3::UnitZ()) *
                     Eigen::AngleAxisd(0.2 * std::sin(2.3 * time), Vec3::UnitX()))
                        .toRotationMatrix();
    return pose;
  };
  const Bur still{0, 0.5, 0.0}, bur{0, 0.05, 2000.0};
  const Setting settings[] = {{"slide over a tooth", tooth, ball, still, {2.0, wander(3e-3, 2.5e-3)}},
                              {"slide over a solid", solid, ball, still, {2.0, wander(3e-3, 2.5e-3)}},
                              {"drill a cavity", solid, ball, bur, {2.0, wander(0.8e-3, 0.8e-3)}},
                              {"turn a probe in a fissure", tooth, probe, still, {1.0, turn}}};
  std::vector<Measurement> rows;
  for (const Setting& setting : settings)
    rows.push_back(
        measure(setting, touchingHeight(*tooth, setting.tool), std::max(2000, static_cast<int>(20000 * scale))));
  return rows;
}

}  // namespace enamel::bench
