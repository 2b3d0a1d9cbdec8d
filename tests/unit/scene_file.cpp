// Scene files: the accepted ones, the refused ones, and contents of the shipped ones.
#include "enamel/collision/scene_file.hpp"

#include <cmath>
#include <filesystem>

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/mesh_update.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/temporary_folder.hpp"

namespace enamel::test_scene_file {

namespace {

const std::string kScene =
    "name = \"test\"\n"
    "start = [0.0, 0.0, 0.01]\n"
    "[[obstacle]]\n"
    "name = \"wall\"\n"
    "shape = \"half_space\"\n"
    "point = [0.0, 0.0, 0.0]\n"
    "normal = [0.0, 0.0, 2.0]\n"
    "[[obstacle]]\n"
    "name = \"box\"\n"
    "shape = \"box\"\n"
    "centre = [0.05, 0.0, 0.0]\n"
    "size = [0.02, 0.03, 0.04]\n"
    "euler_deg = [0.0, 90.0, 0.0]\n"
    "friction = 0.3\n";

Contact nearestTo(const SceneFile& file, const Vec3& position) {
  return nearestContact(file.scene, file.tool, {position, Mat3::Identity()}, nullptr);
}

void requireRefused(const std::string& from, const std::string& to, const std::string& message) {
  INFO(from << " -> " << to);
  std::string text = kScene;
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  CHECK_THROWS_WITH(parseScene(text.replace(at, from.size(), to), "scene.toml"), message);
}

// A file with one sphere, and further keys of it from line 8 on.
SceneFile sphereWith(const std::string& keys) {
  return parseScene(
      "name = \"a\"\nstart = [0, 0, 0.1]\n[[obstacle]]\nname = \"ball\"\nshape = \"sphere\"\n"
      "centre = [0, 0, 0]\nradius = 0.01\n" +
          keys,
      "s.toml");
}

}  // namespace

TEST_CASE("the shipped scenes load, and the tool can reach what they hold", "[scene]") {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ENAMEL_SOURCE_DIR "/data/scenes")) {
    const SceneFile file = loadScene(entry.path().string());
    INFO(file.name);
    const double gap = nearestTo(file, file.start).gap;
    CHECK(gap > 0.0);
    CHECK(gap < 0.02);
    CHECK(file.start.cwiseAbs().maxCoeff() < 0.025);
    ++files;
  }
  CHECK(files >= 6);
}

TEST_CASE("scene files: what is read", "[scene]") {
  const SceneFile file = parseScene(kScene, "scene.toml");
  CHECK(file.name == "test");
  CHECK(file.start == Vec3(0.0, 0.0, 0.01));
  CHECK(file.tool.count == 1);
  CHECK(file.tool.parts[0].radius == 0.0);
  const std::vector<Obstacle>& obstacles = file.scene.obstacles();
  REQUIRE(obstacles.size() == 2);
  CHECK(obstacles[0].pose.rotation.col(2) == Vec3::UnitZ());
  CHECK(obstacles[0].material.friction == 0.0);
  CHECK(std::get<Box>(obstacles[1].shape).half == Vec3(0.01, 0.015, 0.02));
  CHECK(obstacles[1].material.friction == 0.3);
  // Rotated by 90 deg about y, the box is 20 mm high: 1 mm above it and 11 mm above the wall.
  CHECK(nearestTo(file, {0.05, 0.0, 0.011}).gap == Approx(0.001));
  CHECK(nearestTo(file, {0.05, 0.0, 0.011}).material.friction == 0.3);
}

