// Compliant layers: the law of a material, its series with a wall, and ticks in which a tool presses on one.
#include "enamel/render/compliance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "enamel/render/drill.hpp"
#include "plugin/convert.hpp"
#include "support/bench.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_compliance {

namespace {

using test::Bench, test::kTick;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Material layer(double stiffness, double exponent, double thickness, double hysteresis = 0.0,
               double puncture = kInfinity) {
  Material m;
  m.stiffness = stiffness;
  m.exponent = exponent;
  m.thickness = thickness;
  m.hysteresis = hysteresis;
  m.puncture = puncture;
  return m;
}

// A block of 40 x 40 x 20 mm with its upper face at z = 0.
Obstacle block(const Material& material) {
  Obstacle obstacle;
  obstacle.name = "block";
  obstacle.shape = Box{{0.02, 0.02, 0.01}};
  obstacle.pose.position = {0.0, 0.0, -0.01};
  obstacle.material = material;
  return obstacle;
}

double elasticForce(const Material& m, double x) { return forceOf(m, x, x, kTick).force; }

// Means over the last 200 ticks of a press: height of the tool, m, and force of the renderer, N.
struct Rest {
  double height = 0.0, force = 0.0;
};
Rest restUnder(Bench& bench, double push, int ticks) {
  Rest rest;
  for (int i = 0; i < ticks; ++i) {
    REQUIRE(bench.press(push));
    if (i < ticks - 200) continue;
    rest.height += bench.tool().position.z() / 200.0;
    rest.force += bench.force() / 200.0;
  }
  return rest;
}

Material anyLayer(test::Random& random) {
  const auto any = [&](double low, double high) { return std::pow(10.0, random.uniform(low, high)); };
  return layer(any(0, 9), random.uniform(0.0, 1.0) < 0.2 ? 1.0 : random.uniform(1.0, 5.0),
               random.uniform(0.0, 1.0) < 0.3 ? kInfinity : any(-4, -2),
               random.uniform(0.0, 1.0) < 0.3 ? 0.0 : any(-2, 2));
}

// A renderer that sees the contacts as a plugin does.
class AsPlugin final : public Renderer {
 public:
  explicit AsPlugin(Renderer& inner) : inner_(inner) {}

 private:
  void prepare(double period) override { inner_.activate(period); }
  Status render(const TickFrame& frame, TickOutput& output) noexcept override {
    EnamelTickInput plain{};
    toPlain(frame, plain);
    TickFrame seen;
    fromPlain(plain, false, seen);
    return inner_.step(seen, output);
  }
  void resetState() noexcept override { inner_.reset(); }
  StateBlock stateBlock() noexcept override { return {nullptr, 0}; }

  Renderer& inner_;
};

}  // namespace

TEST_CASE("compliance: the stiffness of a material is that at 1 mm", "[compliance]") {
  for (const double exponent : {1.0, 1.5, 3.0}) {
    CHECK(elasticForce(layer(700.0, exponent, kInfinity), 1e-3) == Approx(0.7).epsilon(1e-14));
    CHECK(elasticForce(layer(700.0, exponent, 2e-3), 1e-3) == Approx(1.4).epsilon(1e-14));  // 1 / (1 - 1/2)
    CHECK(elasticForce(layer(700.0, exponent, kInfinity), 2e-3) ==
          Approx(0.7 * std::pow(2.0, exponent)).epsilon(1e-14));
  }
  // Loading at 0.1 m/s with 3 s/m adds 30 %; unloading at more than 1/3 m/s leaves no force, and none pulls.
  const Material damped = layer(700.0, 1.0, kInfinity, 3.0);
  CHECK(forceOf(damped, 1e-3, 0.9e-3, kTick).force == Approx(0.7 * 1.3).epsilon(1e-12));
  CHECK(forceOf(damped, 1e-3, 1.5e-3, kTick).force == 0.0);
  CHECK(forceOf(damped, 1e-3, kNotCompressed, kTick).force == forceOf(damped, 1e-3, 1e-3, kTick).force);
}

TEST_CASE("compliance: the force rises, and its slope is the derivative", "[compliance]") {
  test::Random random(572);
  for (int i = 0; i < 5000; ++i) {
    const Material m = anyLayer(random);
    const double most = std::min(m.thickness, 5e-3), x = most * random.uniform(0.01, 0.98),
                 before = most * random.uniform(0.0, 0.98), step = 1e-6 * std::min(x, most - x);
    const auto [force, slope] = forceOf(m, x, before, kTick);
    const double low = forceOf(m, x - step, before, kTick).force, high = forceOf(m, x + step, before, kTick).force;
    CHECK(low <= force);
    CHECK(force <= high);
    if (low > 0.0)  // rounding 1e-16 over the step, and its third derivative
      CHECK(std::abs((high - low) / (2.0 * step) - slope) <= 1e-6 * slope);
  }
}

