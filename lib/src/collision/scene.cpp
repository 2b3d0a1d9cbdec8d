#include "enamel/collision/scene.hpp"

#include <cmath>

#include "core/toml.hpp"

namespace enamel {
namespace {

constexpr double kLargestPosition = 1.0;  // m
constexpr double kSmallestSize = 1e-4, kLargestSize = 2.0;
constexpr int kMaxObstacles = 64;

void requireWithin(const TomlTable& table, const char* key, const Vec3& value, double low, double high,
                   const char* unit) {
  for (int i = 0; i < 3; ++i)
    if (!(value[i] >= low && value[i] <= high))
      table.fail(std::string(key) + "[" + std::to_string(i) + "]", "is " + formatNumber(value[i]) + ", must be in " +
                                                                       formatNumber(low) + " to " + formatNumber(high) +
                                                                       " " + unit);
}

Vec3 position(TomlTable& table, const char* key) {
  const Vec3 value = table.vector3(key);
  requireWithin(table, key, value, -kLargestPosition, kLargestPosition, "m");
  return value;
}

HalfSpace readHalfSpace(TomlTable& table) {
  HalfSpace wall;
  wall.point = position(table, "point");
  const Vec3 normal = table.vector3("normal");
  const double length = normal.stableNorm();
  if (!(length > 1e-6 && length < 1e6))
    table.fail("normal", "has the length " + formatNumber(length) + ", must be in 1e-06 to 1e+06: it has no direction");
  wall.normal = normal / length;
  return wall;
}

Box readBox(TomlTable& table) {
  Box box;
  box.pose.position = position(table, "centre");
  const Vec3 size = table.vector3("size");
  requireWithin(table, "size", size, kSmallestSize, kLargestSize, "m");
  box.halfSize = 0.5 * size;
  if (table.has("euler_deg")) {
    const Vec3 angles = table.vector3("euler_deg");
    requireWithin(table, "euler_deg", angles, -360.0, 360.0, "deg");
    box.pose.rotation = rotationFromEuler(angles * (M_PI / 180.0));
  }
  return box;
}

Obstacle readObstacle(TomlTable& table) {
  Obstacle obstacle;
  obstacle.name = table.text("name");
  if (obstacle.name.empty()) table.fail("name", "is empty");
  const std::string shape = table.text("shape");
  if (shape == "half_space")
    obstacle.shape = readHalfSpace(table);
  else if (shape == "box")
    obstacle.shape = readBox(table);
  else
    table.fail("shape", "is \"" + shape + "\", must be \"half_space\" or \"box\"");
  if (table.has("material")) {
    const std::int64_t material = table.integer("material");
    if (material < 0 || material > 255)
      table.fail("material", "is " + std::to_string(material) + ", must be in 0 to 255");
    obstacle.material = static_cast<int>(material);
  }
  table.finish();
  return obstacle;
}

Contact contactWith(const Obstacle& obstacle, const Vec3& toolPoint) noexcept {
  if (const auto* wall = std::get_if<HalfSpace>(&obstacle.shape)) return contactWith(*wall, toolPoint);
  return contactWith(*std::get_if<Box>(&obstacle.shape), toolPoint);
}

}  // namespace

Scene flatWall(const HalfSpace& wall) { return {"flat wall", wall.point, {{"wall", wall, 0}}}; }

void queryContacts(const Scene& scene, const Vec3& toolPoint, ContactSnapshot& snapshot) noexcept {
  snapshot.count = 0;
  for (std::size_t i = 0; i < scene.obstacles.size(); ++i) {
    Contact contact = contactWith(scene.obstacles[i], toolPoint);
    contact.obstacle = static_cast<int>(i);
    contact.material = scene.obstacles[i].material;
    // Insertion by gap; what falls off the end is the farthest.
    int place = snapshot.count;
    while (place > 0 && contact.gap < snapshot.contacts[place - 1].gap) --place;
    if (place == kMaxContacts) continue;
    if (snapshot.count < kMaxContacts) ++snapshot.count;
    for (int k = snapshot.count - 1; k > place; --k) snapshot.contacts[k] = snapshot.contacts[k - 1];
    snapshot.contacts[place] = contact;
  }
}

Scene parseScene(std::string_view text, const std::string& file) {
  TomlTable root = parseToml(text, file);
  Scene scene;
  scene.name = root.text("name");
  if (scene.name.empty()) root.fail("name", "is empty");
  scene.start = position(root, "start");
  std::vector<TomlTable> tables = root.tables("obstacle");
  if (tables.empty() || tables.size() > kMaxObstacles)
    root.fail("obstacle",
              "has " + std::to_string(tables.size()) + " elements, must be 1 to " + std::to_string(kMaxObstacles));
  for (TomlTable& table : tables) {
    Obstacle obstacle = readObstacle(table);
    for (const Obstacle& other : scene.obstacles)
      if (other.name == obstacle.name) table.fail("name", "is \"" + obstacle.name + "\", which another obstacle has");
    scene.obstacles.push_back(std::move(obstacle));
  }
  root.finish();
  ContactSnapshot snapshot;
  queryContacts(scene, scene.start, snapshot);
  const Contact& deepest = snapshot.contacts[0];
  if (deepest.gap < 0.0)
    root.fail("start", "is " + formatNumber(-1e3 * deepest.gap) + " mm inside the obstacle \"" +
                           scene.obstacles[static_cast<std::size_t>(deepest.obstacle)].name + "\", must be outside");
  return scene;
}

Scene loadScene(const std::string& path) { return parseScene(readTextFile(path), path); }

}  // namespace enamel
