// Files of solids: every bit survives, and files that were cut or changed are refused with their name.
#include "enamel/collision/solid_file.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "enamel/collision/scene_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_solid_file {

namespace {

const Vec3 kHalf(1.1e-3, 0.9e-3, 0.8e-3), kCentre(1e-3, 2e-3, 3e-3);
constexpr double kCell = 1e-4;
constexpr std::size_t kPreamble = 24;

Solid tooth() {
  std::vector<SolidLayer> layers(3);
  layers[0].name = "enamel";
  layers[0].material.friction = layers[0].material.slidingFriction = 0.1;
  layers[0].tap = tapOf("enamel");
  layers[1].name = "dentine";
  layers[1].hardness = 0.6e9;
  layers[1].depth = 0.3e-3;
  layers[1].material = {2000.0, 0.3, 0.2, 0.5, 1.5, 1e-3, 2.0, 3.0, 0.01, 5e-6, 3e-4};
  layers[2].name = "pulp";
  layers[2].within =
      std::make_shared<const MeshModel>(test::transformed(test::ball(2), 0.3e-3, Vec3(0.2e-3, 0.0, 0.0)));
  return Solid(MeshModel(test::transformed(test::boxMesh(kHalf), 1.0, kCentre)), layers, {kCell, 100});
}

Segment randomAxis(test::Random& random) {
  const Vec3 a = kCentre + kHalf.cwiseProduct(random.vector(1.0));
  return {a, a + random.vector(3e-4)};
}

void cutAnyhow(Solid& solid, std::uint64_t seed, int cuts) {
  test::Random random(seed);
  for (int i = 0; i < cuts; ++i) {
    const Segment axis = randomAxis(random);
    solid.cut(axis, axis, random.uniform(1e-4, 4e-4));
  }
}

// Everything that a solid answers.
void checkSame(const Solid& a, const Solid& b) {
  CHECK(a.cell() == b.cell());
  CHECK(a.low() == b.low());
  CHECK(a.high() == b.high());
  REQUIRE(a.bricks() == b.bricks());
  int differ = 0;
  for (int i = 0; i < a.bricks(); ++i) {
    differ += std::memcmp(&a.samples(i), &b.samples(i), sizeof(BrickSamples)) != 0;
    differ += a.lowOf(i) != b.lowOf(i);
  }
  CHECK(differ == 0);
  CHECK(a.volume() == b.volume());
  REQUIRE(a.layers().size() == b.layers().size());
  for (std::size_t k = 0; k < a.layers().size(); ++k) {
    const SolidLayer &one = a.layers()[k], &other = b.layers()[k];
    CHECK(one.name == other.name);
    CHECK(one.hardness == other.hardness);
    CHECK(one.depth == other.depth);
    CHECK(std::memcmp(&one.material, &other.material, sizeof(Material)) == 0);
    CHECK(std::memcmp(&one.tap, &other.tap, sizeof(Tap)) == 0);
  }
  test::Random random(5710);
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = kCentre + random.vector(2e-3);
    const SolidPoint x = signedDistance(a, p), y = signedDistance(b, p);
    differ += x.distance != y.distance || x.point != y.point || x.normal != y.normal || x.layer != y.layer;
    differ += a.layerAt(p) != b.layerAt(p) || a.brickAt(p) != b.brickAt(p);
  }
  CHECK(differ == 0);
}

void setChecksum(std::string& bytes) {
  const std::uint32_t crc = crc32(std::string_view(bytes).substr(kPreamble));
  const std::uint64_t size = bytes.size() - kPreamble;
  std::memcpy(bytes.data() + 12, &crc, sizeof crc);
  std::memcpy(bytes.data() + 16, &size, sizeof size);
}

