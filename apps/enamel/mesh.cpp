#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numeric>
#include <random>

#include "commands.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/collision/solid_file.hpp"
#include "enamel/collision/solid_surface.hpp"
#include "enamel/core/error.hpp"
#include "mesh_generator.hpp"
#include "mesh_output.hpp"
#include "mesh_prepare.hpp"
#include "program/outputs.hpp"
#include "tooth_generator.hpp"

namespace enamel::app {
namespace {

struct MeshOptions {
  std::string file, generate, output, prepare;
  double unit = 1e-3;       // m
  double deviation = 20.0;  // um
  double base = 0.0;        // mm
  bool solid = false, overwrite = false;
  double cell = 0.1;       // mm
  double triangles = 0.0;  // of a generated mesh; 0: those of the shipped one
};

void printLine(const char* name, const std::string& value) { fmt::print("{:<24} {}\n", name, value); }

void print(const MeshReport& r) {
  const auto line = printLine;
  const auto count = [&line](const char* name, int value) { line(name, std::to_string(value)); };
  count("triangles", r.triangles);
  line("vertices", fmt::format("{} at {} positions", r.vertices, r.places));
  count("components", r.components);
  count("degenerate triangles", r.degenerateTriangles);
  count("duplicate triangles", r.duplicateTriangles);
  count("boundary edges", r.boundaryEdges);
  count("non-manifold edges", r.nonManifoldEdges);
  count("non-manifold vertices", r.nonManifoldVertices);
  count("flipped edges", r.flippedEdges);
  line("watertight", r.watertight ? "yes" : "no");
  if (r.watertight) {
    line("orientation", r.inwards ? "inwards: reverse the triangles" : "outwards");
    line("volume", fmt::format("{:.6g} m^3", r.volume));
  }
  line("area", fmt::format("{:.6g} m^2", r.area));
  line("box", fmt::format("{:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g} m", r.low.x(), r.low.y(), r.low.z(), r.high.x(),
                          r.high.y(), r.high.z()));
}

void print(const PrepareReport& r, const TriangleMesh& result, const std::string& path) {
  const auto count = [](const char* name, int value, const char* why) {
    if (value > 0) printLine(name, fmt::format("{} {}", value, why));
  };
  const auto within = [](const Deviation& d) {
    return fmt::format("{:.3g} um at most, rms {:.3g} um, at {} points", 1e6 * d.most, 1e6 * d.rms, d.points);
  };
  fmt::print("\nprepared: {}\n", path);
  count("joined vertices", r.joinedVertices, "at the position of another");
  count("dropped triangles", r.uselessTriangles, "with a repeated corner, or duplicates");
  count("removed triangles", r.misfitTriangles,
        "where more than two triangles share an edge, or surfaces touch in a vertex");
  count("reversed triangles", r.turnedTriangles, "inside out");
  count("closed holes", r.closedHoles, "");
  count("open holes", r.openHoles, "could not be closed");
  printLine("triangles", fmt::format("{} of {}", result.triangles.size(), r.beforeDecimation));
  if (r.fromClosed.points > 0) {
    printLine("closed to decimated", within(r.fromClosed));
    printLine("decimated to closed", within(r.toClosed));
  }
  printLine("file to prepared", within(r.fromFile));
}

// Compare distances at points near the surface: spread evenly over the mesh, then moved by up to 5 cells.
void printErrors(const MeshModel& model, const Solid& solid) {
  constexpr int kPoints = 100000;
  const TriangleMesh& mesh = model.mesh();
  std::vector<double> areas;
  for (const auto& t : mesh.triangles) {
    const Vec3& a = mesh.vertices[t[0]];
    const double area = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).norm();
    areas.push_back(areas.empty() ? area : areas.back() + area);
  }
  std::mt19937_64 engine(22);
  const auto number = [&engine] { return static_cast<double>(engine() >> 11) * 0x1p-53; };
  std::vector<double> errors;
  int wrong = 0;
  for (int i = 0; i < kPoints; ++i) {
    const auto at = std::upper_bound(areas.begin(), areas.end() - 1, number() * areas.back()) - areas.begin();
    const auto& t = mesh.triangles[static_cast<std::size_t>(at)];
    const double u = number(), v = number() * (1.0 - u);
    const double turn = 2.0 * M_PI * number(), up = 2.0 * number() - 1.0, away = 5.0 * solid.cell() * number();
    const Vec3 way(std::sqrt(1.0 - up * up) * std::cos(turn), std::sqrt(1.0 - up * up) * std::sin(turn), up);
    const Vec3& a = mesh.vertices[t[0]];
    const Vec3 p = a + u * (mesh.vertices[t[1]] - a) + v * (mesh.vertices[t[2]] - a) + away * way;
    const double exact = signedDistance(model, p).distance, found = signedDistance(solid, p).distance;
    errors.push_back(std::abs(found - exact));
    wrong += (found < 0.0) != (exact < 0.0) && std::abs(exact) > 0.5 * solid.cell();
  }
  std::sort(errors.begin(), errors.end());
  const auto quantile = [&errors](double part) { return 1e6 * errors[static_cast<std::size_t>(part * (kPoints - 1))]; };
  printLine("distances",
            fmt::format(
                "error {:.3g} um (median of {} points within 5 cells), {:.3g} (99 %), {:.3g} (99.9 %), {:.3g} at most",
                quantile(0.5), kPoints, quantile(0.99), quantile(0.999), errors.back() * 1e6));
  printLine("wrong side", fmt::format("{} points more than half a cell from the surface", wrong));
}

bool isSolidFile(const std::string& path) { return std::filesystem::u8path(path).extension() == ".solid"; }

void makeSolid(const MeshModel& model, const MeshOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const Solid solid = [&] {
    try {
      return Solid(model, {SolidLayer()}, {1e-3 * options.cell, 0});
    } catch (const Error& error) {
      throw Error(options.file + ": " + error.what());
    }
  }();
  const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const RemovedVolume volumes = solid.volume();
  const double volume = std::accumulate(volumes.begin(), volumes.end(), 0.0), whole = inspect(model.mesh()).volume;
  fmt::print("\nsolid: cells of {} mm\n", options.cell);
  printLine("bricks", fmt::format("{} of {}^3 cells", solid.bricks(), kBrickCells));
  printLine("memory", fmt::format("{:.1f} MB", 1e-6 * static_cast<double>(solid.bytes())));
  printLine("built in", fmt::format("{:.2g} s", took));
  printLine("volume", fmt::format("{:.6g} m^3, {:+.2g} % of the mesh's", volume,
                                  100.0 * (volume - std::abs(whole)) / std::abs(whole)));
  printErrors(model, solid);
  if (options.output.empty()) return;
  if (isSolidFile(options.output)) return saveSolid(solid, options.output);
  const TriangleMesh surface = surfaceOf(solid);
  writeMesh(surface, options.output);
  printLine("surface", fmt::format("{} triangles: {}", surface.triangles.size(), options.output));
}

TriangleMesh generated(const MeshOptions& options) {
  const auto& parts = toothParts();
  if (std::find(parts.begin(), parts.end(), options.generate) != parts.end()) {
    if (options.triangles != 0) throw Error("--triangles applies to molar and jaw only");
    return makeToothPart(options.generate);
  }
  if (options.generate == "molar")
    return makeMolar(options.triangles == 0 ? 6
                                            : static_cast<int>(std::lround(0.5 * std::log2(options.triangles / 8.0))));
  if (options.triangles == 0) return makeJaw(360, 110);
  constexpr double kLength = 3.2;  // rings for each point of a ring
  const double around = std::sqrt(options.triangles / (2.0 * kLength));
  return makeJaw(static_cast<int>(std::lround(kLength * around)), static_cast<int>(std::lround(around)));
}

void run(const MeshOptions& options) {
  if (!(options.solid && isSolidFile(options.output))) checkMeshOutput(options.output);
  checkMeshOutput(options.prepare);
  if (options.generate.empty()) {
    if (options.file.empty()) throw Error("give a mesh file, or --generate with --output");
    const TriangleMesh mesh = loadMesh(options.file, options.unit);
    print(inspect(mesh));
    const MeshModel model(mesh);
    printLine("sign", describe(model));
    if (options.solid) makeSolid(model, options);
    if (options.prepare.empty()) return;
    PrepareReport report;
    const TriangleMesh prepared = prepareMesh(mesh, {1e-6 * options.deviation, 1e-3 * options.base}, report);
    writeMesh(prepared, options.prepare);
    print(report, prepared, options.prepare);
    printLine("sign", describe(MeshModel(prepared)));
    return;
  }
  if (options.output.empty()) throw Error("--generate needs --output");
  writeMesh(generated(options), options.output);
}

}  // namespace

