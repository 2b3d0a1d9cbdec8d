// Guides: errors of their shapes, law and energy of the force, and tools that they lead.
#include "enamel/render/guidance.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "enamel/core/error.hpp"
#include "enamel/device/mapped_mechanism.hpp"
#include "support/bench.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/meshes.hpp"

namespace enamel::test_guidance {

namespace {

using test::Bench, test::kTick, test::ContainsSubstring;

constexpr double kStiffness = 300.0, kForce = 2.0;  // N/m, N
constexpr double kMass = 0.045;                     // of cartesian-3.toml, kg

Guide guide(GuideShape shape, double stiffness = kStiffness, double force = kForce, const Pose& pose = {}) {
  return {std::move(shape), pose, stiffness, force};
}
Guide line(double stiffness = kStiffness, double force = kForce) {  // along x
  return guide(Polyline{{{-0.05, 0.0, 0.0}, {0.05, 0.0, 0.0}}}, stiffness, force);
}

std::vector<GuideShape> shapes() {
  const std::vector<Vec3> bent = {{-0.02, 0.0, 0.0}, {0.0, 0.0, 0.01}, {0.0, 0.015, 0.0}, {0.01, 0.02, -0.02}};
  return {Polyline{bent}, Polyline{bent, 3e-3}, Polyline{{{1e-3, 2e-3, 3e-3}}}, Polyline{{{1e-3, 2e-3, 3e-3}}, 0.01},
          Plane{},        HalfSpace{},          Box{{0.02, 0.01, 0.015}}};
}

// Whether a point of a shape's frame is in the shape, within `near`.
bool isIn(const GuideShape& shape, const Vec3& p, double near) {
  if (const auto* box = std::get_if<Box>(&shape)) return (p.cwiseAbs() - box->half).maxCoeff() <= near;
  if (std::holds_alternative<Plane>(shape)) return std::abs(p.z()) <= near;
  if (std::holds_alternative<HalfSpace>(shape)) return p.z() >= -near;
  const Polyline& l = std::get<Polyline>(shape);
  double least = (p - l.points[0]).norm();
  for (std::size_t i = 1; i < l.points.size(); ++i) {
    const Vec3 edge = l.points[i] - l.points[i - 1];
    const double along = std::clamp((p - l.points[i - 1]).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (p - l.points[i - 1] - along * edge).norm());
  }
  return least <= l.radius + near;
}

std::shared_ptr<const Mechanism> light() { return makeMechanism(loadDevice(test::deviceFile("cartesian-3.toml"))); }

// Moves the TCP along a path, and returns the forces.
struct Path {
  explicit Path(std::vector<Guide> all, const Mechanism& device) : guides(std::move(all)), guidance(device, kTick) {}
  explicit Path(std::vector<Guide> all) : Path(std::move(all), *light()) {}
  Vec3 to(const Vec3& position) {
    frame.time += kTick;
    frame.kinematics.pose.position = position;
    const Vec3 force = guidance.step(guides, frame);
    guidance.sent(1.0);
    return force;
  }
  Vec3 rest(const Vec3& position) {
    for (int i = 0; i < 300; ++i) (void)to(position);  // the ramp takes 100 ticks
    return to(position);
  }