TEST_CASE("compliance: a material in series with a spring carries the same force, and is never stiffer",
          "[compliance]") {
  test::Random random(573);
  for (int i = 0; i < 5000; ++i) {
    const Material m = anyLayer(random);
    const double soft = std::pow(10.0, random.uniform(-7.0, -2.0)), depth = std::pow(10.0, random.uniform(-9.0, -2.0)),
                 before = std::min(depth, 0.99 * m.thickness) * random.uniform(0.0, 1.0);
    const auto forceAt = [&](double d) { return (d - compressionInSeries(m, d, soft, before, kTick)) / soft; };
    const double x = compressionInSeries(m, depth, soft, before, kTick), force = forceOf(m, x, before, kTick).force;
    CHECK(x >= 0.0);
    CHECK(x < m.thickness);
    CHECK(compressionInSeries(m, depth, 0.0, before, kTick) == std::min(depth, m.thickness));
    // The search ends at 1e-13 of x; the slope amplifies it, relative to the force, by exponent and bottoming.
    const double spread = 1e-12 * (depth + x * soft * forceOf(m, x, before, kTick).slope);
    CHECK(std::abs(x + soft * force - depth) <= spread);
    const double more = 1.01 * depth;
    CHECK(forceAt(more) - forceAt(depth) >= -1e-11 * depth / soft);
    CHECK(forceAt(more) - forceAt(depth) <= (more - depth) / soft + 1e-11 * depth / soft);
    const double found = compressionUnder(m, force, before, kTick);
    CHECK(std::abs(forceOf(m, found, before, kTick).force - force) <= 1e-9 * force + spread / soft);
  }
}

TEST_CASE("compliance: no cycle gives energy, alone or in series with a spring", "[compliance]") {
  test::Random random(574);
  for (int run = 0; run < 300; ++run) {
    const Material m = anyLayer(random);
    const double soft = run % 2 == 0 ? 0.0 : std::pow(10.0, random.uniform(-6.0, -3.0)),
                 most = std::min(0.9 * m.thickness, 3e-3);
    const double jump = random.uniform(0.0, 1.0);  // from slow motions to jumps over the whole depth
    double depth = 0.0, x = 0.0, work = 0.0, size = 0.0;
    for (int i = 0; i <= 200; ++i) {
      const double last = depth, before = x;
      depth = i == 200 ? 0.0 : std::clamp(depth + jump * most * random.uniform(-1.0, 1.0), 0.0, most);
      x = soft > 0.0 ? compressionInSeries(m, depth, soft, before, kTick) : depth;
      const double force = soft > 0.0 ? (depth - x) / soft : forceOf(m, x, before, kTick).force;
      work += force * (depth - last);  // of the hand
      size += force * std::abs(depth - last);
    }
    CHECK(work >= -1e-12 * size);  // rounding
    if (m.hysteresis > 1.0 && jump > 0.3) CHECK(work > 0.01 * size);
  }
}

TEST_CASE("compliance: infinite stiffness is the rigid wall", "[compliance]") {
  // At 1e60 N/m and 1 mm a force of 1 kN compresses a material of exponent 3 by 1e-22 m.
  for (const bool spring : {false, true})
    for (const int delay : {0, 2})
      for (const double exponent : {1.0, 1.5, 3.0}) {
        Material rigid, stiff = layer(1e60, exponent, 1e-3, 2.0);
        rigid.friction = rigid.slidingFriction = stiff.friction = stiff.slidingFriction = 0.2;
        Bench at({"tau-nominal.toml", kClosedForm, block(rigid), delay, spring, true});
        Bench on({"tau-nominal.toml", kClosedForm, block(stiff), delay, spring, true});
        double largest = 0.0;
        for (int i = 0; i < 400; ++i) {
          REQUIRE(at.press(6.0));
          REQUIRE(on.press(6.0));
          const JointVector& command = at.haptics->frame().command;
          REQUIRE((on.haptics->frame().command - command).norm() <= 1e-12 * command.norm());
          largest = std::max(largest, at.force());
        }
        CHECK(largest > 3.0);
      }
}