TEST_CASE("scene files: spheres, capsules, meshes and tools stand where the file says", "[scene]") {
  const test::TemporaryFolder folder;
  // A tetrahedron with a face in x = 0, in mm, twice as large and rotated so that its x axis is W's z.
  test::writeFile(folder / "corner.off",
                  "OFF 4 4 0\n0 0 0\n0 2 0\n0 0 2\n-1 0 0\n3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n");
  test::writeFile(
      folder / "scene.toml",
      "name = \"shapes\"\nstart = [0.0, 0.0, 0.05]\n"
      "[[tool]]\nfrom = [0.0, 0.0, 0.002]\nradius = 0.002\n"
      "[[tool]]\nfrom = [0.0, 0.0, 0.004]\nto = [0.0, 0.0, 0.02]\nradius = 0.001\n"
      "[[obstacle]]\nname = \"ball\"\nshape = \"sphere\"\ncentre = [0.1, 0.0, 0.0]\nradius = 0.01\n"
      "[[obstacle]]\nname = \"rod\"\nshape = \"capsule\"\nfrom = [-0.1, -0.02, 0.0]\nto = [-0.1, 0.02, 0.0]\n"
      "radius = 0.005\n"
      "[[obstacle]]\nname = \"tooth\"\nshape = \"mesh\"\nfile = \"corner.off\"\nunit = \"mm\"\nscale = 2\n"
      "position = [0.0, 0.1, 0.001]\neuler_deg = [0.0, -90.0, 0.0]\nstiffness = 3000\nfriction = 0.4\nsliding_friction "
      "= 0.3\nviscosity = 0.5\n");
  const SceneFile file = loadScene(folder / "scene.toml");
  REQUIRE(file.tool.count == 2);
  // The TCP is the lowest point of the ball: 3 mm above each surface.
  CHECK(nearestTo(file, {0.1, 0.0, 0.013}).gap == Approx(0.003));
  CHECK(nearestTo(file, {0.1, 0.0, 0.013}).obstacle == 0);
  CHECK(nearestTo(file, {-0.1, 0.02, 0.008}).gap == Approx(0.003));
  CHECK(nearestTo(file, {-0.1, 0.02, 0.008}).obstacle == 1);
  const Contact tooth = nearestTo(file, {-0.0005, 0.1005, 0.004});
  CHECK(tooth.gap == Approx(0.003));
  CHECK(tooth.material.stiffness == 3000.0);
  CHECK(tooth.material.friction == 0.4);
  CHECK(tooth.material.slidingFriction == 0.3);
  CHECK(tooth.material.viscosity == 0.5);

  CHECK((tooth.normal - Vec3::UnitZ()).norm() < 1e-7);  // single-precision coordinates of the file
  CHECK((tooth.point - Vec3(-0.0005, 0.1005, 0.004)).norm() < 1e-9);
  // Beside the shaft: radius 1 mm, from 4 mm above the TCP on.
  CHECK(nearestTo(file, {0.113, 0.0, -0.012}).gap == Approx(0.002));
}

TEST_CASE("scene files: a packed scene is the same text with other names of files", "[scene]") {
  const test::TemporaryFolder folder;
  const std::string accents = "\xc3\xa9'\xf0\x9f\xa6\xb7.off";  // two bytes, four bytes
  for (const std::string& name : {std::string("a.off"), accents, std::string("c.off")})
    test::writeFile(folder / name, "OFF 4 4 0\n0 0 0\n0 20 0\n0 0 20\n-10 0 0\n3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n");
  const auto text = [](const std::string& first, const std::string& second, const std::string& third) {
    const std::string mesh = "shape = \"mesh\"\nunit = \"mm\"\n";
    return "name = \"\xc3\xa9\" # \xf0\x9f\xa6\xb7\r\nstart = [0.0, 0.0, 0.1]\n[[tool]]\nfrom = [0.0, 0.0, "
           "0.001]\nradius = 0.001\n"
           "[[obstacle]]\nname = \"file = a.off\"\nfile = " +
           first + " # the first\n" + mesh + "[[obstacle]]\nname = '\xc3\xa9'\n" + mesh + "file=" + second + "\n" +
           "[[obstacle]]\nname = \"c\"\n" + mesh + "\"file\" =  " + third;
  };
  test::writeFile(folder / "scene.toml",
                  text("'''a.off'''", "\"\\u00e9'\xf0\x9f\xa6\xb7.off\"", "\"\"\"\nc.off\"\"\""));
  const PackedScene packed = packScene(folder / "scene.toml");
  CHECK(packed.text == text("\"mesh-0.off\"", "\"mesh-1.off\"", "\"mesh-2.off\""));
  REQUIRE(packed.files.size() == 3);
  CHECK(packed.files[1].path == folder / accents);
  for (const auto& [name, path] : packed.files) test::writeFile(folder / name, test::readFile(path));
  CHECK(parseScene(packed.text, folder / "packed.toml").scene.obstacles().size() == 3);
}