  std::vector<Guide> guides;
  TickFrame frame;
  Guidance guidance;
};

Obstacle farBlock() {
  Obstacle obstacle;
  obstacle.name = "far";
  obstacle.shape = Box{{1e-3, 1e-3, 1e-3}};
  obstacle.pose.position = {0.0, 0.0, -0.5};
  return obstacle;
}

Bench::Setting setting(const test::BenchDevice& device, int delay, const Vec3& start, const std::vector<Guide>& guides,
                       bool spring = false) {
  return {device.file, device.plant, farBlock(), delay, spring, true, start, {}, guides};
}

// A block whose top is the plane z = 0.
Obstacle blockBelow() {
  Obstacle block;
  block.name = "block";
  block.shape = Box{{0.02, 0.02, 0.01}};
  block.pose.position = {0.0, 0.0, -0.01};
  return block;
}

}  // namespace

TEST_CASE("guidance: the error leads to the nearest point of the shape, and its rate is the derivative", "[guidance]") {
  test::Random random(576);
  for (const GuideShape& shape : shapes())
    for (int i = 0; i < 2000; ++i) {
      Pose pose;
      pose.position = random.vector(0.02);
      pose.rotation = random.rotation(3.0);
      const Guide g = guide(shape, 1.0, 1.0, pose);
      const Vec3 p = random.vector(0.05), v = random.vector(0.2);
      const GuideError error = errorOf(g, p, v);
      const auto inFrame = [&](const Vec3& point) { return Vec3(pose.rotation.transpose() * (point - pose.position)); };
      CHECK(isIn(shape, inFrame(p - error.offset), 1e-15));  // rounding of lengths below 0.1 m
      const bool isInside = isIn(shape, inFrame(p), 0.0);
      CHECK((error.offset.norm() <= 1e-15) == (isInside || error.offset.isZero(1e-15)));
      // No point of the shape is nearer, also not those between the point and its place.
      for (const double share : {0.5, 0.9, 0.999})
        if (error.offset.norm() > 1e-9) CHECK_FALSE(isIn(shape, inFrame(p - share * error.offset), -1e-12));
      const double step = 1e-6;  // s
      const Vec3 high = errorOf(g, p + step * v, v).offset, low = errorOf(g, p - step * v, v).offset;
      const bool isSmooth = (high - 2.0 * error.offset + low).norm() < 1e-11;  // no kink within 0.2 um
      if (isSmooth) CHECK((error.rate - (high - low) / (2.0 * step)).norm() < 1e-6);
      CHECK(error.rate.dot(v) >= -1e-15);  // damping never gives energy
    }
}

TEST_CASE("guidance: at rest the force is that of a spring, and never more than the limit", "[guidance]") {
  for (const GuideShape& shape : shapes()) {
    Path path({guide(shape)});
    test::Random random(577);
    for (int i = 0; i < 20; ++i) {
      const Vec3 p = random.vector(0.05), e = errorOf(path.guides[0], p, Vec3::Zero()).offset, force = path.rest(p);
      const double size = std::min(kForce, kStiffness * e.norm());
      CHECK((force + size * (e.norm() > 0.0 ? Vec3(e.normalized()) : Vec3(Vec3::Zero()))).norm() < 1e-9);
    }
    for (int i = 0; i < 2000; ++i) CHECK(path.to(random.vector(0.05)).norm() <= kForce * (1.0 + 1e-15));
  }
}

TEST_CASE("guidance: a region does not hold a tool that returns", "[guidance]") {
  Path wall({guide(HalfSpace{})});
  (void)wall.rest({0.0, 0.0, -5e-3});
  for (double z = -5e-3; z < 0.0; z += 2e-4) CHECK(wall.to({0.0, 0.0, z}).z() >= 0.0);
  CHECK(wall.to({0.0, 0.0, 1e-3}).isZero(0.0));
  Path plane({guide(Plane{})});  // brakes it
  (void)plane.rest({0.0, 0.0, -5e-3});
  double least = 1.0;
  for (double z = -5e-3; z < 0.0; z += 2e-4) least = std::min(least, plane.to({0.0, 0.0, z}).z());
  CHECK(least < 0.0);
}

TEST_CASE("guidance: stiffnesses that add up to more than the device permits are reduced by one factor", "[guidance]") {
  const std::shared_ptr<const Mechanism> device = light();
  const double limit = Guidance(*device, kTick).largestStiffness();
  CHECK(limit == Approx(0.01 * kMass / (kTick * kTick)).epsilon(1e-12));
  CHECK(Guidance(*device, 2.0 * kTick).largestStiffness() == Approx(0.25 * limit).epsilon(1e-12));
  Path path({line(3.0 * limit), guide(Plane{}, limit)}, *device);
  const Vec3 force = path.rest({0.0, 1e-3, -1e-3});
  CHECK(force.y() == Approx(-0.75e-3 * limit).epsilon(1e-9));
  CHECK(force.z() == Approx(1e-3 * limit).epsilon(1e-9));
}

TEST_CASE("guidance: numbers are those at the hand, also with a workspace map", "[guidance]") {
  const std::shared_ptr<const Mechanism> device = light();
  WorkspaceMap map;
  map.scale = 4.0;
  const MappedMechanism mapped(device, map);
  // A metre of the scene is a quarter of a metre at the hand.
  CHECK(Guidance(mapped, kTick).largestStiffness() ==
        Approx(Guidance(*device, kTick).largestStiffness() / 4.0).epsilon(1e-12));
  Path path({line(50.0)}, mapped);
  CHECK(4.0 * path.rest({0.0, 0.0, -0.01}).z() == Approx(0.5).epsilon(1e-9));
  CHECK(4.0 * path.rest({0.0, 0.0, -0.1}).z() == Approx(kForce).epsilon(1e-9));
}

TEST_CASE("guidance: a motion of the hand up to 30 Hz gives no energy, at 0 to 3 ticks of delay", "[guidance]") {
  const double limit = Guidance(*light(), kTick).largestStiffness();
  for (const double stiffness : {0.01 * limit, 0.1 * limit, limit})
    for (const int delay : {0, 1, 2, 3})
      for (const double frequency : {0.5, 2.0, 8.0, 20.0, 30.0})
        for (const double speed : {0.01, 0.1, 0.5})  // largest, m/s
          for (const GuideShape& shape : shapes())
            for (const bool round : {false, true}) {
              Path path({guide(shape, stiffness, 1.0)});
              const double size = speed / (2.0 * M_PI * frequency * 1.2);  // m; 1.2: the longer vector below
              const Vec3 centre(0.002, 0.001, -0.003);
              const auto at = [&](int i) {
                const double phase = 2.0 * M_PI * frequency * kTick * i;
                const Vec3 one = size * Vec3(0.3, -0.5, 1.0), other = size * Vec3(0.7, 0.8, 0.2);
                return Vec3(centre + std::sin(phase) * one + (round ? std::cos(phase) : 0.0) * other);
              };
              std::deque<Vec3> sent(static_cast<std::size_t>(delay), Vec3::Zero());
              const int cycle = static_cast<int>(std::lround(10.0 / (frequency * kTick)));  // ten times back and forth
              double work = 0.0, all = 0.0;
              for (int i = 0; i < 400 + cycle; ++i) {
                sent.push_back(path.to(at(i)));
                const double done = sent.front().dot(at(i + 1) - at(i));
                sent.pop_front();
                if (i < 400) continue;  // the ramp, and the beginning of the filter
                work += done;
                all += std::abs(done);
              }
              INFO(stiffness << " N/m, delay " << delay << ", " << frequency << " Hz, " << size << " m, shape "
                             << shape.index() << (round ? ", round" : ""));
              // A cycle in which the guide gave energy would add up over ten: 1e-3 covers a part of one at the end.
              CHECK(work <= 1e-3 * all);
            }
}

TEST_CASE("guidance: the frequencies of the page, above which it gives energy", "[guidance]") {
  const auto work = [](double frequency, int delay) {  // of 400 ticks
    Path path({guide(Plane{}, 100.0, 10.0)});
    const auto at = [&](int i) { return Vec3(0.0, 0.0, 1e-3 * std::sin(2.0 * M_PI * frequency * kTick * i)); };
    std::deque<Vec3> sent(static_cast<std::size_t>(delay), Vec3::Zero());
    double sum = 0.0;
    for (int i = 0; i < 1200; ++i) {
      sent.push_back(path.to(at(i)));
      if (i >= 200) sum += sent.front().dot(at(i + 1) - at(i));
      sent.pop_front();
    }
    return sum;
  };
  for (const auto& [delay, frequency] : {std::pair(0, 133.0), {1, 70.0}, {2, 48.0}, {3, 36.0}}) {
    CHECK(work(frequency - 1.0, delay) < 0.0);
    CHECK(work(frequency + 1.0, delay) > 0.0);
  }
}

TEST_CASE("guidance: a mass on a guide comes to rest, from 0.6 of the device's mass to any", "[guidance]") {
  const double limit = Guidance(*light(), kTick).largestStiffness();
  // Largest distance in the first 2 s and in the last second of 20 s.
  const auto swing = [&](double stiffness, int delay, double ratio) {
    Path path({guide(Polyline{{Vec3::Zero()}}, stiffness, 10.0)});
    std::deque<Vec3> sent(static_cast<std::size_t>(delay), Vec3::Zero());
    Vec3 x(1e-4, 0.0, 0.0), v(0.0, 0.005, 0.0);
    std::pair<double, double> largest(0.0, 0.0);
    for (int i = 0; i < 20000; ++i) {
      sent.push_back(path.to(x));
      const Vec3 a = sent.front() / (ratio * kMass);
      sent.pop_front();
      x += kTick * (v + 0.5 * kTick * a);
      v += kTick * a;
      if (i < 2000) largest.first = std::max(largest.first, x.norm());
      if (i >= 19000) largest.second = std::max(largest.second, x.norm());
    }
    return largest;
  };
  for (const double stiffness : {0.1 * limit, limit, 10.0 * limit})  // the last one is reduced to the limit
    for (const int delay : {0, 1, 2, 3})
      for (const double ratio : {0.6, 1.0, 3.0, 30.0}) {
        const auto [first, last] = swing(stiffness, delay, ratio);
        INFO(stiffness << " N/m, delay " << delay << ", " << ratio << " of the mass");
        CHECK(last < 0.2 * first);
      }
  // The factors of the page, by which the mass may be smaller or the stiffness larger.
  for (const auto& [delay, factor] : {std::pair(3, 1.95), {2, 2.85}, {1, 4.8}, {0, 13.8}}) {
    const auto [stableFirst, stableLast] = swing(limit, delay, 1.05 / factor);
    CHECK(stableLast < 0.01 * stableFirst);
    CHECK(swing(limit, delay, 0.95 / factor).second > 1e-3);  // it swings at the largest force
  }
}

TEST_CASE("guidance: the tool has no more energy than the hand gave and the guides had stored", "[guidance]") {
  const double limit = Guidance(*light(), kTick).largestStiffness();
  const test::BenchDevice light = test::kBenchDevices[2];
  test::Random random(578);
  for (const int delay : {0, 1, 2})
    for (const bool spring : {false, true})
      for (const double stiffness : {0.3 * limit, limit})
        for (const GuideShape& shape : shapes()) {
          const Vec3 start(0.0, 5e-3, -8e-3);
          const Guide g = guide(shape, stiffness, 1.0);
          Bench::Setting exact = setting(light, delay, start, {g}, spring);
          exact.encoders = false;
          Bench bench(exact);
          const double e = errorOf(g, start, Vec3::Zero()).offset.norm(), knee = 1.0 / stiffness;
          double given = e < knee ? 0.5 * stiffness * e * e : e - 0.5 * knee, largest = 0.0;  // J
          Vec3 push = Vec3::Zero(), aim = Vec3::Zero();
          for (int i = 0; i < 1500; ++i) {
            if (i % 50 == 0) aim = random.vector(0.4);
            push += 0.1 * (aim - push);
            const Vec3 before = bench.tool().position;
            const Vec3 hand =
                push - 40.0 * before - 0.5 * bench.tool().twist.head<3>();  // keeps the tool in the workspace
            REQUIRE(bench.step([&](double, const Pose&, const Vec6&) { return hand; }));
            REQUIRE(bench.haptics->guard().fault() == GuardReason::none);
            given += hand.dot(bench.tool().position - before);
            const double energy = 0.5 * kMass * bench.tool().twist.head<3>().squaredNorm();
            INFO("delay " << delay << (spring ? ", spring, " : ", ") << stiffness << " N/m, shape " << shape.index()
                          << ", tick " << i);
            REQUIRE(energy <= given + 1e-9);  // rounding
            largest = std::max(largest, energy);
          }
          CHECK(largest > 1e-4);
        }
}

TEST_CASE("guidance: it leads the tool to the line, on imperfect devices at every delay", "[guidance]") {
  for (const test::BenchDevice& device : test::kBenchDevices)
    for (const int delay : {0, 1, 2})
      for (const bool spring : {false, true}) {
        const double limit =
            Guidance(*Bench({device.file, device.plant, farBlock()}).mechanism, kTick).largestStiffness();
        for (const double stiffness : {300.0, limit}) {
          Bench bench(setting(device, delay, {0.0, 8e-3, -15e-3}, {line(stiffness, kForce)}, spring));
          double moves = 0.0;
          for (int i = 0; i < 3000; ++i) {
            // A hand that holds a pen loosely: 0.1 kg and 3 N s/m would damp more.
            REQUIRE(bench.step([](double, const Pose&, const Vec6& twist) { return Vec3(-1.0 * twist.head<3>()); }));
            REQUIRE(bench.haptics->guard().fault() == GuardReason::none);
            if (i >= 2500) moves = std::max(moves, bench.tool().twist.head<3>().norm());
          }
          const Vec3 p = bench.tool().position;
          INFO(device.file << ", delay " << delay << (spring ? ", spring, " : ", ") << stiffness << " N/m, at "
                           << p.transpose());
          // Friction of the joints, at most 0.5 N at the tool, holds it where the spring is weaker.
          const double friction = std::string(device.plant) == kClosedForm ? 0.0 : 0.5;
          CHECK(std::hypot(p.y(), p.z()) < friction / std::min(stiffness, limit) + 2e-4);
          CHECK(moves < 0.01);
        }
      }
}

TEST_CASE("guidance: stored energy that returns is no fault, energy of a late force is", "[guidance]") {
  const Bench bench({"cartesian-3.toml", kClosedForm, farBlock()});
  Scene scene = bench.scene;
  scene.setGuides({guide(Plane{}, 450.0, 3.0)});
  const auto run = [&](double frequency, double size, int delay, double largest = kUnlimited) {
    GuardOptions options = guardFor(*bench.mechanism, kTick);
    options.delay = delay;
    options.force = largest;
    ImpedanceRenderer renderer({1500.0, 2.0});
    HapticTick tick(*bench.mechanism, scene, Tool{}, renderer, options);
    double most = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const double w = 2.0 * M_PI * frequency, t = kTick * i;
      Pose pose;
      Vec6 twist = Vec6::Zero();
      pose.position.z() = size * std::sin(w * t);
      twist[2] = size * w * std::cos(w * t);
      Kinematics k;
      REQUIRE(bench.mechanism->reach(pose, twist, false, k) == Status::ok);
      Measurement measured;
      measured.time = t;
      measured.q = k.q;
      measured.rates = k.rates;
      Command command;
      (void)tick(measured, command);
      if (tick.guard().fault() != GuardReason::none) return std::pair(tick.guard().fault(), most);
      most = std::max(most, tick.guard().tick(0).energy);
    }
    return std::pair(GuardReason::none, most);
  };
  // Back from 20 mm the plane gives 50 mJ. The guard permits 2.3 mJ to other forces.
  for (const int delay : {0, 1, 2, 3}) {
    const auto [fault, most] = run(1.0, 0.02, delay);
    CHECK(fault == GuardReason::none);
    CHECK(most < 0.1 * guardFor(*bench.mechanism, kTick).energy);
  }
  // Only what the guard lets pass counts as stored.
  CHECK(run(1.0, 0.02, 0, 0.5).first == GuardReason::none);
  CHECK(run(100.0, 1e-3, 3).first == GuardReason::energy);
}

