#include "enamel/collision/scene_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "collision/bur_limits.hpp"
#include "core/message.hpp"
#include "core/toml.hpp"
#include "enamel/collision/contacts.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/solid_file.hpp"
#include "enamel/core/file.hpp"

namespace enamel {
namespace {

constexpr double kLargestPosition = 1.0;  // m
constexpr double kSmallestSize = 1e-4, kLargestSize = 2.0;
constexpr double kLargestToolRadius = 0.05;
constexpr double kLeastHardness = 1e3, kMostHardness = 1e12;  // Pa
constexpr double kLeastThickness = 1e-6, kMostThickness = 0.01;
constexpr double kMostInertia = 1e6, kMostStiffness = 1e9, kMostDamping = 1e6;  // of a suspension, SI
constexpr double kLeastLayer = 1e-5, kMostLayer = 0.1;                          // m
constexpr double kLeastPuncture = 1e-3, kMostPuncture = 1e3;                    // N
constexpr double kShortestWave = 1e-5;                                          // m
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
  Vec3 value = table.vector3(key);
  requireWithin(table, key, value, -kLargestPosition, kLargestPosition, "m");
  return value;
}

double length(TomlTable& table, const char* key, double low, double high) {
  const double value = table.number(key);
  if (!(value >= low && value <= high))
    table.fail(key,
               "is " + formatNumber(value) + ", must be in " + formatNumber(low) + " to " + formatNumber(high) + " m");
  return value;
}

Mat3 rotation(TomlTable& table) {
  if (!table.has("euler_deg")) return Mat3::Identity();
  const Vec3 angles = table.vector3("euler_deg");
  requireWithin(table, "euler_deg", angles, -360.0, 360.0, "deg");
  return rotationFromEuler(angles * (M_PI / 180.0));
}

Vec3 direction(TomlTable& table, const char* key) {
  const Vec3 value = table.vector3(key);
  const double size = value.stableNorm();
  if (!(size > 1e-6 && size < 1e6))
    table.fail(key, "has the length " + formatNumber(size) + ", must be in 1e-06 to 1e+06 to define a direction");
  return value / size;
}

Obstacle readHalfSpace(TomlTable& table) {
  const Vec3 point = position(table, "point");
  return halfSpace("", point, direction(table, "normal"));
}

// A box, of an obstacle or a guide.
template <typename Placed>
Placed readBox(TomlTable& table) {
  Placed box;
  box.pose.position = position(table, "centre");
  const Vec3 size = table.vector3("size");
  requireWithin(table, "size", size, kSmallestSize, kLargestSize, "m");
  box.shape = Box{0.5 * size};
  box.pose.rotation = rotation(table);
  return box;
}

Obstacle readSphere(TomlTable& table) {
  Obstacle sphere;
  sphere.pose.position = position(table, "centre");
  sphere.shape = Sphere{length(table, "radius", kSmallestSize, kLargestSize)};
  return sphere;
}

Obstacle readCapsule(TomlTable& table) {
  const Vec3 from = position(table, "from"), to = position(table, "to");
  const double axis = (to - from).norm();
  if (!(axis >= kSmallestSize))
    table.fail("to", "is " + formatNumber(axis) + " m from \"from\", must be at least " + formatNumber(kSmallestSize) +
                         " m; use a sphere instead");
  Obstacle capsule;
  capsule.pose.position = 0.5 * (from + to);
  capsule.pose.rotation = frameAlong((to - from) / axis);
  capsule.shape = Capsule{length(table, "radius", kSmallestSize, kLargestSize), 0.5 * axis};
  return capsule;
}

// Factor for the coordinates of a mesh file.
double readScale(TomlTable& table) {
  const std::string unit = table.text("unit");
  const double scale = unit == "m" ? 1.0 : unit == "mm" ? 1e-3 : unit == "um" ? 1e-6 : 0.0;
  if (scale == 0.0) table.fail("unit", "is \"" + unit + "\", must be \"m\", \"mm\" or \"um\"");
  if (!table.has("scale")) return scale;
  const double factor = table.number("scale");
  if (!(factor >= 1e-6 && factor <= 1e6))
    table.fail("scale", "is " + formatNumber(factor) + ", must be in 1e-06 to 1e+06");
  return scale * factor;
}

std::string readPath(TomlTable& table, const std::string& sceneFile) {
  const std::string file = table.text("file");
  if (file.empty()) table.fail("file", "is empty");
  return (std::filesystem::u8path(sceneFile).parent_path() / std::filesystem::u8path(file)).generic_u8string();
}

TriangleMesh readMeshFile(TomlTable& table, const std::string& sceneFile, double scale) {
  return loadMesh(readPath(table, sceneFile), scale);
}

Pose readPose(TomlTable& table) {
  Pose pose;
  if (table.has("position")) pose.position = position(table, "position");
  pose.rotation = rotation(table);
  return pose;
}

Obstacle readMesh(TomlTable& table, const std::string& sceneFile, SpareCapacity spare,
                  std::shared_ptr<MeshModel>& model) {
  Obstacle mesh;
  const double scale = readScale(table);
  mesh.pose = readPose(table);
  const bool isThin = table.has("thin") && table.boolean("thin");
  if (isThin) mesh.thickness = length(table, "thickness", kLeastThickness, kMostThickness);
  if (!isThin && table.has("thickness")) table.fail("thickness", "is only valid with thin = true");
  model = std::make_shared<MeshModel>(readMeshFile(table, sceneFile, scale), spare);
  mesh.shape = std::shared_ptr<const MeshModel>(model);
  return mesh;
}

// The name of a material, or a frequency (Hz) and a decay (1/s).
void readTap(TomlTable& table, Tap& tap) {
  if (!table.has("tap")) return;
  const std::string name = table.isText("tap") ? table.text("tap") : "";
  const std::vector<double> numbers = name.empty() ? table.numbers("tap") : std::vector<double>();
  if (name.empty() && numbers.size() != 2)
    table.fail("tap", "has " + std::to_string(numbers.size()) + " numbers, must have 2: Hz and 1/s");
  try {
    tap = name.empty() ? Tap{numbers[0], numbers[1]} : tapOf(name);
    checkTap(tap, "is out of range");
  } catch (const Error& error) {
    table.fail("tap", error.what());
  }
}

// Every key is optional. The default is a rigid surface without friction.
void readMaterial(TomlTable& table, Material& material) {
  const auto read = [&table](const char* key, double low, double high, const std::string& unit, double& value) {
    if (!table.has(key)) return;
    value = table.number(key);
    if (!(value >= low && value <= high))
      table.fail(
          key, "is " + formatNumber(value) + ", must be in " + formatNumber(low) + " to " + formatNumber(high) + unit);
  };
  read("stiffness", 1.0, 1e9, " N/m", material.stiffness);
  read("friction", 0.0, 10.0, "", material.friction);
  material.slidingFriction = material.friction;
  read("sliding_friction", 0.0, material.friction, "", material.slidingFriction);
  read("viscosity", 0.0, 1e3, " N s/m", material.viscosity);
  read("stribeck_speed", 0.0, kLargestStribeck, " m/s", material.stribeck);
  read("wavelength", kShortestWave, kLongestWave, " m", material.wavelength);
  if (table.has("roughness") && !table.has("wavelength"))
    table.fail("roughness", "needs \"wavelength\": the longest one of the rough surface");
  read("roughness", 0.0, kLongestWave, " m", material.roughness);
  if (material.isTooSteep())
    table.fail("roughness", "is " + formatNumber(material.roughness) + ", must be at most " +
                                formatNumber(kSteepestRoughness) + " of \"wavelength\"");
  read("exponent", 1.0, kLargestExponent, "", material.exponent);
  read("layer_thickness", kLeastLayer, kMostLayer, " m", material.thickness);
  read("hysteresis", 0.0, kLargestHysteresis, " s/m", material.hysteresis);
  read("puncture_force", kLeastPuncture, kMostPuncture, " N", material.puncture);
  for (const char* key : {"exponent", "layer_thickness", "hysteresis", "puncture_force"})
    if (table.has(key) && std::isinf(material.stiffness))
      table.fail(key, "needs a finite \"stiffness\", but the material is rigid");
  if (std::isfinite(material.puncture) && std::isinf(material.thickness))
    table.fail("puncture_force", "needs \"layer_thickness\": the depth at which the tool meets the ground");
}

std::shared_ptr<const Suspension> readSuspension(TomlTable& obstacle) {
  if (!obstacle.has("suspension")) return nullptr;
  TomlTable table = obstacle.table("suspension");
  Suspension suspension;
  const auto read = [&table](const char* key, double high, const char* units, Vec6& value) {
    value = table.vector6(key);
    for (int i = 0; i < 6; ++i)
      if (!(value[i] >= 0.0 && value[i] <= high))
        table.fail(std::string(key) + "[" + std::to_string(i) + "]",
                   "is " + formatNumber(value[i]) + ", must be in 0 to " + formatNumber(high) + " " + units);
  };
  if (table.has("centre")) suspension.centre = position(table, "centre");
  read("inertia", kMostInertia, "kg or kg m^2", suspension.inertia);
  for (int i = 0; i < 6; ++i)
    if (suspension.inertia[i] > 0.0 && suspension.inertia[i] < kLeastMovableInertia)
      table.fail("inertia[" + std::to_string(i) + "]", "is " + formatNumber(suspension.inertia[i]) +
                                                           ", must be 0 (locked) or at least " +
                                                           formatNumber(kLeastMovableInertia));
  if (suspension.inertia.isZero(0.0)) table.fail("inertia", "is 0 along and about every axis, must be above 0 in one");
  if (table.has("stiffness")) read("stiffness", kMostStiffness, "N/m or N m/rad", suspension.stiffness);
  if (table.has("damping")) read("damping", kMostDamping, "N s/m or N m s/rad", suspension.damping);
  table.finish();
  return std::make_shared<const Suspension>(suspension);
}

SolidLayer readLayer(TomlTable& table, const std::string& sceneFile, double scale) {
  SolidLayer layer;
  layer.name = table.text("name");
  layer.hardness = table.number("hardness");
  if (!(layer.hardness >= kLeastHardness && layer.hardness <= kMostHardness))
    table.fail("hardness", "is " + formatNumber(layer.hardness) + ", must be in " + formatNumber(kLeastHardness) +
                               " to " + formatNumber(kMostHardness) + " Pa");
  if (table.has("depth") && table.has("file"))
    table.fail("depth", "and \"file\" both define where the layer begins: give one of them");
  if (table.has("depth")) layer.depth = length(table, "depth", 0.0, kLargestSize);
  if (table.has("file")) layer.within = std::make_shared<const MeshModel>(readMeshFile(table, sceneFile, scale));
  readMaterial(table, layer.material);
  readTap(table, layer.tap);
  table.finish();
  return layer;
}

Obstacle readSolid(TomlTable& table, const std::string& sceneFile, std::shared_ptr<Solid>& solid) {
  Obstacle obstacle;
  obstacle.pose = readPose(table);
  if (const std::string path = readPath(table, sceneFile); std::filesystem::u8path(path).extension() == ".solid") {
    for (const char* key : {"unit", "scale", "cell", "layer"})
      if (table.has(key)) table.fail(key, "is part of the saved solid: remove it here");
    solid = std::make_shared<Solid>(loadSolid(path));
    obstacle.shape = std::shared_ptr<const Solid>(solid);
    return obstacle;
  }
  const double scale = readScale(table);
  SolidOptions options;
  if (table.has("cell")) options.cell = length(table, "cell", Solid::kSmallestCell, kLargestSize);
  const MeshModel surface(readMeshFile(table, sceneFile, scale));
  std::vector<SolidLayer> layers;
  for (TomlTable& layer : table.tables("layer")) layers.push_back(readLayer(layer, sceneFile, scale));
  try {
    solid = std::make_shared<Solid>(surface, layers, options);
  } catch (const Error& error) {
    table.fail("shape", std::string("is \"solid\": ") + error.what());
  }
  obstacle.shape = std::shared_ptr<const Solid>(solid);
  return obstacle;
}

Obstacle readObstacle(TomlTable& table, const std::string& sceneFile, SpareCapacity spare,
                      std::shared_ptr<MeshModel>& model, std::shared_ptr<Solid>& solid) {
  const std::string name = table.text("name");
  if (name.empty()) table.fail("name", "is empty");
  const std::string shape = table.text("shape");
  Obstacle obstacle;
  if (shape == "half_space")
    obstacle = readHalfSpace(table);
  else if (shape == "box")
    obstacle = readBox<Obstacle>(table);
  else if (shape == "sphere")
    obstacle = readSphere(table);
  else if (shape == "capsule")
    obstacle = readCapsule(table);
  else if (shape == "mesh")
    obstacle = readMesh(table, sceneFile, spare, model);
  else if (shape == "solid")
    obstacle = readSolid(table, sceneFile, solid);
  else
    table.fail("shape",
               "is \"" + shape + "\", must be \"half_space\", \"box\", \"sphere\", \"capsule\", \"mesh\" or \"solid\"");
  obstacle.name = name;
  readMaterial(table, obstacle.material);
  readTap(table, obstacle.tap);
  obstacle.suspension = readSuspension(table);
  table.finish();
  return obstacle;
}

Polyline readLine(TomlTable& table) {
  Polyline line;
  line.points = table.points("points");
  for (std::size_t i = 0; i < line.points.size(); ++i)
    requireWithin(table, ("points[" + std::to_string(i) + "]").c_str(), line.points[i], -kLargestPosition,
                  kLargestPosition, "m");
  if (table.has("radius")) line.radius = length(table, "radius", 0.0, kLargestSize);
  return line;
}

Guide readGuide(TomlTable& table) {
  const std::string shape = table.text("shape");
  Guide guide;
  if (shape == "line") {
    guide.shape = readLine(table);
  } else if (shape == "plane" || shape == "half_space") {
    guide.pose.position = position(table, "point");
    guide.pose.rotation = frameAlong(direction(table, "normal"));
    if (shape == "plane")
      guide.shape = Plane{};
    else
      guide.shape = HalfSpace{};
  } else if (shape == "box") {
    guide = readBox<Guide>(table);
  } else {
    table.fail("shape", "is \"" + shape + "\", must be \"line\", \"plane\", \"half_space\" or \"box\"");
  }
  const auto read = [&table](const char* key, double high, const char* unit, double& value) {
    value = table.number(key);
    if (!(value >= 0.0 && value <= high))
      table.fail(key, "is " + formatNumber(value) + ", must be in 0 to " + formatNumber(high) + " " + unit);
  };
  read("stiffness", kLargestGuideStiffness, "N/m", guide.stiffness);
  read("max_force", kLargestGuideForce, "N", guide.maxForce);
  try {
    checkGuide(guide, "is not valid");
  } catch (const Error& error) {
    table.fail("points", error.what());
  }
  table.finish();
  return guide;
}

// Note three problems: a mesh without a certain inside, a size that suggests another unit, cells larger than the tool.
void addNotes(const Obstacle& obstacle, const Tool& tool, std::vector<std::string>& notes) {
  const std::string name = "obstacle \"" + obstacle.name + "\": ";
  if (const auto* found = std::get_if<std::shared_ptr<const MeshModel>>(&obstacle.shape)) {
    const MeshModel& mesh = **found;
    if (!(obstacle.thickness > 0.0) && !isSound(mesh)) notes.push_back(name + describe(mesh));
  } else if (const auto* solid = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape)) {
    for (int part = 0; part < tool.count; ++part)
      if (const double radius = tool.parts[static_cast<std::size_t>(part)].radius;
          radius > 0.0 && radius < (*solid)->cell())
        notes.push_back(name + "its cells of " + formatNumber(1e3 * (*solid)->cell()) +
                        " mm are larger than the radius of the tool's part " + std::to_string(part) + ", " +
                        formatNumber(1e3 * radius) + " mm: make `cell` smaller");
  }
  if (const double size = unusualSize(obstacle); size > 0.0)
    notes.push_back(name + "is " + formatNumber(std::round(1e9 * size) / 1e6) +
                    " mm across; if this size is wrong, its unit is probably 1000 times " +
                    (size > 1.0 ? "smaller" : "larger") + ": see `unit` and `scale`");
}

