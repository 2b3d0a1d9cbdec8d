// Cutting inside the tick: the rate is Archard's, the force is the hand's, and contacts match the material.
#include "enamel/render/drill.hpp"

#include <cmath>
#include <functional>
#include <memory>
#include <numeric>
#include <utility>

#include "enamel/collision/implicit_surface.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "support/catch.hpp"
#include "support/contacts.hpp"
#include "support/devices.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_drill {

namespace {

constexpr double kCell = 1e-4, kRadius = 0.5e-3, kEnamel = 3.4e9, kDentine = 0.6e9;
const Bur kBur{0, 0.1, 2000.0};

const Vec3 kHalf{3e-3, 3e-3, 2e-3};  // of the tooth

// A block with a groove along y, 1.5 mm deep, whose walls lean by an angle from the vertical.
TriangleMesh grooved(double angle) {
  const Vec3 border = kHalf + Vec3::Constant(kCell);
  return surfaceOf(
      [&](const Vec3& p) {
        const double groove = std::abs(p.x()) * std::cos(angle) - (p.z() - kHalf.z() + 1.5e-3) * std::sin(angle);
        return std::max((p.cwiseAbs() - kHalf).maxCoeff(), -groove);
      },
      -border, border, 0.5 * kCell);
}

std::shared_ptr<Solid> tooth(double dentine = 0.4e-3, double groove = 0.0) {
  return std::make_shared<Solid>(
      MeshModel(groove > 0.0 ? grooved(groove) : test::boxMesh(kHalf)),
      std::vector<SolidLayer>{{"enamel", {}, kEnamel, 0.0, nullptr}, {"dentine", {}, kDentine, dentine, nullptr}},
      SolidOptions{kCell});
}

Tool ball() {
  Tool tool;
  tool.parts[0].radius = kRadius;
  return tool;
}

struct Cut {
  double force, torque;            // mean wall force along the push, N; deviation of the noisiest joint, N m
  double volume, depth;            // of the second half, m^3, m
  double expected;                 // volume by Archard's law, m^3
  double feedEnamel, feedDentine;  // m/s
  double deepest;                  // of the whole time, m
};

// A hand presses with 2 N on top of the tooth, which is tilted, or on the walls of its groove.
Cut press(Renderer& renderer, const Mechanism& device, int delay, double tilt, const Bur& bur = kBur,
          double dentine = 0.4e-3, const Tool& tool = ball(), double groove = 0.0) {
  const auto solid = tooth(dentine, groove);
  LoopSetup setup;
  setup.scene = Scene();
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(tilt, Vec3(1.0, 0.4, 0.0).normalized()).toRotationMatrix();
  const Vec3 normal = pose.rotation.col(2);
  pose.position = -2e-3 * normal;
  setup.scene.add({"tooth", std::shared_ptr<const Solid>(solid), pose, Vec6::Zero(), {}});
  setup.tool = tool;
  double tip = 0.0, radius = 0.0;  // m: height of the TCP above it, largest of the head
  for (std::size_t i = 0; i < static_cast<std::size_t>(tool.head); ++i) {
    tip = std::max(tip, tool.parts[i].radius - tool.parts[i].a.z());
    radius = std::max(radius, tool.parts[i].radius);
  }
  setup.start.position = (tip + 0.05e-3) * normal;
  if (groove > 0.0) setup.start.position += (radius / std::sin(groove) - radius - 1.5e-3) * normal;
  setup.encoders = {true, RateSource::difference};
  setup.delay.low = setup.delay.high = delay;
  VirtualLoop loop(device, renderer, setup);
  Drill drill(setup.tool, {solid}, bur);
  drill.spin(true);
  loop.attach(&drill);
  Cut cut{};
  std::vector<JointVector> torques;
  TickRecord record;
  const int ticks = 2000;
  double depth = 0.0, atFirst = 0.0, enamelTime = 0.0, dentineTime = 0.0;
  for (int i = 0; i < ticks; ++i) {
    const double force = 2.0 * std::clamp((i - 20) / 100.0, 0.0, 1.0);
    const auto load = [&](double, const Pose& at, const Vec6& twist) {
      Vec6 wrench = guidingWrench(at, twist, setup.start, normal);
      wrench.head<3>() -= force * normal + 3.0 * normal.dot(twist.head<3>()) * normal;
      return wrench;
    };
    REQUIRE(loop.tick(load, record) == Status::ok);
    REQUIRE(record.guard == GuardReason::none);
    cut.deepest = std::max(cut.deepest, -record.nearest.gap);
    const double before = depth;
    depth = tip - normal.dot(record.pose.position);
    if (i == ticks / 2) atFirst = depth;
    const RemovedVolume& removed = drill.removed();
    const double volume = removed[0] + removed[1];
    if (i < ticks / 4) continue;
    if (removed[0] > 0.9 * volume) cut.feedEnamel += depth - before, enamelTime += 1e-3;
    if (removed[1] > 0.9 * volume) cut.feedDentine += depth - before, dentineTime += 1e-3;
    if (i < ticks / 2) continue;
    cut.force += normal.dot(record.rendered.head<3>()) / (0.5 * ticks);
    cut.volume += volume;
    const double hardness = volume > 0.0 ? (removed[0] * kEnamel + removed[1] * kDentine) / volume : kEnamel;
    cut.expected += bur.wear * 2.0 * 2.0 * M_PI * radius * bur.turns / hardness * 1e-3;
    torques.push_back(record.torque);
  }
  cut.depth = depth - atFirst;
  cut.feedEnamel /= std::max(enamelTime, 1e-3);
  cut.feedDentine /= std::max(dentineTime, 1e-3);
  for (int joint = 0; joint < device.joints(); ++joint) {
    double mean = 0.0, square = 0.0;
    for (const JointVector& torque : torques) mean += torque[joint] / static_cast<double>(torques.size());
    for (const JointVector& torque : torques) square += std::pow(torque[joint] - mean, 2);
    cut.torque = std::max(cut.torque, std::sqrt(square / static_cast<double>(torques.size())));
  }
  return cut;
}

}  // namespace

