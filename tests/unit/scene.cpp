// Scenes: distances and normals of obstacles, the order of contacts, and the files.
#include "enamel/collision/scene.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

using namespace enamel;

namespace {

Box randomBox(test::Random& random) {
  Box box;
  box.pose.position = random.vector(0.05);
  box.pose.rotation = rotationFromEuler(random.vector(3.0));
  for (int i = 0; i < 3; ++i) box.halfSize[i] = random.uniform(0.002, 0.03);
  return box;
}

bool inside(const Box& box, const Vec3& x) {
  const Vec3 local = box.pose.rotation.transpose() * (x - box.pose.position);
  return (local.cwiseAbs().array() <= box.halfSize.array()).all();
}

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
    "material = 3\n";

void requireRefused(const std::string& from, const std::string& to, const std::string& message) {
  INFO(from << " -> " << to);
  std::string text = kScene;
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  CHECK_THROWS_WITH(parseScene(text.replace(at, from.size(), to), "scene.toml"), message);
}

}  // namespace

TEST_CASE("box: gap and normal lead to the surface, and the gap is the distance", "[scene]") {
  test::Random random(501);
  int in = 0, out = 0;
  for (int i = 0; i < 20000; ++i) {
    const Box box = randomBox(random);
    const Vec3 x = box.pose.position + random.vector(0.06);
    const Contact contact = contactWith(box, x);
    REQUIRE(contact.normal.norm() == Approx(1.0).epsilon(1e-12));
    REQUIRE((contact.gap < 0.0) == inside(box, x));
    (contact.gap < 0.0 ? in : out) += 1;
    // Walking the gap back along the normal ends on the surface: one rounding of sizes of 0.1 m.
    REQUIRE(std::abs(contactWith(box, x - contact.gap * contact.normal).gap) < 1e-15);
    // No point of the surface is nearer: the distance is 1-Lipschitz.
    const Vec3 y = x + random.vector(0.02);
    REQUIRE(std::abs(contactWith(box, y).gap - contact.gap) <= (y - x).norm() + 1e-15);
  }
  CHECK(in > 200);
  CHECK(out > 10000);
}

TEST_CASE("box: faces, an edge, a vertex, the surface itself and the centre", "[scene]") {
  Box box;
  box.halfSize = {1.0, 2.0, 3.0};
  CHECK(contactWith(box, {1.5, 0.0, 0.0}).gap == 0.5);
  CHECK(contactWith(box, {-1.5, 0.0, 0.0}).normal == -Vec3::UnitX());
  CHECK(contactWith(box, {4.0, 6.0, 0.0}).gap == 5.0);
  CHECK(contactWith(box, {4.0, 6.0, 0.0}).normal == Vec3(0.6, 0.8, 0.0));
  CHECK(contactWith(box, {2.0, 4.0, 5.0}).gap == 3.0);
  CHECK(contactWith(box, {0.0, -2.0, 0.0}).gap == 0.0);
  CHECK(contactWith(box, {0.0, -2.0, 0.0}).normal == -Vec3::UnitY());
  CHECK(contactWith(box, Vec3::Zero()).gap == -1.0);
  CHECK(contactWith(box, Vec3::Zero()).normal == Vec3::UnitX());
  CHECK(contactWith(box, {1.0 + 1e-300, 0.0, 0.0}).gap == 0.0);
  const Contact vanishing = contactWith(box, {0.0, 0.0, 3.0 + 1e-15});
  CHECK(vanishing.normal == Vec3::UnitZ());
}

TEST_CASE("contacts come deepest first, one an obstacle, the farthest left out", "[scene]") {
  test::Random random(502);
  ContactSnapshot snapshot;
  for (int i = 0; i < 2000; ++i) {
    Scene scene;
    const int count = 1 + i % 12;
    for (int k = 0; k < count; ++k) {
      const std::string name = std::to_string(k);
      if (k % 2 == 0)
        scene.obstacles.push_back({name, HalfSpace{random.vector(0.02), random.direction()}, k});
      else
        scene.obstacles.push_back({name, randomBox(random), k});
    }
    const Vec3 x = random.vector(0.03);
    queryContacts(scene, x, snapshot);
    REQUIRE(snapshot.count == std::min(count, kMaxContacts));
    std::vector<double> gaps;
    for (const Obstacle& obstacle : scene.obstacles)
      gaps.push_back(std::visit([&x](const auto& shape) { return contactWith(shape, x).gap; }, obstacle.shape));
    for (int k = 0; k < snapshot.count; ++k) {
      const Contact& contact = snapshot.contacts[k];
      REQUIRE(contact.gap == gaps[static_cast<std::size_t>(contact.obstacle)]);
      REQUIRE(contact.material == contact.obstacle);
    }
    std::sort(gaps.begin(), gaps.end());
    for (int k = 0; k < snapshot.count; ++k) REQUIRE(snapshot.contacts[k].gap == gaps[static_cast<std::size_t>(k)]);
  }
}

