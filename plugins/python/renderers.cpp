#include "renderers.hpp"

#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/passivity.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/render/virtual_coupling.hpp"
#include "setup.hpp"

namespace enamel::python {

void Failure::keep(std::exception_ptr error) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!first_) first_ = std::move(error);
}

void Failure::rethrow() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (first_) std::rethrow_exception(first_);
}

namespace {

// Share an object that any thread may release.
std::shared_ptr<py::object> shared(py::object object) {
  return {new py::object(std::move(object)), [](py::object* kept) {
            const py::gil_scoped_acquire acquire;
            delete kept;
          }};
}

/// A renderer whose controller is a Python object: for experiments, not for real time. Its state cannot be saved.
class ScriptedRenderer final : public Renderer {
 public:
  ScriptedRenderer(std::shared_ptr<py::object> self, std::shared_ptr<Failure> failure)
      : self_(std::move(self)), failure_(std::move(failure)) {
    needsInertia_ = self_->attr("needs_inertia").cast<bool>();
  }
  bool needsInertia() const noexcept override { return needsInertia_; }

 private:
  template <typename Body>
  bool attempt(const Body& body) noexcept {
    if (failed_) return false;
    const py::gil_scoped_acquire acquire;
    try {
      body();
      return true;
    } catch (...) {
      failed_ = true;
      failure_->keep(std::current_exception());
      return false;
    }
  }

  void prepare(double period) override {
    const py::gil_scoped_acquire acquire;
    self_->attr("activate")(period);
  }
  void resetState() noexcept override {
    attempt([this] { self_->attr("reset")(); });
  }
  StateBlock stateBlock() noexcept override { return {nullptr, 0}; }

  Status render(const TickFrame& input, TickOutput& output) noexcept override {
    const Kinematics& k = input.kinematics;
    const bool done = attempt([&] {
      const Array torque = Array::ensure(self_->attr("render")(py::cast(input)));
      if (!torque) throw py::type_error("render() must return an array with the torque of every joint");
      output.torque = joints(torque, static_cast<int>(k.q.size()), "the result of render()", "N m or N");
    });
    if (!done) return Status::notFinite;
    const Contact& deepest = input.contacts.contacts[0];
    const bool touches = input.contacts.count > 0 && deepest.gap < 0.0;
    output.mode = touches ? RenderMode::contact : RenderMode::free;
    if (touches) output.normalForce = deepest.normal.dot(wrenchOf(k, output.torque - k.gravity).head<3>());
    return Status::ok;
  }

  std::shared_ptr<py::object> self_;
  std::shared_ptr<Failure> failure_;
  bool needsInertia_ = false, failed_ = false;
};

}  // namespace

MakeRenderer makerOf(const py::object& renderer, const std::shared_ptr<Failure>& failure) {
  if (py::isinstance<RendererRecipe>(renderer)) return renderer.cast<const RendererRecipe&>().make;
  if (!PyCallable_Check(renderer.ptr()))
    throw py::type_error(
        "a renderer must be the result of enamel.position_control() or a similar function, or a callable that returns "
        "a PythonRenderer");
  return [make = shared(renderer), failure]() -> std::unique_ptr<Renderer> {
    const py::gil_scoped_acquire acquire;
    py::object made = (*make)();
    if (py::isinstance<RendererRecipe>(made)) return made.cast<const RendererRecipe&>().make();
    if (!py::hasattr(made, "render")) throw py::type_error("the callable must return a PythonRenderer");
    return std::make_unique<ScriptedRenderer>(shared(std::move(made)), failure);
  };
}