TEST_CASE("drill: the hand's force, Archard's rate, and dentine is felt", "[drill]") {
  const auto device = makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml")));
  const auto check = [](const Cut& cut) {
    INFO("force " << cut.force << " N, deviation " << cut.torque << " N m, volume " << 1e9 * cut.volume << " mm3 of "
                  << 1e9 * cut.expected << ", feed " << 1e3 * cut.feedEnamel << " and " << 1e3 * cut.feedDentine
                  << " mm/s");
    CHECK(cut.force == Approx(2.0).epsilon(0.05));
    CHECK(cut.volume == Approx(cut.expected).epsilon(0.2));  // the hardness at the border is a mean over 20 ticks
    CHECK(cut.depth > 0.2e-3);
    CHECK(cut.torque < 0.05);
  };
  for (const int delay : {0, 1}) {
    INFO("servo, delay " << delay);
    PositionControlRenderer servo(positionControlFor(*device, 1e-3, delay, delay));
    const Cut cut = press(servo, *device, delay, 0.3 * delay);
    check(cut);
    CHECK(cut.feedDentine > 2.0 * cut.feedEnamel);
  }
  INFO("spring: it swings by a millimetre");
  ImpedanceRenderer spring(ImpedanceOptions{2000.0, 2.0});
  check(press(spring, *device, 0, 0.0));
}

TEST_CASE("drill: the hand's force and no chatter at any feed", "[drill]") {
  const auto device = makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml")));
  for (const int delay : {0, 1})
    for (const double wear : {0.02, 0.1, 0.35}) {  // 0.1, 0.5 and 1.6 mm/s in enamel
      PositionControlRenderer servo(positionControlFor(*device, 1e-3, delay, delay));
      const Cut cut = press(servo, *device, delay, 0.15, {0, wear, 2000.0}, 5e-3);
      INFO("delay " << delay << ", feed " << 1e3 * cut.feedEnamel << " mm/s, force " << cut.force
                    << " N, deviation of a torque " << cut.torque << " N m");
      CHECK(cut.force == Approx(2.0).epsilon(0.05));
      CHECK(cut.volume == Approx(cut.expected).epsilon(0.1));
      CHECK(cut.torque < 0.05);
    }
}

