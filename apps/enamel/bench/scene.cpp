// Measures scenes. One row for each kind of obstacle has the contacts of a ball of 1 mm that slides over it. Then come
// a servo with one contact and with six.
#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "bench/scene_cost.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/render/tick.hpp"
#include "mesh_generator.hpp"

namespace enamel::bench {
namespace {

constexpr double kTickPeriod = 1e-3;  // s
constexpr double kSlide = 30e-6;      // m a tick
constexpr double kHover = 50e-6;      // m
constexpr double kBall = 0.5e-3;      // m

Tool ballTool() {
  Tool tool;
  tool.parts[0].radius = kBall;
  return tool;
}

Scene sceneOf(Shape shape, double thickness = 0.0) {
  Scene scene;
  Obstacle obstacle{"obstacle", std::move(shape), Pose(), Vec6::Zero(), {}};
  obstacle.thickness = thickness;
  scene.add(obstacle);
  return scene;
}

// Six planes around a ball that rests between them.
Scene pit() {
  Scene scene;
  for (int i = 0; i < 6; ++i) {
    const Vec3 normal = Vec3(std::cos(i * M_PI / 3.0), std::sin(i * M_PI / 3.0), 1.0).normalized();
    scene.add(halfSpace(fmt::format("plane {}", i), -kBall * normal, normal));
  }
  return scene;
}

// `distance`: distance of an outside point from the obstacle, m. Its time is the reference if `isReference`.
Measurement measure(const std::string& name, Scene& scene, const Vec3& start, int ticks, double reach,
                    const std::function<double(const Vec3&)>& distance, bool isReference, bool moves = false) {
  const Tool tool = ballTool();
  std::vector<Pose> poses = slideOver(scene, tool, start, ticks, reach);
  std::vector<Pose> frames(moves ? poses.size() : 0);
  for (std::size_t i = 0; i < frames.size(); ++i) {  // the obstacle moves, and the tool with it
    const double t = kTickPeriod * static_cast<double>(i);
    frames[i].position = {1e-3 * std::sin(5.0 * t), 2e-3 * std::sin(3.0 * t), 0.0};
    frames[i].rotation = Eigen::AngleAxisd(0.1 * std::sin(4.0 * t), Vec3::UnitZ()).toRotationMatrix();
    poses[i].position = frames[i].position + frames[i].rotation * poses[i].position;
  }
  double error = 0.0;
  int failures = 0;
  const int every = std::max(1, ticks / (isReference ? 20 : 1000));
  std::vector<double> reference_us;
  const auto before = [&](int i) {
    if (moves) failures += scene.move(0, frames[static_cast<std::size_t>(i)], Vec6::Zero()) != Status::ok;
  };
  const auto check = [&](int i, const ContactSnapshot& contacts) {
    if (i % every != 0 || contacts.count == 0 || contacts.contacts[0].gap < 0.0) return;
    Vec3 p = poses[static_cast<std::size_t>(i)].position;
    if (moves) {
      const Pose& frame = frames[static_cast<std::size_t>(i)];
      p = frame.rotation.transpose() * (p - frame.position);
    }
    double exact = 0.0;
    reference_us.push_back(timeOnce([&] { exact = distance(p); }));
    error = std::max(error, std::abs(contacts.contacts[0].gap + kBall - exact));
  };
  const SceneCost cost = costOf(scene, tool, poses, before, check);
  Measurement row = rowOf(name, cost.times_us, failures > 0 || reference_us.empty() ? 1.0 : error,
                          isReference ? "m, gap, against all triangles" : "m, gap, against its formula");
  if (isReference && !reference_us.empty()) {
    std::sort(reference_us.begin(), reference_us.end());
    row.reference_us = percentile(reference_us, 0.5);
  }
  return row;
}

// Measure a whole tick of position control on the TAU, pressed into the scene.
Measurement measureServo(const std::string& name, const Scene& scene, int ticks) {
  const TauMechanism mechanism(nominalDevice());
  PositionControlRenderer servo(positionControlFor(mechanism, kTickPeriod, 0, 0));
  GuardOptions guard = guardFor(mechanism, kTickPeriod);
  guard.energy = guard.oscillation = kUnlimited;  // the path does not depend on the torques
  HapticTick tick(mechanism, scene, ballTool(), servo, guard);
  Kinematics k;
  Command command;
  std::vector<double> times_us;
  int faults = 0, most = 0;
  for (int i = 0; i < ticks; ++i) {
    const double t = kTickPeriod * i;
    Pose pose;
    Vec6 twist = Vec6::Zero();
    pose.position = {2e-5 * std::sin(3.0 * t), 2e-5 * std::cos(2.0 * t), 2e-5 * std::sin(7.0 * t)};
    twist.head<3>() << 6e-5 * std::cos(3.0 * t), -4e-5 * std::sin(2.0 * t), 1.4e-4 * std::cos(7.0 * t);
    faults += mechanism.reach(pose, twist, false, k) != Status::ok;
    enamel::Measurement measured;
    measured.time = t;
    measured.q = k.q;
    measured.rates = k.rates;
    times_us.push_back(timeOnce([&] { faults += tick(measured, command) != Status::ok; }));
    most = std::max(most, tick.frame().contacts.count);
  }
  Measurement row = rowOf(fmt::format("whole tick of position control, {} ({} contacts)", name, most), times_us, faults,
                          "ticks that were not ok");
  row.goal_us = most > 1 ? 8.0 : 3.0;
  return row;
}

}  // namespace

double exhaustiveDistance(const TriangleMesh& mesh, const Vec3& p) {
  double least = 1e300;
  for (const auto& t : mesh.triangles) {
    const std::array<Vec3, 3> v = {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]};
    const Vec3 normal = (v[1] - v[0]).cross(v[2] - v[0]);
    bool inside = normal.squaredNorm() > 0.0;
    for (int i = 0; i < 3; ++i) {
      const Vec3 edge = v[(i + 1) % 3] - v[i], way = p - v[i];
      inside = inside && normal.cross(edge).dot(way) >= 0.0;
      const double length = edge.squaredNorm();
      const double s = length > 0.0 ? std::min(std::max(way.dot(edge) / length, 0.0), 1.0) : 0.0;
      least = std::min(least, (way - s * edge).norm());
    }
    if (inside) least = std::min(least, std::abs(normal.dot(p - v[0])) / normal.norm());
  }
  return least;
}