Tool readTool(TomlTable& root) {
  Tool tool;
  if (!root.has("tool")) return tool;
  if (root.isText("tool")) {
    const std::string name = root.text("tool");
    try {
      return toolOf(name);
    } catch (const Error& error) {
      root.fail("tool", std::string("is ") + error.what());
    }
  }
  std::vector<TomlTable> tables = root.tables("tool");
  if (tables.empty() || tables.size() > kMaxToolParts)
    root.fail("tool", "has " + std::to_string(tables.size()) + " parts, must be 1 to " + std::to_string(kMaxToolParts));
  tool.count = 0;
  for (TomlTable& table : tables) {
    ToolPart& part = tool.parts[tool.count++];
    part.a = part.b = position(table, "from");
    if (table.has("to")) part.b = position(table, "to");
    part.radius = length(table, "radius", 0.0, kLargestToolRadius);
    table.finish();
  }
  return tool;
}

std::optional<Bur> readBur(TomlTable& root, const Tool& tool) {
  if (!root.has("bur")) return std::nullopt;
  TomlTable table = root.table("bur");
  Bur bur;
  const auto read = [&table](const char* key, double low, double high, double& value) {
    if (!table.has(key)) return;
    value = table.number(key);
    if (!(value >= low && value <= high))
      table.fail(key, "is " + formatNumber(value) + ", must be in " + formatNumber(low) + " to " + formatNumber(high));
  };
  double part = 0.0;
  read("part", 0.0, tool.count - tool.head, part);
  bur.part = static_cast<int>(part);
  if (bur.part != part) table.fail("part", "is " + formatNumber(part) + ", must be a whole number");
  for (const BurNumber& number : kBurNumbers) read(number.key, number.low, number.high, bur.*number.value);
  read("torque", 1e-6, 10.0, bur.torque);
  double blades = 0.0;
  read("blades", 0.0, kMostBlades, blades);
  bur.blades = static_cast<int>(blades);
  if (bur.blades != blades) table.fail("blades", "is " + formatNumber(blades) + ", must be a whole number");
  const double radius = tool.parts[static_cast<std::size_t>(bur.part)].radius;
  if (!(radius > 0.0))
    root.fail("bur", "is part " + std::to_string(bur.part) + " of the tool, whose radius must be greater than 0 mm");
  if (radius > Solid::kLargestBur)
    root.fail("bur", "is part " + std::to_string(bur.part) + " of the tool, whose radius of " +
                         formatNumber(1e3 * radius) + " mm must be at most " + formatNumber(1e3 * Solid::kLargestBur) +
                         " mm");
  table.finish();
  return bur;
}