TEST_CASE("a scene of one half space answers with the half space's own bits", "[scene]") {
  test::Random random(503);
  ContactSnapshot snapshot;
  for (int i = 0; i < 1000; ++i) {
    const HalfSpace wall{random.vector(0.02), random.direction()};
    const Vec3 x = random.vector(0.03);
    queryContacts(flatWall(wall), x, snapshot);
    REQUIRE(snapshot.count == 1);
    REQUIRE(snapshot.contacts[0].gap == contactWith(wall, x).gap);
    REQUIRE(snapshot.contacts[0].normal == wall.normal);
    REQUIRE(snapshot.contacts[0].point == x);
  }
}

TEST_CASE("the shipped scenes load, and the tool can reach what they hold", "[scene]") {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(ENAMEL_SOURCE_DIR "/data/scenes")) {
    const Scene scene = loadScene(entry.path().string());
    INFO(scene.name);
    ContactSnapshot snapshot;
    queryContacts(scene, scene.start, snapshot);
    CHECK(snapshot.contacts[0].gap > 0.0);
    CHECK(snapshot.contacts[0].gap < 0.02);
    CHECK(scene.start.cwiseAbs().maxCoeff() < 0.025);
    ++files;
  }
  CHECK(files >= 4);
}

TEST_CASE("scene files: what is read", "[scene]") {
  const Scene scene = parseScene(kScene, "scene.toml");
  CHECK(scene.name == "test");
  CHECK(scene.start == Vec3(0.0, 0.0, 0.01));
  REQUIRE(scene.obstacles.size() == 2);
  CHECK(std::get<HalfSpace>(scene.obstacles[0].shape).normal == Vec3::UnitZ());
  CHECK(scene.obstacles[0].material == 0);
  const Box& box = std::get<Box>(scene.obstacles[1].shape);
  CHECK(box.halfSize == Vec3(0.01, 0.015, 0.02));
  CHECK(scene.obstacles[1].material == 3);
  CHECK(contactWith(box, {0.05, 0.0, 0.011}).gap == Approx(0.001));  // turned by 90 deg about y: 20 mm along z
}

TEST_CASE("scene files: what is refused, and how", "[scene]") {
  requireRefused("name = \"test\"\n", "", "scene.toml:1: name: is missing");
  requireRefused("name = \"test\"", "name = 3", "scene.toml:1: name: is an integer, must be a string");
  requireRefused("start = [0.0, 0.0, 0.01]", "start = [0.0, 0.01]",
                 "scene.toml:2: start: has 2 elements, must be a list of 3 numbers");
  requireRefused("start = [0.0, 0.0, 0.01]", "start = [0.0, 0.0, -0.002]",
                 "scene.toml:2: start: is 2 mm inside the obstacle \"wall\", must be outside");
  requireRefused("start = [0.0, 0.0, 0.01]", "start = [0.0, 0.0, 3.0]",
                 "scene.toml:2: start[2]: is 3, must be in -1 to 1 m");
  requireRefused("shape = \"half_space\"", "shape = \"cone\"",
                 "scene.toml:5: obstacle[0].shape: is \"cone\", must be \"half_space\" or \"box\"");
  requireRefused("normal = [0.0, 0.0, 2.0]", "normal = [0.0, 0.0, 0.0]",
                 "scene.toml:7: obstacle[0].normal: has the length 0, must be in 1e-06 to 1e+06: it has no direction");
  requireRefused("normal = [0.0, 0.0, 2.0]", "normal = [0.0, 0.0, nan]",
                 "scene.toml:7: obstacle[0].normal[2]: is nan, must be finite");
  requireRefused("normal = [0.0, 0.0, 2.0]", "normal = [0.0, 0.0, 2.0]\nsize = [1, 1, 1]",
                 "scene.toml:8: obstacle[0].size: is not a known key");
  requireRefused("name = \"box\"", "name = \"wall\"",
                 "scene.toml:9: obstacle[1].name: is \"wall\", which another obstacle has");
  requireRefused("size = [0.02, 0.03, 0.04]", "size = [0.02, 0.0, 0.04]",
                 "scene.toml:12: obstacle[1].size[1]: is 0, must be in 1e-04 to 2 m");
  requireRefused("euler_deg = [0.0, 90.0, 0.0]", "euler_deg = [0.0, 900.0, 0.0]",
                 "scene.toml:13: obstacle[1].euler_deg[1]: is 900, must be in -360 to 360 deg");
  requireRefused("material = 3", "material = -1", "scene.toml:14: obstacle[1].material: is -1, must be in 0 to 255");
  requireRefused("material = 3", "material = 3\ncolour = 1", "scene.toml:15: obstacle[1].colour: is not a known key");
  CHECK_THROWS_WITH(parseScene("name = \"a\"\nstart = [0, 0, 0]\nobstacle = []\n", "s.toml"),
                    "s.toml:3: obstacle: has 0 elements, must be 1 to 64");
  CHECK_THROWS_WITH(loadScene("/no/such/scene.toml"), "/no/such/scene.toml: cannot open the file");
  CHECK_THROWS_AS(parseScene("name = ", "s.toml"), ConfigurationError);
}
