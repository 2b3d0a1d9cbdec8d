// Scenes, meshes and contacts in Python. The headers in lib/include describe the functions.
#include <limits>
#include <tuple>
#include <variant>

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/cut_comparison.hpp"
#include "enamel/collision/label_volume.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/solid_file.hpp"
#include "enamel/core/error.hpp"
#include "keywords.hpp"

namespace enamel::python {
namespace {

using SceneClass = py::class_<SceneFile, std::shared_ptr<SceneFile>>;
using Labels = py::array_t<std::uint16_t, py::array::f_style | py::array::forcecast>;
using Triangles = py::array_t<int, py::array::c_style | py::array::forcecast>;

Pose rowPose(const Array& positions, const std::optional<Array>& rotations, py::ssize_t i) {
  Pose pose;
  pose.position = Eigen::Map<const Vec3>(positions.data() + 3 * i);
  if (rotations)
    pose.rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotations->data() + 9 * i);
  return pose;
}

py::ssize_t countOf(const Array& positions, const std::optional<Array>& rotations) {
  requireShape(positions, "positions", {-1, 3}, "m");
  if (rotations) requireShape(*rotations, "rotations", {positions.shape(0), 3, 3}, "axes of the platform as columns");
  return positions.shape(0);
}

py::array contactsOf(const SceneFile& file, const Array& positions, const std::optional<Array>& rotations,
                     double margin, bool follow) {
  const py::ssize_t count = countOf(positions, rotations);
  std::vector<ContactRow> rows;
  {
    const py::gil_scoped_release release;
    ToolCache cache = makeToolCache(file.scene, file.tool);
    ToolTrack track;
    if (follow) track = makeToolTrack(file.scene, file.tool);
    ContactSnapshot contacts;
    rows.reserve(static_cast<std::size_t>(count));
    for (py::ssize_t i = 0; i < count; ++i) {
      const Pose pose = rowPose(positions, rotations, i);
      const Status status = follow ? followContacts(file.scene, file.tool, pose, margin, track, contacts)
                                   : findContacts(file.scene, file.tool, pose, margin, &cache, contacts);
      if (status != Status::ok) require(status, "contacts of pose " + std::to_string(i));
      for (int k = 0; k < contacts.count; ++k) rows.push_back(rowOf(i, contacts.contacts[static_cast<std::size_t>(k)]));
    }
  }
  return arrayOf(std::move(rows));
}

py::array nearestOf(const SceneFile& file, const Array& positions, const std::optional<Array>& rotations) {
  const py::ssize_t count = countOf(positions, rotations);
  std::vector<ContactRow> rows;
  {
    const py::gil_scoped_release release;
    ToolCache cache = makeToolCache(file.scene, file.tool);
    rows.reserve(static_cast<std::size_t>(count));
    for (py::ssize_t i = 0; i < count; ++i)
      rows.push_back(rowOf(i, nearestContact(file.scene, file.tool, rowPose(positions, rotations, i), &cache)));
  }
  return arrayOf(std::move(rows));
}

Material materialOf(double stiffness, double friction) {
  Material material;
  material.stiffness = stiffness;
  material.friction = material.slidingFriction = friction;
  return material;
}

int addObstacle(SceneFile& file, const std::string& name, Shape shape, const Pose& pose, const Material& material,
                double thickness = 0.0) {
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.shape = std::move(shape);
  obstacle.pose = pose;
  obstacle.material = material;
  obstacle.thickness = thickness;
  return file.scene.add(std::move(obstacle));
}

const Obstacle& obstacleAt(const SceneFile& file, int obstacle) {
  const auto slot = static_cast<std::size_t>(obstacle);
  if (slot >= file.scene.obstacles().size()) throw Error("the scene has no obstacle " + std::to_string(obstacle));
  return file.scene.obstacles()[slot];
}

void addGuide(SceneFile& file, GuideShape shape, const Pose& pose, double stiffness, double maxForce) {
  std::vector<Guide> guides;
  if (file.scene.guides()) guides = *file.scene.guides();
  guides.push_back({std::move(shape), pose, stiffness, maxForce});
  file.scene.setGuides(std::move(guides));
}

struct MeshOptions {
  Array position = Array(3, Vec3(Vec3::Zero()).data());
  std::optional<Array> rotation;
  double stiffness = std::numeric_limits<double>::infinity(), friction = 0.0, thickness = 0.0;
};

Keywords<MeshOptions> meshKeywords() {
  using O = MeshOptions;
  Keywords<O> keywords("add_mesh", false);
  keywords.add("position", &O::position).add("rotation", &O::rotation).add("stiffness", &O::stiffness);
  keywords.add("friction", &O::friction).add("thickness", &O::thickness);
  return keywords;
}

std::shared_ptr<const MeshModel> modelOf(const Array& vertices, const Triangles& triangles) {
  requireShape(vertices, "vertices", {-1, 3}, "m");
  if (triangles.ndim() != 2 || triangles.shape(1) != 3)
    throw py::value_error("triangles must have the shape (n, 3) and contain numbers of vertices");
  TriangleMesh mesh;
  mesh.vertices.resize(static_cast<std::size_t>(vertices.shape(0)));
  mesh.triangles.resize(static_cast<std::size_t>(triangles.shape(0)));
  static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(std::array<int, 3>) == 3 * sizeof(int));
  if (!mesh.vertices.empty()) std::memcpy(mesh.vertices[0].data(), vertices.data(), 24 * mesh.vertices.size());
  if (!mesh.triangles.empty()) std::memcpy(mesh.triangles[0].data(), triangles.data(), 12 * mesh.triangles.size());
  const py::gil_scoped_release release;
  return std::make_shared<const MeshModel>(std::move(mesh));
}