TEST_CASE("scene files: solids and burs", "[scene]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "tooth.off", "OFF 4 4 0\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
  test::writeFile(folder / "pulp.off", "OFF 4 4 0\n1 1 1\n2 1 1\n1 2 1\n1 1 2\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n");
  test::writeFile(folder / "open.off", "OFF 3 1 0\n0 0 0\n9 0 0\n0 9 0\n3 0 1 2\n");
  const std::string text =
      "name = \"solid\"\nstart = [0.0, 0.0, 0.02]\n[[tool]]\nfrom = [0.0, 0.0, 0.001]\nradius = 0.001\n"
      "[bur]\nwear = 0.2\nturns = 500.0\n"
      "[[obstacle]]\nname = \"tooth\"\nshape = \"solid\"\nfile = \"tooth.off\"\nunit = \"mm\"\ncell = 0.0005\n"
      "[[obstacle.layer]]\nname = \"enamel\"\nhardness = 3e9\nfriction = 0.1\n"
      "[[obstacle.layer]]\nname = \"pulp\"\nhardness = 1e8\nfile = \"pulp.off\"\nstiffness = 2000\n";
  const auto read = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    if (!from.empty()) changed.replace(changed.find(from), from.size(), to);
    test::writeFile(folder / "scene.toml", changed);
    return loadScene(folder / "scene.toml");
  };
  const SceneFile file = read("", "");
  REQUIRE(file.bur);
  CHECK(file.bur->part == 0);
  CHECK(file.bur->wear == 0.2);
  CHECK(file.bur->turns == 500.0);
  CHECK((std::isinf(file.bur->torque) && file.bur->runOut == 0.0 && file.bur->blades == 0));
  REQUIRE(file.solids.size() == 1);
  const Solid& solid = *file.solids[0];
  CHECK(solid.cell() == 0.0005);
  REQUIRE(solid.layers().size() == 2);
  CHECK(solid.layers()[0].material.friction == 0.1);
  CHECK(solid.layers()[1].material.stiffness == 2000.0);
  CHECK(solid.layerAt(Vec3(1e-3, 1e-3, 1e-3)) == 1);
  CHECK(solid.layerAt(Vec3(3e-3, 1e-3, 1e-3)) == 0);
  CHECK(nearestTo(file, {0.002, 0.002, 0.02}).gap < 0.012);
  CHECK(loadScene(ENAMEL_SOURCE_DIR "/data/scenes/molar.toml").solids[0] == nullptr);

  const auto refuses = [&](const std::string& from, const std::string& to, const std::string& message) {
    INFO(from << " -> " << to);
    CHECK_THROWS_WITH(read(from, to), test::ContainsSubstring(message));
  };
  refuses("tooth.off", "open.off", "shape: is \"solid\": the mesh of a solid must be closed");
  refuses("\"pulp.off\"", "\"open.off\"", "the mesh where it begins must be closed");
  refuses("cell = 0.0005", "cell = 0.0", "cell: is 0, must be in 1e-06 to 2 m");
  refuses("cell = 0.0005", "cell = 0.000002", "too small: the solid needs more than 1 GB");
  refuses("hardness = 3e9", "hardness = -1.0", "hardness: is -1, must be in 1000 to 1e+12 Pa");
  refuses("hardness = 1e8", "hardness = 1e8\ndepth = 0.001", "both define where the layer begins");
  refuses("turns = 500.0", "turns = 2e4", "turns: is 20000, must be in 0 to 10000");
  refuses("wear = 0.2", "part = 1", "part: is 1, must be in 0 to 0");
  refuses("wear = 0.2", "torque = 0.0", "torque: is 0, must be in 1e-06 to 10");
  refuses("wear = 0.2", "run_out = 0.1", "run_out: is 0.1, must be in 0 to 1e-04");
  refuses("wear = 0.2", "blades = 2.5", "blades: is 2.5, must be a whole number");
  const Bur motor = *read("wear = 0.2",
                          "torque = 1e-3\ninertia = 2e-8\ndrag = 0.4\nrun_out = 5e-6\nblades = 6\n"
                          "shaft_compliance = 1e-5\nshaft_frequency = 500.0\nshaft_damping = 0.1")
                         .bur;
  CHECK((motor.torque == 1e-3 && motor.inertia == 2e-8 && motor.drag == 0.4));
  CHECK((motor.runOut == 5e-6 && motor.blades == 6));
  CHECK((motor.shaftCompliance == 1e-5 && motor.shaftFrequency == 500.0 && motor.shaftDamping == 0.1));
  refuses("radius = 0.001", "radius = 0.0", "whose radius must be greater than 0 mm");
  refuses("wear = 0.2", "speed = 1", "is not a known key");
}