void addMesh(CLI::App& app) {
  auto options = std::make_shared<MeshOptions>();
  CLI::App* command =
      app.add_subcommand("mesh", "Checks a mesh file (ply, obj, stl, off) and prints its defects and size");
  command->add_option("file", options->file, "mesh file");
  command->add_option("--unit", options->unit, "unit of the file's coordinates: m, mm or um")
      ->transform(CLI::CheckedTransformer(std::map<std::string, double>{{"m", 1.0}, {"mm", 1e-3}, {"um", 1e-6}}))
      ->default_str("mm");
  std::vector<std::string> names = toothParts();
  names.insert(names.end(), {"molar", "jaw"});
  auto* generate = command->add_option("--generate", options->generate, "generate a mesh instead (PLY or STL in mm)")
                       ->check(CLI::IsMember(names));
  command
      ->add_option("--triangles", options->triangles,
                   "about so many triangles; default: those of the shipped mesh. The number of a molar is 8 times a "
                   "power of 4")
      ->check(CLI::Range(128.0, 1e7))
      ->needs(generate);
  auto* output = command->add_option("--output", options->output, "file for the generated mesh or the solid's surface");
  auto* prepare =
      command
          ->add_option("--prepare", options->prepare,
                       "file for the prepared mesh (PLY or STL in mm): manifold, with holes closed and fewer triangles")
          ->excludes(generate)
          ->excludes(output);
  command
      ->add_option("--deviation", options->deviation, "largest deviation caused by removing triangles, um; 0: keep all")
      ->check(CLI::Range(0.0, 1e6))
      ->needs(prepare)
      ->capture_default_str();
  command
      ->add_option("--base", options->base,
                   "close the longest opening with a base so far below it, mm; 0: like every hole")
      ->check(CLI::Range(0.0, 1e3))
      ->needs(prepare)
      ->capture_default_str();
  auto* solid = command
                    ->add_flag("--solid", options->solid,
                               "make a solid that can be cut from the file's closed mesh and print its error; --output "
                               "writes its surface (PLY or STL in mm), or the solid itself (.solid)")
                    ->excludes(generate)
                    ->excludes(prepare);
  command->add_option("--cell", options->cell, "edge of the solid's cells, mm")
      ->check(CLI::Range(1e-3, 1e3))
      ->needs(solid)
      ->capture_default_str();
  addOverwrite(*command, options->overwrite, {"--output", "--prepare"});
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
