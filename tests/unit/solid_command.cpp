// `enamel solid` as a user runs it: volumes of a cut block, comparison with a target, colours.
#include <cstring>
#include <sstream>

#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/solid_file.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/meshes.hpp"

namespace enamel::test_solid_command {

using test::ContainsSubstring;

namespace {

const Vec3 kHalf(1.5e-3, 1.5e-3, 1e-3);
constexpr double kRadius = 0.5e-3;

// A block of two layers with half a ball cut out of its top.
void saveBlock(const std::string& path) {
  std::vector<SolidLayer> layers(2);
  layers[0].name = "enamel";
  layers[1].name = "dentine";
  layers[1].depth = 0.3e-3;
  Solid solid(MeshModel(test::boxMesh(kHalf)), layers, {1e-4});
  const Vec3 top(0.0, 0.0, kHalf.z());
  solid.cut({top, top}, {top, top}, kRadius);
  saveSolid(solid, path);
}

// A block, mm, whose top is lower by `depth` m.
void writeTarget(const std::string& path, double depth) {
  std::ostringstream text;
  for (int i = 0; i < 8; ++i)
    text << "v " << (i & 1 ? 1.5 : -1.5) << ' ' << (i & 2 ? 1.5 : -1.5) << ' ' << (i & 4 ? 1.0 - 1e3 * depth : -1.0)
         << '\n';
  text
      << "f 1 3 2\nf 2 3 4\nf 5 6 7\nf 6 8 7\nf 1 2 5\nf 2 6 5\nf 3 7 4\nf 4 7 8\nf 1 5 3\nf 3 5 7\nf 2 4 6\nf 4 8 6\n";
  test::writeFile(path, text.str());
}

// The numbers of the row that begins with a name, from `at` on.
std::vector<double> row(const std::string& text, const std::string& name, std::size_t at = 0) {
  const std::size_t begin = text.find("\n" + name + " ", at);
  REQUIRE(begin != std::string::npos);
  std::istringstream line(text.substr(begin + 1 + name.size(), text.find('\n', begin + 1) - begin - 1 - name.size()));
  std::vector<double> numbers;
  for (double number = 0.0; line >> number;) numbers.push_back(number);
  return numbers;
}

}  // namespace

TEST_CASE("a saved solid is measured, compared with a target, and written with colours", "[unit]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "block.solid", target = folder / "target.obj", ply = folder / "cut.ply";
  saveBlock(file);
  const double hole = 2.0 / 3.0 * 3.141592653589793 * std::pow(1e3 * kRadius, 3), whole = 8e9 * kHalf.prod();  // mm^3
  const test::CommandResult alone = test::run("solid " + file + " --output " + (folder / "cut.stl"));
  INFO(alone.output);
  REQUIRE(alone.status == 0);
  CHECK(row(alone.output, "all")[0] == Approx(whole - hole).epsilon(0.01));
  CHECK(row(alone.output, "all")[1] == Approx(hole).epsilon(0.02));
  const double inEnamel = row(alone.output, "enamel")[1], inDentine = row(alone.output, "dentine")[1];
  CHECK(inEnamel + inDentine == Approx(hole).epsilon(0.02));
  CHECK(inDentine > 0.05 * hole);  // the lowest 0.2 mm of the ball
  const MeshReport report = inspect(loadMesh(folder / "cut.stl", 1e-3));
  CHECK(report.watertight);
  CHECK(1e9 * report.volume == Approx(whole - hole).epsilon(0.01));

  // The top should be 0.2 mm lower: under cut around the ball, over cut below it.
  const double depth = 0.2, r = 1e3 * kRadius, cap = r - depth;  // mm
  writeTarget(target, 1e-3 * depth);
  const double over = 3.141592653589793 * cap * cap * (3.0 * r - cap) / 3.0;
  const test::CommandResult compared =
      test::run("solid " + file + " --target " + target + " --range 0.1 --output " + ply);
  INFO(compared.output);
  REQUIRE(compared.status == 0);
  const std::vector<double> all = row(compared.output, "all");
  CHECK(all[0] == Approx(hole).epsilon(0.02));
  CHECK(all[1] == Approx(9.0 * depth).epsilon(0.02));
  CHECK(all[2] == Approx(over).epsilon(0.05));
  CHECK(all[3] == Approx(9.0 * depth - (hole - over)).epsilon(0.02));
  const std::size_t regions = compared.output.find("floors") - 1;
  const std::vector<double> floors = row(compared.output, "floors", regions),
                            walls = row(compared.output, "walls", regions), sums = row(compared.output, "all", regions);
  CHECK(sums[0] == Approx(all[2]).margin(1e-3));
  CHECK(floors[0] + walls[0] == Approx(sums[0]).margin(1e-3));
  CHECK(floors[1] > 0.9 * sums[1]);
  CHECK(sums[5] == Approx(cap).margin(0.01));    // below the target
  CHECK(sums[6] == Approx(depth).margin(0.01));  // above it
  // In a PLY each vertex has a position and a colour, 15 bytes.
  const TriangleMesh mesh = loadMesh(ply, 1e-3);
  const std::string bytes = test::readFile(ply);
  const std::size_t begin = bytes.find("end_header\n") + 11;
  int wrong = 0, high = 0, deep = 0, grey = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    unsigned char rgb[3];
    std::memcpy(rgb, bytes.data() + begin + 15 * v + 12, 3);
    const double above = mesh.vertices[v].z() - (kHalf.z() - 1e-3 * depth);
    const bool isTop = above > 0.11e-3,
               isHole = above < -0.11e-3 && above > -0.5e-3 && mesh.vertices[v].head<2>().norm() < kRadius;
    if (isTop) wrong += rgb[0] != 0xD5 || rgb[1] != 0x5E || rgb[2] != 0x00, ++high;
    if (isHole) wrong += rgb[0] != 0x00 || rgb[1] != 0x72 || rgb[2] != 0xB2, ++deep;
    if (above < -0.8e-3) wrong += rgb[0] != 0x66 || rgb[1] != 0x70 || rgb[2] != 0x7C, ++grey;
  }
  CHECK(wrong == 0);
  CHECK(std::min({high, deep, grey}) > 20);

