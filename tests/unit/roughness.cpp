// Rough surfaces: statistics of the height, what a ball feels of it, and a tool that slides over it on simulated
// devices.
#include "enamel/render/roughness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "enamel/sim/push.hpp"
#include "support/bench.hpp"
#include "support/catch.hpp"

namespace enamel::test_roughness {

namespace {

constexpr double kTick = test::kTick;

Material rough(double roughness, double wavelength) {
  Material material;
  material.roughness = roughness;
  material.wavelength = wavelength;
  return material;
}

// A place within 1 m of the origin, by number.
Vec3 place(std::uint32_t number) {
  const auto share = [&](std::uint32_t axis) { return 2.0 * randomInstant(7 + axis, number) - 1.0; };
  return {share(0), share(1), share(2)};
}

Vec3 direction(std::uint32_t number) { return place(1000000 + number).normalized(); }

double rms(const std::vector<double>& values) {
  double sum = 0.0, squares = 0.0;
  for (const double v : values) sum += v, squares += v * v;
  const auto n = static_cast<double>(values.size());
  return std::sqrt(squares / n - sum * sum / (n * n));
}

}  // namespace

TEST_CASE("the height of a rough surface has the stated root mean square and no mean", "[roughness]") {
  const Material material = rough(5e-6, 4e-4);
  double sum = 0.0;
  std::vector<double> heights;
  for (std::uint32_t i = 0; i < 20000; ++i) {
    heights.push_back(heightAt(material, 0.1 * place(i), 0.0, 0.0).height);
    sum += heights.back();
  }
  // The standard deviation of the mean is 0.7 % of the roughness, that of the root mean square about 0.5 %.
  CHECK(std::abs(sum / 20000.0) < 0.03 * material.roughness);
  CHECK(rms(heights) == Approx(material.roughness).epsilon(0.025));
  std::vector<double> felt;  // by a ball of 2 mm: lib/docs/surfaces.md
  for (std::uint32_t i = 0; i < 20000; ++i)
    felt.push_back(heightAt(rough(6e-6, 3e-4), 0.1 * place(i), 1e-3, 0.0).height);
  CHECK(rms(felt) == Approx(5.2e-6).epsilon(0.03));
  CHECK(heightAt(Material{}, Vec3(1e-3, 2e-3, 3e-3), 0.0, 0.0).height == 0.0);
}

TEST_CASE("the gradient of a rough surface is the derivative of its height", "[roughness]") {
  const Material material = rough(5e-6, 4e-4);
  constexpr double kStep = 1e-8;  // m: errors of about (2 pi step / shortest wavelength)^2, and of rounding
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Vec3 at = 0.1 * place(i);
    const SurfaceHeight surface = heightAt(material, at, 1e-4, 1e-5);
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 step = kStep * Vec3::Unit(axis);
      const double difference =
          heightAt(material, at + step, 1e-4, 1e-5).height - heightAt(material, at - step, 1e-4, 1e-5).height;
      CHECK(std::abs(surface.gradient[axis] - 0.5 * difference / kStep) < 1e-5);
    }
  }
}

TEST_CASE("the spectrum of a rough surface falls as that of a self-affine one", "[roughness]") {
  // The spectrum of a profile goes with the wave number to the power -(1 + 2 H). Waves that run obliquely to the line
  // look longer, so the first octave is not used.
  const Material material = rough(5e-6, 4e-4);
  constexpr int kSamples = 1024, kLines = 300, kBins = 8;
  constexpr double kSpacing = 1e-5;
  const double lowest = 2.0 / material.wavelength, highest = 8.0 / material.wavelength;
  std::array<double, kBins> power{};
  for (std::uint32_t line = 0; line < kLines; ++line) {
    const Vec3 from = 0.1 * place(line), along = direction(line);
    std::vector<double> height(kSamples);
    for (int i = 0; i < kSamples; ++i) {
      const double window = 0.5 - 0.5 * std::cos(2.0 * M_PI * (i + 0.5) / kSamples);
      height[static_cast<std::size_t>(i)] = window * heightAt(material, from + i * kSpacing * along, 0.0, 0.0).height;
    }
    for (int bin = 0; bin < kBins; ++bin) {
      const double frequency = lowest * std::pow(highest / lowest, (bin + 0.5) / kBins);
      double cosine = 0.0, sine = 0.0;
      for (int i = 0; i < kSamples; ++i) {
        cosine += height[static_cast<std::size_t>(i)] * std::cos(2.0 * M_PI * frequency * kSpacing * i);
        sine += height[static_cast<std::size_t>(i)] * std::sin(2.0 * M_PI * frequency * kSpacing * i);
      }
      power[static_cast<std::size_t>(bin)] += cosine * cosine + sine * sine;
    }
  }
  double xx = 0.0, xy = 0.0, x0 = 0.5 * (kBins - 1);
  for (int bin = 0; bin < kBins; ++bin) {
    xx += (bin - x0) * (bin - x0);
    xy += (bin - x0) * std::log(power[static_cast<std::size_t>(bin)]);
  }
  const double slope = xy / xx / (std::log(highest / lowest) / kBins);
  INFO("slope " << slope);
  CHECK(slope == Approx(-2.6).margin(0.35));
}

