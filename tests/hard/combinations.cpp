// Combinations of the features that a tooth is felt by, on three devices at delays of 0 to 2 ticks: a hand taps,
// presses, slides in a circle, and holds. Each pair of two features' settings occurs in the short run; ENAMEL_LONG=1
// adds random combinations of all.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "enamel/render/drill.hpp"
#include "support/bench.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_combinations {

namespace {

using test::Bench, test::kTick;

// The settings of a run, and their number.
enum Factor { kDevice, kDelay, kTap, kLayer, kSupport, kSurface, kBur, kGuides, kHand, kFactors };
constexpr std::array<int, kFactors> kSettings{3, 3, 3, 4, 4, 3, 4, 3, 3};
using Combination = std::array<int, kFactors>;

constexpr double kRadius = 0.5e-3;                       // of the bur, m
const Vec3 kHalf{8e-3, 8e-3, 3e-3};                      // of the block, m; its upper face is z = 0
constexpr double kSlide = 0.3, kHold = 1.0, kEnd = 1.3;  // s, when these begin

const char* const kTaps[] = {"", "enamel", "plastic"};

Material materialOf(const Combination& c, double force) {
  Material m;
  if (c[kLayer] == 1) m = {500.0, 0.0, 0.0, 0.0, 1.5, 2e-3, 3.0};
  if (c[kLayer] == 2) m = {4e3, 0.0, 0.0, 0.0, 1.5, 1e-3, 2.0, 0.7 * force};
  if (c[kLayer] == 3) m = {1e5, 0.0, 0.0, 0.0, 1.0, 1e-4, 0.0};
  if (c[kSurface] > 0) {
    m.friction = 0.2;
    m.slidingFriction = c[kSurface] == 1 ? 0.2 : 0.1;
    m.stribeck = c[kSurface] == 1 ? 0.0 : 5e-3;
    m.roughness = c[kSurface] == 1 ? 6e-6 : 1e-5;
    m.wavelength = c[kSurface] == 1 ? 3e-4 : 1e-3;
  }
  return m;
}

std::shared_ptr<const Suspension> supportOf(const Combination& c) {
  if (c[kSupport] == 0) return nullptr;
  Suspension s;
  const auto all = [](double linear, double angular) {
    Vec6 v;
    v << linear, linear, linear, angular, angular, angular;
    return v;
  };
  if (c[kSupport] == 1) {  // the tooth of data/scenes/mobile-molar.toml
    s.inertia = all(2e-3, 6e-8);
    s.stiffness = all(9.8e4, 14.0);
  } else if (c[kSupport] == 2) {  // a loose tooth
    s.inertia = all(2e-3, 6e-8);
    s.stiffness = all(5e3, 1.0);
  } else {  // a jaw
    s.inertia = all(0.3, 0.0);
    s.stiffness = all(5e3, 0.0);
  }
  s.damping = 2.0 * 0.3 * s.inertia.cwiseProduct(s.stiffness).cwiseSqrt();
  s.centre = {0.0, 0.0, kHalf.z()};
  return std::make_shared<const Suspension>(s);
}

Bur burOf(const Combination& c) {
  Bur bur{0, 0.05, 2000.0};
  bur.torque = 1.5e-3;
  if (c[kBur] == 2) {  // a slow handpiece that vibrates
    bur.turns = 100.0;
    bur.wear = 1.0;
    bur.torque = 2e-3;
    bur.runOut = 1e-5;
    bur.blades = 6;
    bur.shaftCompliance = 1e-5;  // it chatters
    bur.shaftFrequency = 120.0;
  }
  return bur;
}

// Guides that the tool meets while it slides: a plane and a wall across the surface, and one that presses on it.
std::vector<Guide> guidesOf(const Combination& c, double force) {
  if (c[kGuides] == 0) return {};
  Pose below;
  below.position.z() = -0.02;
  if (c[kGuides] == 2) return {{Plane{}, below, 1e3, 0.3 * force}};
  return {{Plane{}, {Vec3::Zero(), frameAlong(Vec3::UnitY())}, 1e4, 0.3 * force},
          {HalfSpace{}, {{-1e-3, 0.0, 0.0}, frameAlong(Vec3::UnitX())}, 1e4, 0.3 * force}};
}

// Energy of the guides' springs with the tool at a place, J.
double storedIn(const std::vector<Guide>& guides, double stiffness, const Vec3& place) {
  double sum = 0.0;
  for (const Guide& guide : guides) {
    const double k = std::min(guide.stiffness, stiffness), e = errorOf(guide, place, Vec3::Zero()).offset.norm(),
                 knee = guide.maxForce / k;
    sum += e < knee ? 0.5 * k * e * e : guide.maxForce * (e - 0.5 * knee);
  }
  return sum;
}

struct Outcome {
  GuardReason fault = GuardReason::none;
  double given = 0.0;    // largest energy that the motors had given to the tool without that of the guides, J
  double change = 0.0;   // mean change of the force in a tick while the hand holds, N
  double removed = 0.0;  // m^3
};

Outcome run(const Combination& c) {
  const test::BenchDevice& device = test::kBenchDevices[c[kDevice]];
  Bench::Setting setting;
  setting.device = device.file;
  setting.plant = device.plant;
  setting.delay = c[kDelay];
  setting.encoders = true;
  setting.tool.parts[0] = {{0.0, 0.0, kRadius}, {0.0, 0.0, kRadius}, kRadius};
  setting.guides = guidesOf(c, device.force);
  if (c[kHand] == 2) setting.handpiece.mass = 0.05;
  Obstacle& block = setting.obstacle;
  block.name = "block";
  block.pose.position.z() = -kHalf.z();
  block.material = materialOf(c, device.force);
  const Tap tap = c[kTap] > 0 ? tapOf(kTaps[c[kTap]]) : Tap{};
  block.suspension = supportOf(c);
  std::shared_ptr<Solid> solid;
  if (c[kBur] > 0) {
    solid = std::make_shared<Solid>(MeshModel(test::boxMesh(kHalf)),
                                    std::vector<SolidLayer>{{"enamel", block.material, 3.4e9, 0.0, nullptr, tap}},
                                    SolidOptions{2e-4});
    block.shape = std::shared_ptr<const Solid>(solid);
  } else {
    block.shape = Box{kHalf};
    block.tap = tap;
  }
  Bench bench(setting);
  std::optional<Drill> drill;
  if (solid) {
    drill.emplace(setting.tool, std::vector<std::shared_ptr<Solid>>{solid}, burOf(c));
    drill->spin(c[kBur] < 3);  // 3: a solid, and a bur at rest
    bench.haptics->attach(&*drill);
  }
  const double stiffness = bench.haptics->guidance().largestStiffness();

  Outcome result;
  double work = 0.0, vibration = 0.0, before = 0.0;  // vibration: most that the bur may give, J
  std::optional<Pose> rest;                          // of the finger: it rests on a tooth while the tool slides
  for (int i = 0; i < static_cast<int>(kEnd / kTick); ++i) {
    const Pose was = bench.tool().pose();
    if (c[kHand] > 0 && i == static_cast<int>(kSlide / kTick)) rest = was;
    if (drill && i == static_cast<int>(kHold / kTick)) drill->spin(false);
    const auto hand = [&](double time, const Pose& pose, const Vec6& twist) {
      constexpr double kReach = 2e-3, kRate = 2.0 * M_PI / (kHold - kSlide);  // a circle at up to 18 mm/s
      const double angle = kRate * std::clamp(time - kSlide, 0.0, kHold - kSlide);
      const bool slides = time > kSlide && time < kHold;
      const Vec3 target(kReach * std::sin(angle), kReach * (1.0 - std::cos(angle)), 0.0),
          rate = slides ? Vec3(kRate * kReach * Vec3(std::cos(angle), std::sin(angle), 0.0)) : Vec3(Vec3::Zero());
      Vec6 wrench;
      wrench.head<3>() = 2000.0 * (target - pose.position) + 10.0 * (rate - twist.head<3>());
      const double push = time < 0.05 ? 0.3 : time < kHold ? device.force : 0.5 * device.force;
      wrench[2] = -push - 3.0 * twist[2];
      wrench.tail<3>() = holdingMoment(pose.rotation, bench.setup.start.rotation, twist.tail<3>());
      if (rest) {
        const Vec3 arm = pose.rotation * kFingerRest.point,
                   way = pose.position + arm - rest->position - rest->rotation * kFingerRest.point;
        const Vec3 force = -kFingerRest.grip.stiffness * way - kFingerRest.grip.damping * translationAt(twist, arm);
        wrench.head<3>() += force;
        wrench.tail<3>() += arm.cross(force);
      }
      return wrench;
    };
    bench.loop->step();
    const Kinematics& k = bench.virtualDevice->kinematics();
    const Vec6 acting = wrenchOf(k, bench.virtualDevice->torque() - k.gravity);
    REQUIRE(bench.virtualDevice->advance(hand) == Status::ok);
    result.fault = bench.haptics->guard().fault();
    if (result.fault != GuardReason::none) return result;
    const Pose now = bench.tool().pose();
    work += acting.head<3>().dot(now.position - was.position) +
            acting.tail<3>().dot(rotationVector(now.rotation * was.rotation.transpose()));
    if (drill) {
      result.removed += drill->removed()[0];
      // A head that vibrates is a surface that moves: it may give its speed times the force.
      const ContactSnapshot& contacts = bench.haptics->frame().contacts;
      if (c[kBur] == 2 && drill->turns() > 0.0 && contacts.count > 0)
        vibration += kTick * acting.head<3>().norm() * contacts.contacts[0].obstacleVelocity.norm();
    }
    result.given =
        std::max(result.given, work - vibration - storedIn(setting.guides, stiffness, bench.setup.start.position) +
                                   storedIn(setting.guides, stiffness, now.position));
    const double force = bench.force();
    if (i >= static_cast<int>(kEnd / kTick) - 200) result.change += std::abs(force - before) / 200.0;
    before = force;
  }
  return result;
}

void check(const Combination& c, bool judgesChange = true) {
  static std::map<std::pair<int, int>, double> rigid;  // change of the force on a rigid smooth wall
  const auto [place, isNew] = rigid.try_emplace({c[kDevice], c[kDelay]}, 0.0);
  if (isNew) {
    Combination plain{};
    plain[kDevice] = c[kDevice];
    plain[kDelay] = c[kDelay];
    place->second = run(plain).change;
  }
  // An unstable loop swings between zero and the force that it holds, of the hand and of a guide that presses.
  const double held = (c[kGuides] == 2 ? 0.8 : 0.5) * test::kBenchDevices[c[kDevice]].force;
  const Outcome result = run(c);
  INFO(test::kBenchDevices[c[kDevice]].file << ", delay " << c[kDelay] << ", tap " << kTaps[c[kTap]] << ", layer "
                                            << c[kLayer] << ", support " << c[kSupport] << ", surface " << c[kSurface]
                                            << ", bur " << c[kBur] << ", guides " << c[kGuides] << ", hand " << c[kHand]
                                            << ": " << result.given << " J, " << result.change << " N a tick");
  CHECK(result.fault == GuardReason::none);
  CHECK(result.given < 1e-3);  // as for one rough surface
  if (judgesChange) CHECK(result.change <= std::max(1.5 * place->second, held));
  if (c[kBur] > 0 && c[kSupport] == 0) CHECK((result.removed > 0.0) == (c[kBur] < 3));
}

// Combinations that contain each pair of two factors' settings: each row takes, factor by factor, the setting with the
// most pairs that are new.
std::vector<Combination> pairwise() {
  std::map<std::array<int, 4>, bool> isNew;
  for (int a = 0; a < kFactors; ++a)
    for (int b = 0; b < a; ++b)
      for (int x = 0; x < kSettings[a]; ++x)
        for (int y = 0; y < kSettings[b]; ++y) isNew[{a, x, b, y}] = true;
  std::vector<Combination> rows;
  test::Random random(5781);
  std::size_t left = isNew.size();
  while (left > 0) {
    Combination best{};
    int most = 0;
    for (int attempt = 0; attempt < 50; ++attempt) {
      Combination row{};
      int sum = 0;
      for (int a = 0; a < kFactors; ++a) {
        int highest = -1;
        const int first = static_cast<int>(random.uniform(0.0, kSettings[a]));
        for (int i = 0; i < kSettings[a]; ++i) {
          const int x = (first + i) % kSettings[a];
          int pairs = 0;
          for (int b = 0; b < a; ++b) pairs += isNew.at({a, x, b, row[b]});
          if (pairs > highest) highest = pairs, row[a] = x;
        }
        sum += highest;
      }
      if (sum > most) most = sum, best = row;
    }
    for (int a = 0; a < kFactors; ++a)
      for (int b = 0; b < a; ++b) {
        bool& pair = isNew.at({a, best[a], b, best[b]});
        left -= pair;
        pair = false;
      }
    rows.push_back(best);
  }
  return rows;
}

}  // namespace