TEST_CASE("compliance: the force at a depth is that of the law within 1 %", "[compliance]") {
  for (const auto& [spring, delay] : {std::pair(false, 0), {false, 1}, {false, 2}, {true, 0}})
    for (const double stiffness : {500.0, 2e3, 1e4, 1e5})
      for (const double exponent : {1.0, 1.5, 3.0})
        for (const double thickness : {2e-3, kInfinity}) {
          const Material m = layer(stiffness, exponent, thickness, 1.0);
          Bench bench({"tau-nominal.toml", kClosedForm, block(m), delay, spring});
          const auto [height, force] = restUnder(bench, 5.0, 900);
          INFO("delay " << delay << (spring ? ", spring, " : ", ") << stiffness << " N/m, exponent " << exponent
                        << ", thickness " << thickness << " m");
          CHECK(force == Approx(5.0).epsilon(0.01));
          CHECK(elasticForce(m, -height - (spring ? force / 1500.0 : 0.0)) == Approx(force).epsilon(0.01));
        }
}

TEST_CASE("compliance: a shallow valley is as stiff as a plane", "[compliance]") {
  // Two faces that rise by 1 : 5. A ball in the valley has a contact with each; without sharing it would be twice as
  // stiff. With it, the vertical force is 2 cos a / (1 + cos 2a) F(x cos a) = F(x cos a) / cos a, for a = 11 deg.
  constexpr double a = 0.02, deep = 0.01, kRadius = 3e-3;  // m
  TriangleMesh valley;
  for (const double y : {-a, a}) {
    valley.vertices.insert(valley.vertices.end(), {{-a, y, 0.2 * a}, {0.0, y, 0.0}, {a, y, 0.2 * a}});
    valley.vertices.insert(valley.vertices.end(), {{a, y, -deep}, {-a, y, -deep}});
  }
  valley.triangles = {{0, 1, 5}, {1, 6, 5}, {1, 2, 6}, {2, 7, 6}, {2, 3, 7}, {3, 8, 7}, {3, 4, 8}, {4, 9, 8},
                      {4, 0, 9}, {0, 5, 9}, {0, 4, 1}, {1, 4, 3}, {1, 3, 2}, {5, 6, 9}, {6, 8, 9}, {6, 7, 8}};
  for (const double exponent : {1.0, 1.5, 3.0}) {
    const Material m = layer(2e3, exponent, 2e-3, 1.0);
    Bench::Setting setting{"tau-nominal.toml", kClosedForm, block(m)};
    setting.obstacle.shape = std::make_shared<const MeshModel>(valley);
    setting.obstacle.pose.position.setZero();
    setting.tool.parts[0] = {{0.0, 0.0, kRadius}, {0.0, 0.0, kRadius}, kRadius};
    Bench bench(setting);
    const auto [height, force] = restUnder(bench, 5.0, 900);
    CHECK(bench.haptics->frame().contacts.count == 2);
    CHECK(force == Approx(5.0).epsilon(0.01));
    const double touch = kRadius * (std::sqrt(1.04) - 1.0);  // height of the ball that touches both faces
    const double cosine = 1.0 / std::sqrt(1.04);
    CHECK(elasticForce(m, (touch - height) * cosine) / cosine == Approx(force).epsilon(0.01));
  }
}

TEST_CASE("compliance: a plugin sees the stiffness that the layer has under its force", "[compliance]") {
  for (const double stiffness : {500.0, 2e3, 1e5})
    for (const double exponent : {1.0, 1.5, 3.0}) {
      const Material m = layer(stiffness, exponent, 2e-3, 1.0);
      Bench bench({"tau-nominal.toml", kClosedForm, block(m), 0, true});
      ImpedanceRenderer spring({1500.0, 2.0});
      AsPlugin plugin(spring);
      plugin.activate(kTick);
      bench.haptics->select(plugin);
      const auto [height, force] = restUnder(bench, 5.0, 1500);
      INFO(stiffness << " N/m, exponent " << exponent);
      CHECK(force == Approx(5.0).epsilon(0.01));
      CHECK(elasticForce(m, -height - force / 1500.0) == Approx(force).epsilon(0.01));
    }
}

TEST_CASE("compliance: two contacts share a load by the law", "[compliance]") {
  // A capsule lies on the block: two contacts, each with half of the force.
  for (const double exponent : {1.0, 1.5, 3.0})
    for (const double stiffness : {1e3, 1e5})
      for (const bool spring : {false, true}) {
        const Material m = layer(stiffness, exponent, 2e-3, 1.0);
        Bench::Setting lying{"tau-nominal.toml", kClosedForm, block(m), 0, spring};
        lying.tool.parts[0] = {{-3e-3, 0.0, 1e-3}, {3e-3, 0.0, 1e-3}, 1e-3};
        Bench bench(lying);
        const auto [height, force] = restUnder(bench, 5.0, 900);
        INFO((spring ? "spring, " : "") << stiffness << " N/m, exponent " << exponent);
        CHECK(bench.haptics->frame().contacts.count == 2);
        CHECK(force == Approx(5.0).epsilon(0.01));
        CHECK(2.0 * elasticForce(m, -height - (spring ? 0.5 * force / 1500.0 : 0.0)) == Approx(force).epsilon(0.01));
      }
}