TEST_CASE("drill: a head of several parts cuts what one part would cut under the same force", "[drill]") {
  const auto device = makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml")));
  for (const char* name : {"cylinder-010-020", "flat-010-020", "cone-012-030-006", "flame-012-030"})
    for (const int delay : {0, 1}) {
      PositionControlRenderer servo(positionControlFor(*device, 1e-3, delay, delay));
      const Cut cut = press(servo, *device, delay, 0.0, kBur, 5e-3, toolOf(name));
      INFO(name << ", delay " << delay << ": " << cut.force << " N, deviation " << cut.torque << " N m, volume "
                << 1e9 * cut.volume << " mm3 of " << 1e9 * cut.expected);
      CHECK(cut.force == Approx(2.0).epsilon(0.05));
      CHECK(cut.volume == Approx(cut.expected).epsilon(0.1));
      CHECK(cut.depth > 0.1e-3);
      CHECK(cut.torque < 0.05);
      // 0.8 mm if the contacts at the ends of a cylinder take each other's place from tick to tick.
      CHECK(cut.deepest < kCell);
    }
}

TEST_CASE("drill: between steep walls it cuts what it cuts on a flat tooth", "[drill]") {
  const auto device = makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml")));
  for (const char* name : {"round-010", "flat-010-020"})
    for (const double degrees : {45.0, 35.0, 25.0, 15.0})
      for (const int delay : {0, 1}) {
        PositionControlRenderer servo(positionControlFor(*device, 1e-3, delay, delay));
        const Cut cut = press(servo, *device, delay, 0.0, kBur, 5e-3, toolOf(name), degrees * M_PI / 180.0);
        INFO(name << ", walls of " << degrees << " deg, delay " << delay << ": volume " << 1e9 * cut.volume
                  << " mm3 of " << 1e9 * cut.expected);
        CHECK(cut.force == Approx(2.0).epsilon(0.05));
        CHECK(cut.volume == Approx(cut.expected).epsilon(0.1));
      }
}

TEST_CASE("drill: contacts and material go together while it cuts", "[drill]") {
  const auto solid = tooth();
  Scene scene;
  Pose pose;
  pose.rotation = rotationFromEuler(Vec3(0.2, -0.4, 1.0));
  pose.position = Vec3(1e-3, 2e-3, -3e-3);
  scene.add({"tooth", std::shared_ptr<const Solid>(solid), pose, Vec6::Zero(), {}});
  Tool tool = ball();
  tool.count = 2;  // the shaft does not cut
  tool.parts[1] = {Vec3(0, 0, 1.5e-3), Vec3(0, 0, 8e-3), 0.3e-3};
  ToolTrack track = makeToolTrack(scene, tool);
  Drill drill(tool, {solid}, {0, 5.0, 2000.0});
  drill.spin(true);
  test::Random random(2210);
  Pose at;
  Vec3 goal(0, 0, 0);
  at.position = pose.position + Vec3(0, 0, 6e-3);
  int cuts = 0, touches = 0, lost = 0, unfounded = 0, vanished = 0, unfelt = 0;
  // There is material half a cell behind the contact's surface. Only if the axis is outside.
  const auto isTouch = [](const Contact& c) { return c.gap < 0.0 && c.gap > -0.1e-3; };
  const auto isFounded = [&](const Contact& c) {
    const Vec3 behind = c.point - (c.gap + 0.5 * kCell) * c.normal;
    const Vec3 inside = pose.rotation.transpose() * (behind - pose.position);
    return std::abs(signedDistance(*solid, inside, 1e-3).distance) < 2.0 * kCell || isInside(*solid, inside);
  };
  const int ticks = test::count(3000, 60000);
  for (int i = 0; i < ticks; ++i) {
    if (i % 100 == 0) goal = pose.position + pose.rotation * random.vector(4e-3);
    const Vec3 way = goal - at.position;
    if (way.norm() > 1e-9) at.position += std::min(3e-5, way.norm()) * way.normalized();
    ContactSnapshot contacts;
    REQUIRE(followContacts(scene, tool, at, 1e-3, track, contacts) == Status::ok);
    for (int k = 0; k < contacts.count; ++k)
      unfounded += isTouch(contacts.contacts[k]) && !isFounded(contacts.contacts[k]);
    drill.correct(contacts);
    const double whole = drill.removed()[0] + drill.removed()[1];
    drill.cut(scene, at, contacts.count > 0 ? Vec3(2.0 * contacts.contacts[0].normal) : Vec3(Vec3::Zero()), 1e-3,
              contacts);
    const double removed = drill.removed()[0] + drill.removed()[1];
    cuts += removed > 0.0;
    lost += !std::isfinite(removed) || removed < 0.0 || !std::isfinite(whole);
    const Vec3 centre = pose.rotation.transpose() * (at.position - pose.position);
    const SolidPoint nearest = signedDistance(*solid, centre, 2e-3);
    bool feels = false;
    for (int k = 0; k < contacts.count; ++k) {
      const Contact& c = contacts.contacts[k];
      feels = feels || c.gap < 0.0;
      if (!isTouch(c)) continue;
      ++touches;
      vanished += !isFounded(c);
    }
    unfelt += nearest.found && nearest.distance < kRadius - kCell && !feels;
    // The walls push the tool back, so that it is not driven through them.
    for (int k = 0; k < contacts.count; ++k) {
      const Contact& c = contacts.contacts[k];
      if (c.gap < -2e-5) at.position -= 0.5 * (c.gap + 2e-5) * c.normal;
    }
  }
  CHECK(cuts > ticks / 6);
  CHECK(touches > ticks / 6);
  CHECK(lost == 0);
  CHECK(unfounded == 0);
  CHECK((vanished == 0 || vanished < touches / 1000));  // a sliver may disappear in the tick that felt it
  CHECK(unfelt == 0);
}