TEST_CASE("guidance: without stiffness or force the ticks are those without guides, bit for bit", "[guidance]") {
  Obstacle block = blockBelow();
  for (const bool spring : {false, true})
    for (const std::vector<Guide>& none : {std::vector<Guide>{line(0.0, 5.0)}, {line(300.0, 0.0)}}) {
      Bench without({"tau-nominal.toml", kClosedForm, block, 1, spring, true});
      Bench with({"tau-nominal.toml", kClosedForm, block, 1, spring, true, {0.0, 0.0, 2e-3}, {}, none});
      for (int i = 0; i < 300; ++i) {
        REQUIRE(without.press(5.0));
        REQUIRE(with.press(5.0));
        REQUIRE(with.haptics->frame().command == without.haptics->frame().command);
      }
      CHECK(with.force() > 3.0);
    }
}

TEST_CASE("guidance: position control on a wall stays stable beside a guide", "[guidance]") {
  Obstacle block = blockBelow();
  block.material.friction = block.material.slidingFriction = 0.2;
  for (const test::BenchDevice& device : test::kBenchDevices)
    for (const int delay : {0, 1, 2}) {
      const test::HeldForce alone = test::holdAfterPress(device, block, delay, 800);
      // A line above the surface, one below it, and a wall across it, where the tool is.
      for (const double height : {5e-3, -5e-3}) {
        Pose pose;
        pose.position = {1e-3, 0.0, height};
        const std::vector<Guide> guides = {guide(Polyline{{{-0.05, 0.0, 0.0}, {0.05, 0.0, 0.0}}}, 1e4, 1.0, pose),
                                           guide(HalfSpace{}, 1e4, 1.0, {{2e-3, 0.0, 0.0}, frameAlong(Vec3::UnitX())})};
        const auto [change, force] = test::holdAfterPress(device, block, delay, 800, guides);
        INFO(device.file << ", delay " << delay << ", height " << height);
        CHECK(change <= std::max(1.5 * alone.change, 0.5 * device.force));
        // The line adds its force to that of the hand, on the way to the surface. The wall carries the sum.
        CHECK(std::abs(force - 0.5 * device.force) < 0.1 * device.force);
      }
    }
}