TEST_CASE("compliance: the tool has no more energy than the hand has given", "[compliance]") {
  for (const int delay : {0, 1, 2})
    for (const double stiffness : {500.0, 2e3, 1e4, 1e5})
      for (const double exponent : {1.0, 1.5, 3.0})
        for (const double puncture : {kInfinity, 1.0}) {
          Bench bench({"cartesian-3.toml", kClosedForm, block(layer(stiffness, exponent, 2e-3, 1.0, puncture)), delay});
          const double toolMass = 0.045;  // of the device file
          double work = 0.0, largest = 0.0;
          for (int i = 0; i < 800; ++i) {
            const double z = bench.tool().position.z(), push = i < 400   ? -0.8 - 0.7 * std::sin(0.2 * i)
                                                               : i < 500 ? -1.5
                                                               : i < 550 ? 0.0
                                                                         : -0.3;
            REQUIRE(bench.step([&](double, const Pose&, const Vec6&) { return Vec3(0.0, 0.0, push); }));
            work += push * (bench.tool().position.z() - z);
            const double energy = 0.5 * toolMass * std::pow(bench.tool().twist[2], 2);
            REQUIRE(energy <= work + 1e-12);  // rounding: energies are up to 10 mJ
            largest = std::max(largest, energy);
          }
          CHECK(largest > 1e-5);
        }
}

TEST_CASE("compliance: a layer breaks at its puncture force, and holds again after the tool has left", "[compliance]") {
  for (const bool spring : {false, true})
    for (const int delay : {0, 1, 2}) {
      if (spring && delay > 0) continue;  // without damping it swings
      const Material m = layer(1e3, 1.5, 1.5e-3, 0.5, 3.0);
      Bench bench({"tau-nominal.toml", kClosedForm, block(m), delay, spring, false, {0.0, 0.0, 5e-5}});
      const auto run = [&](double push, int ticks, const auto& check) {
        for (int i = 0; i < ticks; ++i) {
          REQUIRE(bench.press(push));
          check();
        }
      };
      const auto isPunctured = [&] {
        const ContactSnapshot& contacts = bench.haptics->frame().contacts;
        return contacts.count > 0 && contacts.contacts[0].isPunctured;
      };
      const auto atLayer = [&] {
        REQUIRE(!isPunctured());
        REQUIRE(bench.haptics->frame().output.normalForce <= 3.0);
      };
      INFO((spring ? "spring, " : "") << "delay " << delay);
      run(1.0, 400, atLayer);  // a step of 1 N swings to 2 N
      CHECK(bench.force() == Approx(1.0).epsilon(0.05));
      CHECK(bench.depth() < 1.5e-3);
      // Pressed harder, the tool falls to the ground and rests there. Only the spring, 2 mm deep, holds it on the way.
      double least = kInfinity;
      run(4.0, 600, [&] { least = std::min(least, isPunctured() ? bench.force() : kInfinity); });
      CHECK(isPunctured());
      CHECK(least < (spring ? 2.5 : 1e-6));
      CHECK(bench.force() == Approx(4.0).epsilon(0.02));
      CHECK(bench.depth() == Approx(1.5e-3 + (spring ? 4.0 / 1500.0 : 0.0)).margin(spring ? 2e-5 : 5e-6));
      CHECK(bench.haptics->frame().contacts.contacts[0].gap == Approx(1.5e-3 - bench.depth()).margin(2e-6));
      // Within the layer nothing holds it either.
      for (int i = 0; bench.depth() > -2e-5; ++i) {
        REQUIRE(i < 2000);
        run(-0.2, 1, [&] {
          if (!spring && bench.depth() > 0.0 && bench.depth() < 1.4e-3) REQUIRE(std::abs(bench.force()) < 1e-6);
        });
      }
      // Outside, the layer is whole again.
      run(0.2, 1, [] {});
      CHECK(bench.depth() < 0.0);
      run(0.2, 400, atLayer);
      run(1.0, 400, atLayer);
      CHECK(bench.force() == Approx(1.0).epsilon(0.05));
    }
}