TEST_CASE("drill: what does not spin does not cut; what is refused", "[drill]") {
  const auto solid = tooth();
  Scene scene;
  scene.add({"tooth", std::shared_ptr<const Solid>(solid), Pose(), Vec6::Zero(), {}});
  const Tool tool = ball();
  Pose at;
  at.position.z() = 2e-3 + 0.9 * kRadius;
  const auto once = [&](Drill& drill, const Vec3& force) {
    ContactSnapshot contacts;
    REQUIRE(findContacts(scene, tool, at, 1e-3, nullptr, contacts) == Status::ok);
    const double gap = contacts.contacts[0].gap;
    drill.correct(contacts);
    CHECK(contacts.contacts[0].gap >= gap);
    drill.cut(scene, at, force, 1e-3, contacts);
    return drill.removed()[0];
  };
  Drill drill(tool, {solid}, kBur);
  CHECK(once(drill, Vec3(0, 0, 2)) == 0.0);
  drill.spin(true);
  CHECK(once(drill, Vec3(0, 0, std::nan(""))) == 0.0);
  double removed = 0.0;
  for (int i = 0; i < 50; ++i) removed += once(drill, Vec3(0, 0, 2));
  CHECK(removed > 0.0);
  drill.spin(false);
  CHECK(once(drill, Vec3(0, 0, 2)) == 0.0);
  Drill other(tool, {nullptr}, kBur);
  other.spin(true);
  CHECK(once(other, Vec3(0, 0, 2)) == 0.0);
  CHECK_THROWS_WITH(Drill(tool, {solid}, {1, 0.1, 1.0}),
                    test::ContainsSubstring("part 1 of the tool, must be below its number of parts, 1"));
  CHECK_THROWS_WITH(Drill(Tool(), {solid}, kBur), test::ContainsSubstring("must have a radius greater than 0 mm"));
  Tool large = tool;
  large.parts[0].radius = 6e-3;
  CHECK_THROWS_WITH(Drill(large, {solid}, kBur), test::ContainsSubstring("a radius of 6 mm, must be at most 5 mm"));
  CHECK_THROWS_WITH(Drill(tool, {solid}, {0, 0.0, 1.0}), test::ContainsSubstring("wear"));
  CHECK_THROWS_WITH(Drill(tool, {solid}, {0, 0.1, 1e5}), test::ContainsSubstring("10000"));
}

// A bur on a flat tooth under a constant force, without a device.
namespace {

struct Spun {
  std::shared_ptr<Solid> solid = tooth(1.9e-3);  // enamel
  Scene scene;
  Drill drill;
  Pose pose;
  double volume = 0.0;