TEST_CASE("a ball feels of a rough surface what it can reach", "[roughness]") {
  // The ball's centre moves on the surface dilated by the ball. heightAt() reduces each wave instead.
  const Material material = rough(6e-6, 4e-4);
  const double radius = GENERATE(5e-5, 2.5e-4, 1e-3);
  constexpr double kSpacing = 1e-5;
  const int reach = static_cast<int>(std::sqrt(8.0 * 6e-6 * radius) / kSpacing) + 1;  // drops below 4 roughnesses
  std::vector<double> dilated, felt;
  for (std::uint32_t i = 0; i < 150; ++i) {
    const Vec3 centre(0.05 * place(i).x(), 0.05 * place(i).y(), 0.0);
    double highest = -1.0;
    for (int x = -reach; x <= reach; ++x)
      for (int y = -reach; y <= reach; ++y) {
        const double aside = kSpacing * std::hypot(x, y);
        if (aside >= radius) continue;
        const double drop = radius - std::sqrt(radius * radius - aside * aside);
        highest = std::max(highest, heightAt(material, centre + kSpacing * Vec3(x, y, 0.0), 0.0, 0.0).height - drop);
      }
    dilated.push_back(highest);
    felt.push_back(heightAt(material, centre, radius, 0.0).height);
  }
  INFO("radius " << radius << " m: dilated " << rms(dilated) << ", felt " << rms(felt));
  CHECK(rms(felt) == Approx(rms(dilated)).epsilon(0.3));
}

TEST_CASE("waves that a tick cannot sample do not exist", "[roughness]") {
  const Material material = rough(5e-6, 4e-4);
  for (std::uint32_t i = 0; i < 100; ++i) {
    const Vec3 at = 0.1 * place(i);
    CHECK(heightAt(material, at, 0.0, 0.25 * material.wavelength).height == 0.0);
    CHECK(heightAt(material, at, 0.0, material.wavelength / 80.0 * 0.999).height ==
          heightAt(material, at, 0.0, 0.0).height);
  }
}