namespace {

// A probe of 0.5 mm above a layer with friction that breaks at 1 N.
Bench::Setting probeOver(double friction, const std::string& device, int delay, bool spring) {
  Material m = layer(4e3, 1.5, 1.5e-3, 0.5, 1.0);
  m.friction = m.slidingFriction = friction;
  Bench::Setting setting{device, kClosedForm, block(m), delay, spring, false, {0.0, 0.0, 5e-5}};
  setting.tool.parts[0] = {{0.0, 0.0, 2.5e-4}, {0.0, 0.0, 2.5e-4}, 2.5e-4};
  return setting;
}
// Pressed in by its radius, this ball has 4 kN/m 0.25 mm sqrt(0.25); the walls have the area of 2 d / r such balls.
double gripAt(double depth) { return 2.0 * depth / 2.5e-4 * 4e3 * 2.5e-4 * 0.5; }

// A ball above the middle of a block of 4 mm on the TAU.
Bench::Setting onTooth(const std::shared_ptr<const Solid>& solid, double radius) {
  Bench::Setting setting;
  setting.device = "tau-nominal.toml";
  setting.obstacle.name = "tooth";
  setting.obstacle.shape = solid;
  setting.obstacle.pose.position = {0.0, 0.0, -2e-3};
  setting.start = {0.0, 0.0, 5e-5};
  setting.tool.parts[0] = {{0.0, 0.0, radius}, {0.0, 0.0, radius}, radius};
  return setting;
}

}  // namespace

TEST_CASE("compliance: the walls of a hole hold a probe by their friction", "[compliance]") {
  constexpr double kFriction = 0.3;
  for (const auto& [spring, delay] : {std::pair(false, 0), {false, 1}, {false, 2}, {true, 0}}) {
    INFO((spring ? "spring, " : "") << "delay " << delay);
    Bench bench(probeOver(kFriction, "tau-nominal.toml", delay, spring));
    const auto grip = [&] { return bench.haptics->frame().contacts.contacts[0].grip; };
    for (int i = 0; i < 600; ++i) REQUIRE(bench.press(5.0));  // almost to the ground
    CHECK(grip() == Approx(gripAt(std::min(1.5e-3, bench.depth()))).epsilon(0.01));
    CHECK(bench.depth() > 1.3e-3);
    for (int i = 0; i < 800; ++i) REQUIRE(bench.press(std::max(0.0, 5.0 - 0.01 * i)));  // a spring would throw it out
    double strongest = 0.0, most = 0.0;
    for (double pull = 0.0; pull < 3.0 && bench.tool().twist[2] < 0.01; pull += 1e-3) {  // until it slips out
      REQUIRE(bench.press(-pull));
      if (-bench.force() <= strongest) continue;
      strongest = -bench.force();
      most = kFriction * grip();
    }
    CHECK(strongest > 0.3);
    CHECK(strongest == Approx(most).epsilon(0.02));
    for (int i = 0; bench.depth() > 0.0; ++i) {
      REQUIRE(i < 2000);
      REQUIRE(bench.press(-1.5 * kFriction * gripAt(1.5e-3)));
    }
    REQUIRE(bench.press(0.0));
    CHECK(grip() == 0.0);
  }
}

TEST_CASE("compliance: parts at one place share a layer, a puncture and a hole", "[compliance]") {
  struct Felt {
    double depth, broke, pull;  // m under 0.5 N; N at which the layer breaks, and that pulls the tool out
  };
  const auto feel = [](const Tool& tool, bool spring) {
    Bench::Setting setting = probeOver(0.3, "tau-nominal.toml", 0, spring);
    setting.tool = tool;
    Bench bench(setting);
    Felt felt{};
    const auto isBroken = [&] { return bench.haptics->frame().contacts.contacts[0].isPunctured; };
    for (int i = 0; i < 600; ++i) REQUIRE(bench.press(0.5));
    felt.depth = bench.depth();
    for (felt.broke = 0.5; felt.broke < 6.0 && !isBroken(); felt.broke += 1e-3) REQUIRE(bench.press(felt.broke));
    for (int i = 0; i < 600; ++i) REQUIRE(bench.press(5.0));
    for (int i = 0; i < 800; ++i) REQUIRE(bench.press(std::max(0.0, 5.0 - 0.01 * i)));
    for (double pull = 0.0; pull < 6.0 && bench.tool().twist[2] < 0.01; pull += 1e-3) {
      REQUIRE(bench.press(-pull));
      felt.pull = std::max(felt.pull, -bench.force());
    }
    return felt;
  };
  for (const bool spring : {false, true}) {
    INFO((spring ? "spring" : "position control"));
    Tool one = probeOver(0.3, "tau-nominal.toml", 0, false).tool, three = one, rod = one;
    three.count = 3;
    three.parts[1] = three.parts[2] = three.parts[0];
    rod.count = 2;  // a thinner rod on the ball, which enters the hole behind it
    rod.parts[1] = {{0.0, 0.0, 8e-4}, {0.0, 0.0, 1e-2}, 2e-4};
    const Felt felt = feel(one, spring);
    CHECK(felt.broke == Approx(1.0).epsilon(0.05));
    CHECK(felt.pull > 0.3);
    for (const Tool& tool : {three, rod}) {
      const Felt same = feel(tool, spring);
      if (!spring) CHECK(same.depth == Approx(felt.depth).epsilon(0.01));  // each contact has a spring of its own
      CHECK(same.broke == Approx(felt.broke).epsilon(0.02));
      CHECK(same.pull == Approx(felt.pull).epsilon(0.02));
    }
  }
}