  // With the axis along x the side is the floor.
  const test::CommandResult turned = test::run("solid " + file + " --target " + target + " --axis 1 0 0");
  CHECK(row(turned.output, "walls", turned.output.find("floors") - 1)[1] > 0.9 * sums[1]);
}

TEST_CASE("enamel solid refuses what it cannot use in one line; enamel mesh makes a solid", "[unit]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "block.solid", target = folder / "target.obj";
  saveBlock(file);
  test::writeFile(target, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  for (const auto& [arguments, problem] :
       {std::pair{file + " --target " + target, "target.obj: the target of a preparation must be closed"},
        {target, "target.obj: is not a saved solid"},
        {file + " --output a.obj", "a.obj: the extension must be .ply or .stl"},
        {file + " --output " + file, "block.solid"}}) {
    const test::CommandResult result = test::run("solid " + arguments);
    INFO(result.output);
    CHECK(result.status != 0);
    CHECK_THAT(result.output, ContainsSubstring(problem));
    CHECK(result.output.find('\n') == result.output.size() - 1);
  }
  writeTarget(target, 0.0);
  const std::string made = folder / "made.solid";
  REQUIRE(test::run("mesh " + target + " --solid --cell 0.1 --output " + made).status == 0);
  const Solid solid = loadSolid(made);
  CHECK(solid.cell() == 1e-4);
  CHECK(1e9 * solid.volume()[0] == Approx(8e9 * kHalf.prod()).epsilon(0.01));
}

}  // namespace enamel::test_solid_command