  explicit Spun(const Bur& bur) : drill(ball(), {solid}, bur) {
    Pose at;
    at.position.z() = -2e-3;
    scene.add({"tooth", std::shared_ptr<const Solid>(solid), at, Vec6::Zero(), {}});
    pose.position.z() = kRadius;
    drill.spin(true);
  }

  // Press with a force for some seconds. The bur follows the surface that it cuts.
  void press(double force, double seconds) {
    for (double t = 0.0; t < seconds - 1e-9; t += 1e-3) {
      ContactSnapshot contacts;
      if (force > 0.0) {
        contacts = test::contactsOf(scene, ball(), pose, 1e-3);
        pose.position.z() -= std::max(0.0, contacts.contacts[0].gap) + 1e-6;
        contacts = test::contactsOf(scene, ball(), pose, 1e-3);
      }
      drill.correct(contacts);
      drill.cut(scene, pose, force * Vec3::UnitZ(), 1e-3, contacts);
      volume += drill.removed()[0];
    }
  }
};

constexpr double kWear = 0.02;  // slow, so that the bur fits its hole

// A turbine whose speed settles in 10 ms.
Bur turbine() {
  Bur bur{0, kWear, 2000.0};
  bur.torque = 1e-3;
  bur.drag = 0.4;
  bur.inertia = bur.torque * 0.01 / (2.0 * M_PI * bur.turns);
  return bur;
}

}  // namespace

TEST_CASE("drill: the speed falls linearly with the load, down to a stall", "[drill]") {
  const Bur bur = turbine();
  for (const double share : {0.0, 0.25, 0.5, 0.9}) {  // of the load that stalls it
    Spun spun(bur);
    spun.press(0.0, 0.2);
    CHECK(spun.drill.turns() == Approx(bur.turns));
    spun.press(share * bur.torque / (bur.drag * kRadius), 1.0);
    CHECK(spun.drill.load() == Approx(share * bur.torque).margin(1e-12));
    CHECK(spun.drill.turns() == Approx((1.0 - share) * bur.turns).epsilon(1e-6));
  }
  Spun stalled(bur);
  stalled.press(0.0, 0.2);
  stalled.press(1.5 * bur.torque / (bur.drag * kRadius), 1.0);
  CHECK(stalled.drill.turns() == 0.0);
  const double cut = stalled.volume;
  stalled.press(1.5 * bur.torque / (bur.drag * kRadius), 0.5);
  CHECK(stalled.volume == cut);
  stalled.press(0.5 * bur.torque / (bur.drag * kRadius), 1.0);  // it starts again under less force
  CHECK(stalled.drill.turns() == Approx(0.5 * bur.turns).epsilon(1e-6));
  CHECK(stalled.volume > cut);
}

TEST_CASE("drill: a bur that cuts is held by its pit, by the force over twice the height of the surface", "[drill]") {
  Spun spun({0, kWear, 2000.0});
  CHECK(spun.drill.hold() == 0.0);
  CHECK(spun.drill.obstacle() == -1);
  spun.press(2.0, 0.5);
  CHECK(spun.drill.obstacle() == 0);
  CHECK(spun.drill.hold() == Approx(2.0 / (2.0 * kCell * kCell / (4.0 * kRadius))));
  spun.press(0.0, 1e-3);
  CHECK(spun.drill.hold() == 0.0);
}

TEST_CASE("drill: the speed approaches its equilibrium with the time constant of the rotor", "[drill]") {
  const Bur bur = turbine();
  Spun spun(bur);
  spun.press(0.0, 0.01);
  CHECK(spun.drill.turns() == Approx((1.0 - std::exp(-1.0)) * bur.turns).epsilon(1e-9));
  spun.drill.spin(false);
  const double before = spun.drill.turns();
  spun.press(0.0, 0.01);
  CHECK(spun.drill.turns() == Approx(std::exp(-1.0) * before).epsilon(1e-9));
}

TEST_CASE("drill: the rate is that of the present speed, and a strong motor is a constant speed", "[drill]") {
  const double force = 0.5 * turbine().torque / (turbine().drag * kRadius);
  const auto rate = [&](const Bur& bur) {
    Spun spun(bur);
    spun.press(0.0, 0.2);
    spun.press(force, 0.5);
    const double before = spun.volume;
    spun.press(force, 0.5);
    return 2.0 * (spun.volume - before);
  };
  Bur constant{0, kWear, 2000.0}, strong = turbine();
  strong.torque = 1e12;
  const double full = rate(constant);
  CHECK(full == Approx(kWear * force * 2.0 * M_PI * kRadius * 2000.0 / kEnamel).epsilon(0.05));
  CHECK(rate(turbine()) == Approx(0.5 * full).epsilon(0.05));
  CHECK(rate(strong) == Approx(full).epsilon(1e-6));
}

