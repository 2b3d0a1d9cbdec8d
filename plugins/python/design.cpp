// The paper's servo design in Python.
#include "binding.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_file.hpp"

namespace enamel::python {

void addDesign(py::module_& m) {
  py::class_<ServoDesign>(m, "ServoDesign",
                          "A servo u = -K [q'; q - q_op; xi] and the models for which it was designed.")
      .def_readonly("period", &ServoDesign::period, "Period of the ticks T_s, s.")
      .def_readonly("K", &ServoDesign::K, "Gain, (n, 3n), N m s/rad, N m/rad and N m/(rad s).")
      .def_readonly("P", &ServoDesign::P, "Cost-to-go matrix, (3n, 3n).")
      .def_property_readonly(
          "A", [](const ServoDesign& self) -> const Eigen::MatrixXd& { return self.plant.A; },
          py::return_value_policy::reference_internal,
          "State matrix of the continuous plant with states [q'; q - q_op], (2n, 2n).")
      .def_property_readonly(
          "B", [](const ServoDesign& self) -> const Eigen::MatrixXd& { return self.plant.B; },
          py::return_value_policy::reference_internal, "Input matrix of the continuous plant, (2n, n).");
  m.def(
      "design_servo",
      [](const Device& device, const std::optional<Array>& position, double period, double velocity, double weight,
         double integral, double torque) {
        Pose pose;
        if (position) pose.position = vec3(*position, "position", "m");
        const py::gil_scoped_release release;
        return designServo(device.mechanism, pose, period, ServoWeights{velocity, weight, integral, torque});
      },
      py::arg("device"), py::arg("position") = py::none(), py::arg("period") = 1e-3, py::arg("velocity") = 1.0,
      py::arg("weight") = 1e3, py::arg("integral") = 1e7, py::arg("torque") = 1.0,
      "Design the paper's servo for a device at rest at a position (m; default: home): linearisation, transformation, "
      "integrators, zero-order hold and Riccati equation. The weights are those of rate, position, integral and "
      "torque. Raises DesignError if the pose is out of reach or singular, or a weight is negative.");
  m.def(
      "load_servo", [](const py::object& path) { return loadServo(py::str(path).cast<std::string>()).gain; },
      py::arg("path"), "Return the gain, (n, 3n), of a file of enamel design. Raises ConfigurationError.");
}

}  // namespace enamel::python