TEST_CASE("guidance: position control holds a wall against a guide", "[guidance]") {
  Obstacle block = blockBelow();
  Pose below;
  below.position = {0.0, 0.0, -0.02};
  for (const test::BenchDevice& device : test::kBenchDevices)
    for (const int delay : {0, 1, 2}) {
      const double push = 0.5 * device.force;
      // Mean depth in the last of 1000 ticks under a hand and under a guide of the same force, m.
      const auto depth = [&](bool guided) {
        std::vector<Guide> guides;
        if (guided) guides = {guide(Plane{}, 400.0, push, below)};
        Bench bench({device.file, device.plant, block, delay, false, true, {0.0, 0.0, 5e-4}, {}, guides});
        double mean = 0.0;
        for (int i = 0; i < 1000; ++i) {
          REQUIRE(bench.press(guided ? 0.0 : push));
          REQUIRE(bench.haptics->guard().fault() == GuardReason::none);
          if (i >= 500) mean += bench.depth() / 500.0;
        }
        return mean;
      };
      const double byHand = depth(false), byGuide = depth(true);
      INFO(device.file << ", delay " << delay << ": " << 1e6 * byHand << " um by hand, " << 1e6 * byGuide << " um");
      CHECK(std::abs(byGuide - byHand) < 3e-5);
    }
}