TEST_CASE("drill: the head vibrates by its run-out and by the feed of a blade", "[drill]") {
  Bur bur{0, 0.1, 50.0};  // a slow handpiece
  bur.runOut = 1e-5;
  Spun spun(bur);
  constexpr int kTicks = 1000;
  double sum = 0.0, squares = 0.0, along = 0.0, work = 0.0, last = 0.0;
  for (int i = 0; i < kTicks; ++i) {
    spun.press(0.0, 1e-3);
    ContactSnapshot contacts;
    contacts.count = 1;
    contacts.contacts[0].part = 0;
    contacts.contacts[0].normal = Vec3::UnitX();
    spun.drill.vibrate(spun.pose, 1e-3, contacts);
    const Contact& c = contacts.contacts[0];
    sum += c.gap;
    squares += c.gap * c.gap;
    // The gap shrinks by the outward velocity of the surface, to the second order.
    if (i > 0) along = std::max(along, std::abs(c.gap + 1e-3 * c.obstacleVelocity.x() - last));
    work += c.gap * c.obstacleVelocity.x();
    last = c.gap;
  }
  CHECK(std::abs(sum) / kTicks < 1e-9);
  CHECK(std::sqrt(squares / kTicks) == Approx(bur.runOut / std::sqrt(2.0)).epsilon(1e-6));
  const double rate = 2.0 * M_PI * bur.turns;
  CHECK(along < 0.5 * bur.runOut * rate * rate * 1e-6 * 1.01 + 1e-12);
  CHECK(std::abs(work) / kTicks < 1e-9 * bur.runOut * rate);

  const auto amplitude = [](double turns, double period) {
    Bur fast{0, 0.1, turns};
    fast.runOut = 1e-5;
    Spun turning(fast);
    ContactSnapshot contacts;
    contacts.count = 1;
    contacts.contacts[0].part = 0;
    contacts.contacts[0].normal = Vec3::UnitX();
    turning.drill.vibrate(turning.pose, period, contacts);
    return std::hypot(contacts.contacts[0].gap, contacts.contacts[0].obstacleVelocity.x() / (2.0 * M_PI * turns));
  };
  CHECK(amplitude(125.0, 1e-3) == Approx(1e-5));       // 8 ticks a turn
  CHECK(amplitude(1.0 / 6e-3, 1e-3) == Approx(5e-6));  // 6
  CHECK(amplitude(250.0, 1e-3) == 0.0);                // 4
  CHECK(amplitude(250.0, 2.5e-4) == Approx(1e-5));     // at 4 kHz

  Bur bladed{0, 2.0, 10.0};  // only the blades vibrate, while it cuts
  bladed.blades = 8;
  Spun cutting(bladed);
  ContactSnapshot contacts;
  contacts.count = 1;
  contacts.contacts[0].part = 0;
  cutting.drill.vibrate(cutting.pose, 1e-3, contacts);
  CHECK(contacts.contacts[0].gap == 0.0);
  cutting.press(20.0, 1.0);
  REQUIRE(cutting.drill.feed() > 0.0);
  double most = 0.0, feed = 0.0;
  for (int i = 0; i < 200; ++i) {
    cutting.press(20.0, 1e-3);
    feed = std::max(feed, cutting.drill.feed());
    contacts.contacts[0].gap = 0.0;
    cutting.drill.vibrate(cutting.pose, 1e-3, contacts);
    most = std::max(most, std::abs(contacts.contacts[0].gap));
  }
  CHECK(most == Approx(0.5 * feed / 80.0).epsilon(0.1));
}