std::string problemOf(const std::string& bytes) {
  try {
    (void)parseSolid(bytes, "a.solid");
  } catch (const ConfigurationError& error) {
    CHECK(error.file() == "a.solid");
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("solid file: all bits come back, and later cuts and undo act the same", "[unit]") {
  const test::TemporaryFolder folder;
  const std::string path = folder / "tooth.solid";
  for (const int cuts : {0, 5, 100}) {
    INFO(cuts << " cuts");
    Solid solid = tooth();
    cutAnyhow(solid, 5711, cuts);
    saveSolid(solid, path);
    Solid loaded = loadSolid(path, 100);
    checkSame(solid, loaded);
    CHECK(loaded.layers()[2].within == nullptr);
    saveSolid(loaded, folder / "again.solid");
    CHECK(test::readFile(folder / "again.solid") == test::readFile(path));
    CHECK(loaded.takeChanged() == -1);
    CHECK_FALSE(loaded.undo());
    // The same cut, and back.
    solid.mark();
    cutAnyhow(solid, 5712, 3);
    cutAnyhow(loaded, 5712, 3);
    checkSame(solid, loaded);
    CHECK(loaded.takeChanged() >= 0);
    CHECK(solid.undo() == loaded.undo());
    checkSame(solid, loaded);
    solid.restore();
    loaded.restore();
    checkSame(solid, loaded);
    checkSame(loaded, tooth());
  }
  // A file without cuts is small: bricks inside have no samples.
  saveSolid(tooth(), path);
  CHECK(test::readFile(path).size() < tooth().bytes() / 2);
}

TEST_CASE("solid file: a copy that follows the changes of another solid is saved", "[unit]") {
  const test::TemporaryFolder folder;
  Solid solid = tooth(), copy = solid;
  cutAnyhow(solid, 5713, 10);
  for (int brick = solid.takeChanged(); brick >= 0; brick = solid.takeChanged()) copy.set(brick, solid.samples(brick));
  checkSame(solid, copy);
  saveSolid(copy, folder / "copy.solid");
  checkSame(solid, loadSolid(folder / "copy.solid"));
}

TEST_CASE("solid file: an obstacle of a scene", "[unit]") {
  const test::TemporaryFolder folder;
  Solid solid = tooth();
  cutAnyhow(solid, 5714, 10);
  saveSolid(solid, folder / "tooth.solid");
  const std::string scene =
      "name = \"a\"\nstart = [0.0, 0.0, 0.02]\n[[obstacle]]\nname = \"tooth\"\nshape = \"solid\"\n"
      "file = \"tooth.solid\"\nposition = [0.0, 0.0, -0.001]\n";
  const SceneFile file = parseScene(scene, folder / "a.toml");
  REQUIRE(file.solids[0]);
  checkSame(solid, *file.solids[0]);
  CHECK(file.scene.obstacles()[0].pose.position == Vec3(0.0, 0.0, -0.001));
  for (const char* key : {"unit = \"mm\"", "scale = 2.0", "cell = 1e-4", "layer = []"})
    CHECK_THROWS_WITH(parseScene(scene + key, folder / "a.toml"), test::ContainsSubstring("part of the saved solid"));
  test::writeFile(folder / "a.toml", scene);
  const PackedScene packed = packScene(folder / "a.toml");
  REQUIRE(packed.files.size() == 1);
  CHECK(packed.files[0].name == "mesh-0.solid");
  test::writeFile(folder / "tooth.solid", "ENAMELS");
  CHECK_THROWS_WITH(loadScene(folder / "a.toml"), test::ContainsSubstring("tooth.solid: is not a saved solid"));
}

TEST_CASE("solid file: what was cut off or changed is refused", "[unit]") {
  const test::TemporaryFolder folder;
  Solid solid = tooth();
  cutAnyhow(solid, 5715, 10);
  const std::string path = folder / "tooth.solid";
  saveSolid(solid, path);
  const std::string whole = test::readFile(path);
  CHECK(problemOf(whole).empty());
  CHECK_THROWS_WITH(loadSolid(folder / "none.solid"), test::ContainsSubstring("none.solid"));
  CHECK_THROWS_WITH(parseSolid(whole, path, -1), test::ContainsSubstring("undo"));
  CHECK_THAT(problemOf("ply\nformat"), test::ContainsSubstring("a.solid: is not a saved solid"));
  std::string longer = whole + "x";
  CHECK_THAT(problemOf(longer), test::ContainsSubstring("is damaged"));
  setChecksum(longer);
  CHECK_THAT(problemOf(longer), test::ContainsSubstring("bytes after the last brick"));
  std::string other = whole;
  other[8] = 2;
  CHECK_THAT(problemOf(other), test::ContainsSubstring("has the version 2 of saved solids, must be 1"));

  test::Random random(5716);
  const auto at = [&](std::size_t size) {
    return static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(size)));
  };
  // Cut off anywhere, also with a checksum that fits.
  for (std::size_t i = 0; i < 400; ++i) {
    const std::size_t size = i < 200 ? i : at(whole.size());
    std::string part = whole.substr(0, size);
    CHECK_FALSE(problemOf(part).empty());
    if (size < kPreamble) continue;
    setChecksum(part);
    CHECK_FALSE(problemOf(part).empty());
  }
  // A changed bit is found by the checksum. With a checksum that fits, the file is refused or gives a valid solid.
  int accepted = 0;
  for (int i = 0; i < test::count(400, 20000); ++i) {
    std::string changed = whole;
    const std::size_t byte = i % 2 == 0 ? at(400) : at(whole.size());
    changed[byte] = static_cast<char>(changed[byte] ^ 1 << at(8));
    CHECK_FALSE(problemOf(changed).empty());
    if (byte < kPreamble) continue;
    setChecksum(changed);
    try {
      Solid odd = parseSolid(changed, "a.solid");
      cutAnyhow(odd, 5717, 1);
      (void)odd.volume();
      (void)signedDistance(odd, Vec3::Zero(), 0.1);
      ++accepted;
    } catch (const ConfigurationError& error) {
      CHECK(error.file() == "a.solid");
    }
  }
  CHECK(accepted > 0);
}

