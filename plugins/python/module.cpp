// The Python module enamel._enamel: errors, devices, scenes, contacts. Every function says what the header says.
#include <sstream>

#include "binding.hpp"
#include "enamel/collision/contacts.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/plugin/host.hpp"

namespace enamel::python {

std::string shapeOf(const Array& array) {
  std::ostringstream text;
  text << '(';
  for (py::ssize_t i = 0; i < array.ndim(); ++i) text << (i > 0 ? ", " : "") << array.shape(i);
  text << (array.ndim() == 1 ? ",)" : ")");
  return text.str();
}

void requireShape(const Array& array, const char* name, std::initializer_list<py::ssize_t> shape, const char* unit) {
  bool fits = array.ndim() == static_cast<py::ssize_t>(shape.size());
  std::ostringstream wanted;
  wanted << '(';
  py::ssize_t i = 0;
  for (const py::ssize_t size : shape) {
    fits = fits && (size < 0 || array.shape(i) == size);
    wanted << (i++ > 0 ? ", " : "");
    size < 0 ? wanted << 'n' : wanted << size;
  }
  wanted << (shape.size() == 1 ? ",)" : ")");
  if (!fits)
    throw py::value_error(std::string(name) + " has the shape " + shapeOf(array) + ", must be " + wanted.str() + ", " +
                          unit);
}

Vec3 vec3(const Array& array, const char* name, const char* unit) {
  requireShape(array, name, {3}, unit);
  return Eigen::Map<const Vec3>(array.data());
}

Vec6 vec6(const Array& array, const char* name, const char* unit) {
  requireShape(array, name, {6}, unit);
  return Eigen::Map<const Vec6>(array.data());
}

JointVector joints(const Array& array, int count, const char* name, const char* unit) {
  requireShape(array, name, {count}, unit);
  return Eigen::Map<const Eigen::VectorXd>(array.data(), count);
}

Pose poseOf(const Array& position, const std::optional<Array>& rotation) {
  Pose pose;
  pose.position = vec3(position, "position", "m");
  if (rotation) {
    requireShape(*rotation, "rotation", {3, 3}, "axes of the platform as columns");
    pose.rotation = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation->data());
    if (!isRotation(pose.rotation)) throw py::value_error("rotation is no right-handed orthonormal matrix to 1e-6");
  }
  return pose;
}

void require(Status status, const std::string& what) {
  if (status != Status::ok) throw Error(what + ": " + toString(status));
}

ContactRow rowOf(std::int64_t pose, const Contact& c) noexcept {
  ContactRow row{pose, c.obstacle, c.part, c.triangle, static_cast<std::int32_t>(c.feature), c.gap, {}, {}, {}};
  for (int i = 0; i < 3; ++i) {
    row.point[i] = c.point[i];
    row.normal[i] = c.normal[i];
    row.velocity[i] = c.obstacleVelocity[i];
  }
  return row;
}

py::array arrayOf(std::vector<ContactRow> rows) {
  auto kept = std::make_unique<std::vector<ContactRow>>(std::move(rows));
  const auto count = static_cast<py::ssize_t>(kept->size());
  const ContactRow* const data = kept->data();
  return py::array_t<ContactRow>(count, data, keep(std::move(kept)));
}

void Table::column(const char* name, std::vector<int> shape, const char* kind) {
  int width = 1;
  for (const int size : shape) width *= size;
  columns_.push_back({name, std::move(shape), width, kind});
}

void Table::addJoints(const JointVector& v, int width) {
  for (int i = 0; i < width; ++i) numbers_.push_back(i < v.size() ? v[i] : std::numeric_limits<double>::quiet_NaN());
}

py::array Table::finish() {
  py::list fields;
  std::size_t width = 0;
  for (const Column& c : columns_) {
    fields.append(py::make_tuple(c.name, c.kind, py::tuple(py::cast(c.shape))));
    width += static_cast<std::size_t>(c.width);
  }
  auto kept = std::make_unique<std::vector<double>>(std::move(numbers_));
  const auto count = static_cast<py::ssize_t>(kept->size() / width);
  const double* const data = kept->data();
  return py::array(py::dtype::from_args(fields), {count}, {static_cast<py::ssize_t>(8 * width)}, data,
                   keep(std::move(kept)));
}