TEST_CASE("compliance: the walls of a hole only take energy", "[compliance]") {
  for (const int delay : {0, 1, 2})
    for (const double friction : {0.05, 0.3}) {
      Bench bench(probeOver(friction, "cartesian-3.toml", delay, false));
      test::Random random(575);
      double work = 0.0, push = -2.0, largest = 0.0;
      int held = 0;
      for (int i = 0; i < 2000; ++i) {
        if (i > 200 && i % 20 == 0) push = random.uniform(-2.0, 1.0);
        const double z = bench.tool().position.z();
        const Vec3 hand(0.0, 0.0, push - (z > 0.0 ? 100.0 * z : 0.0));
        REQUIRE(bench.step([&](double, const Pose&, const Vec6&) { return hand; }));
        work += hand.z() * (bench.tool().position.z() - z);
        const double energy = 0.5 * 0.045 * bench.tool().twist.head<3>().squaredNorm();  // mass of the device file
        REQUIRE(energy <= work + 1e-12);                                                 // rounding
        largest = std::max(largest, energy);
        held += bench.haptics->frame().contacts.count > 0 && bench.haptics->frame().contacts.contacts[0].grip > 0.0;
      }
      CHECK(largest > 1e-5);
      CHECK(held > 200);
    }
}

TEST_CASE("compliance: a layer of a solid ends where the next one begins, also after a cut", "[compliance]") {
  constexpr double kCell = 1e-4, kDeep = 8e-4, kCut = 3e-4, kRadius = 5e-4;  // m
  Material soft = layer(500.0, 1.5, kInfinity, 1.0);
  const auto tooth = [&] {
    return std::make_shared<Solid>(
        MeshModel(test::boxMesh({3e-3, 3e-3, 2e-3})),
        std::vector<SolidLayer>{{"caries", soft, 1e8, 0.0, nullptr}, {"dentine", Material{}, 6e8, kDeep, nullptr}},
        SolidOptions{kCell});
  };
  const auto solid = tooth();
  Bench::Setting setting = onTooth(solid, kRadius);
  for (const double removed : {0.0, kCut}) {
    if (removed > 0.0) {  // a groove of a larger ball, whose lowest line is `removed` deep
      const double bur = 2e-3, high = 2e-3 - removed + bur;
      Segment from{{-5e-3, 0.0, high}, {-5e-3, 0.0, high}};
      for (double x = -4.9e-3; x < 5e-3; x += 1e-4) {
        const Segment to{{x, 0.0, high}, {x, 0.0, high}};
        (void)solid->cut(from, to, bur);
        from = to;
      }
      setting.start.z() -= removed;
    }
    Bench bench(setting);
    const auto [height, force] = restUnder(bench, 4.0, 900);
    const double depth = -height - removed;
    const Contact& contact = bench.haptics->frame().contacts.contacts[0];
    INFO("removed " << removed << " m, thickness " << contact.material.thickness << " m");
    CHECK(contact.material.thickness == Approx(kDeep - removed).margin(0.51 * kCell));
    Material here = soft;
    here.thickness = contact.material.thickness;
    CHECK(force == Approx(4.0).epsilon(0.01));
    // The surface of the groove is known within a twentieth of a cell.
    CHECK(elasticForce(here, depth + 5e-6) >= 0.99 * force);
    CHECK(elasticForce(here, depth - 5e-6) <= 1.01 * force);
  }
  // A thinner layer in the file remains so thin.
  soft.thickness = 2e-4;  // less than the layer
  setting.obstacle.shape = std::shared_ptr<const Solid>(tooth());
  setting.start.z() = 5e-5;
  Bench bench(setting);
  for (int i = 0; i < 300; ++i) REQUIRE(bench.press(4.0));
  CHECK(bench.haptics->frame().contacts.contacts[0].material.thickness == 2e-4);
}