TEST_CASE("guidance: a guide does not push a movable obstacle, the wall does", "[guidance]") {
  Obstacle block = blockBelow();
  Suspension s;
  s.centre = {0.0, 0.0, 0.01};
  s.inertia << 0.0, 0.0, 2e-3, 0.0, 0.0, 0.0;
  s.stiffness << 0.0, 0.0, 5e4, 0.0, 0.0, 0.0;
  s.damping << 0.0, 0.0, 6.0, 0.0, 0.0, 0.0;
  block.suspension = std::make_shared<const Suspension>(s);
  Pose below;
  below.position = {0.0, 0.0, -0.02};
  Bench bench({"tau-nominal.toml",
               kClosedForm,
               block,
               0,
               false,
               false,
               {0.0, 0.0, 1e-4},
               {},
               {guide(Plane{}, 1000.0, 2.0, below)}});
  for (int i = 0; i < 1000; ++i)
    REQUIRE(bench.step([&](double, const Pose& pose, const Vec6& twist) {
      return Vec3(guidingWrench(pose, twist, bench.setup.start, Vec3::UnitZ()).head<3>());
    }));
  // The wall holds the tool against the guide: the motors give nothing, the block carries 2 N.
  CHECK(std::abs(bench.force()) < 0.02);
  CHECK(bench.state().offset[2] == Approx(-2.0 / 5e4).epsilon(0.02));
}