namespace {

// Return the largest amplitude of a head on its shaft, in chips, in the last tenth of many passes of a blade. A blade
// cuts the chip of a pass and the waves that earlier blades left; a chip of a pass holds the shaft at rest. `share`:
// force over chip by the limit. `pass`: time between two blades by the period of the shaft.
double swingOf(double share, double damping, double pass) {
  constexpr int kSteps = 400, kPasses = 3000;  // of a pass
  const double rate = 2.0 * M_PI, step = pass / kSteps, give = share * 2.0 * damping * (1.0 + damping);
  std::vector<double> surface(kSteps, 0.0);
  double swing = 1e-3, speed = 0.0, most = 0.0;
  for (int i = 0; i < kSteps * kPasses; ++i) {
    double& left = surface[static_cast<std::size_t>(i % kSteps)];
    const double chip = std::max(0.0, left + 1.0 - swing);
    speed += step * (rate * rate * (give * (chip - 1.0) - swing) - 2.0 * damping * rate * speed);
    swing += step * speed;
    left = std::min(left + 1.0, swing);
    if (i > kSteps * kPasses / 10 * 9) most = std::max(most, std::abs(swing));
  }
  return most;
}

double largestSwing(double share, double damping) {
  double most = 0.0;
  for (double pass = 0.55; pass < 1.0; pass += 0.025) most = std::max(most, swingOf(share, damping, pass));
  return most;
}

// A slow bur with 8 blades that chatters at a share of the limit under a force. The chips of a stiff one say where that
// is.
Bur chattering(double share, double force) {
  Bur bur{0, 0.5, 50.0};
  bur.blades = 8;
  Spun stiff(bur);
  stiff.press(force, 0.3);
  bur.shaftFrequency = 100.0;
  const double chip = stiff.drill.feed() / (bur.turns * bur.blades);
  bur.shaftCompliance = share * 2.0 * bur.shaftDamping * (1.0 + bur.shaftDamping) * chip / force;
  return bur;
}

}  // namespace

TEST_CASE("drill: the limit of chatter and its amplitude are those of a head that cuts its own waves", "[drill]") {
  for (const double damping : {0.02, 0.05, 0.1}) {
    INFO("damping " << damping);
    CHECK(largestSwing(0.9, damping) < 1e-4);
    const double swing = largestSwing(1.1, damping);  // the blades just leave the surface: 1 / sqrt(2)
    CHECK(swing > 0.5);
    CHECK(swing < 1.2);
  }
  constexpr double kForce = 10.0;
  for (const double share : {0.5, 2.0}) {
    const Bur bur = chattering(share, kForce);
    Spun spun(bur);
    spun.press(kForce, 1.0);
    const double chip = spun.drill.feed() / (bur.turns * bur.blades);
    REQUIRE(chip > 0.0);
    INFO("share " << share << " of the limit: " << spun.drill.chatter() << " m, chip " << chip);
    if (share < 1.0) {
      CHECK(spun.drill.chatter() < 1e-3 * chip);  // what began before the feed was known decays
    } else {
      CHECK(spun.drill.chatter() == Approx(chip / std::sqrt(2.0)));
      spun.press(0.0, 1e-3);
      CHECK(spun.drill.chatter() == 0.0);
    }
  }
}

TEST_CASE("drill: the motor pays for the chatter, which takes at most what the cut takes", "[drill]") {
  test::Random random(57);
  int chatters = 0;
  for (int i = 0; i < 40; ++i) {
    Bur bur{0, std::pow(10.0, random.uniform(-1.0, 1.0)), std::pow(10.0, random.uniform(0.5, 3.0))};
    bur.blades = 1 + static_cast<int>(random.uniform(0.0, 12.0));
    bur.drag = random.uniform(0.0, 1.0);
    bur.shaftCompliance = std::pow(10.0, random.uniform(-8.0, -4.0));
    bur.shaftFrequency = std::pow(10.0, random.uniform(1.0, 5.0));
    bur.shaftDamping = random.uniform(0.0, 0.5);
    Spun spun(bur);
    const double force = random.uniform(0.5, 5.0);
    for (int k = 0; k < 50; ++k) {
      spun.press(force, 1e-3);
      const double a = spun.drill.chatter(), rate = 2.0 * M_PI * bur.shaftFrequency,
                   lost = bur.shaftDamping * rate / bur.shaftCompliance * a * a / (2.0 * M_PI * spun.drill.turns()),
                   cut = spun.drill.load() - lost;
      chatters += a > 0.0;
      REQUIRE(a >= 0.0);
      CHECK(a <= std::max(0.0, spun.drill.feed()) / (bur.turns * bur.blades) / std::sqrt(2.0) * (1.0 + 1e-12));
      CHECK(cut <= bur.drag * force * kRadius * (1.0 + 1e-9));
      CHECK(lost <= cut * (1.0 + 1e-9));
    }
  }
  CHECK(chatters > 200);
}