namespace {

struct Slide {
  double follows = 0.0;  // correlation of the tool's height with the surface
  double height = 0.0;   // root mean square of the tool's height, m
  double given = 0.0;    // energy that the motors gave, J
  GuardReason fault = GuardReason::none;
};

// Slide to and fro over a plane at up to `speed` m/s for 2 s, pressed with the force of the device.
Slide slide(const test::BenchDevice& device, const Obstacle& wall, int delay, double speed, bool encoders = true) {
  test::Bench bench({device.file, device.plant, wall, delay, false, encoders});
  constexpr double kRate = 2.0 * M_PI * 1.0;  // turns of the target, rad/s
  const double reach = speed / kRate;
  std::vector<double> tool, surface;
  Slide result;
  for (int i = 0; i < 2500; ++i) {
    const Vec3 before = bench.tool().position;
    REQUIRE(bench.step([&](double time, const Pose& pose, const Vec6& twist) {
      const double angle = kRate * std::max(0.0, time - 0.5);
      const Vec3 target(reach * std::sin(angle), reach * (1.0 - std::cos(angle)), 0.0);
      const Vec3 rate = kRate * reach * Vec3(std::cos(angle), std::sin(angle), 0.0);
      Vec3 force =
          2000.0 * (target - pose.position) + 10.0 * ((time > 0.5 ? rate : Vec3(Vec3::Zero())) - twist.head<3>());
      force.z() = -(time < 0.05 ? 0.3 : device.force) - 3.0 * twist[2];
      return force;
    }));
    const Kinematics& k = bench.haptics->frame().kinematics;
    const Vec3 command = wrenchOf(k, bench.haptics->frame().command - k.gravity).head<3>();
    result.fault = bench.haptics->guard().fault();
    if (i < 500) continue;
    result.given += command.dot(bench.tool().position - before);
    tool.push_back(bench.tool().position.z());
    surface.push_back(heightAt(wall.material, Vec3(before.x(), before.y(), 0.0), 0.0, 0.0).height);
  }
  double both = 0.0, toolMean = 0.0, surfaceMean = 0.0;
  const auto n = static_cast<double>(tool.size());
  for (std::size_t i = 0; i < tool.size(); ++i) toolMean += tool[i] / n, surfaceMean += surface[i] / n;
  for (std::size_t i = 0; i < tool.size(); ++i) both += (tool[i] - toolMean) * (surface[i] - surfaceMean) / n;
  result.height = rms(tool);
  const double size = result.height * rms(surface);
  result.follows = size > 0.0 ? both / size : 0.0;
  return result;
}

Obstacle plane(const Material& material) {
  Obstacle wall = halfSpace("wall", Vec3::Zero(), Vec3::UnitZ());
  wall.material = material;
  return wall;
}

}  // namespace

TEST_CASE("a tool slides over a rough wall without a fault, and the wall gives no energy", "[roughness]") {
  const test::BenchDevice device = test::kBenchDevices[GENERATE(0, 1, 2)];
  const int delay = GENERATE(0, 1, 2);
  const Slide rough20 = slide(device, plane(rough(2e-5, 1e-3)), delay, 0.03);
  INFO(device.file << ", delay " << delay << ": given " << rough20.given << " J");
  CHECK(rough20.fault == GuardReason::none);
  CHECK(rough20.given < 1e-3);  // less than the goal for a pressed smooth wall
}

TEST_CASE("position control follows a rough wall on the TAU", "[roughness]") {
  const int delay = GENERATE(0, 1, 2);
  const Slide felt = slide(test::kBenchDevices[0], plane(rough(5e-6, 1e-3)), delay, 0.01);
  INFO("delay " << delay << ": correlation " << felt.follows << ", height " << felt.height << " m");
  CHECK(felt.follows > 0.8);
  CHECK(felt.height == Approx(5e-6).margin(4e-6));
  CHECK(slide(test::kBenchDevices[0], plane(Material{}), delay, 0.01).height < 0.5 * felt.height);
}

TEST_CASE("a bur that spins feels no roughness", "[roughness]") {
  ContactSnapshot contacts;
  contacts.count = 2;
  for (int i = 0; i < 2; ++i) {
    Contact& contact = contacts.contacts[static_cast<std::size_t>(i)];
    contact.material = rough(2e-5, 1e-3);
    contact.part = i;
    contact.point = Vec3(1e-3, 2e-3, 0.0);
  }
  Tool tool;
  tool.count = 2;
  const Scene scene = flatWall();
  Kinematics at;
  at.jacobian = decltype(at.jacobian)::Zero(6, 1);
  roughen(scene, tool, at, JointVector::Zero(1), kTick, {1, 1}, contacts);
  const bool isFirst = contacts.contacts[0].part == 0;  // the deeper one is first
  const Contact& rest = contacts.contacts[isFirst ? 0 : 1];
  const Contact& bur = contacts.contacts[isFirst ? 1 : 0];
  CHECK(bur.gap == 0.0);
  CHECK(bur.normal == Vec3::UnitZ());
  const SurfaceHeight surface = heightAt(rest.material, Vec3(1e-3, 2e-3, 0.0), 0.0, 0.0);
  CHECK(rest.gap == -surface.height);
  CHECK(contacts.contacts[0].gap <= contacts.contacts[1].gap);
  const Vec3 tilted(-surface.gradient.x(), -surface.gradient.y(), 1.0);
  CHECK(rest.normal.isApprox(tilted.normalized(), 1e-12));
}

}  // namespace enamel::test_roughness