TEST_CASE("solid file: impossible values are named", "[unit]") {
  const test::TemporaryFolder folder;
  std::vector<SolidLayer> layers(1);
  layers[0].name = "only";
  Solid solid(MeshModel(test::transformed(test::boxMesh(kHalf), 1.0, kCentre)), layers, {kCell});
  cutAnyhow(solid, 5718, 5);
  saveSolid(solid, folder / "a.solid");
  const std::string whole = test::readFile(folder / "a.solid");
  const auto with = [&](std::size_t at, auto value) {
    std::string bytes = whole;
    std::memcpy(bytes.data() + kPreamble + at, &value, sizeof value);
    setChecksum(bytes);
    return problemOf(bytes);
  };
  // cell, origin, three counts, two numbers, length of a name, "only", fifteen numbers, the first brick
  const std::size_t hardness = 8 + 24 + 12 + 8 + 4 + 4, brick = hardness + 15 * 8;
  CHECK_THAT(with(0, 1e-9), test::ContainsSubstring("cell"));
  CHECK_THAT(with(0, std::nan("")), test::ContainsSubstring("cell"));
  CHECK_THAT(with(8, 1e300), test::ContainsSubstring("1e9 m"));
  CHECK_THAT(with(32, 0), test::ContainsSubstring("number of bricks along an axis"));
  CHECK_THAT(with(32, 1 << 30), test::ContainsSubstring("too large"));
  CHECK_THAT(with(44, 9), test::ContainsSubstring("number of layers"));
  CHECK_THAT(with(48, 1 << 30), test::ContainsSubstring("number of bricks is too large"));
  CHECK_THAT(with(52, 1 << 30), test::ContainsSubstring("ends too early"));
  CHECK_THAT(with(hardness, -1.0), test::ContainsSubstring("layer 0") && test::ContainsSubstring("hardness"));
  CHECK_THAT(with(hardness + 8, -1.0), test::ContainsSubstring("layer 0: its depth"));
  CHECK_THAT(with(hardness + 24, -1.0), test::ContainsSubstring("layer 0") && test::ContainsSubstring("friction"));
  CHECK_THAT(with(brick, 1000), test::ContainsSubstring("brick 0: it is outside"));
  CHECK_THAT(with(brick + 12, static_cast<char>(64)), test::ContainsSubstring("brick 0: its flags"));
  CHECK_THAT(with(brick + 13, static_cast<char>(1)), test::ContainsSubstring("brick 0: its layer"));
  CHECK_THAT(with(brick + 14, 3.0f), test::ContainsSubstring("brick 0: a sample"));
  CHECK_THAT(with(brick + 14, std::nanf("")), test::ContainsSubstring("brick 0: a sample"));
  // Each brick in the place of the first one, and each cut one with more material than before at a sample.
  int cut = 0;
  std::size_t at = brick;
  for (int i = 0; i < solid.bricks(); ++i) {
    const std::string name = "brick " + std::to_string(i);
    std::array<std::int32_t, 3> place;
    std::memcpy(place.data(), whole.data() + kPreamble + brick, sizeof place);
    if (i > 0) CHECK_THAT(with(at, place), test::ContainsSubstring(name + ": it is in the place of another"));
    const int flags = whole[kPreamble + at + 12];
    const std::size_t original = at + 13 + ((flags & 2) != 0 ? 512 : 1);
    const std::size_t now = original + ((flags & 1) != 0 ? sizeof(BrickSamples) : 0);
    BrickSamples before;
    before.fill(-Solid::kBand);
    if ((flags & 1) != 0) std::memcpy(before.data(), whole.data() + kPreamble + original, sizeof before);
    const auto high = static_cast<std::size_t>(std::max_element(before.begin(), before.end()) - before.begin());
    if ((flags & 4) != 0 && before[high] > -Solid::kBand) {
      CHECK_THAT(with(now + high * sizeof(float), -Solid::kBand),
                 test::ContainsSubstring(name + ": a cut has added material"));
      ++cut;
    }
    at = now + ((flags & 4) != 0 ? sizeof(BrickSamples) : 0);
  }
  CHECK(kPreamble + at == whole.size());
  CHECK(cut > 0);
}

}  // namespace enamel::test_solid_file