// Offset in UTF-8 text of a position of toml++, which counts lines and characters from 1.
std::size_t offsetOf(std::string_view text, const toml::source_position& position) {
  std::size_t offset = 0;
  for (unsigned line = 1; line < position.line; ++line) offset = text.find('\n', offset) + 1;
  unsigned column = 1;
  while (column < position.column) {
    ++offset;
    const bool isWithinCharacter = offset < text.size() && (static_cast<unsigned char>(text[offset]) & 0xc0) == 0x80;
    if (!isWithinCharacter) ++column;
  }
  return offset;
}

}  // namespace

SceneFile parseScene(std::string_view text, const std::string& file, SpareCapacity spare) {
  TomlTable root = parseToml(text, file);
  if (root.has("platform")) root.fail("platform", "this is a device file, a scene file is needed");
  SceneFile result;
  result.name = root.text("name");
  if (result.name.empty()) root.fail("name", "is empty");
  result.start = position(root, "start");
  result.tool = readTool(root);
  result.bur = readBur(root, result.tool);
  if (root.has("max_force")) {
    result.maxForce = root.number("max_force");
    if (!(result.maxForce >= 0.0 && result.maxForce <= 1e3))
      root.fail("max_force", "is " + formatNumber(result.maxForce) + ", must be in 0 to 1000 N");
  }
  std::vector<TomlTable> tables = root.tables("obstacle");
  if (tables.empty() || tables.size() > kMaxObstacles)
    root.fail("obstacle",
              "has " + std::to_string(tables.size()) + " elements, must be 1 to " + std::to_string(kMaxObstacles));
  for (TomlTable& table : tables) {
    std::shared_ptr<MeshModel>& model = result.meshes.emplace_back();
    std::shared_ptr<Solid>& solid = result.solids.emplace_back();
    Obstacle obstacle = readObstacle(table, file, spare, model, solid);
    for (const Obstacle& other : result.scene.obstacles())
      if (other.name == obstacle.name)
        table.fail("name", "is \"" + obstacle.name + "\", which is also the name of another obstacle");
    addNotes(obstacle, result.tool, result.notes);
    result.scene.add(std::move(obstacle));
  }
  std::vector<Guide> guides;
  if (root.has("guide"))
    for (TomlTable& table : root.tables("guide")) guides.push_back(readGuide(table));
  try {
    result.scene.setGuides(std::move(guides));
  } catch (const Error& error) {
    root.fail("guide", error.what());
  }
  root.finish();
  const Contact nearest = nearestContact(result.scene, result.tool, {result.start, Mat3::Identity()}, nullptr);
  if (nearest.gap < 0.0)
    root.fail("start", "is " + formatNumber(-1e3 * nearest.gap) + " mm inside the obstacle \"" +
                           result.scene.obstacles()[static_cast<std::size_t>(nearest.obstacle)].name +
                           "\", must be outside");
  return result;
}