namespace {

// ---- devices -----------------------------------------------------------------------------------------------------

Device deviceOf(DeviceParameters parameters) {
  auto mechanism = makeMechanism(parameters);
  return {std::move(parameters), std::move(mechanism)};
}

template <typename Member>
void addVector(py::class_<Kinematics>& c, const char* name, Member member, const char* doc) {
  c.def_readonly(name, member, doc);  // an array that looks into the object
}

// ---- scenes ------------------------------------------------------------------------------------------------------

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

int addObstacle(SceneFile& file, const std::string& name, Shape shape, const Array& position,
                const std::optional<Array>& rotation, double stiffness, double friction, double thickness = 0.0) {
  Obstacle obstacle;
  obstacle.name = name;
  obstacle.shape = std::move(shape);
  obstacle.pose = poseOf(position, rotation);
  obstacle.material.stiffness = stiffness;
  obstacle.material.friction = obstacle.material.sliding = friction;
  obstacle.thickness = thickness;
  return file.scene.add(std::move(obstacle));
}

std::shared_ptr<const MeshModel> modelOf(const Array& vertices,
                                         const py::array_t<int, py::array::c_style | py::array::forcecast>& triangles) {
  requireShape(vertices, "vertices", {-1, 3}, "m");
  if (triangles.ndim() != 2 || triangles.shape(1) != 3)
    throw py::value_error("triangles must have the shape (n, 3): numbers of vertices");
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
  if (model == nullptr) throw Error("obstacle " + std::to_string(obstacle) + " is no mesh");
  return **model;
}

void setTool(SceneFile& file, const std::vector<std::tuple<Array, Array, double>>& parts) {
  Tool tool;
  if (parts.size() > kMaxToolParts)
    throw Error("a tool has " + std::to_string(parts.size()) + " parts, at most " + std::to_string(kMaxToolParts) +
                " can be");
  tool.count = static_cast<int>(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
    tool.parts[i] = {vec3(std::get<0>(parts[i]), "an end of a part", "m"),
                     vec3(std::get<1>(parts[i]), "an end of a part", "m"), std::get<2>(parts[i])};
  require(checkTool(tool), "the tool");
  file.tool = tool;
}

}  // namespace

void addDevice(py::module_& m) {
  py::class_<Kinematics> k(m, "Kinematics",
                           "Everything about a mechanism in motion that one tick computes once, in W. Its arrays look "
                           "into the object and cannot be written.");
  addVector(k, "q", &Kinematics::q, "Joint coordinates, (n,), rad or m.");
  addVector(k, "rates", &Kinematics::rates, "q', (n,), rad/s or m/s.");
  addVector(k, "twist", &Kinematics::twist, "V = J q', (6,), m/s and rad/s.");
  addVector(k, "jacobian", &Kinematics::jacobian, "J, (6, n).");
  addVector(k, "inverse_transposed", &Kinematics::inverseTransposed,
            "(6, n): F = this tau is the wrench on the platform of torques tau, q' = this^T V.");
  addVector(k, "gravity", &Kinematics::gravity, "Torque that balances gravity at rest, (n,), N m or N.");
  addVector(k, "inertia", &Kinematics::inertia,
            "M(q), (n, n), kg m^2 or kg; (0, 0) where a renderer's needs_inertia does not ask for it.");
  k.def_property_readonly(
      "position", [](const Kinematics& self) -> const Vec3& { return self.pose.position; },
      py::return_value_policy::reference_internal, "TCP in W, (3,), m.");
  k.def_property_readonly(
      "rotation", [](const Kinematics& self) -> const Mat3& { return self.pose.rotation; },
      py::return_value_policy::reference_internal, "Axes of the platform in W as columns, (3, 3).");

  py::class_<Device>(m, "Device",
                     "A mechanism: geometry and mass of a device. Immutable; may be shared between threads.")
      .def(py::init([](const py::object& path) { return deviceOf(loadDevice(py::str(path).cast<std::string>())); }),
           py::arg("path"),
           "Reads a device file (TOML). Raises ConfigurationError with file, line, key, value and limit.")
      .def_static(
          "parse", [](const std::string& text, const std::string& file) { return deviceOf(parseDevice(text, file)); },
          py::arg("text"), py::arg("file") = "text", "The same for text in memory; `file` stands in messages.")
      .def_property_readonly(
          "name", [](const Device& self) { return self.mechanism->name(); }, "As the file has it.")
      .def_property_readonly(
          "joints", [](const Device& self) { return self.mechanism->joints(); }, "n.")
      .def_property_readonly(
          "max_torque", [](const Device& self) { return self.mechanism->limits().torque; },
          "Largest torque of every motor, (n,), N m or N.")
      .def_property_readonly(
          "count", [](const Device& self) { return self.mechanism->limits().count; },
          "Step of every encoder, (n,), rad or m.")
      .def_property_readonly(
          "home", [](const Device& self) -> const Kinematics& { return self.mechanism->home(); },
          py::return_value_policy::reference_internal, "At rest at the home pose (P = W), with inertia.")
      .def(
          "track",
          [](const Device& self, const Array& q, const std::optional<Array>& rates) {
            const int n = self.mechanism->joints();
            Kinematics kinematics = self.mechanism->home();
            require(self.mechanism->track(joints(q, n, "q", "rad or m"),
                                          rates ? joints(*rates, n, "rates", "rad/s or m/s") : JointVector::Zero(n),
                                          true, kinematics),
                    "forward kinematics");
            return kinematics;
          },
          py::arg("q"), py::arg("rates") = py::none(),
          "Forward kinematics: everything from joint coordinates and rates, with inertia. The search begins at home. "
          "Raises Error: notFinite, unreachable, singular, notConverged.")
      .def(
          "reach",
          [](const Device& self, const Array& position, const std::optional<Array>& rotation,
             const std::optional<Array>& twist) {
            Kinematics kinematics;
            require(
                self.mechanism->reach(poseOf(position, rotation),
                                      twist ? vec6(*twist, "twist", "m/s and rad/s") : Vec6::Zero(), true, kinematics),
                "inverse kinematics");
            return kinematics;
          },
          py::arg("position"), py::arg("rotation") = py::none(), py::arg("twist") = py::none(),
          "Inverse kinematics: everything from pose and twist, with inertia. Raises Error: notFinite, unreachable "
          "(also: a turn that the platform cannot make), singular.")
      .def(
          "accelerate",
          [](const Device& self, const Array& position, const Array& torque, const std::optional<Array>& rotation,
             const std::optional<Array>& twist, const std::optional<Array>& wrench) {
            Vec6 acceleration;
            require(self.mechanism->accelerate(
                        poseOf(position, rotation), twist ? vec6(*twist, "twist", "m/s and rad/s") : Vec6::Zero(),
                        joints(torque, self.mechanism->joints(), "torque", "N m or N"),
                        wrench ? vec6(*wrench, "wrench", "N and N m") : Vec6::Zero(), acceleration),
                    "forward dynamics");
            return acceleration;
          },
          py::arg("position"), py::arg("torque"), py::arg("rotation") = py::none(), py::arg("twist") = py::none(),
          py::arg("wrench") = py::none(),
          "Forward dynamics: V' = [v'; w'], (6,), at a pose and twist under joint torques and a wrench on the platform "
          "at the TCP (N, N m), with gravity, friction and damping. Raises Error as reach().")
      .def(
          "damped",
          [](const Device& self, const Array& damping) {
            DeviceParameters parameters = self.parameters;
            addDamping(parameters, vec6(damping, "damping", "N s/m and N m s/rad"));
            return deviceOf(std::move(parameters));
          },
          py::arg("damping"),
          "The device with more viscous damping of the TCP's twist, (6,), axes of W, N s/m and N m s/rad.")
      .def("__repr__", [](const Device& self) {
        return "<enamel.Device \"" + self.mechanism->name() + "\", " + std::to_string(self.mechanism->joints()) +
               " joints>";
      });
}

void addScene(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(ContactRow, pose, obstacle, part, triangle, feature, gap, point, normal, velocity);
  m.attr("contact_dtype") = py::dtype::of<ContactRow>();
  const double rigid = std::numeric_limits<double>::infinity();
  const py::tuple origin = py::make_tuple(0.0, 0.0, 0.0);
  py::class_<SceneFile, std::shared_ptr<SceneFile>>(
      m, "Scene", "What the tool is, where it begins and what it can touch. Obstacles are numbered from 0.")
      .def(py::init([](const py::object& path) {
             if (path.is_none()) return std::make_shared<SceneFile>();
             const std::string file = py::str(path).cast<std::string>();
             const py::gil_scoped_release release;
             return std::make_shared<SceneFile>(loadScene(file));
           }),
           py::arg("path") = py::none(),
           "Reads a scene file (TOML); without one an empty scene, whose tool is a point at the TCP. Raises "
           "ConfigurationError with file, line, key, value and limit.")
      .def_property_readonly(
          "name", [](const SceneFile& self) { return self.name; }, "As the file has it.")
      .def_property_readonly(
          "notes", [](const SceneFile& self) { return self.notes; },
          "One line for each mesh whose inside is not certain.")
      .def_property_readonly(
          "obstacles",
          [](const SceneFile& self) {
            std::vector<std::string> names;
            for (const Obstacle& obstacle : self.scene.obstacles()) names.push_back(obstacle.name);
            return names;
          },
          "Their names, by number.")
      .def_property(
          "start", [](const SceneFile& self) { return self.start; },
          [](SceneFile& self, const Array& start) { self.start = vec3(start, "start", "m"); },
          "Of the TCP in W, (3,), m; the tool does not touch there.")
      .def("set_tool", &setTool, py::arg("parts"),
           "Makes the tool of capsules: (end, end, radius), in the platform's frame, m; a sphere where both ends are "
           "the "
           "same, a point where the radius is 0. Raises Error: more than 8 parts, an end or radius beyond 1 m.")
      .def(
          "add_half_space",
          [](SceneFile& self, const std::string& name, const Array& point, const Array& normal, double stiffness,
             double friction) {
            const Vec3 n = vec3(normal, "normal", "outward, of any length");
            if (!(n.norm() > 0.0) || !n.allFinite()) throw py::value_error("normal has no direction");
            Obstacle wall = halfSpace(name, vec3(point, "point", "m"), n.normalized());
            wall.material.stiffness = stiffness;
            wall.material.friction = wall.material.sliding = friction;
            return self.scene.add(std::move(wall));
          },
          py::arg("name"), py::arg("point") = origin, py::arg("normal") = py::make_tuple(0.0, 0.0, 1.0),
          py::arg("stiffness") = rigid, py::arg("friction") = 0.0,
          "Half space behind the plane through `point` (m, W) with the outward normal `normal`. Returns its number. "
          "Raises Error: a name that is empty or taken.")
      .def(
          "add_sphere",
          [](SceneFile& self, const std::string& name, const Array& centre, double radius, double stiffness,
             double friction) { return addObstacle(self, name, Sphere{radius}, centre, {}, stiffness, friction); },
          py::arg("name"), py::arg("centre"), py::arg("radius"), py::arg("stiffness") = rigid,
          py::arg("friction") = 0.0, "Solid ball, m. Returns its number. Raises Error: a shape without size.")
      .def(
          "add_box",
          [](SceneFile& self, const std::string& name, const Array& centre, const Array& size,
             const std::optional<Array>& rotation, double stiffness, double friction) {
            return addObstacle(self, name, Box{0.5 * vec3(size, "size", "m")}, centre, rotation, stiffness, friction);
          },
          py::arg("name"), py::arg("centre"), py::arg("size"), py::arg("rotation") = py::none(),
          py::arg("stiffness") = rigid, py::arg("friction") = 0.0,
          "Solid box about `centre` with edges of `size`, m. Returns its number. Raises Error: a shape without size.")
      .def(
          "add_mesh",
          [](SceneFile& self, const std::string& name, const Array& vertices,
             const py::array_t<int, py::array::c_style | py::array::forcecast>& triangles, const Array& position,
             const std::optional<Array>& rotation, double stiffness, double friction, double thickness) {
            return addObstacle(self, name, modelOf(vertices, triangles), position, rotation, stiffness, friction,
                               thickness);
          },
          py::arg("name"), py::arg("vertices"), py::arg("triangles"), py::arg("position") = origin,
          py::arg("rotation") = py::none(), py::arg("stiffness") = rigid, py::arg("friction") = 0.0,
          py::arg("thickness") = 0.0,
          "Triangle mesh: vertices (n, 3), m, in the mesh's own frame; triangles (m, 3), numbers of vertices, "
          "counterclockwise seen from outside; copied. Thickness above 0: the mesh is the middle of a sheet. Returns "
          "its "
          "number. Raises Error with the number of the vertex or triangle.")
      .def(
          "mesh",
          [](const py::object& self, int obstacle) {
            const TriangleMesh& mesh = meshAt(self.cast<const SceneFile&>(), obstacle).mesh();
            return py::make_tuple(
                view(mesh.vertices.front().data(), {static_cast<py::ssize_t>(mesh.vertices.size()), 3}, self),
                view(mesh.triangles.front().data(), {static_cast<py::ssize_t>(mesh.triangles.size()), 3}, self));
          },
          py::arg("obstacle"),
          "Vertices (n, 3), m, and triangles (m, 3) of a mesh, without a copy; they cannot be written. Raises Error: "
          "the "
          "obstacle is no mesh.")
      .def(
          "describe", [](const SceneFile& self, int obstacle) { return describe(meshAt(self, obstacle)); },
          py::arg("obstacle"), "What a mesh is and what that means for the sign of its distances, in one line.")
      .def(
          "move",
          [](SceneFile& self, int obstacle, const Array& position, const std::optional<Array>& rotation,
             const std::optional<Array>& twist) {
            require(self.scene.move(obstacle, poseOf(position, rotation),
                                    twist ? vec6(*twist, "twist", "m/s and rad/s") : Vec6::Zero()),
                    "obstacle " + std::to_string(obstacle));
          },
          py::arg("obstacle"), py::arg("position"), py::arg("rotation") = py::none(), py::arg("twist") = py::none(),
          "Moves an obstacle. Raises Error: a number that no obstacle has.")
      .def("contacts", &contactsOf, py::arg("positions"), py::arg("rotations") = py::none(), py::arg("margin") = 1e-3,
           py::arg("follow") = false,
           "All contacts whose gap is at most `margin` (m) at each pose: positions (n, 3), m, rotations (n, 3, 3). A "
           "structured array (contact_dtype), a row a contact: `pose` is the number of the pose; of one pose the "
           "deepest "
           "comes first. With `follow` the tool moves from pose to pose and is let through no wall, however thin. "
           "Raises "
           "Error: a pose that is not finite. The GIL is released.")
      .def("nearest", &nearestOf, py::arg("positions"), py::arg("rotations") = py::none(),
           "The contact of smallest gap, near or far, at each pose: contact_dtype, (n,). The GIL is released.");

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
      "Reads a mesh file (.ply, .obj, .stl, .off): vertices (n, 3), m, and triangles (m, 3), without a copy. `scale`: "
      "m "
      "per unit of the file. Raises ConfigurationError with the file and the number of the vertex, face or line.");
}

}  // namespace enamel::python

PYBIND11_MODULE(_enamel, m) {
  namespace py = pybind11;
  using namespace enamel;
  m.doc() = "Stiff contact on haptic devices. SI units; W: x right, y up, z from the wall towards the user.";
  // The last that is registered is tried first.
  const auto error = py::register_exception<Error>(m, "Error", PyExc_RuntimeError);
  py::register_exception<PluginError>(m, "PluginError", error);
  py::register_exception<DesignError>(m, "DesignError", error);
  static py::object configurationError =
      py::exception<ConfigurationError>(m, "ConfigurationError", error);  // with file, line and key
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const ConfigurationError& e) {
      py::object instance = configurationError(e.what());
      instance.attr("file") = e.file();
      instance.attr("line") = e.line();
      instance.attr("key") = e.key();
      PyErr_SetObject(configurationError.ptr(), instance.ptr());
    }
  });
  python::addDevice(m);
  python::addScene(m);
  python::addRuns(m);
}