TEST_CASE("scene files: a suspension is read", "[scene]") {
  const auto with = [](const std::string& keys) { return sphereWith("[obstacle.suspension]\n" + keys); };
  const std::string mass = "inertia = [1, 1, 2, 0, 0, 3]\n";
  const SceneFile loose = with(mass), sprung = with(mass +
                                                    "stiffness = [1, 2, 3, 4, 5, 6]\ndamping = [0, 0, 7, 0, 0, 0]\n"
                                                    "centre = [0.1, 0.2, 0.3]\n");
  const Suspension& free = *loose.scene.obstacles()[0].suspension;
  CHECK(free.inertia == (Vec6() << 1, 1, 2, 0, 0, 3).finished());
  CHECK((free.stiffness.isZero(0.0) && free.damping.isZero(0.0) && free.centre.isZero(0.0)));
  const Suspension& held = *sprung.scene.obstacles()[0].suspension;
  CHECK(held.stiffness == (Vec6() << 1, 2, 3, 4, 5, 6).finished());
  CHECK(held.damping == (Vec6() << 0, 0, 7, 0, 0, 0).finished());
  CHECK(held.centre == Vec3(0.1, 0.2, 0.3));
  CHECK_THROWS_WITH(with(""), test::ContainsSubstring("obstacle[0].suspension.inertia: is missing"));
  CHECK_THROWS_WITH(with("inertia = [0, 0, 0, 0, 0, 0]\n"),
                    test::ContainsSubstring("is 0 along and about every axis, must be above 0 in one"));
  CHECK_THROWS_WITH(with("inertia = [1, 1, 1e-13, 0, 0, 0]\n"),
                    test::ContainsSubstring("suspension.inertia[2]: is 1e-13, must be 0 (locked) or at least 1e-12"));
  CHECK_THROWS_WITH(with("inertia = [1, 1, -1, 0, 0, 0]\n"),
                    test::ContainsSubstring("suspension.inertia[2]: is -1, must be in 0 to 1e+06 kg or kg m^2"));
  CHECK_THROWS_WITH(with(mass + "stiffness = [0, 2e9, 0, 0, 0, 0]\n"),
                    test::ContainsSubstring("suspension.stiffness[1]: is 2e+09, must be in 0 to 1e+09 N/m or N m/rad"));
  CHECK_THROWS_WITH(with(mass + "mass = 1\n"), test::ContainsSubstring("suspension.mass: is not a known key"));
}

TEST_CASE("scene files: a rough surface and its friction are read", "[scene]") {
  const Material& m = sphereWith(
                          "friction = 0.4\nsliding_friction = 0.2\nstribeck_speed = 0.01\nroughness = 5e-6\n"
                          "wavelength = 3e-4\n")
                          .scene.obstacles()[0]
                          .material;
  CHECK((m.friction == 0.4 && m.slidingFriction == 0.2 && m.stribeck == 0.01));
  CHECK((m.roughness == 5e-6 && m.wavelength == 3e-4));
  for (const auto& [keys, problem] :
       {std::pair("stribeck_speed = -1\n", "s.toml:8: obstacle[0].stribeck_speed: is -1, must be in 0 to 10 m/s"),
        {"wavelength = 1.0\n", "s.toml:8: obstacle[0].wavelength: is 1, must be in 1e-05 to 0.01 m"},
        {"roughness = 5e-6\n",
         "s.toml:8: obstacle[0].roughness: needs \"wavelength\": the longest one of the rough surface"},
        {"wavelength = 1e-4\nroughness = 5e-6\n",
         "s.toml:9: obstacle[0].roughness: is 5e-06, must be at most 0.02 of \"wavelength\""}})
    CHECK_THROWS_WITH(sphereWith(keys), problem);
  Scene scene;  // the same from programs, without a file
  Obstacle ball{"ball", Sphere{0.01}, Pose{}, Vec6::Zero(), {}};
  ball.material.roughness = 1e-6;
  CHECK_THROWS_WITH(scene.add(ball), test::ContainsSubstring("a roughness of 1e-06 m and a wavelength of 0 m"));
  ball.material.roughness = 0.0;
  ball.material.stribeck = std::nan("");
  CHECK_THROWS_WITH(scene.add(ball), test::ContainsSubstring("a Stribeck speed of nan m/s, must be in 0 to 10 m/s"));
}