std::vector<Pose> slideOver(const Scene& scene, const Tool& tool, const Vec3& start, int ticks, double reach) {
  Numbers numbers(25);
  ToolCache cache = makeToolCache(scene, tool);
  std::vector<Pose> poses;
  Pose pose;
  pose.position = start;
  Vec3 way = numbers.vector().normalized(), touched = start;
  bool isOnIt = false;
  for (int i = 0; i < ticks; ++i) {
    poses.push_back(pose);
    const Contact nearest = nearestContact(scene, tool, pose, &cache);
    if (nearest.gap == kNoLimit) continue;
    const double wanted = 0.5 * kHover * (1.0 + std::sin(0.02 * i));
    if (!isOnIt && nearest.gap < kHover) {
      isOnIt = true;
      touched = pose.position;
    }
    if (isOnIt && (pose.position - touched).norm() > reach) way = touched - pose.position;
    way = (way.normalized() + 0.1 * numbers.vector()).eval();
    way -= nearest.normal * nearest.normal.dot(way);
    if (isOnIt) pose.position += std::min(kSlide, reach) * way.normalized();
    pose.position += std::clamp(wanted - nearest.gap, -kHover, kHover) * nearest.normal;
  }
  return poses;
}

SceneCost costOf(const Scene& scene, const Tool& tool, const std::vector<Pose>& poses,
                 const std::function<void(int)>& before,
                 const std::function<void(int, const ContactSnapshot&)>& after) {
  ToolTrack track = makeToolTrack(scene, tool);
  ContactSnapshot contacts;
  SceneCost cost;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (before) before(static_cast<int>(i));
    cost.times_us.push_back(
        timeOnce([&] { keep(followContacts(scene, tool, poses[i], kContactMargin, track, contacts)); }));
    cost.most = std::max(cost.most, contacts.count);
    cost.touching += (contacts.count > 0 ? 1.0 : 0.0) / static_cast<double>(poses.size());
    if (after) after(static_cast<int>(i), contacts);
  }
  std::sort(cost.times_us.begin(), cost.times_us.end());
  return cost;
}