TEST_CASE("guidance: a bur that a guide presses cuts as one that a hand presses", "[guidance]") {
  constexpr double kRadius = 0.5e-3, kPush = 2.0;  // m, N
  const auto removed = [](bool guides) {
    const auto solid =
        std::make_shared<Solid>(MeshModel(test::boxMesh(Vec3(3e-3, 3e-3, 2e-3))),
                                std::vector<SolidLayer>{{"dentine", {}, 0.6e9, 0.0, nullptr}}, SolidOptions{1e-4});
    Bench::Setting pressed;
    pressed.device = "tau-nominal.toml";
    pressed.obstacle.name = "tooth";
    pressed.obstacle.shape = std::shared_ptr<const Solid>(solid);
    pressed.obstacle.pose.position.z() = -2e-3;
    pressed.start = {0.0, 0.0, kRadius + 5e-5};
    pressed.tool.parts[0].radius = kRadius;
    Pose below;
    below.position.z() = -0.02;
    if (guides) pressed.guides = {guide(Plane{}, 1000.0, kPush, below)};
    Bench bench(pressed);
    Drill drill(pressed.tool, {solid}, Bur{0, 0.1, 2000.0});
    drill.spin(true);
    bench.haptics->attach(&drill);
    double volume = 0.0;
    for (int i = 0; i < 800; ++i) {
      REQUIRE(bench.step([&](double, const Pose& pose, const Vec6& twist) {
        Vec3 force = guidingWrench(pose, twist, bench.setup.start, Vec3::UnitZ()).head<3>();
        force.z() -= (guides ? 0.0 : std::min(1.0, 0.01 * i) * kPush) + 3.0 * twist[2];
        return force;
      }));
      volume += drill.removed()[0];
    }
    return volume;
  };
  const double byHand = removed(false);
  CHECK(byHand > 1e-11);  // Archard's rate: 0.8 s of 0.1 x 2 N x 2 pi 0.5 mm x 2000 / s / 0.6 GPa are 1.7 mm^3
  CHECK(removed(true) == Approx(byHand).epsilon(0.05));
}