SceneFile loadScene(const std::string& path, SpareCapacity spare) { return parseScene(readFile(path), path, spare); }

PackedScene packScene(const std::string& path) {
  PackedScene packed{readFile(path), {}};
  (void)parseScene(packed.text, path);  // check it first, with its own messages
  toml::table scene = toml::parse(packed.text, path);
  const std::filesystem::path folder = std::filesystem::u8path(path).parent_path();
  struct Name {
    std::size_t begin, end;  // in the text
    std::string name;
  };
  std::vector<Name> names;
  const auto pack = [&](toml::node& node) {
    const toml::node* value = node.as_table()->get("file");
    if (value == nullptr) return;
    const std::string& file = **value->as_string();
    std::string name = "mesh-" + std::to_string(names.size()) + std::filesystem::u8path(file).extension().u8string();
    packed.files.push_back({name, (folder / std::filesystem::u8path(file)).u8string()});
    names.push_back({offsetOf(packed.text, value->source().begin), offsetOf(packed.text, value->source().end),
                     '"' + std::move(name) + '"'});
  };
  for (toml::node& obstacle : *scene["obstacle"].as_array()) {
    pack(obstacle);
    if (toml::array* layers = (*obstacle.as_table())["layer"].as_array())
      for (toml::node& layer : *layers) pack(layer);
  }
  std::sort(names.begin(), names.end(), [](const Name& a, const Name& b) { return a.begin > b.begin; });
  for (const Name& name : names) packed.text.replace(name.begin, name.end - name.begin, name.name);
  return packed;
}

}  // namespace enamel