TEST_CASE("scene files: a compliant layer is read", "[scene]") {
  const SceneFile file =
      sphereWith("stiffness = 1500\nexponent = 1.5\nlayer_thickness = 0.002\nhysteresis = 0.8\npuncture_force = 2.5\n");
  const Material& gum = file.scene.obstacles()[0].material;
  CHECK((gum.stiffness == 1500.0 && gum.exponent == 1.5 && gum.thickness == 0.002));
  CHECK((gum.hysteresis == 0.8 && gum.puncture == 2.5 && gum.isLayer()));
  const Material& linear = sphereWith("stiffness = 1500\n").scene.obstacles()[0].material;
  CHECK((!linear.isLayer() && std::isinf(linear.thickness) && std::isinf(linear.puncture)));
  const std::string soft = "stiffness = 1500\n";
  for (const auto& [keys, problem] :
       {std::pair(soft + "exponent = 0.5\n", "s.toml:9: obstacle[0].exponent: is 0.5, must be in 1 to 10"),
        {soft + "layer_thickness = 2.0\n", "s.toml:9: obstacle[0].layer_thickness: is 2, must be in 1e-05 to 0.1 m"},
        {soft + "hysteresis = -1\n", "s.toml:9: obstacle[0].hysteresis: is -1, must be in 0 to 100 s/m"},
        {soft + "layer_thickness = 0.002\npuncture_force = 0\n",
         "s.toml:10: obstacle[0].puncture_force: is 0, must be in 0.001 to 1000 N"},
        {soft + "puncture_force = 2\n",
         "s.toml:9: obstacle[0].puncture_force: needs \"layer_thickness\": the depth at which the tool meets the "
         "ground"},
        {std::string("hysteresis = 1\n"),
         "s.toml:8: obstacle[0].hysteresis: needs a finite \"stiffness\", but the material is rigid"}})
    CHECK_THROWS_WITH(sphereWith(keys), problem);
  // The same from programs, without a file.
  Scene scene;
  Obstacle ball{"ball", Sphere{0.01}, Pose{}, Vec6::Zero(), {}};
  ball.material.hysteresis = 1.0;
  CHECK_THROWS_WITH(scene.add(ball), test::ContainsSubstring("needs a finite stiffness"));
  ball.material.stiffness = 1500.0;
  ball.material.puncture = 2.0;
  CHECK_THROWS_WITH(scene.add(ball), test::ContainsSubstring("a puncture force needs a thickness"));
  ball.material.thickness = 2e-3;
  ball.material.exponent = 11.0;
  CHECK_THROWS_WITH(scene.add(ball), test::ContainsSubstring("an exponent in 1 to 10"));
  ball.material.exponent = 1.5;
  CHECK(scene.add(ball) == 0);
}

TEST_CASE("scene files: taps are read", "[scene]") {
  const auto with = [](const std::string& keys) {
    return parseScene(
               "name = \"a\"\nstart = [0, 0, 0.1]\n[[obstacle]]\nname = \"b\"\nshape = \"sphere\"\n"
               "centre = [0, 0, 0]\nradius = 0.01\n" +
                   keys,
               "s.toml")
        .scene.obstacles()[0]
        .tap;
  };
  CHECK(with("").frequency == 0.0);
  for (const NamedTap& known : kNamedTaps) {
    const Tap read = with("tap = \"" + std::string(known.name) + "\"\n");
    CHECK((read.frequency == known.tap.frequency && read.decay == known.tap.decay));
  }
  const Tap own = with("tap = [200, 0]\n");
  CHECK((own.frequency == 200.0 && own.decay == 0.0));
  for (const auto& [keys, message] :
       {std::pair{"tap = \"wood\"\n", "tap: is \"wood\", must be one of \"enamel\", \"dentine\""},
        {"tap = 200\n", "tap: is an integer, must be a list of numbers"},
        {"tap = [200]\n", "tap: has 1 numbers, must have 2: Hz and 1/s"},
        {"tap = [5, 90]\n",
         "tap: is out of range: a tap has a frequency of 10 to 1000 Hz and a decay of 0 to 2000 1/s"},
        {"tap = [300, 3000]\n", "not 300 Hz and 3000 1/s"}})
    CHECK_THROWS_WITH(with(keys), test::ContainsSubstring(message));
}