TEST_CASE("compliance: a bur that starts in a pressed layer stays, and cuts what it has compressed", "[compliance]") {
  const auto solid = std::make_shared<Solid>(
      MeshModel(test::boxMesh({3e-3, 3e-3, 2e-3})),
      std::vector<SolidLayer>{{"caries", layer(4e3, 1.5, 1e-3, 3.0, 8.0), 5e8, 0.0, nullptr}}, SolidOptions{1e-4});
  const Bench::Setting setting = onTooth(solid, 5e-4);
  Bench bench(setting);
  Drill drill(setting.tool, {solid}, Bur{});
  bench.haptics->attach(&drill);
  const double pressed = -restUnder(bench, 4.0, 600).height;
  REQUIRE(pressed > 3e-4);
  REQUIRE_FALSE(bench.haptics->frame().contacts.contacts[0].isPunctured);
  drill.spin(true);
  const double start = bench.tool().position.z();
  double force = 0.0, sunk = pressed, most = 0.0, least = 0.0;  // m: highest and lowest place until it is free
  double removed = 0.0, expected = 0.0;                         // m^3: by Archard's law
  int free = 0;
  for (; free < 5000 && sunk > 0.0; ++free) {
    REQUIRE(bench.press(4.0));
    const Contact& contact = bench.haptics->frame().contacts.contacts[0];
    REQUIRE_FALSE(contact.isPunctured);
    CHECK(contact.sunk <= sunk);
    sunk = contact.sunk;
    expected += 1e-3 * drill.recession() * M_PI * 0.25e-6;
    removed += drill.removed()[0];
    const double rise = bench.tool().position.z() - start;
    most = std::max(most, rise);
    least = std::min(least, rise);
    force += bench.force();
  }
  INFO("pressed by " << pressed << " m, free after " << free << " ticks, moved by " << least << " to " << most << " m");
  CHECK(free < 5000);
  CHECK(removed == Approx(expected).epsilon(0.05));
  CHECK(most < 0.01 * pressed);
  CHECK(least > -0.05 * pressed);
  CHECK(force / free == Approx(4.0).epsilon(0.05));
  for (int i = 0; i < 500; ++i) REQUIRE(bench.press(4.0));
  CHECK(bench.tool().position.z() < start - 1e-5);  // then it sinks as it cuts
}

TEST_CASE("compliance: in a broken layer the ground is one thickness below the nearest surface", "[compliance]") {
  constexpr double kThick = 1e-3, kRadius = 3e-4, kStep = 1e-5;  // m
  const auto solid = std::make_shared<Solid>(
      MeshModel(test::boxMesh({4e-3, 4e-3, 3e-3})),
      std::vector<SolidLayer>{{"caries", layer(4e3, 1.5, kThick, 0.0, 1.0), 1e8, 0.0, nullptr}}, SolidOptions{2e-4});
  for (const double y : {-8e-4, 0.0, 7e-4}) {  // shallow grooves: a god object on the surface would jump in them
    const Segment from{{-5e-3, y, 3.45e-3}, {-5e-3, y, 3.45e-3}}, to{{5e-3, y, 3.45e-3}, {5e-3, y, 3.45e-3}};
    (void)solid->cut(from, to, 5e-4);
  }
  Scene scene;
  scene.add({"tooth", std::shared_ptr<const Solid>(solid), Pose(), Vec6::Zero(), {}});
  Tool tool;
  tool.parts[0].radius = kRadius;
  TickScene ticked(scene, tool);
  test::Random random(571);
  Pose pose;
  double time = 0.0, height = 3.4e-3;
  ContactSnapshot contacts;
  for (int i = 0; i < 3000; ++i, time += kTick) {
    height = std::max(height - kStep, 3e-3 - random.uniform(0.5, 0.9) * kThick);
    pose.position = {1e-3 * std::sin(1e-2 * i), 1e-3 * std::cos(1.7e-2 * i), height};
    REQUIRE(ticked.findContacts(pose, time, kTick, {}, 0.0, contacts) == Status::ok);
    TickOutput output;
    output.normalForce = 2.0;  // more than the layer holds
    ticked.compliance().press(output, kTick, contacts);
    if (i < 100) continue;
    REQUIRE(contacts.count == 1);
    REQUIRE(contacts.contacts[0].isPunctured);
    const SolidPoint nearest = signedDistance(*solid, pose.position);
    CHECK(contacts.contacts[0].gap == Approx(nearest.distance - kRadius + kThick).margin(1e-12));
    CHECK(contacts.contacts[0].normal.dot(nearest.normal) == Approx(1.0).margin(1e-12));
  }
}