TEST_CASE("drill: ticks render the chatter that they can sample", "[drill]") {
  Bur bur = chattering(2.0, 10.0);
  for (const double frequency : {100.0, 170.0, 300.0}) {
    bur.shaftFrequency = frequency;
    Spun spun(bur);
    spun.press(10.0, 0.5);
    double most = 0.0, speed = 0.0, chatter = 0.0;
    for (int i = 0; i < 200; ++i) {
      spun.press(10.0, 1e-3);
      ContactSnapshot contacts;
      contacts.count = 1;
      contacts.contacts[0].part = 0;
      contacts.contacts[0].normal = Vec3::UnitZ();  // the run-out is 0, and ticks do not sample the blades
      spun.drill.vibrate(spun.pose, 1e-3, contacts);
      most = std::max(most, std::abs(contacts.contacts[0].gap));
      speed = std::max(speed, std::abs(contacts.contacts[0].obstacleVelocity.z()));
      chatter = std::max(chatter, spun.drill.chatter());
    }
    const double share = std::clamp(250.0 / spun.drill.chatterFrequency() - 1.0, 0.0, 1.0);  // from 4 to 8 ticks
    INFO(frequency << " Hz: " << most << " of " << chatter);
    REQUIRE(chatter > 0.0);
    CHECK(spun.drill.chatterFrequency() == Approx(frequency * std::sqrt(1.1)));
    CHECK(most == Approx(share * chatter).epsilon(0.1).margin(1e-15));
    CHECK(speed == Approx(2.0 * M_PI * spun.drill.chatterFrequency() * most).epsilon(0.1).margin(1e-12));
  }
}

TEST_CASE("drill: a vibrating bur that slows down cuts without a fault on every device", "[drill]") {
  Bur bur{0, 0.5, 100.0};
  bur.torque = 2e-3;
  bur.runOut = 1e-5;
  bur.blades = 1;
  bur.shaftCompliance = 1e-5;
  bur.shaftFrequency = 120.0;
  for (const char* file : {"tau-nominal.toml", "delta.toml", "cartesian-3.toml"}) {
    const auto device = makeMechanism(modelFor(kClosedForm, loadDevice(test::deviceFile(file))));
    for (const int delay : {0, 1, 2}) {
      INFO(file << ", delay " << delay);
      PositionControlRenderer servo(positionControlFor(*device, 1e-3, delay, delay));
      const Cut cut = press(servo, *device, delay, 0.0, bur);  // requires that the guard has no fault
      CHECK(cut.force == Approx(2.0).epsilon(0.05));
      CHECK(cut.volume == Approx((1.0 - 2.0 * bur.drag * kRadius / bur.torque) * cut.expected).epsilon(0.1));
    }
  }
}

TEST_CASE("drill: wrong numbers of a motor are refused", "[drill]") {
  const auto refusal = [](const std::function<void(Bur&)>& change) {
    Bur bur;
    change(bur);
    try {
      const Drill drill(ball(), {tooth()}, bur);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  CHECK(refusal([](Bur&) {}) == "accepted");
  CHECK(refusal([](Bur& b) { b.torque = 0.0; }) == "the torque of the bur is 0 N m, must be above 0");
  CHECK_THAT(refusal([](Bur& b) { b.inertia = std::nan(""); }),
             test::ContainsSubstring("the inertia of the bur is nan"));
  CHECK_THAT(refusal([](Bur& b) { b.drag = -1.0; }), test::ContainsSubstring("must be in 0 to 10"));
  CHECK_THAT(refusal([](Bur& b) { b.runOut = 1e-3; }),
             test::ContainsSubstring("the run_out of the bur is 0.001 m, must be in 0 to 1e-04"));
  CHECK_THAT(refusal([](Bur& b) { b.blades = -1; }), test::ContainsSubstring("the number of blades of the bur is -1"));
}

}  // namespace enamel::test_drill