std::vector<Measurement> measureScene(double scale) {
  const int ticks = std::max(2000, static_cast<int>(10000 * scale));
  constexpr double kReach = 3e-3;  // m
  const Vec3 above(1e-4, 2e-4, 5e-3);
  std::vector<Measurement> rows;
  const auto analytic = [&](const std::string& name, const Shape& shape, const auto& body) {
    Scene scene = sceneOf(shape);
    rows.push_back(measure(
        name, scene, above, ticks, kReach, [&](const Vec3& p) { return signedDistance(body, p).distance; }, false));
  };
  analytic("plane", HalfSpace{}, HalfSpace{});
  analytic("box", Box{{3e-3, 3e-3, 3e-3}}, Box{{3e-3, 3e-3, 3e-3}});
  const Vec3 aboveMolar(1e-4, 2e-4, 9e-3);
  for (const auto& [size, levels] : {std::pair<const char*, int>{"2 k", 4}, {"33 k", 6}, {"524 k", 8}}) {
    if (scale < 0.2 && levels > 6) continue;
    const TriangleMesh mesh = app::makeMolar(levels);
    const auto model = std::make_shared<const MeshModel>(mesh);
    const auto exact = [&](const Vec3& p) { return exhaustiveDistance(mesh, p); };
    Scene scene = sceneOf(model);
    rows.push_back(measure(fmt::format("molar of {} triangles", size), scene, aboveMolar, ticks, kReach, exact, true));
    if (levels != 6) continue;
    rows.push_back(measure("the same, moving", scene, aboveMolar, ticks, kReach, exact, true, true));
    TriangleMesh scan = mesh;  // a scan has no floor
    scan.triangles.erase(std::remove_if(scan.triangles.begin(), scan.triangles.end(),
                                        [&](const auto& t) { return scan.vertices[t[0]].z() < 1e-3; }),
                         scan.triangles.end());
    const auto openModel = std::make_shared<const MeshModel>(scan);
    const auto exactOpen = [&](const Vec3& p) { return exhaustiveDistance(scan, p); };
    Scene open = sceneOf(openModel);
    rows.push_back(measure("the same, an open scan", open, aboveMolar, ticks, kReach, exactOpen, true));
    Scene sheet = sceneOf(openModel, 1e-4);
    rows.push_back(measure(
        "the same, a sheet of 0.1 mm", sheet, aboveMolar, ticks, kReach,
        [&](const Vec3& p) { return exactOpen(p) - 0.5e-4; }, true));
    const auto solid =
        std::make_shared<const Solid>(*model, std::vector<SolidLayer>{SolidLayer()}, SolidOptions{1e-4, 0});
    Scene cut = sceneOf(solid);
    rows.push_back(measure("the same, a solid of 0.1 mm cells", cut, aboveMolar, ticks, kReach, exact, true));
  }
  {
    Scene scene = pit();
    rows.push_back(measure(
        "six planes", scene, Vec3(0, 0, 1e-3), ticks, 5e-5,
        [&](const Vec3& p) {
          double least = kNoLimit;
          for (const Obstacle& o : scene.obstacles())
            least = std::min(least, o.pose.rotation.col(2).dot(p - o.pose.position));
          return least;
        },
        false));
  }
  rows.push_back(measureServo("a plane", flatWall(Vec3(0, 0, -kBall)), ticks));
  rows.push_back(measureServo("six planes", pit(), ticks));
  return rows;
}

}  // namespace enamel::bench
