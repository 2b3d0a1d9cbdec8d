#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <memory>

#include "bench/scene_cost.hpp"
#include "commands.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/core/error.hpp"

namespace enamel::app {
namespace {

struct SceneOptions {
  std::string file;
  bool explain = false;
};

// From lib/docs/collision.md and contacts.hpp.
constexpr double kBytesOfTriangle = 244.0, kBytesOfCache = 19e3;

std::string whatIs(const HalfSpace&) { return "half space: a plane, nothing is built"; }
std::string whatIs(const Box&) { return "box: a formula, nothing is built"; }
std::string whatIs(const Sphere&) { return "sphere: a formula, nothing is built"; }
std::string whatIs(const Capsule&) { return "capsule: a formula, nothing is built"; }
std::string whatIs(const std::shared_ptr<const MeshModel>& mesh) {
  const auto triangles = mesh->mesh().triangles.size();
  return fmt::format("mesh of {} triangles, {:.2g} MB: {}", triangles,
                     1e-6 * kBytesOfTriangle * static_cast<double>(triangles), describe(*mesh));
}
std::string whatIs(const std::shared_ptr<const Solid>& solid) {
  std::string layers;
  for (const SolidLayer& layer : solid->layers()) layers += (layers.empty() ? "" : ", ") + layer.name;
  return fmt::format("solid of {} bricks, cells of {:.3g} mm, {:.2g} MB{}{}", solid->bricks(), 1e3 * solid->cell(),
                     1e-6 * static_cast<double>(solid->bytes()), layers.empty() ? "" : ": ", layers);
}

std::string count(int number, const char* what) { return fmt::format("{} {}{}", number, what, number == 1 ? "" : "s"); }

std::string materialText(const Material& m) {
  std::string text = std::isinf(m.stiffness) ? "rigid" : fmt::format("{:.4g} N/m", m.stiffness);
  text += m.friction > 0.0 ? fmt::format(", friction {:.3g}", m.friction) : ", without friction";
  if (m.slidingFriction != m.friction) text += fmt::format(", {:.3g} while sliding", m.slidingFriction);
  if (m.stribeck > 0.0) text += fmt::format(" (Stribeck speed {:.3g} m/s)", m.stribeck);
  if (m.viscosity > 0.0) text += fmt::format(", {:.3g} N s/m", m.viscosity);
  if (m.roughness > 0.0)
    text += fmt::format(", rough: {:.3g} um, waves up to {:.3g} mm", 1e6 * m.roughness, 1e3 * m.wavelength);
  if (!m.isLayer()) return text;
  if (m.exponent != 1.0) text += fmt::format(", exponent {:.3g} (the stiffness is that at 1 mm)", m.exponent);
  if (std::isfinite(m.thickness)) text += fmt::format(", layer of {:.3g} mm", 1e3 * m.thickness);
  if (m.hysteresis > 0.0) text += fmt::format(", hysteresis {:.3g} s/m", m.hysteresis);
  if (std::isfinite(m.puncture)) text += fmt::format(", breaks at {:.3g} N", m.puncture);
  return text;
}

// The axes along and about which an obstacle moves.
std::string suspensionText(const Suspension& s) {
  constexpr const char* kAxes[] = {"along x", "along y", "along z", "about x", "about y", "about z"};
  std::string text;
  for (int i = 0; i < 6; ++i) {
    const double m = s.inertia[i], k = s.stiffness[i];
    if (m == 0.0) continue;  // locked
    text += fmt::format("{}{} {:.3g} {}", text.empty() ? "moves " : "; ", kAxes[i], m, i < 3 ? "kg" : "kg m^2");
    text += k > 0.0
                ? fmt::format(", {:.5g} {} ({:.4g} Hz)", k, i < 3 ? "N/m" : "N m/rad", std::sqrt(k / m) / (2.0 * M_PI))
                : std::string(", loose");
  }
  return text;
}

constexpr const char* kGuides[] = {"line", "plane", "half space", "box"};  // in the order of GuideShape

void printCost(const std::string& name, const Scene& scene, const SceneFile& file) {
  constexpr int kTicks = 5000;
  constexpr double kReach = 5e-3;  // m
  const std::vector<Pose> poses = bench::slideOver(scene, file.tool, file.start, kTicks, kReach);
  const bench::SceneCost cost = bench::costOf(scene, file.tool, poses);
  fmt::print("{:<24} {:>10.3g} {:>10.3g} {:>10.3g} {:>9} {:>9.0f}\n", name, bench::percentile(cost.times_us, 0.5),
             bench::percentile(cost.times_us, 0.99), bench::percentile(cost.times_us, 0.999), cost.most,
             100.0 * cost.touching);
}

void explain(const SceneFile& file, double seconds) {
  int meshes = 0;
  for (const auto& mesh : file.meshes) meshes += mesh != nullptr;
  const auto obstacles = static_cast<int>(file.scene.obstacles().size());
  fmt::print("\nread and built in {:.3g} s\n", seconds);
  fmt::print("a tick queries {} of part and obstacle, {} of them with a mesh: {:.3g} KB of lists of near triangles\n",
             count(file.tool.count * obstacles, "pair"), file.tool.count * meshes,
             1e-3 * kBytesOfCache * meshes * file.tool.count);
  fmt::print("\nthe tool slides over the obstacles at 30 mm/s; time for the contacts of a tick, us:\n");
  fmt::print("{:<24} {:>10} {:>10} {:>10} {:>9} {:>9}\n", "", "median", "p99", "p99.9", "at once", "touching %");
  if (obstacles > 1)
    for (const Obstacle& obstacle : file.scene.obstacles()) {
      Scene alone;
      alone.add(obstacle);
      printCost(obstacle.name + " alone", alone, file);
    }
  printCost("the scene", file.scene, file);
}

void run(const SceneOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const SceneFile file = loadScene(options.file);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  fmt::print("{}: the tool has {}, its TCP begins at {:.4g} {:.4g} {:.4g} m\n", file.name,
             count(file.tool.count, "part"), file.start.x(), file.start.y(), file.start.z());
  for (const Obstacle& obstacle : file.scene.obstacles()) {
    fmt::print("{:<12} {}\n", obstacle.name,
               std::visit([](const auto& shape) { return whatIs(shape); }, obstacle.shape));
    if (const auto* solid = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape)) {
      for (const SolidLayer& layer : (*solid)->layers())
        fmt::print("{:<12} {}: {}\n", "", layer.name, materialText(layer.material));
    } else {
      fmt::print("{:<12} {}\n", "", materialText(obstacle.material));
    }
    if (obstacle.tap.frequency > 0.0) fmt::print("{:<12} a tap rings at {:.3g} Hz\n", "", obstacle.tap.frequency);
    if (obstacle.suspension) fmt::print("{:<12} {}\n", "", suspensionText(*obstacle.suspension));
  }
  if (const auto& guides = file.scene.guides())
    for (const Guide& guide : *guides)
      fmt::print("{:<12} {}, {:.4g} N/m, at most {:.3g} N\n", "guide", kGuides[guide.shape.index()], guide.stiffness,
                 guide.maxForce);
  if (file.bur)
    fmt::print("{:<12} part {} of the tool cuts, {:.4g} 1/min{}\n", "bur", file.bur->part, 60.0 * file.bur->turns,
               std::isinf(file.bur->torque) ? "" : fmt::format(", {:.3g} N mm at rest", 1e3 * file.bur->torque));
  for (const std::string& note : file.notes) fmt::print("note: {}\n", note);
  if (options.explain) explain(file, seconds);
}

}  // namespace

void addScene(CLI::App& app) {
  auto options = std::make_shared<SceneOptions>();
  CLI::App* command = app.add_subcommand("scene", "Checks a scene file and prints its contents");
  command->add_option("file", options->file, "scene file (TOML)")->required();
  command->add_flag("--explain", options->explain,
                    "print what a program builds from the scene and the time of its ticks on this machine");
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
