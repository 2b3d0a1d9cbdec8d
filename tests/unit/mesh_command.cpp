// `enamel mesh` as a user runs it: the shipped meshes are sound and equal to the generator's.
#include <algorithm>
#include <sstream>

#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/proximity.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"

namespace enamel::test_mesh_command {

using test::ContainsSubstring;

TEST_CASE("the report names what was counted", "[unit]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "flap.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 2 0\n3 0 1 2\n");
  const test::CommandResult result = test::run("mesh " + (folder / "flap.off") + " --unit m");
  CHECK(result.status == 0);
  CHECK_THAT(result.output, ContainsSubstring("boundary edges           3") &&
                                ContainsSubstring("watertight               no") &&
                                ContainsSubstring("area                     1 m^2"));
}

TEST_CASE("a file that cannot be used is refused in one line", "[unit]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "cut.off", "OFF 3 1 0\n0 0 0\n1 0 0\n");
  for (const std::string& arguments :
       {"mesh " + (folder / "cut.off"), std::string("mesh"), std::string("mesh --generate molar")}) {
    const test::CommandResult result = test::run(arguments);
    CHECK(result.status == 1);
    CHECK(result.output.find('\n') == result.output.size() - 1);
  }
}

TEST_CASE("a scene says what it is made of and what a tick of it costs, a broken one why it is none") {
  const std::string scenes = std::string(ENAMEL_SOURCE_DIR) + "/data/scenes/";
  const test::CommandResult wall = test::run("scene " + scenes + "flat-wall.toml --explain");
  INFO(wall.output);
  CHECK(wall.status == 0);
  CHECK_THAT(wall.output,
             ContainsSubstring("a plane, nothing is built") && ContainsSubstring("0 of them with a mesh: 0 KB"));
  const test::CommandResult jaw = test::run("scene " + scenes + "jaw.toml --explain");
  CHECK_THAT(jaw.output, ContainsSubstring("mesh of 79200 triangles") &&
                             ContainsSubstring("2 pairs of part and obstacle, 2 of them"));
  // The last line: median, p99, p99.9, simultaneous contacts, share of the ticks with contact.
  std::istringstream last(jaw.output.substr(jaw.output.find("the scene ") + 10));
  double median = 0.0, p99 = 0.0, p999 = 0.0, most = 0.0, touching = 0.0;
  last >> median >> p99 >> p999 >> most >> touching;
  CHECK(median > 0.0);
  CHECK(median <= p99);
  CHECK(p99 <= p999);
  CHECK(most >= 1);
  CHECK(touching > 50);
  const test::TemporaryFolder folder;
  test::writeFile(folder / "none.toml", "name = \"none\"\nstart = [0, 0, 0]\n");
  const test::CommandResult mobile = test::run("scene " + scenes + "mobile-molar.toml");
  CHECK_THAT(mobile.output, ContainsSubstring("moves along x 0.002 kg, 98000 N/m (1114 Hz); along y"));
  CHECK_THAT(mobile.output, ContainsSubstring("moves along x 5.2e-05 kg, loose; along y 5.2e-05 kg, loose; about z"));
  const test::CommandResult caries = test::run("scene " + scenes + "caries.toml");
  CHECK_THAT(caries.output, ContainsSubstring("enamel: rigid, friction 0.1\n"));
  CHECK_THAT(caries.output,
             ContainsSubstring("caries: 4000 N/m, friction 0.3, exponent 1.5 (the stiffness is that at 1 "
                               "mm), layer of 1.3 mm, hysteresis 2 s/m, breaks at 2 N\n"));
  CHECK_THAT(caries.output, ContainsSubstring("layer of 1.7 mm, hysteresis 2 s/m, breaks at 3 N\n"));
  CHECK_THAT(test::run("scene " + scenes + "taps.toml").output, ContainsSubstring("a tap rings at 310 Hz"));
  CHECK_THAT(test::run("scene " + scenes + "surfaces.toml").output,
             ContainsSubstring("rigid, friction 0.2, rough: 6 um, waves up to 0.3 mm") &&
                 ContainsSubstring("rigid, friction 0.5, 0.2 while sliding (Stribeck speed 0.01 m/s)"));
  CHECK_THAT(test::run("scene " + scenes + "slow-bur.toml").output,
             ContainsSubstring("part 0 of the tool cuts, 3600 1/min, 2 N mm at rest"));
  CHECK_THAT(test::run("scene " + scenes + "guides.toml").output,
             ContainsSubstring("guide        half space, 100 N/m, at most 1.5 N"));
  const test::CommandResult none = test::run("scene " + (folder / "none.toml"));
  CHECK(none.status == 1);
  CHECK_THAT(none.output, ContainsSubstring("none.toml") && ContainsSubstring("obstacle"));
}

TEST_CASE("bench writes its table as a page, and every program says what it was built with") {
  const test::TemporaryFolder folder;
  const std::string page = folder / "bench.md";
  const test::CommandResult bench = test::run("bench --filter 'scene plane' --scale 0.01 --report " + page);
  INFO(bench.output);
  CHECK(bench.status == 0);
  const std::string text = test::readFile(page);
  CHECK_THAT(text, ContainsSubstring("## scene\n") && ContainsSubstring("\n| plane | ") &&
                       ContainsSubstring("gap, against its formula"));
  const test::CommandResult version = test::run("--version");
  CHECK(version.status == 0);
  CHECK_THAT(version.output,
             ContainsSubstring("enamel 0.") && ContainsSubstring("Eigen 3.") && ContainsSubstring("plugin ABI 3"));
  CHECK_THAT(text, ContainsSubstring(version.output.substr(7, 10)));
}

namespace {

// Return a mesh as from a scanner: the upper part of the molar, open below, with separate vertices for every triangle.
// It has holes, a duplicate triangle, and one with the opposite orientation.
std::string scanOf(const TriangleMesh& molar) {
  std::ostringstream text;
  text.precision(9);
  int number = 0;
  for (const auto& t : molar.triangles) {
    const auto isLow = [&](int v) { return molar.vertices[v].z() < 1e-3; };
    if (std::any_of(t.begin(), t.end(), isLow) || ++number % 100 == 0) continue;
    for (int copies = number == 7 ? 2 : 1; copies > 0; --copies) {
      for (const int v : t) text << "v " << 1e3 * molar.vertices[v].transpose() << '\n';
      text << (number == 450 ? "f -1 -2 -3\n" : "f -3 -2 -1\n");
    }
  }
  return text.str();
}

}  // namespace

TEST_CASE("the shipped tooth has the dimensions of a lower first molar, and its parts are those of the generator",
          "[unit]") {
  const test::TemporaryFolder folder;
  const auto meshOf = [](const std::string& part) {
    return MeshModel(loadMesh(ENAMEL_SOURCE_DIR "/data/meshes/tooth-" + part + ".ply", 1e-3));
  };
  const MeshModel block = meshOf("block"), bone = meshOf("bone"), enamel = meshOf("enamel"),
                  dentine = meshOf("dentine"), pulp = meshOf("pulp");
  for (const MeshModel* part : {&block, &bone, &enamel, &dentine, &pulp})
    CHECK(describe(*part) == "watertight: the sign of distances is exact");
  // Sources: data/meshes/README.md.
  const auto onAxis = [](const MeshModel& part, double z) { return signedDistance(part, Vec3(0.0, 0.0, z)).distance; };
  const auto changeBelow = [&](const MeshModel& part, double z) {  // the next place where the axis enters or leaves
    const bool isInside = onAxis(part, z) < 0.0;
    while ((onAxis(part, z) < 0.0) == isInside && z > -20e-3) z -= 5e-5;
    return z;
  };
  const auto within = [](const MeshModel& part, const Vec3& p) { return signedDistance(part, p).distance < 0.0; };
  double cusp = -1.0, apex = 1.0;
  for (const Vec3& v : block.mesh().vertices)
    if (v.y() < 0.0) cusp = std::max(cusp, v.z());
  for (const Vec3& v : dentine.mesh().vertices) apex = std::min(apex, v.z());
  const double ceiling = changeBelow(pulp, 0.0), floor = changeBelow(pulp, ceiling),
               furcation = changeBelow(dentine, floor);
  CHECK(cusp - ceiling == Approx(6.36e-3).margin(0.93e-3));
  CHECK(cusp - floor == Approx(7.95e-3).margin(0.79e-3));
  CHECK(cusp - furcation == Approx(10.90e-3).margin(1.21e-3));
  CHECK(cusp - apex == Approx(21.5e-3).margin(1e-3));
  const auto& canals = pulp.mesh().vertices;
  CHECK(std::all_of(canals.begin(), canals.end(), [&](const Vec3& v) { return within(dentine, v); }));
  // On a cusp: enamel, dentine below it, gum beside the neck, bone below the gum.
  const Vec3 tip(-2.6e-3, -2.3e-3, cusp);
  CHECK(within(enamel, tip - Vec3(0.0, 0.0, 1.5e-3)));
  CHECK_FALSE(within(dentine, tip - Vec3(0.0, 0.0, 1.5e-3)));
  CHECK(within(dentine, tip - Vec3(0.0, 0.0, 3e-3)));
  const Vec3 beside(0.0, -5.5e-3, -4e-3);
  CHECK(within(block, beside));
  CHECK_FALSE(within(enamel, beside));
  CHECK_FALSE(within(bone, beside));
  CHECK(within(bone, Vec3(0.0, 0.0, -12e-3)));
  // The shipped parts have fewer triangles.
  for (const std::string part : {"block", "bone"}) {
    REQUIRE(test::run("mesh --generate tooth-" + part + " --output " + (folder / (part + ".ply"))).status == 0);
    const MeshModel shipped = meshOf(part), made(loadMesh(folder / (part + ".ply"), 1e-3));
    CHECK(shipped.mesh().triangles.size() < made.mesh().triangles.size() / 4);
    double most = 0.0;
    for (const Vec3& v : made.mesh().vertices) most = std::max(most, closestPoint(shipped, v).distance);
    CHECK(most < 50e-6);
  }
  CHECK_THAT(test::run("mesh --generate tooth-pulp --triangles 1000 --output " + (folder / "pulp.ply")).output,
             ContainsSubstring("--triangles applies to molar and jaw only"));
}

TEST_CASE("a scan is made a solid, within the deviation that is allowed", "[unit]") {
  const test::TemporaryFolder folder;
  const TriangleMesh molar = loadMesh(ENAMEL_SOURCE_DIR "/data/meshes/molar.ply", 1e-3);
  test::writeFile(folder / "scan.obj", scanOf(molar));
  const std::string command = "mesh " + (folder / "scan.obj") + " --overwrite --prepare " + (folder / "made.ply");
  const MeshModel whole(molar);
  const TriangleMesh scan = loadMesh(folder / "scan.obj", 1e-3);
  REQUIRE_FALSE(inspect(scan).watertight);
  std::size_t fewest = scan.triangles.size();
  for (const double most : {0.0, 20.0}) {  // um
    INFO("deviation " << most);
    const test::CommandResult result = test::run(command + " --base 2 --deviation " + std::to_string(most));
    CHECK_THAT(result.output,
               ContainsSubstring("dropped triangles        1 ") && ContainsSubstring("file to prepared"));
    REQUIRE(result.status == 0);
    const TriangleMesh made = loadMesh(folder / "made.ply", 1e-3);
    const MeshModel model(made);
    CHECK(isSound(model));
    CHECK(inspect(made).components == 1);
    CHECK(inspect(made).low.z() < inspect(scan).low.z() - 1e-3);  // the base across the opening
    // Where the scan was: measured by the scan's vertices and the upper vertices of the result.
    double back = 0.0;
    std::size_t lost = 0;  // triangles attached by one vertex only
    for (const Vec3& v : scan.vertices) lost += closestPoint(model, v).distance > 1e-6 * most + 1e-8;
    for (const Vec3& v : made.vertices)
      if (v.z() > 1.3e-3) back = std::max(back, closestPoint(whole, v).distance);
    const double holes = 20e-6;  // of a triangle's size, closed by flat faces
    CHECK(lost < scan.vertices.size() / 500);
    // The printed values agree with these, from more points.
    double there = 0.0;
    for (const auto& t : scan.triangles)
      for (std::size_t i = 0; i < 3; ++i) {
        const Vec3 corner = scan.vertices[static_cast<std::size_t>(t[i])];
        const Vec3 next = scan.vertices[static_cast<std::size_t>(t[(i + 1) % 3])];
        there = std::max(
            {there, closestPoint(model, corner).distance, closestPoint(model, 0.5 * (corner + next)).distance});
      }
    const std::string printed = result.output.substr(result.output.find("file to prepared") + 16);
    CHECK(std::stod(printed) >= 1e6 * there * (1.0 - 6e-3));
    CHECK(back < 1e-6 * most + holes);
    CHECK((most > 0.0 ? made.triangles.size() < fewest : made.triangles.size() > fewest));
    fewest = made.triangles.size();
  }
  CHECK(fewest < scan.triangles.size() * 2 / 3);
  const test::CommandResult lid = test::run(command + " --deviation 0");  // closed like a hole
  CHECK(lid.status == 0);
  CHECK(inspect(loadMesh(folder / "made.ply", 1e-3)).watertight);
  CHECK(test::run("mesh " + (folder / "scan.obj") + " --base 2").status != 0);
  CHECK(test::run(command + " --deviation -1").status != 0);
}

TEST_CASE("a closed mesh is made a solid, and its surface a mesh", "[unit]") {
  const test::TemporaryFolder folder;
  // A wedge, 8 x 6 x 5 mm.
  test::writeFile(folder / "wedge.off",
                  "OFF 6 8 0\n0 0 0\n8 0 0\n0 6 0\n0 0 5\n8 0 5\n0 6 5\n"
                  "3 0 2 1\n3 3 4 5\n3 0 1 4\n3 0 4 3\n3 1 2 5\n3 1 5 4\n3 2 0 3\n3 2 3 5\n");
  const std::string command = "mesh " + (folder / "wedge.off") + " --solid --cell 0.4";
  for (const char* name : {"made.ply", "made.stl"}) {
    const test::CommandResult result = test::run(command + " --output " + (folder / name));
    INFO(result.output);
    REQUIRE(result.status == 0);
    CHECK_THAT(result.output, ContainsSubstring("wrong side               0 points") && ContainsSubstring("bricks") &&
                                  ContainsSubstring("memory"));
    const std::string distances = result.output.substr(result.output.find("error ") + 6);
    CHECK(std::stod(distances) < 20.0);  // um: a twentieth of a cell
    const MeshReport report = inspect(loadMesh(folder / name, 1e-3));
    CHECK(report.watertight);
    CHECK_FALSE(report.inwards);
    CHECK(report.volume == Approx(120e-9).epsilon(0.03));
    CHECK((report.high - Vec3(8e-3, 6e-3, 5e-3)).norm() < 0.5e-3);
  }
  test::writeFile(folder / "flap.off", "OFF 3 1 0\n0 0 0\n1 0 0\n0 2 0\n3 0 1 2\n");
  CHECK_THAT(test::run("mesh " + (folder / "flap.off") + " --solid").output,
             ContainsSubstring("flap.off: the mesh of a solid must be closed"));
  CHECK_THAT(test::run(command + " --output a.obj").output,
             ContainsSubstring("a.obj: the extension must be .ply or .stl"));
  CHECK(test::run("mesh " + (folder / "wedge.off") + " --solid --cell 0").status != 0);
  CHECK(test::run("mesh " + (folder / "wedge.off") + " --cell 0.1").status != 0);
}

TEST_CASE("a mesh inside out is turned round", "[unit]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "in.off", "OFF 4 4 0\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n");
  const test::CommandResult result = test::run("mesh " + (folder / "in.off") + " --prepare " + (folder / "out.ply"));
  CHECK_THAT(result.output, ContainsSubstring("reversed triangles       4 "));
  const MeshReport report = inspect(loadMesh(folder / "out.ply", 1e-3));
  CHECK(report.watertight);
  CHECK_FALSE(report.inwards);
}

TEST_CASE("the shipped meshes are closed, in mm, and made by the generator", "[unit]") {
  const test::TemporaryFolder folder;
  for (const char* name : {"molar", "jaw"}) {
    INFO(name);
    const std::string shipped = ENAMEL_SOURCE_DIR "/data/meshes/" + std::string(name) + ".ply";
    const TriangleMesh mesh = loadMesh(shipped, 1e-3);
    const MeshReport report = inspect(mesh);
    CHECK(report.watertight);
    CHECK_FALSE(report.inwards);
    CHECK(report.degenerateTriangles + report.duplicateTriangles + report.nonManifoldVertices == 0);
    CHECK((report.high - report.low).norm() < 0.1);
    REQUIRE(
        test::run(std::string("mesh --generate ") + name + " --overwrite --output " + (folder / "made.ply")).status ==
        0);
    const TriangleMesh made = loadMesh(folder / "made.ply", 1e-3);
    REQUIRE(made.triangles == mesh.triangles);
    double difference = 0.0;  // sines and powers may differ in the last bit between C libraries
    for (std::size_t v = 0; v < made.vertices.size(); ++v)
      difference = std::max(difference, (made.vertices[v] - mesh.vertices[v]).norm());
    CHECK(difference < 1e-8);
  }
}

}  // namespace enamel::test_mesh_command
