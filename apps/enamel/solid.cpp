#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <numeric>

#include "colours/palette.hpp"
#include "commands.hpp"
#include "enamel/collision/cut_comparison.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/solid_file.hpp"
#include "enamel/collision/solid_surface.hpp"
#include "enamel/core/error.hpp"
#include "mesh_output.hpp"
#include "program/outputs.hpp"

namespace enamel::app {
namespace {

struct SolidCommandOptions {
  std::string file, target, output;
  double unit = 1e-3;  // m
  std::vector<double> axis = {0.0, 0.0, 1.0};
  double range = 1e3 * viewer::kCutRange;  // mm
  bool overwrite = false;
};

double sum(const RemovedVolume& volume) { return std::accumulate(volume.begin(), volume.end(), 0.0); }

// A table of volumes by layer, m^3 in mm^3, with their sum.
void printVolumes(const Solid& solid, const std::vector<std::pair<const char*, RemovedVolume>>& columns) {
  const auto row = [&](const std::string& name, const auto& valueOf) {
    fmt::print("{:<16}", name);
    for (const auto& column : columns) fmt::print(" {:>12.4f}", 1e9 * valueOf(column.second));
    fmt::print("\n");
  };
  fmt::print("{:<16}", "mm^3");
  for (const auto& column : columns) fmt::print(" {:>12}", column.first);
  fmt::print("\n");
  for (std::size_t k = 0; k < solid.layers().size(); ++k)
    row(solid.layers()[k].name, [k](const RemovedVolume& volume) { return volume[k]; });
  row("all", sum);
}

void print(const Solid& solid, const CutComparison& c) {
  printVolumes(
      solid,
      {{"removed", c.removed}, {"planned", c.planned}, {"over cut", c.whole.overCut}, {"under cut", c.whole.underCut}});
  fmt::print("\n{:<16} {:>12} {:>12} {:>10} {:>10} {:>10} {:>10} {:>10}\n", "", "over cut", "under cut", "surface",
             "mean", "95 %", "deepest", "highest");
  fmt::print("{:<16} {:>12} {:>12} {:>10} {:>10} {:>10} {:>10} {:>10}\n", "", "mm^3", "mm^3", "mm^2", "mm", "mm", "mm",
             "mm");
  const std::pair<const char*, const CutDifference*> regions[] = {
      {"floors", &c.floors}, {"walls", &c.walls}, {"all", &c.whole}};
  for (const auto& [name, d] : regions)
    fmt::print("{:<16} {:>12.4f} {:>12.4f} {:>10.3f} {:>10.3f} {:>10.3f} {:>10.3f} {:>10.3f}\n", name,
               1e9 * sum(d->overCut), 1e9 * sum(d->underCut), 1e6 * d->area, 1e3 * d->mean, 1e3 * d->p95,
               1e3 * d->deepest, 1e3 * d->highest);
}

// Grey outside of the preparation.
std::vector<Vec3> coloursOf(const CutComparison& c, double range) {
  std::vector<Vec3> colours;
  for (std::size_t v = 0; v < c.distance.size(); ++v)
    colours.push_back(c.isPrepared[v] == 0 ? viewer::rgbOf(viewer::kMuted) : viewer::cutColour(c.distance[v] / range));
  return colours;
}

void run(const SolidCommandOptions& options) {
  checkMeshOutput(options.output);
  const Solid solid = loadSolid(options.file);
  const std::string what = fmt::format("{}: {} bricks, cells of {:.4g} mm, {:.3g} MB in memory\n", options.file,
                                       solid.bricks(), 1e3 * solid.cell(), 1e-6 * static_cast<double>(solid.bytes()));
  if (options.target.empty()) {
    Solid uncut = solid;
    uncut.restore();
    const RemovedVolume now = solid.volume(), before = uncut.volume();
    RemovedVolume removed{};
    for (std::size_t k = 0; k < removed.size(); ++k) removed[k] = before[k] - now[k];
    fmt::print("{}", what);
    printVolumes(solid, {{"left", now}, {"removed", removed}});
    if (!options.output.empty()) writeMesh(surfaceOf(solid), options.output);
    return;
  }
  const TriangleMesh target = loadMesh(options.target, options.unit);
  try {
    const CutComparison c =
        compareCut(solid, MeshModel(target), Vec3(options.axis[0], options.axis[1], options.axis[2]));
    fmt::print("{}", what);
    print(solid, c);
    if (!options.output.empty()) writeMesh(c.surface, options.output, coloursOf(c, 1e-3 * options.range));
  } catch (const Error& error) {
    throw Error(options.target + ": " + error.what());
  }
}

}  // namespace

void addSolid(CLI::App& app) {
  auto options = std::make_shared<SolidCommandOptions>();
  CLI::App* command = app.add_subcommand(
      "solid", "Prints the volumes of a saved solid that a bur has cut, and compares it with a target");
  command->add_option("file", options->file, "saved solid (.solid)")->required();
  auto* target = command->add_option("--target", options->target,
                                     "closed mesh (ply, obj, stl, off) in the solid's frame: how it should be cut");
  command->add_option("--unit", options->unit, "unit of the target's coordinates: m, mm or um")
      ->transform(CLI::CheckedTransformer(std::map<std::string, double>{{"m", 1.0}, {"mm", 1e-3}, {"um", 1e-6}}))
      ->default_str("mm")
      ->needs(target);
  command
      ->add_option("--axis", options->axis,
                   "direction out of the tooth. Faces of the target within 45 deg of it are floors, others walls")
      ->expected(3)
      ->needs(target)
      ->capture_default_str();
  command->add_option("--range", options->range, "distance with the full colour of a PLY, mm")
      ->check(CLI::Range(1e-3, 1e3))
      ->needs(target)
      ->capture_default_str();
  command->add_option("--output", options->output,
                      "file for the cut surface (PLY or STL in mm). With --target a PLY is coloured by the distance "
                      "from it: blue is too deep, red is too high, grey is not in the preparation");
  addOverwrite(*command, options->overwrite, {"--output"});
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