TEST_CASE("combinations: each pair of features is stable and passive on every device and delay", "[combinations]") {
  for (const Combination& c : pairwise()) check(c);
}

TEST_CASE("combinations: some that needed a repair", "[combinations]") {
  check({0, 1, 0, 0, 2, 0, 1, 0, 2});  // a bur that came fast was taken for one that cuts fast
  check({0, 1, 1, 0, 2, 0, 1, 2, 0});  // a contact that vanished did not give way as the loose tooth did
  check({0, 1, 2, 1, 3, 1, 1, 2, 0});  // a bur sank into a layer while it cut
  check({2, 0, 0, 2, 1, 0, 2, 2, 1});  // it pierced the layer, and cut the ground away under itself
  check({1, 1, 1, 1, 2, 0, 1, 1, 0});  // a new contact forgot how deep a layer was pressed
  check({0, 0, 0, 2, 0, 2, 2, 0, 0});  // a god object on the surface said where the ground of a broken layer was
  check({0, 1, 0, 1, 2, 0, 2, 2, 1});  // a loose tooth swung in the groove of the bur
  check({1, 0, 2, 2, 0, 2, 2, 0, 2});  // a contact that vanished went on with the speed that a tap gave it
}

TEST_CASE("combinations: random ones", "[combinations]") {
  if (!test::longRun()) return;
  test::Random random(5782 + test::seed());
  for (int i = 0; i < 3000; ++i) {
    Combination c;
    for (int a = 0; a < kFactors; ++a) c[a] = static_cast<int>(random.uniform(0.0, kSettings[a]));
    check(c, c[kDevice] != 1 || c[kDelay] != 0);  // else a plain wall swings too: lib/docs/stability.md
  }
}

}  // namespace enamel::test_combinations