TEST_CASE("compliance: an explorer sinks into the caries of caries.toml and is held there, not in a sound molar",
          "[compliance]") {
  const std::string scenes = std::string(ENAMEL_SOURCE_DIR) + "/data/scenes/";
  const SceneFile file = loadScene(scenes + "caries.toml"), sound = loadScene(scenes + "mobile-molar.toml");
  // How far it sinks between 0.5 and 4 N in the central fissure, and rises when it is pulled with 0.3 N for 0.3 s, m.
  const auto probe = [&](const Obstacle& molar) {
    Bench::Setting setting;
    setting.device = "tau-nominal.toml";
    setting.obstacle = molar;
    setting.obstacle.suspension = nullptr;
    setting.tool = file.tool;
    setting.start = {0.0, 0.0, 2.9e-3};
    Bench bench(setting);
    double height = 0.0;
    for (int i = 0; i < 2000; ++i) {
      REQUIRE(bench.press(i < 1000 ? 0.5 : 4.0));
      REQUIRE(bench.haptics->guard().fault() == GuardReason::none);
      if (i == 999) height = bench.tool().position.z();
    }
    const double low = bench.tool().position.z();
    for (int i = 0; i < 300; ++i) REQUIRE(bench.press(-0.3));
    return std::pair(height - low, bench.tool().position.z() - low);
  };
  const auto [sinks, rises] = probe(file.scene.obstacles()[0]);
  const auto [soundSinks, soundRises] = probe(sound.scene.obstacles()[0]);
  CHECK(sinks > 3e-4);  // 0.4 mm by the law of one contact 1.3 mm above sound tissue
  CHECK(rises < 2e-4);
  CHECK(std::abs(soundSinks) < 2e-5);
  CHECK(soundRises > 1e-3);
}

TEST_CASE("compliance: a saved state continues bit for bit, also in a broken layer", "[compliance]") {
  for (const double push : {1.0, 5.0}) {  // below and above the puncture force
    const Bench::Setting setting{
        "tau-nominal.toml", kClosedForm, block(layer(1e3, 1.5, 1.5e-3, 2.0, 3.0)), 0, false, false, {0.0, 0.0, 5e-5}};
    Bench bench(setting);
    for (int i = 0; i < 150; ++i) REQUIRE(bench.press(push));
    test::ContinuedTick copy(bench);
    int punctured = 0;
    for (int i = 0; i < 100; ++i) {
      copy.stepBoth();
      punctured += copy.tick().frame().contacts.contacts[0].isPunctured;
    }
    CHECK(punctured == (push > 3.0 ? 100 : 0));
  }
}

TEST_CASE("compliance: stable on imperfect devices at every delay", "[compliance]") {
  const bool isLong = test::longRun();
  int runs = 0;
  for (const test::BenchDevice& device : test::kBenchDevices)
    for (const int delay : {0, 1, 2}) {
      const auto run = [&](const Material& material) {
        return test::holdAfterPress(device, block(material), delay, 800);
      };
      Material rigid;
      rigid.friction = rigid.slidingFriction = 0.2;
      const test::HeldForce reference = run(rigid);
      for (const double stiffness : {500.0, 2e3, 1e4, 1e5})
        for (const double exponent : {1.0, 1.5, 3.0})
          for (const double puncture : {kInfinity, 0.7 * device.force})
            for (const double hysteresis : {0.0, 3.0})
              for (const double thickness : {2e-3, 1e-4}) {  // the thin layer bottoms out
                if (!isLong && runs++ % 5 != 0) continue;    // the whole grid with ENAMEL_LONG
                Material m = layer(stiffness, exponent, thickness, hysteresis, puncture);
                m.friction = m.slidingFriction = 0.2;
                INFO(device.file << ", delay " << delay << ", " << stiffness << " N/m, exponent " << exponent
                                 << ", thickness " << thickness << " m, puncture " << puncture << " N, hysteresis "
                                 << hysteresis << " s/m");
                const auto [change, force] = run(m);
                // An unstable loop swings between zero and the largest force. Punctured, the tool rests on rigid
                // ground.
                CHECK(change <= std::max(1.5 * reference.change, 0.5 * device.force));
                CHECK(std::abs(force - reference.force) < 0.1 * device.force);
              }
    }
}

}  // namespace enamel::test_compliance