TEST_CASE("guidance: it ramps in, begins again with other guides, and repeats its force without a sample",
          "[guidance]") {
  Path path({line()});
  CHECK(path.to({0.0, 0.0, -1.0}).norm() == Approx(0.01 * kForce).epsilon(1e-12));
  for (int i = 0; i < 49; ++i) (void)path.to({0.0, 0.0, -1.0});
  const Vec3 half = path.to({0.0, 0.0, -1.0});
  CHECK(half.norm() == Approx(0.51 * kForce).epsilon(1e-12));
  path.frame.age = 1;
  CHECK(path.to({0.0, 0.0, -2.0}) == half);
  CHECK(path.frame.guided.isZero(0.0));

  const Bench bench({"tau-nominal.toml", kClosedForm, farBlock()});
  Scene with = bench.scene, other = bench.scene, moved;
  with.setGuides({line()});
  other.setGuides({line()});
  moved = with;  // the same guides
  (void)moved.move(0, {{0.0, 0.0, -0.4}, Mat3::Identity()}, Vec6::Zero());
  ImpedanceRenderer renderer({1500.0, 2.0});
  Kinematics k = bench.mechanism->home();
  Pose pose;
  pose.position = {0.0, 0.0, -0.02};
  REQUIRE(bench.mechanism->reach(pose, Vec6::Zero(), false, k) == Status::ok);
  HapticTick tick(*bench.mechanism, with, Tool{}, renderer, kTick, pose);
  double time = 0.0;
  const auto forceAfter = [&](int ticks) {
    for (int i = 0; i < ticks; ++i) {
      Measurement measured;
      measured.time = time += kTick;
      measured.q = k.q;
      measured.rates = k.rates;
      Command command;
      REQUIRE(tick(measured, command) == Status::ok);
    }
    return wrenchOf(k, tick.frame().command - k.gravity).z();
  };
  CHECK(forceAfter(200) == Approx(kForce).epsilon(1e-9));
  TickScene again(moved, Tool{}), different(other, Tool{}), none(bench.scene, Tool{});
  tick.exchange(again);
  CHECK(forceAfter(1) == Approx(kForce).epsilon(1e-9));
  tick.exchange(different);
  CHECK(forceAfter(1) == Approx(0.01 * kForce).epsilon(1e-9));
  CHECK(forceAfter(200) == Approx(kForce).epsilon(1e-9));
  tick.exchange(none);
  CHECK(std::abs(forceAfter(1)) < 1e-12);
}

TEST_CASE("guidance: a guard that is open again lets the guides ramp in", "[guidance]") {
  // 2 N are more than the tenth of 3.3 N at which the guard engages.
  Bench bench({"cartesian-3.toml", kClosedForm, farBlock(), 0, true, false, {0.0, 0.0, -0.02}, {}, {line()}});
  Kinematics k;
  REQUIRE(bench.mechanism->reach(bench.setup.start, Vec6::Zero(), false, k) == Status::ok);
  double time = 0.0;
  const auto forceAfter = [&](int ticks, bool enabled) {
    for (int i = 0; i < ticks; ++i) {
      Measurement measured;
      measured.time = time += kTick;
      measured.q = k.q;
      measured.rates = k.rates;
      measured.enabled = enabled;
      Command command;
      REQUIRE((*bench.haptics)(measured, command) == Status::ok);
    }
    return wrenchOf(k, bench.haptics->frame().command - k.gravity).z();
  };
  CHECK(forceAfter(200, true) == Approx(kForce).epsilon(1e-9));
  CHECK(forceAfter(50, false) == 0.0);
  CHECK(forceAfter(2, true) < 0.1);
  CHECK(forceAfter(200, true) == Approx(kForce).epsilon(1e-9));
  bench.haptics->reset();
  CHECK(forceAfter(2, true) < 0.1);
  CHECK(forceAfter(200, true) == Approx(kForce).epsilon(1e-9));
}