TEST_CASE("scene files: guides are read", "[scene]") {
  const auto with = [](const std::string& keys) {
    return parseScene(
        "name = \"a\"\nstart = [0, 0, 0.1]\n[[obstacle]]\nname = \"b\"\nshape = \"sphere\"\n"
        "centre = [0, 0, 0]\nradius = 0.01\n" +
            keys,
        "s.toml");
  };
  const std::string force = "stiffness = 200\nmax_force = 1.5\n",
                    plane = "point = [0, 0, 0.02]\nnormal = [0, 2, 0]\n" + force;
  CHECK(with("").scene.guides() == nullptr);
  const SceneFile file = with(
      "[[guide]]\nshape = \"line\"\npoints = [[0, 0, 0], [0.1, 0, 0]]\n" + force +
      "[[guide]]\nshape = \"line\"\npoints = [[0.1, 0, 0]]\nradius = 0.05\n" + force +
      "[[guide]]\nshape = \"plane\"\n" + plane + "[[guide]]\nshape = \"half_space\"\n" + plane +
      "[[guide]]\nshape = \"box\"\ncentre = [0, 0, 0.1]\nsize = [0.1, 0.2, 0.3]\neuler_deg = [0, 0, 90]\n" + force);
  REQUIRE(file.scene.guides() != nullptr);
  const std::vector<Guide>& guides = *file.scene.guides();
  REQUIRE(guides.size() == 5);
  for (const Guide& guide : guides) CHECK((guide.stiffness == 200.0 && guide.maxForce == 1.5));
  const Vec3 p(0.05, 0.3, 0.02);
  const auto offset = [&](std::size_t i) { return errorOf(guides[i], p, Vec3::Zero()).offset; };
  CHECK((offset(0) - Vec3(0.0, 0.3, 0.02)).norm() < 1e-15);
  const Vec3 fromBall = p - Vec3(0.1, 0.0, 0.0);
  CHECK((offset(1) - (fromBall - 0.05 * fromBall.normalized())).norm() < 1e-15);
  CHECK((offset(2) - Vec3(0.0, 0.3, 0.0)).norm() < 1e-15);
  CHECK(offset(3).isZero(0.0));                              // on the side of the normal
  CHECK((offset(4) - Vec3(0.0, 0.25, 0.0)).norm() < 1e-15);  // 0.2 m along x after the turn, 0.1 m along y
  for (const auto& [keys, message] :
       {std::pair{std::string("shape = \"ball\"\n"),
                  "s.toml:9: guide[0].shape: is \"ball\", must be \"line\", \"plane\", \"half_space\" or \"box\""},
        {"shape = \"line\"\npoints = 3\n" + force, "points: is an integer, must be a list of points of 3 numbers"},
        {"shape = \"line\"\npoints = [[0, 0]]\n" + force, "points[0]: has 2 elements, must be a list of 3 numbers"},
        {"shape = \"line\"\npoints = [[0, 0, 0], [0, 9, 0]]\n" + force, "points[1][1]: is 9, must be in -1 to 1 m"},
        {"shape = \"line\"\npoints = []\n" + force, "points: is not valid: the line has 0 points, must have 1 to 64"},
        {"shape = \"line\"\npoints = [[0, 0, 0], [0, 0, 0]]\n" + force, "points 0 and 1 of the line are equal"},
        {"shape = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 0]\n" + force, "normal: has the length 0"},
        {"shape = \"plane\"\nradius = 1\n" + plane, "guide[0].radius: is not a known key"},
        {"shape = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nstiffness = -1\nmax_force = 1\n",
         "stiffness: is -1, must be in 0 to 1e+05 N/m"},
        {"shape = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\nstiffness = 1\nmax_force = 101\n",
         "max_force: is 101, must be in 0 to 100 N"}})
    CHECK_THROWS_WITH(with("[[guide]]\n" + keys), test::ContainsSubstring(message));
  std::string nine;
  for (int i = 0; i < 9; ++i) nine += "[[guide]]\nshape = \"plane\"\n" + plane;
  CHECK_THROWS_WITH(with(nine), test::ContainsSubstring("guide: the scene has 9 guides, must have at most 8"));
}

