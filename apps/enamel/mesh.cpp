#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstring>
#include <memory>

#include "commands.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "mesh_generator.hpp"
#include "mesh_prepare.hpp"

namespace enamel::app {
namespace {

struct MeshOptions {
  std::string file, generate, output, prepare;
  double unit = 1e-3;       // m
  double deviation = 20.0;  // um
  double base = 0.0;        // mm
};

void printLine(const char* name, const std::string& value) { fmt::print("{:<24} {}\n", name, value); }

void print(const MeshReport& r) {
  const auto line = printLine;
  const auto count = [&line](const char* name, int value) { line(name, std::to_string(value)); };
  count("triangles", r.triangles);
  line("vertices", fmt::format("{} at {} places", r.vertices, r.places));
  count("components", r.components);
  count("degenerate triangles", r.degenerateTriangles);
  count("duplicate triangles", r.duplicateTriangles);
  count("boundary edges", r.boundaryEdges);
  count("non-manifold edges", r.nonManifoldEdges);
  count("non-manifold vertices", r.nonManifoldVertices);
  count("flipped edges", r.flippedEdges);
  line("watertight", r.watertight ? "yes" : "no");
  if (r.watertight) {
    line("orientation", r.inwards ? "inwards: turn the triangles round" : "outwards");
    line("volume", fmt::format("{:.6g} m^3", r.volume));
  }
  line("area", fmt::format("{:.6g} m^2", r.area));
  line("box", fmt::format("{:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g} m", r.low.x(), r.low.y(), r.low.z(), r.high.x(),
                          r.high.y(), r.high.z()));
}

// Binary PLY in mm.
void write(const TriangleMesh& mesh, const std::string& path) {
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment units mm\nelement vertex {}\nproperty float x\n"
      "property float y\nproperty float z\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  const auto put = [&bytes](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (const Vec3& v : mesh.vertices)
    for (int k = 0; k < 3; ++k) put(static_cast<float>(1e3 * v[k]));
  for (const auto& t : mesh.triangles) {
    put(std::uint8_t{3});
    for (const int v : t) put(static_cast<std::int32_t>(v));
  }
  writeFile(path, bytes);
}

void print(const PrepareReport& r, const TriangleMesh& result, const std::string& path) {
  const auto count = [](const char* name, int value, const char* why) {
    if (value > 0) printLine(name, fmt::format("{} {}", value, why));
  };
  const auto within = [](const Deviation& d) {
    return fmt::format("{:.3g} um at most, rms {:.3g} um, at {} points", 1e6 * d.most, 1e6 * d.rms, d.points);
  };
  fmt::print("\nprepared: {}\n", path);
  count("joined vertices", r.joinedVertices, "at the place of another");
  count("dropped triangles", r.uselessTriangles, "with a repeated corner or twice there");
  count("left out triangles", r.misfitTriangles, "where more than two meet at an edge or sheets in a corner");
  count("turned triangles", r.turnedTriangles, "inside out");
  count("closed holes", r.closedHoles, "");
  count("open holes", r.openHoles, "could not be closed");
  printLine("triangles", fmt::format("{} of {}", result.triangles.size(), r.beforeDecimation));
  if (r.fromClosed.points > 0) {
    printLine("closed to decimated", within(r.fromClosed));
    printLine("decimated to closed", within(r.toClosed));
  }
  printLine("file to prepared", within(r.fromFile));
}

void run(const MeshOptions& options) {
  if (options.generate.empty()) {
    if (options.file.empty()) throw Error("needs a mesh file, or --generate with --output");
    const TriangleMesh mesh = loadMesh(options.file, options.unit);
    print(inspect(mesh));
    printLine("sign", describe(MeshModel(mesh)));
    if (options.prepare.empty()) return;
    PrepareReport report;
    const TriangleMesh prepared = prepareMesh(mesh, {1e-6 * options.deviation, 1e-3 * options.base}, report);
    write(prepared, options.prepare);
    print(report, prepared, options.prepare);
    printLine("sign", describe(MeshModel(prepared)));
    return;
  }
  if (options.output.empty()) throw Error("--generate needs --output");
  write(options.generate == "molar" ? makeMolar(6) : makeJaw(360, 110), options.output);
}

}  // namespace

void addMesh(CLI::App& app) {
  auto options = std::make_shared<MeshOptions>();
  CLI::App* command = app.add_subcommand("mesh", "What is wrong with a mesh file (ply, obj, stl, off), and its size");
  command->add_option("file", options->file, "mesh file");
  command->add_option("--unit", options->unit, "of the file's coordinates: m, mm or um")
      ->transform(CLI::CheckedTransformer(std::map<std::string, double>{{"m", 1.0}, {"mm", 1e-3}, {"um", 1e-6}}))
      ->default_str("mm");
  auto* generate = command->add_option("--generate", options->generate, "makes a mesh instead (PLY in mm)")
                       ->check(CLI::IsMember({"molar", "jaw"}));
  command->add_option("--output", options->output, "where the made mesh goes");
  auto* prepare = command
                      ->add_option("--prepare", options->prepare,
                                   "makes the file's mesh manifold, closes its holes, leaves out triangles, and "
                                   "writes it here (PLY in mm)")
                      ->excludes(generate);
  command->add_option("--deviation", options->deviation, "that leaving out triangles may cause, um; 0: all stay")
      ->check(CLI::Range(0.0, 1e6))
      ->needs(prepare)
      ->capture_default_str();
  command->add_option("--base", options->base, "closes the longest opening so far below it, mm; 0: like every hole")
      ->check(CLI::Range(0.0, 1e3))
      ->needs(prepare)
      ->capture_default_str();
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
