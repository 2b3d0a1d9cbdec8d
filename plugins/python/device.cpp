// Devices and their kinematics in Python. The headers in lib/include describe the functions.
#include "binding.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/device_file.hpp"

namespace enamel::python {
namespace {

Device deviceOf(DeviceParameters parameters) {
  auto mechanism = makeMechanism(parameters);
  return {std::move(parameters), std::move(mechanism)};
}

template <typename Member>
void addVector(py::class_<Kinematics>& c, const char* name, Member member, const char* doc) {
  c.def_readonly(name, member, doc);  // an array that refers to the object
}

void addKinematics(py::module_& m) {
  py::class_<Kinematics> k(m, "Kinematics",
                           "Kinematics and dynamics of a mechanism in motion, as a tick computes them once, in W. The "
                           "arrays are read-only views of this object.");
  addVector(k, "q", &Kinematics::q, "Joint coordinates, (n,), rad or m.");
  addVector(k, "rates", &Kinematics::rates, "Joint rates q', (n,), rad/s or m/s.");
  addVector(k, "twist", &Kinematics::twist, "Twist V = J q' of the TCP, (6,), m/s and rad/s.");
  addVector(k, "jacobian", &Kinematics::jacobian, "J, (6, n).");
  addVector(k, "inverse_transposed", &Kinematics::inverseTransposed,
            "Inverse transpose of the Jacobian, (6, n): torques tau put the wrench F = J^-T tau on the platform, and "
            "q' = (J^-T)^T V.");
  addVector(k, "gravity", &Kinematics::gravity, "Torque that balances gravity at rest, (n,), N m or N.");
  addVector(
      k, "inertia", &Kinematics::inertia,
      "Joint-space inertia M(q), (n, n), kg m^2 or kg; (0, 0) in a tick if the renderer's needs_inertia is False.");
  k.def_property_readonly(
      "position", [](const Kinematics& self) -> const Vec3& { return self.pose.position; },
      py::return_value_policy::reference_internal, "Position of the TCP in W, (3,), m.");
  k.def_property_readonly(
      "rotation", [](const Kinematics& self) -> const Mat3& { return self.pose.rotation; },
      py::return_value_policy::reference_internal, "Axes of the platform in W as columns, (3, 3).");
}

void addMotion(py::class_<Device>& device) {
  device
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
          "Return everything from joint coordinates and rates (forward kinematics), with inertia. The search begins at "
          "home. Raises Error: notFinite, unreachable, singular, notConverged.")
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
          "Return everything from pose and twist (inverse kinematics), with inertia. Raises Error: notFinite, "
          "unreachable (also for a rotation that the platform cannot make), singular.")
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
          "Return the acceleration V' = [v'; w'], (6,), m/s^2 and rad/s^2, at a pose and twist (forward dynamics). "
          "Loads are joint torques, a wrench on the platform at the TCP (N, N m), gravity, friction and damping. "
          "Raises Error as reach() "
          "does.");
}

}  // namespace

void addDevice(py::module_& m) {
  addKinematics(m);
  py::class_<Device> device(m, "Device", "A device: its geometry, masses and motors. Immutable; threads may share it.");
  device
      .def(py::init([](const py::object& path) { return deviceOf(loadDevice(py::str(path).cast<std::string>())); }),
           py::arg("path"),
           "Read a device file (TOML). Raises ConfigurationError with file, line, key, value and limit.")
      .def_static(
          "parse", [](const std::string& text, const std::string& file) { return deviceOf(parseDevice(text, file)); },
          py::arg("text"), py::arg("file") = "text",
          "Read the text of a device file. Messages name it `file`. Raises ConfigurationError.")
      .def_property_readonly(
          "name", [](const Device& self) { return self.mechanism->name(); }, "Name in the device file.")
      .def_property_readonly(
          "joints", [](const Device& self) { return self.mechanism->joints(); }, "Number of joints, n.")
      .def_property_readonly(
          "max_torque", [](const Device& self) { return self.mechanism->limits().effort; },
          "Largest torque of each motor, (n,), N m or N.")
      .def_property_readonly(
          "encoder_step", [](const Device& self) { return self.mechanism->limits().encoderStep; },
          "Step of each encoder, (n,), rad or m.")
      .def_property_readonly(
          "count",
          [](const Device& self) {
            warnDeprecated("Device.count: is now called encoder_step; version 0.4 removes the old name");
            return self.mechanism->limits().encoderStep;
          },
          "Old name of encoder_step.")
      .def_property_readonly(
          "home", [](const Device& self) -> const Kinematics& { return self.mechanism->home(); },
          py::return_value_policy::reference_internal, "Kinematics at rest at the home pose (P = W), with inertia.")
      .def(
          "damped",
          [](const Device& self, const Array& damping) {
            DeviceParameters parameters = self.parameters;
            addDamping(parameters, vec6(damping, "damping", "N s/m and N m s/rad"));
            return deviceOf(std::move(parameters));
          },
          py::arg("damping"),
          "Return the device with added viscous damping of the TCP's twist, (6,), axes of W, N s/m and N m s/rad.")
      .def(
          "with_handpiece",
          [](const Device& self, double mass, const Array& com, const std::optional<Array>& inertia,
             const Array& gravity) {
            DeviceParameters parameters = self.parameters;
            Handpiece handpiece;
            handpiece.mass = mass;
            handpiece.com = vec3(com, "com", "m");
            if (inertia) {
              requireShape(*inertia, "inertia", {3, 3}, "kg m^2");
              handpiece.inertia = Eigen::Map<const Mat3>(inertia->data());  // symmetric
            }
            handpiece.gravity = vec3(gravity, "gravity", "m/s^2");
            addHandpiece(parameters, handpiece);
            return deviceOf(std::move(parameters));
          },
          py::arg("mass"), py::arg("com") = py::make_tuple(0.0, 0.0, 0.0), py::arg("inertia") = py::none(),
          py::arg("gravity") = py::make_tuple(0.0, -9.81, 0.0),
          "Return the device with a body that is fixed to its platform: mass (kg), centre of mass in P (m), inertia "
          "about it (kg m^2). Every renderer then balances its weight. `gravity` (m/s^2, W) counts for Cartesian "
          "devices. Raises Error for a negative mass, or numbers that the device cannot take.")
      .def("__repr__", [](const Device& self) {
        return "<enamel.Device \"" + self.mechanism->name() + "\", " + std::to_string(self.mechanism->joints()) +
               " joints>";
      });
  addMotion(device);
}

}  // namespace enamel::python