TEST_CASE("scene files: what is refused, and how", "[scene]") {
  requireRefused("name = \"test\"\n", "", "scene.toml:1: name: is missing");
  requireRefused("name = \"test\"", "platform = {}",
                 "scene.toml:1: platform: this is a device file, a scene file is needed");
  requireRefused("name = \"test\"", "name = 3", "scene.toml:1: name: is an integer, must be a string");
  requireRefused("start = [0.0, 0.0, 0.01]", "start = [0.0, 0.01]",
                 "scene.toml:2: start: has 2 elements, must be a list of 3 numbers");
  requireRefused("start = [0.0, 0.0, 0.01]", "start = [0.0, 0.0, -0.002]",
                 "scene.toml:2: start: is 2 mm inside the obstacle \"wall\", must be outside");
  requireRefused("start = [0.0, 0.0, 0.01]", "start = [0.0, 0.0, 3.0]",
                 "scene.toml:2: start[2]: is 3, must be in -1 to 1 m");
  requireRefused("shape = \"half_space\"", "shape = \"cone\"",
                 "scene.toml:5: obstacle[0].shape: is \"cone\", must be \"half_space\", "
                 "\"box\", \"sphere\", \"capsule\", \"mesh\" or \"solid\"");
  requireRefused("normal = [0.0, 0.0, 2.0]", "normal = [0.0, 0.0, 0.0]",
                 "scene.toml:7: obstacle[0].normal: has the length 0, must be in 1e-06 to 1e+06 to define a direction");
  requireRefused("normal = [0.0, 0.0, 2.0]", "normal = [0.0, 0.0, nan]",
                 "scene.toml:7: obstacle[0].normal[2]: is nan, must be finite");
  requireRefused("normal = [0.0, 0.0, 2.0]", "normal = [0.0, 0.0, 2.0]\nsize = [1, 1, 1]",
                 "scene.toml:8: obstacle[0].size: is not a known key; possible are exponent, friction, hysteresis, "
                 "layer_thickness, name, "
                 "normal, point, puncture_force, roughness, shape, sliding_friction, stiffness, stribeck_speed, "
                 "suspension, tap, viscosity, wavelength");
  requireRefused("name = \"box\"", "name = \"wall\"",
                 "scene.toml:9: obstacle[1].name: is \"wall\", which is also the name of another obstacle");
  requireRefused("size = [0.02, 0.03, 0.04]", "size = [0.02, 0.0, 0.04]",
                 "scene.toml:12: obstacle[1].size[1]: is 0, must be in 1e-04 to 2 m");
  requireRefused("euler_deg = [0.0, 90.0, 0.0]", "euler_deg = [0.0, 900.0, 0.0]",
                 "scene.toml:13: obstacle[1].euler_deg[1]: is 900, must be in -360 to 360 deg");
  requireRefused("friction = 0.3", "friction = -1", "scene.toml:14: obstacle[1].friction: is -1, must be in 0 to 10");
  requireRefused("friction = 0.3", "friction = 0.3\nsliding_friction = 0.4",
                 "scene.toml:15: obstacle[1].sliding_friction: is 0.4, must be in 0 to 0.3");
  requireRefused("friction = 0.3", "stiffness = 0",
                 "scene.toml:14: obstacle[1].stiffness: is 0, must be in 1 to 1e+09 N/m");
  requireRefused(
      "friction = 0.3", "friction = 0.3\ncolour = 1",
      "scene.toml:15: obstacle[1].colour: is not a known key; possible are centre, euler_deg, exponent, friction, "
      "hysteresis, "
      "layer_thickness, name, puncture_force, roughness, shape, size, sliding_friction, stiffness, stribeck_speed, "
      "suspension, tap, viscosity, wavelength");
  CHECK_THROWS_WITH(parseScene("name = \"a\"\nstart = [0, 0, 0]\nobstacle = []\n", "s.toml"),
                    "s.toml:3: obstacle: has 0 elements, must be 1 to 64");
  CHECK_THROWS_WITH(loadScene("/no/such/scene.toml"),
                    "/no/such/scene.toml: cannot open the file: No such file or directory");
  CHECK_THROWS_AS(parseScene("name = ", "s.toml"), ConfigurationError);

  const auto meshed = [](const std::string& keys) {
    return "name = \"a\"\nstart = [0, 0, 0]\n[[obstacle]]\nname = \"m\"\nshape = \"mesh\"\n" + keys;
  };
  CHECK_THROWS_WITH(parseScene(meshed("file = \"no.ply\"\nunit = \"mm\"\n"), "/no/such/s.toml"),
                    test::ContainsSubstring("/no/such/no.ply"));
  CHECK_THROWS_WITH(parseScene(meshed("file = \"no.ply\"\n"), "s.toml"), "s.toml:3: obstacle[0].unit: is missing");
  CHECK_THROWS_WITH(parseScene(meshed("file = \"no.ply\"\nunit = \"inch\"\n"), "s.toml"),
                    "s.toml:7: obstacle[0].unit: is \"inch\", must be \"m\", \"mm\" or \"um\"");
  for (const auto& [keys, problem] : {std::pair("thin = 1\n", "thin: is an integer, must be true or false"),
                                      {"thin = true\n", "thickness: is missing"},
                                      {"thin = true\nthickness = 0.0\n", "thickness: is 0, must be in 1e-06 to 0.01 m"},
                                      {"thickness = 0.001\n", "thickness: is only valid with thin = true"}})
    CHECK_THROWS_WITH(parseScene(meshed("file = \"no.ply\"\nunit = \"mm\"\n" + std::string(keys)), "s.toml"),
                      test::ContainsSubstring(problem));
  CHECK_THROWS_WITH(parseScene(meshed("file = \"no.ply\"\nunit = \"mm\"\nscale = 0\n"), "s.toml"),
                    "s.toml:8: obstacle[0].scale: is 0, must be in 1e-06 to 1e+06");
  for (const char* limit : {"1e-6", "1e6"})
    CHECK_THROWS_WITH(
        parseScene(meshed("file = \"no.ply\"\nunit = \"mm\"\nscale = " + std::string(limit) + "\n"), "s.toml"),
        test::ContainsSubstring("no.ply") && !test::ContainsSubstring("scale"));
  const std::string tool = "name = \"a\"\nstart = [0, 0, 0]\n[[tool]]\nfrom = [0, 0, 0]\n";
  CHECK_THROWS_WITH(parseScene(tool, "s.toml"), "s.toml:3: tool[0].radius: is missing");
  CHECK_THROWS_WITH(parseScene(tool + "radius = 1\n", "s.toml"),
                    "s.toml:5: tool[0].radius: is 1, must be in 0 to 0.05 m");
}