TEST_CASE("guidance: a saved state continues bit for bit", "[guidance]") {
  const test::BenchDevice device = test::kBenchDevices[0];
  for (const int ticks : {40, 400}) {  // in the ramp, and after it
    Bench bench(setting(device, 0, {0.0, 5e-3, -5e-3}, {line(), guide(Box{{0.001, 0.001, 0.001}})}));
    for (int i = 0; i < ticks; ++i)
      REQUIRE(bench.step([&](double time, const Pose&, const Vec6&) { return Vec3(std::sin(20.0 * time), 0.5, 0.0); }));
    test::ContinuedTick copy(bench);
    for (int i = 0; i < 100; ++i) copy.stepBoth(1e-5);
  }
  Path path({line()});
  (void)path.rest({0.0, 0.0, -1.0});
  std::array<double, Guidance::kNumbers> state{};
  path.guidance.saveState(state.data());
  path.guidance.loadState(state.data());
  CHECK(path.to({0.0, 0.0, -1.0}).norm() == Approx(kForce).epsilon(1e-12));
  state[3] = std::nan("");
  path.guidance.loadState(state.data());  // begins again
  CHECK(path.to({0.0, 0.0, -1.0}).norm() == Approx(0.01 * kForce).epsilon(1e-12));
}

TEST_CASE("guidance: the page has the limit of every device file", "[guidance]") {
  const std::string page = test::readFile(ENAMEL_SOURCE_DIR "/lib/docs/guides.md");
  int devices = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ENAMEL_SOURCE_DIR "/data/devices")) {
    const std::shared_ptr<const Mechanism> device = makeMechanism(loadDevice(entry.path().string()));
    const double limit = Guidance(*device, kTick).largestStiffness(),
                 mass = guardFor(*device, kTick).brake * kTick / 0.05;  // least mass, as the guard's brake has it
    char row[100];
    std::snprintf(row, sizeof row, "\n| %s | %.0f | %.0f |", entry.path().filename().string().c_str(), 1e3 * mass,
                  limit);
    INFO(row);
    CHECK(page.find(row) != std::string::npos);
    ++devices;
  }
  CHECK(devices >= 12);
}

TEST_CASE("guidance: what is refused, and how", "[guidance]") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Scene scene;
  const auto refused = [&](const Guide& g, const std::string& message) {
    CHECK_THROWS_WITH(scene.setGuides({line(), g}), ContainsSubstring("guide 1: " + message));
  };
  refused(line(-1.0), "the stiffness is -1, must be in 0 to 1e+05 N/m");
  refused(line(kNan), "the stiffness is nan");
  refused(line(300.0, 101.0), "the largest force is 101, must be in 0 to 100 N");
  refused(line(300.0, kNan), "the largest force is nan");
  refused(guide(Polyline{}), "the line has 0 points, must have 1 to 64");
  refused(guide(Polyline{std::vector<Vec3>(65, Vec3::Zero())}), "the line has 65 points");
  refused(guide(Polyline{{Vec3::Zero(), Vec3::Zero()}}), "points 0 and 1 of the line are equal");
  refused(guide(Polyline{{Vec3::Zero(), {1e-200, 0.0, 0.0}}}), "points 0 and 1 of the line are equal");
  refused(guide(Polyline{{{0.0, kNan, 0.0}}}), "point 0 must be within 100 m");
  refused(guide(Polyline{{Vec3::Zero()}, -1e-3}), "the radius is -0.001, must be at least 0 m");
  refused(guide(Box{{0.0, 1.0, 1.0}}), "the size of the box must be positive");
  refused(guide(Box{{kNan, 1.0, 1.0}}), "the size of the box must be positive");
  refused(guide(Plane{}, 1.0, 1.0, {{kNan, 0.0, 0.0}, Mat3::Identity()}), "the position must be within 100 m");
  refused(guide(Plane{}, 1.0, 1.0, {Vec3::Zero(), 2.0 * Mat3::Identity()}), "the rotation is not");
  CHECK_THROWS_WITH(scene.setGuides(std::vector<Guide>(9, line())),
                    ContainsSubstring("has 9 guides, must have at most 8"));
  CHECK(scene.guides() == nullptr);
  scene.setGuides({line()});
  const Scene copy = scene;
  CHECK(copy.guides() == scene.guides());
  scene.setGuides({});
  CHECK(scene.guides() == nullptr);
}

}  // namespace enamel::test_guidance