namespace {

RendererRecipe positionControl(const Device& device, double period, const Delays& delay, const std::string& plant) {
  const auto model = makeMechanism(modelFor(plantName(plant), device.parameters));
  const PositionControlOptions options = positionControlFor(*model, period, delay.first, delay.second);
  PositionControlRenderer{options};  // fail now rather than in a run
  return {"position-control", [options] { return std::make_unique<PositionControlRenderer>(options); }};
}

RendererRecipe hold(const Device& device, double period, const std::optional<Eigen::MatrixXd>& gain, bool release,
                    bool antiWindup) {
  const auto design = gain ? *gain : designServo(device.mechanism, Pose{}, period).K;
  if (design.rows() > kMaxJoints || design.cols() > 3 * kMaxJoints)
    throw Error("the gain is " + std::to_string(design.rows()) + " x " + std::to_string(design.cols()) +
                ", must be n x 3n with n at most " + std::to_string(kMaxJoints));
  HoldOptions options;
  options.release = release;
  options.antiWindup = antiWindup;
  const ServoGain servo = design;
  HoldRenderer(servo, period, options);
  return {"hold", [=] { return std::make_unique<HoldRenderer>(servo, period, options); }};
}

RendererRecipe impedance(double stiffness, double damping) {
  const ImpedanceOptions options{stiffness, damping};
  ImpedanceRenderer{options};
  return {"impedance", [options] { return std::make_unique<ImpedanceRenderer>(options); }};
}

RendererRecipe passivity(double stiffness, double damping, bool memory) {
  const ImpedanceOptions options{stiffness, damping};
  ImpedanceRenderer{options};
  return {"passivity", [options, memory] {
            return std::make_unique<PassivityRenderer>(std::make_unique<ImpedanceRenderer>(options),
                                                       memory ? PassivityBound::memory : PassivityBound::energy);
          }};
}

RendererRecipe virtualCoupling(double stiffness, double damping, double mass) {
  const VirtualCouplingOptions options{stiffness, damping, mass};
  VirtualCouplingRenderer{options};
  return {"virtual-coupling", [options] { return std::make_unique<VirtualCouplingRenderer>(options); }};
}

RendererRecipe plugin(const py::object& path, const py::object& device, const std::map<std::string, py::object>& set) {
  const auto library = PluginLibrary::load(py::str(path).cast<std::string>());
  PluginSetup setup;
  if (!device.is_none()) setup.devicePath = py::str(device).cast<std::string>();
  for (const auto& [key, value] : set) setup.parameters[key] = py::str(value).cast<std::string>();
  (void)makeRenderer(library, setup);
  return {library->description().name, [library, setup] { return makeRenderer(library, setup); }};
}

void addTick(py::module_& m) {
  py::class_<TickFrame>(m, "Tick", "Input of a renderer at a tick, SI units, in W.")
      .def_readonly("time", &TickFrame::time, "Time, s, strictly increasing.")
      .def_readonly("kinematics", &TickFrame::kinematics, "Measured kinematics; with inertia if needs_inertia is True.")
      .def_readonly("max_torque", &TickFrame::maxTorque, "Limit of each motor, (n,), N m or N.")
      .def_readonly("age", &TickFrame::age,
                    "Periods since the sample; 0 for a new sample. Above 0, kinematics and contacts are those of the "
                    "last sample.")
      .def_property_readonly(
          "applied", [](const TickFrame& self) { return self.applied.value_or(JointVector()); },
          "Torque that acted since the last tick, (n,), N m or N; (0,) if the device does not report it.")
      .def_property_readonly(
          "contacts",
          [](const TickFrame& self) {
            std::vector<ContactRow> rows;
            for (int i = 0; i < self.contacts.count; ++i)
              rows.push_back(rowOf(0, self.contacts.contacts[static_cast<std::size_t>(i)]));
            return arrayOf(std::move(rows));
          },
          "Contacts with a gap of at most 1 mm, the deepest first (contact_dtype).");
}

}  // namespace

void addRenderers(py::module_& m) {
  addTick(m);
  py::class_<RendererRecipe>(m, "Renderer", "Recipe of a renderer: every run makes its own renderer from it.")
      .def_readonly("name", &RendererRecipe::name)
      .def("__repr__", [](const RendererRecipe& self) { return "<enamel.Renderer \"" + self.name + "\">"; });
  m.def("position_control", &positionControl, py::arg("device"), py::arg("period") = 1e-3,
        py::arg("delay") = Delays{0, 0}, py::arg("plant") = kClosedForm,
        "Return the contact-space servo. It pushes, never pulls, and lets the tool slide. `delay`: smallest and "
        "largest delay of the command, ticks. `plant`: as in push(); the servo takes the plant's drives into account; "
        "use \"imperfect\" for a real device. Raises Error if a number is outside its range or the plant is unknown.");
  m.def("hold", &hold, py::arg("device"), py::arg("period") = 1e-3, py::arg("gain") = py::none(),
        py::arg("release") = true, py::arg("anti_windup") = false,
        "Return the paper's controller: from the first touch on, a servo holds the tool there. `gain`, (n, 3n), is "
        "that of design_servo(), by default designed at home. Raises Error if the gain is not n x 3n or not finite, "
        "and DesignError.");
  m.def("impedance", &impedance, py::arg("stiffness") = 6000.0, py::arg("damping") = 0.0,
        "Return the conventional wall: a spring (N/m) and a damper (N s/m) along the contact's normal. Raises Error if "
        "one is negative or not finite.");
  m.def("passivity", &passivity, py::arg("stiffness") = 6000.0, py::arg("damping") = 0.0, py::arg("memory") = false,
        "Return the impedance wall with time-domain passivity control. With `memory`, each depth returns only the "
        "energy that it has received. Raises Error as impedance() does.");
  m.def("virtual_coupling", &virtualCoupling, py::arg("stiffness") = 3000.0, py::arg("damping") = 2.0,
        py::arg("mass") = 0.02,
        "Return a virtual coupling: a virtual tool (kg) touches the wall; a spring (N/m) and a damper (N s/m) couple "
        "the device to it. Raises Error if a number is not positive or not finite; the damping may be 0.");
  m.def(
      "plugin",
      [](const py::object& path, const py::object& device, const py::kwargs& parameters) {
        return plugin(path, device, parameters.cast<std::map<std::string, py::object>>());
      },
      py::arg("path"), py::arg("device") = py::none(),
      "Return a renderer from a plugin file. `device`: path of the device file; further parameters are the plugin's. "
      "Raises PluginError if it cannot be loaded or refuses the configuration.");
}

}  // namespace enamel::python