const MeshModel& meshAt(const SceneFile& file, int obstacle) {
  const bool there = obstacle >= 0 && static_cast<std::size_t>(obstacle) < file.scene.obstacles().size();
  const auto* const model = there ? std::get_if<std::shared_ptr<const MeshModel>>(
                                        &file.scene.obstacles()[static_cast<std::size_t>(obstacle)].shape)
                                  : nullptr;
  if (model == nullptr) throw Error("obstacle " + std::to_string(obstacle) + " is not a mesh");
  return **model;
}

using ToolParts = std::vector<std::tuple<Array, Array, double>>;

void setTool(SceneFile& file, const std::variant<std::string, ToolParts>& named) {
  if (const auto* const name = std::get_if<std::string>(&named)) {
    file.tool = toolOf(*name);
    return;
  }
  const ToolParts& parts = std::get<ToolParts>(named);
  Tool tool;
  if (parts.size() > kMaxToolParts)
    throw Error("the tool has " + std::to_string(parts.size()) + " parts, must have at most " +
                std::to_string(kMaxToolParts));
  tool.count = static_cast<int>(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
    tool.parts[i] = {vec3(std::get<0>(parts[i]), "an end of a part", "m"),
                     vec3(std::get<1>(parts[i]), "an end of a part", "m"), std::get<2>(parts[i])};
  require(checkTool(tool), "the tool");
  file.tool = tool;
}

void addObstacles(SceneClass& scene) {
  const double rigid = std::numeric_limits<double>::infinity();
  scene
      .def(
          "add_half_space",
          [](SceneFile& self, const std::string& name, const Array& point, const Array& normal, double stiffness,
             double friction) {
            const Vec3 n = vec3(normal, "normal", "outward, of any length");
            if (!(n.norm() > 0.0) || !n.allFinite())
              throw py::value_error("the length of normal is zero or not finite: it must define a direction");
            Obstacle wall = halfSpace(name, vec3(point, "point", "m"), n.normalized());
            wall.material = materialOf(stiffness, friction);
            return self.scene.add(std::move(wall));
          },
          py::arg("name"), py::arg("point") = py::make_tuple(0.0, 0.0, 0.0),
          py::arg("normal") = py::make_tuple(0.0, 0.0, 1.0), py::arg("stiffness") = rigid, py::arg("friction") = 0.0,
          "Add the half space behind the plane through `point` (m, W) with the outward normal `normal` and return its "
          "number. Raises Error if the name is empty or already used.")
      .def(
          "add_sphere",
          [](SceneFile& self, const std::string& name, const Array& centre, double radius, double stiffness,
             double friction) {
            return addObstacle(self, name, Sphere{radius}, poseOf(centre, {}), materialOf(stiffness, friction));
          },
          py::arg("name"), py::arg("centre"), py::arg("radius"), py::arg("stiffness") = rigid,
          py::arg("friction") = 0.0,
          "Add a ball with centre and radius in m and return its number. Raises Error if the size is not positive.")
      .def(
          "add_box",
          [](SceneFile& self, const std::string& name, const Array& centre, const Array& size,
             const std::optional<Array>& rotation, double stiffness, double friction) {
            return addObstacle(self, name, Box{0.5 * vec3(size, "size", "m")}, poseOf(centre, rotation),
                               materialOf(stiffness, friction));
          },
          py::arg("name"), py::arg("centre"), py::arg("size"), py::arg("rotation") = py::none(),
          py::arg("stiffness") = rigid, py::arg("friction") = 0.0,
          "Add a box about `centre` with edges of `size`, m, and return its number. Raises Error if a size is not "
          "positive.")
      .def(
          "soften",
          [](SceneFile& self, int obstacle, double stiffness, double exponent, double thickness, double hysteresis,
             double puncture) {
            Obstacle soft = obstacleAt(self, obstacle);
            if (std::holds_alternative<std::shared_ptr<const Solid>>(soft.shape))
              throw Error("obstacle \"" + soft.name + "\": a solid has the materials of its layers");
            soft.material.stiffness = stiffness;
            soft.material.exponent = exponent;
            soft.material.thickness = thickness;
            soft.material.hysteresis = hysteresis;
            soft.material.puncture = puncture;
            self.scene.replace(obstacle, std::move(soft));
          },
          py::arg("obstacle"), py::arg("stiffness"), py::arg("exponent") = 1.0, py::arg("thickness") = rigid,
          py::arg("hysteresis") = 0.0, py::arg("puncture") = rigid,
          "Make the surface of an obstacle a compliant layer. At a depth of x m it pushes with stiffness x (x / 1 "
          "mm)^(exponent - 1) / (1 - x / thickness), times 1 + hysteresis x' while x grows by x' m/s. A force of "
          "`puncture` N breaks it. Raises Error if a number is not valid.")
      .def(
          "set_surface",
          [](SceneFile& self, int obstacle, double friction, const std::optional<double>& sliding, double stribeck,
             double viscosity, double roughness, double wavelength) {
            Obstacle changed = obstacleAt(self, obstacle);
            if (std::holds_alternative<std::shared_ptr<const Solid>>(changed.shape))
              throw Error("obstacle \"" + changed.name + "\": a solid has the materials of its layers");
            changed.material.friction = friction;
            changed.material.slidingFriction = sliding.value_or(friction);
            changed.material.stribeck = stribeck;
            changed.material.viscosity = viscosity;
            changed.material.roughness = roughness;
            changed.material.wavelength = wavelength;
            self.scene.replace(obstacle, std::move(changed));
          },
          py::arg("obstacle"), py::arg("friction") = 0.0, py::arg("sliding_friction") = py::none(),
          py::arg("stribeck_speed") = 0.0, py::arg("viscosity") = 0.0, py::arg("roughness") = 0.0,
          py::arg("wavelength") = 0.0,
          "Set what a sliding tool feels: friction at rest and while sliding (default: the same), the speed (m/s) at "
          "which it has fallen by 63 %, viscosity (N s/m), and of a rough surface its root mean square height and its "
          "longest wavelength (m). Raises Error if a number is not valid.")
      .def(
          "set_tap",
          [](SceneFile& self, int obstacle, const std::variant<std::string, std::pair<double, double>>& tap) {
            Obstacle changed = obstacleAt(self, obstacle);
            if (const auto* const name = std::get_if<std::string>(&tap))
              changed.tap = tapOf(*name);
            else
              std::tie(changed.tap.frequency, changed.tap.decay) = std::get<1>(tap);
            self.scene.replace(obstacle, std::move(changed));
          },
          py::arg("obstacle"), py::arg("tap"),
          "Let the handle vibrate after an impact on an obstacle. `tap` is enamel, dentine, metal or plastic, or a "
          "frequency (Hz) and a decay (1/s); both 0: no vibration. Raises Error for another name or number.")
      .def(
          "suspend",
          [](SceneFile& self, int obstacle, const Array& inertia, const Array& stiffness, const Array& damping,
             const Array& centre) {
            Obstacle movable = obstacleAt(self, obstacle);
            movable.suspension = std::make_shared<const Suspension>(Suspension{
                vec3(centre, "centre", "m"), vec6(inertia, "inertia", "kg and kg m^2"),
                vec6(stiffness, "stiffness", "N/m and N m/rad"), vec6(damping, "damping", "N s/m and N m s/rad")});
            self.scene.replace(obstacle, std::move(movable));
          },
          py::arg("obstacle"), py::arg("inertia"), py::arg("stiffness") = py::make_tuple(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
          py::arg("damping") = py::make_tuple(0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
          py::arg("centre") = py::make_tuple(0.0, 0.0, 0.0),
          "Let contact forces move an obstacle: a body on springs and dampers along and about the axes of its frame, "
          "at "
          "`centre` (m). The other arguments have six numbers: along x, y, z (kg, N/m, N s/m), then about them. Raises "
          "Error if a number is not valid.");
}

void addGuides(SceneClass& scene) {
  scene
      .def(
          "add_line_guide",
          [](SceneFile& self, const Array& points, double stiffness, double maxForce, double radius) {
            requireShape(points, "points", {-1, 3}, "m");
            Polyline line{{}, radius};
            for (py::ssize_t i = 0; i < points.shape(0); ++i)
              line.points.emplace_back(Eigen::Map<const Vec3>(points.data() + 3 * i));
            addGuide(self, std::move(line), {}, stiffness, maxForce);
          },
          py::arg("points"), py::arg("stiffness"), py::arg("max_force"), py::arg("radius") = 0.0,
          "Pull the TCP to the line through `points` (n, 3), m, or within `radius` (m) of it: with `stiffness` (N/m), "
          "and at most `max_force` (N). Raises Error if a number is not valid.")
      .def(
          "add_plane_guide",
          [](SceneFile& self, const Array& point, const Array& normal, double stiffness, double maxForce,
             bool oneSided) {
            const Vec3 n = vec3(normal, "normal", "of any length");
            if (!(n.norm() > 0.0) || !n.allFinite())
              throw py::value_error("the length of normal is zero or not finite: it must define a direction");
            GuideShape shape = Plane{};
            if (oneSided) shape = HalfSpace{};
            addGuide(self, shape, {vec3(point, "point", "m"), frameAlong(n.normalized())}, stiffness, maxForce);
          },
          py::arg("point"), py::arg("normal"), py::arg("stiffness"), py::arg("max_force"), py::arg("one_sided") = false,
          "Pull the TCP to the plane through `point` (m, W) with the normal `normal`. With `one_sided`, keep it on the "
          "side to which the normal points. Raises Error if a number is not valid.")
      .def(
          "add_box_guide",
          [](SceneFile& self, const Array& centre, const Array& size, double stiffness, double maxForce,
             const std::optional<Array>& rotation) {
            addGuide(self, Box{0.5 * vec3(size, "size", "m")}, poseOf(centre, rotation), stiffness, maxForce);
          },
          py::arg("centre"), py::arg("size"), py::arg("stiffness"), py::arg("max_force"),
          py::arg("rotation") = py::none(),
          "Keep the TCP in a box about `centre` with edges of `size`, m. Raises Error if a number is not valid.");
}

void addMeshObstacle(SceneClass& scene) {
  const Keywords<MeshOptions> keywords = meshKeywords();
  const std::string doc = keywords.documented(
      "self: " + TypeName<SceneFile>::text() + ", name: str, vertices: " + TypeName<Array>::text() +
          ", triangles: numpy.ndarray[numpy.int32]",
      "int",
      "Add a triangle mesh and return its number. Vertices (n, 3), m, are in the mesh's own frame; triangles (m, 3) "
      "are numbers of vertices, counterclockwise seen from outside. Both are copied. With a thickness above 0, the "
      "mesh is the middle of a sheet. Raises Error with the number of the vertex or triangle.");
  py::options help;
  help.disable_function_signatures();
  scene.def(
      "add_mesh",
      [keywords](SceneFile& self, const std::string& name, const Array& vertices, const Triangles& triangles,
                 const py::args& placed, const py::kwargs& named) {
        const MeshOptions options = keywords.read(placed, named);
        return addObstacle(self, name, modelOf(vertices, triangles), poseOf(options.position, options.rotation),
                           materialOf(options.stiffness, options.friction), options.thickness);
      },
      py::arg("name"), py::arg("vertices"), py::arg("triangles"), doc.c_str());
}

const Solid& solidAt(const SceneFile& file, int obstacle) {
  const auto* const solid = std::get_if<std::shared_ptr<const Solid>>(&obstacleAt(file, obstacle).shape);
  if (solid == nullptr) throw Error("obstacle " + std::to_string(obstacle) + " is not a solid");
  return **solid;
}

py::dict dictOf(const CutDifference& difference, py::ssize_t layers) {
  py::dict values;
  values["over_cut"] = Array(layers, difference.overCut.data());
  values["under_cut"] = Array(layers, difference.underCut.data());
  values["area"] = difference.area;
  values["mean"] = difference.mean;
  values["p95"] = difference.p95;
  values["deepest"] = difference.deepest;
  values["highest"] = difference.highest;
  return values;
}

py::dict cutAgainst(const SceneFile& file, int obstacle, const Array& vertices, const Triangles& triangles,
                    const Array& axis) {
  const Solid& solid = solidAt(file, obstacle);
  const std::shared_ptr<const MeshModel> target = modelOf(vertices, triangles);
  const Vec3 up = vec3(axis, "axis", "of any length");
  auto compared = std::make_unique<CutComparison>();
  {
    const py::gil_scoped_release release;
    *compared = compareCut(solid, *target, up);
  }
  const CutComparison& c = *compared;
  const py::capsule owner = keep(std::move(compared));
  const auto layers = static_cast<py::ssize_t>(solid.layers().size()),
             count = static_cast<py::ssize_t>(c.distance.size());
  py::list names;
  for (const SolidLayer& layer : solid.layers()) names.append(layer.name);
  py::dict result;
  result["layers"] = names;
  result["removed"] = Array(layers, c.removed.data());
  result["planned"] = Array(layers, c.planned.data());
  result["whole"] = dictOf(c.whole, layers);
  result["floors"] = dictOf(c.floors, layers);
  result["walls"] = dictOf(c.walls, layers);
  result["vertices"] = view(reinterpret_cast<const double*>(c.surface.vertices.data()), {count, 3}, owner);
  result["triangles"] = view(reinterpret_cast<const int*>(c.surface.triangles.data()),
                             {static_cast<py::ssize_t>(c.surface.triangles.size()), 3}, owner);
  result["distance"] = view(c.distance.data(), {count}, owner);
  result["is_prepared"] = view(reinterpret_cast<const bool*>(c.isPrepared.data()), {count}, owner);
  return result;
}

int addSolid(SceneFile& file, const std::string& name, std::shared_ptr<Solid> solid, const Pose& pose) {
  const int number = addObstacle(file, name, std::shared_ptr<const Solid>(solid), pose, {});
  file.solids.resize(file.scene.obstacles().size());
  file.solids.back() = std::move(solid);
  return number;
}

int addLabels(SceneFile& file, const std::string& name, const Labels& labels,
              const std::vector<std::tuple<std::string, std::vector<int>, double>>& layers, const Array& spacing,
              std::optional<double> smoothing, double cell, const Array& position,
              const std::optional<Array>& rotation) {
  if (labels.ndim() != 3) throw Error("labels must have 3 axes, x, y and z, has " + std::to_string(labels.ndim()));
  LabelVolume volume;
  for (py::ssize_t axis = 0; axis < 3; ++axis)
    volume.size[static_cast<std::size_t>(axis)] = static_cast<int>(labels.shape(axis));
  volume.spacing = vec3(spacing, "spacing", "m");
  volume.labels.assign(labels.data(), labels.data() + labels.size());
  std::vector<LabelLayer> parts;
  for (const auto& [layer, itsLabels, hardness] : layers) {
    LabelLayer part{{}, itsLabels};
    part.layer.name = layer;
    part.layer.hardness = hardness;
    parts.push_back(std::move(part));
  }
  const Pose pose = poseOf(position, rotation);
  std::shared_ptr<Solid> solid;
  {
    const py::gil_scoped_release release;
    solid =
        std::make_shared<Solid>(solidOf(volume, parts, smoothing.value_or(volume.spacing.mean()), SolidOptions{cell}));
  }
  return addSolid(file, name, std::move(solid), pose);
}

void addSolids(SceneClass& scene) {
  scene.def(
      "add_labels", &addLabels, py::arg("name"), py::arg("labels"), py::arg("layers"), py::arg("spacing"),
      py::arg("smoothing") = py::none(), py::arg("cell") = SolidOptions().cell,
      py::arg("position") = py::make_tuple(0.0, 0.0, 0.0), py::arg("rotation") = py::none(),
      "Add a solid made from the labels of voxels, such as a segmented CT, and return its number. `labels` is an array "
      "of the axes x, y and z; `spacing` is the distance of voxels along these (m), and the first voxel is at the "
      "position. `layers` has a tuple for each layer, outermost first: name, labels, hardness (Pa). `smoothing` is the "
      "standard deviation of a Gaussian mean (m; default: the mean spacing), `cell` the resolution of the solid (m). "
      "Raises Error if a layer vanishes or a number is outside its range. The GIL is released.");
  scene.def(
      "add_solid",
      [](SceneFile& self, const std::string& name, const py::object& path, const Array& position,
         const std::optional<Array>& rotation) {
        return addSolid(self, name, std::make_shared<Solid>(loadSolid(py::str(path).cast<std::string>())),
                        poseOf(position, rotation));
      },
      py::arg("name"), py::arg("path"), py::arg("position") = py::make_tuple(0.0, 0.0, 0.0),
      py::arg("rotation") = py::none(),
      "Add a saved solid (.solid) and return its number. Raises ConfigurationError with the file.");
  scene.def(
      "save_solid",
      [](const SceneFile& self, int obstacle, const py::object& path) {
        saveSolid(solidAt(self, obstacle), py::str(path).cast<std::string>());
      },
      py::arg("obstacle"), py::arg("path"),
      "Write a solid with its cuts, layers and materials to a file (.solid). Raises Error.");
  scene.def(
      "compare_cut", &cutAgainst, py::arg("obstacle"), py::arg("vertices"), py::arg("triangles"),
      py::arg("axis") = py::make_tuple(0.0, 0.0, 1.0),
      "Compare a cut solid with the target of a preparation: a closed mesh in the solid's frame, m. The result has the "
      "names of the layers, the volumes `removed` and `planned` of each layer (m^3), and dictionaries `whole`, "
      "`floors` and `walls`: over_cut and under_cut of each layer (m^3), area (m^2), mean, p95, deepest and highest "
      "(m) of the surface's distance from the target. `vertices`, `triangles`, `distance` (m, of each vertex) and "
      "`is_prepared` are the surface of the solid. Floors are faces of the target within 45 deg of `axis`. Raises "
      "Error for a target that is not closed. The GIL is released.");
}

void addMeshes(SceneClass& scene) {
  scene
      .def(
          "mesh",
          [](const py::object& self, int obstacle) {
            const TriangleMesh& mesh = meshAt(self.cast<const SceneFile&>(), obstacle).mesh();
            return py::make_tuple(
                view(mesh.vertices.front().data(), {static_cast<py::ssize_t>(mesh.vertices.size()), 3}, self),
                view(mesh.triangles.front().data(), {static_cast<py::ssize_t>(mesh.triangles.size()), 3}, self));
          },
          py::arg("obstacle"),
          "Return vertices (n, 3), m, and triangles (m, 3) of a mesh as read-only views. Raises Error if the obstacle "
          "is not a mesh.")
      .def(
          "describe", [](const SceneFile& self, int obstacle) { return describe(meshAt(self, obstacle)); },
          py::arg("obstacle"),
          "Describe the defects of a mesh and how the sign of its distances is computed, in one line. Raises Error if "
          "the obstacle is not a mesh.")
      .def(
          "move",
          [](SceneFile& self, int obstacle, const Array& position, const std::optional<Array>& rotation,
             const std::optional<Array>& twist) {
            require(self.scene.move(obstacle, poseOf(position, rotation),
                                    twist ? vec6(*twist, "twist", "m/s and rad/s") : Vec6::Zero()),
                    "obstacle " + std::to_string(obstacle));
          },
          py::arg("obstacle"), py::arg("position"), py::arg("rotation") = py::none(), py::arg("twist") = py::none(),
          "Move an obstacle. Raises Error if the number of the obstacle is unknown.");
}

void addQueries(SceneClass& scene) {
  scene
      .def("contacts", &contactsOf, py::arg("positions"), py::arg("rotations") = py::none(), py::arg("margin") = 1e-3,
           py::arg("follow") = false,
           "Return all contacts with a gap of at most `margin` (m) at each pose: positions (n, 3), m, rotations (n, 3, "
           "3). The result is a structured array (contact_dtype), one row a contact; `pose` is the number of the pose. "
           "The deepest contact of a pose comes first. With `follow`, the tool moves from pose to pose and cannot "
           "tunnel through thin walls. Raises Error if a pose is not finite. The GIL is released.")
      .def("nearest", &nearestOf, py::arg("positions"), py::arg("rotations") = py::none(),
           "Return the contact with the smallest gap, at any distance, at each pose: contact_dtype, (n,). The GIL is "
           "released.");
}

void addMeshFile(py::module_& m) {
  m.def(
      "load_mesh",
      [](const py::object& path, double scale) {
        auto mesh = std::make_unique<TriangleMesh>(loadMesh(py::str(path).cast<std::string>(), scale));
        const TriangleMesh& kept = *mesh;
        const py::capsule owner = keep(std::move(mesh));
        return py::make_tuple(
            view(kept.vertices.front().data(), {static_cast<py::ssize_t>(kept.vertices.size()), 3}, owner),
            view(kept.triangles.front().data(), {static_cast<py::ssize_t>(kept.triangles.size()), 3}, owner));
      },
      py::arg("path"), py::arg("scale") = 1.0,
      "Read a mesh file (.ply, .obj, .stl, .off) and return vertices (n, 3), m, and triangles (m, 3). `scale`: metres "
      "per unit of the file. Raises ConfigurationError with the file and the number of the vertex, face or line.");
}

}  // namespace

void addScene(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(ContactRow, pose, obstacle, part, triangle, feature, gap, point, normal, velocity);
  m.attr("contact_dtype") = py::dtype::of<ContactRow>();
  SceneClass scene(m, "Scene",
                   "The tool, its start, and the obstacles that it can touch. Obstacles are numbered from 0.");
  scene
      .def(py::init([](const py::object& path) {
             if (path.is_none()) return std::make_shared<SceneFile>();
             const std::string file = py::str(path).cast<std::string>();
             const py::gil_scoped_release release;
             return std::make_shared<SceneFile>(loadScene(file));
           }),
           py::arg("path") = py::none(),
           "Read a scene file (TOML). Without a path, make an empty scene whose tool is a point at the TCP. Raises "
           "ConfigurationError with file, line, key, value and limit.")
      .def_property_readonly(
          "name", [](const SceneFile& self) { return self.name; }, "Name in the scene file.")
      .def_property_readonly(
          "notes", [](const SceneFile& self) { return self.notes; },
          "Notes about the obstacles, one line each: meshes whose inside is not certain, improbable sizes, cells "
          "larger than the tool.")
      .def_property_readonly(
          "obstacles",
          [](const SceneFile& self) {
            std::vector<std::string> names;
            for (const Obstacle& obstacle : self.scene.obstacles()) names.push_back(obstacle.name);
            return names;
          },
          "Names of the obstacles, by number.")
      .def_property(
          "start", [](const SceneFile& self) { return self.start; },
          [](SceneFile& self, const Array& start) { self.start = vec3(start, "start", "m"); },
          "Start of the TCP in W, (3,), m. The tool does not touch there.")
      .def(
          "set_tool", &setTool, py::arg("parts"),
          "Make the tool of capsules (end, end, radius) in the platform's frame, m. A capsule with equal ends is a "
          "sphere; with a radius of 0 it is a point. A name is also possible: round-010 is a ball bur of 1 mm, further "
          "ones are in tool.hpp. Raises Error for more than 8 parts, an end or radius above 1 m, or another name.");
  addObstacles(scene);
  addGuides(scene);
  addMeshObstacle(scene);
  addMeshes(scene);
  addSolids(scene);
  addQueries(scene);
  addMeshFile(m);
}

}  // namespace enamel::python