TEST_CASE("scene files: a probable wrong unit, and cells larger than the bur, are noted", "[scene]") {
  const test::TemporaryFolder folder;
  test::writeFile(
      folder / "box.off",
      "OFF 8 12 0\n-5 -5 -10\n5 -5 -10\n5 5 -10\n-5 5 -10\n-5 -5 0\n5 -5 0\n5 5 0\n-5 5 0\n3 0 2 1\n3 0 3 2\n3 4 5 "
      "6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 2 3 7\n3 2 7 6\n3 1 2 6\n3 1 6 5\n3 0 4 7\n3 0 7 3\n");
  const auto notes = [&](const std::string& shape, const std::string& keys) {
    return parseScene(
               "name = \"a\"\nstart = [0, 0, 0.02]\n[[tool]]\nfrom = [0, 0, 0]\nto = [0, 0, 0]\nradius = "
               "0.0005\n[[obstacle]]\nname = \"box\"\nshape = "
               "\"" +
                   shape + "\"\nfile = \"box.off\"\n" + keys,
               folder / "s.toml")
        .notes;
  };
  CHECK(notes("mesh", "unit = \"mm\"\n").empty());
  REQUIRE(notes("mesh", "unit = \"m\"\n").size() == 1);
  CHECK_THAT(
      notes("mesh", "unit = \"m\"\n")[0],
      test::ContainsSubstring(
          "obstacle \"box\": is 10000 mm across; if this size is wrong, its unit is probably 1000 times smaller"));
  REQUIRE(notes("mesh", "unit = \"um\"\n").size() == 1);
  CHECK_THAT(
      notes("mesh", "unit = \"um\"\n")[0],
      test::ContainsSubstring("is 0.01 mm across; if this size is wrong, its unit is probably 1000 times larger"));
  const std::string layer = "[[obstacle.layer]]\nname = \"enamel\"\nhardness = 3e9\n";
  CHECK(notes("solid", "unit = \"mm\"\ncell = 0.0005\n" + layer).empty());
  REQUIRE(notes("solid", "unit = \"mm\"\ncell = 0.0006\n" + layer).size() == 1);
  CHECK_THAT(notes("solid", "unit = \"mm\"\ncell = 0.0006\n" + layer)[0],
             test::ContainsSubstring("its cells of 0.6 mm are larger than the radius of the tool's part 0, 0.5 mm"));
}

TEST_CASE("scene files: an open mesh is noted, a sheet is none", "[scene]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "flap.off", "OFF 3 1 0\n-10 -10 0\n10 -10 0\n0 10 0\n3 0 1 2\n");
  const auto scene = [&](const std::string& keys) {
    return parseScene(
        "name = \"a\"\nstart = [0, 0, 0.005]\n[[obstacle]]\nname = \"flap\"\nshape = \"mesh\"\n"
        "file = \"flap.off\"\nunit = \"mm\"\n" +
            keys,
        folder / "s.toml");
  };
  const SceneFile open = scene(""), thin = scene("thin = true\nthickness = 0.001\n");
  REQUIRE(open.notes.size() == 1);
  CHECK_THAT(open.notes[0], test::ContainsSubstring("obstacle \"flap\": open (3 boundary edges)"));
  CHECK(thin.notes.empty());
  for (const double z : {0.004, -0.004}) {
    CHECK(std::abs(nearestTo(thin, {0, 0, z}).gap - 0.0035) < 1e-12);
    CHECK(std::abs(nearestTo(open, {0, 0, z}).gap - 0.004) < 1e-12);
  }
}

TEST_CASE("scene files: a mesh of a scene may be edited", "[scene]") {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "flap.off", "OFF 3 1 0\n-10 -10 0\n10 -10 0\n0 10 0\n3 0 1 2\n");
  const SceneFile file = parseScene(
      "name = \"a\"\nstart = [0, 0, 0.005]\n[[obstacle]]\nname = \"floor\"\nshape = \"half_space\"\n"
      "point = [0, 0, -0.1]\nnormal = [0, 0, 1]\n[[obstacle]]\nname = \"flap\"\nshape = \"mesh\"\n"
      "file = \"flap.off\"\nunit = \"mm\"\n",
      folder / "s.toml", {1, 1});
  REQUIRE(file.meshes.size() == 2);
  CHECK(file.meshes[0] == nullptr);
  const Vec3 tip(0, 0, 0.003);
  const std::array<int, 3> side{0, 1, 3};
  REQUIRE(addVertices(*file.meshes[1], &tip, 1) == Status::ok);
  REQUIRE(addTriangles(*file.meshes[1], &side, 1) == Status::ok);
  CHECK(std::abs(nearestTo(file, {0, 0, 0.004}).gap - 0.001) < 1e-12);
}

}  // namespace enamel::test_scene_file
