// Measures a solid that is cut: a molar with cells of 0.1 mm, and a ball of 1 mm.
#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "bench/measurement.hpp"
#include "enamel/collision/contacts.hpp"
#include "enamel/collision/solid_surface.hpp"
#include "enamel/render/drill.hpp"
#include "mesh_generator.hpp"

namespace enamel::bench {
namespace {

constexpr double kCell = 1e-4, kRadius = 0.5e-3;  // m
constexpr double kStep = 30e-6;                   // m: 30 mm/s at 1 kHz
constexpr double kReach = 1e-3;                   // m

double sum(const RemovedVolume& volume) { return std::accumulate(volume.begin(), volume.end(), 0.0); }

Tool ball() {
  Tool tool;
  tool.parts[0].radius = kRadius;
  return tool;
}

// Return whether the radii of curvature at a place exceed 1 mm. Test: in all directions the height of the mesh above
// the tangent plane is at most that of a parabola.
bool isGentle(const MeshModel& mesh, const SurfacePoint& place) {
  constexpr double kAside = 0.3e-3, kRadiusOfCurvature = 1e-3;  // m
  const Vec3 u = place.normal.unitOrthogonal(), v = place.normal.cross(u);
  for (int k = 0; k < 8; ++k) {
    const Vec3 aside = kAside * (std::cos(0.25 * M_PI * k) * u + std::sin(0.25 * M_PI * k) * v);
    const Vec3 there = signedDistance(mesh, place.point + aside).point - place.point;
    const double height = place.normal.dot(there);
    if (std::abs(height) > 0.5 * (there.squaredNorm() - height * height) / kRadiusOfCurvature) return false;
  }
  return true;
}

// Measure a ball that moves around on the molar, up to 0.3 mm above it.
void measureQueries(const MeshModel& mesh, const std::shared_ptr<Solid>& solid, int calls,
                    std::vector<Measurement>& rows) {
  Scene scene;
  scene.add({"molar", std::shared_ptr<const Solid>(solid), Pose(), Vec6::Zero(), {}});
  const Tool tool = ball();
  ToolTrack track = makeToolTrack(scene, tool);
  Numbers numbers(22);
  Vec3 p(0.0, 0.0, 8e-3), way = Vec3::UnitX();
  std::vector<double> distances_us, plain_us, meshes_us, contacts_us;
  double error = 0.0, gapError = 0.0;
  ContactSnapshot contacts;
  ProximityCache cache;
  SolidCache solidCache;
  for (int i = 0; i < calls; ++i) {
    const SurfacePoint near = signedDistance(mesh, p + kStep * way);
    way += 0.1 * numbers.vector();
    way = (way - near.normal * near.normal.dot(way)).normalized();
    p = near.point + (kRadius + 0.15e-3 * (1.0 + std::sin(0.01 * i))) * near.normal;
    SurfacePoint exact;
    SolidPoint found;
    meshes_us.push_back(timeOnce([&] { exact = signedDistance(mesh, p, &cache); }));
    distances_us.push_back(timeOnce([&] { found = signedDistance(*solid, p, kNoLimit, &solidCache); }));
    plain_us.push_back(timeOnce([&] { keep(signedDistance(*solid, p)); }));
    error = std::max(error, std::abs(found.distance - exact.distance));
    Pose pose;
    pose.position = p;
    contacts_us.push_back(timeOnce([&] { keep(followContacts(scene, tool, pose, kReach, track, contacts)); }));
    const double gap = contacts.count > 0 ? contacts.contacts[0].gap : kReach;
    if (isGentle(mesh, exact)) gapError = std::max(gapError, std::abs(gap - (exact.distance - kRadius)));
  }
  std::sort(meshes_us.begin(), meshes_us.end());
  for (const auto& [cached, times_us] : {std::pair{", cache", distances_us}, std::pair{", no cache", plain_us}}) {
    rows.push_back(rowOf(fmt::format("signed distance, molar at 0.1 mm, haptic path{}", cached), times_us, error,
                         "m, against the mesh"));
    rows.back().reference_us = percentile(meshes_us, 0.5);
  }
  rows.push_back(rowOf("contacts of a 1 mm ball with it, followed", contacts_us, gapError,
                       "m, gap against the mesh where it curves by radii above 1 mm"));
}

// Measure a ball that is pressed with 2 N and moves to random goals; contacts push it out of the solid.
void measureCutting(const std::shared_ptr<Solid>& solid, const Tool& tool, const Bur& bur, const std::string& what,
                    int calls, std::vector<Measurement>& rows) {
  Scene scene;
  scene.add({"molar", std::shared_ptr<const Solid>(solid), Pose(), Vec6::Zero(), {}});
  ToolTrack track = makeToolTrack(scene, tool);
  Drill drill(tool, {solid}, bur);
  drill.spin(true);
  Numbers numbers(22);
  Pose at;
  at.position.z() = 8e-3;
  Vec3 goal = Vec3::Zero();
  const double whole = sum(solid->volume());
  double removed = 0.0, error = 0.0;
  std::vector<double> cuts_us, bricks_us;
  ContactSnapshot contacts;
  SolidSurface surface;
  for (int i = 0; i < calls; ++i) {
    if (i % 300 == 0) goal = 3e-3 * numbers.vector();
    const Vec3 way = goal - at.position;
    at.position += std::min(kStep, way.norm()) * way.normalized();
    const Vec3 force = contacts.count > 0 ? Vec3(2.0 * contacts.contacts[0].normal) : Vec3(Vec3::Zero());
    const double time_us = timeOnce([&] {
      keep(followContacts(scene, tool, at, kReach, track, contacts));
      drill.vibrate(at, 1e-3, contacts);
      drill.correct(contacts);
      drill.cut(scene, at, force, 1e-3, contacts);
    });
    const double taken = sum(drill.removed());
    removed += taken;
    if (taken > 0.0) cuts_us.push_back(time_us);
    for (int k = 0; k < contacts.count; ++k)
      at.position -= 0.5 * std::min(contacts.contacts[k].gap + 2e-5, 0.0) * contacts.contacts[k].normal;
    for (int brick; (brick = solid->takeChanged()) >= 0;) {
      surface.clear();
      const double extraction_us = timeOnce([&] { appendSurface(*solid, brick, solid->samples(brick), surface); });
      if (surface.mesh.triangles.empty()) continue;
      bricks_us.push_back(extraction_us);
      error = std::max(error, std::abs(signedDistance(*solid, surface.mesh.vertices[0]).distance));
    }
  }
  const double gone = whole - sum(solid->volume());
  rows.push_back(rowOf(fmt::format("tick that cuts with a 1 mm {} ({} of {})", what, cuts_us.size(), calls), cuts_us,
                       std::abs(removed - gone) / gone, "volume that was said to be removed, relative"));
  rows.back().goal_us = 60.0;
  rows.push_back(
      rowOf("surface of a brick that a tick changed", bricks_us, error, "m, a vertex from the surface of queries"));
}

}  // namespace

std::vector<Measurement> measureSolid(double scale) {
  std::vector<Measurement> rows;
  const MeshModel mesh(app::makeMolar(6));
  const auto solid = std::make_shared<Solid>(
      mesh, std::vector<SolidLayer>{{"enamel", {}, 3.4e9, 0.0, nullptr}, {"dentine", {}, 0.6e9, 1e-3, nullptr}},
      SolidOptions{kCell});
  const int calls = std::max(2000, static_cast<int>(20000 * scale));
  measureQueries(mesh, solid, calls, rows);
  measureCutting(std::make_shared<Solid>(*solid), ball(), {0, 0.5, 2000.0}, "ball", calls, rows);
  const double constant_us = rows[rows.size() - 2].median_us;
  Bur slow{0, 15.0, 67.0};  // it removes as much
  slow.torque = 1.0;
  slow.runOut = 5e-6;
  slow.blades = 1;
  slow.shaftCompliance = 1e-5;
  slow.shaftFrequency = 100.0;
  measureCutting(std::make_shared<Solid>(*solid), ball(), slow, "ball that slows down, vibrates and chatters", calls,
                 rows);
  rows.pop_back();
  rows.back().reference_us = constant_us;
  measureCutting(std::make_shared<Solid>(*solid), toolOf("flame-010-040"), {0, 0.5, 2000.0}, "flame", calls, rows);
  rows.pop_back();
  rows.back().reference_us = constant_us;
  rows.back().goal_us = kNoGoal;
  return rows;
}

}  // namespace enamel::bench
