// The Python module enamel._enamel: errors, names of enumerators, and the parts of the other files.
#include <cstdlib>

#include "binding.hpp"
#include "enamel/core/error.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/guard.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/study/metrics.hpp"

namespace enamel::python {
namespace {

template <typename Enum>
py::tuple namesUpTo(Enum last) {
  py::list names;
  for (int i = 0; i <= static_cast<int>(last); ++i) names.append(toString(static_cast<Enum>(i)));
  return py::tuple(names);
}

// pybind11 before 2.12 takes NumPy 2 for NumPy 1, and arrays would have wrong contents.
void refuseNumpy2() {
#if PYBIND11_VERSION_HEX < 0x020C0000
  std::string version;
  try {
    version = py::str(py::module_::import("numpy").attr("__version__"));
  } catch (const py::error_already_set&) {
    return;  // functions that need arrays report the missing NumPy
  }
  if (std::atoi(version.c_str()) >= 2)
    throw py::import_error(
        "enamel was built with pybind11 " PYBIND11_TOSTRING(PYBIND11_VERSION_MAJOR) "." PYBIND11_TOSTRING(
            PYBIND11_VERSION_MINOR) ", whose arrays are wrong under NumPy " +
        version + ": install numpy<2, or build enamel with pybind11 2.12 or newer");
#endif
}

}  // namespace
}  // namespace enamel::python

PYBIND11_MODULE(_enamel, m) {
  namespace py = pybind11;
  using namespace enamel;
  python::refuseNumpy2();
  m.attr("_pybind11") = py::make_tuple(PYBIND11_VERSION_MAJOR, PYBIND11_VERSION_MINOR);
  m.doc() = "Stiff contact on haptic devices. SI units; W: x right, y up, z from the wall towards the user.";
  // The translator that is registered last is tried first.
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
  m.attr("modes") = python::namesUpTo(RenderMode::fault);
  m.attr("statuses") = python::namesUpTo(Status::stopped);
  m.attr("guard_reasons") = python::namesUpTo(GuardReason::early);
  m.attr("verdicts") = python::namesUpTo(FirstImpactVerdict::flies);
  m.attr("plants") = plantNames();
  python::addDevice(m);
  python::addScene(m);
  python::addRenderers(m);
  python::addDesign(m);
  python::addPush(m);
  python::addStudy(m);
  python::addWall(m);
  python::addRecording(m);
}
