// Renderers for runs from Python: linked renderers, plugins, and renderers written in Python.
#pragma once

#include <exception>
#include <mutex>

#include "binding.hpp"
#include "enamel/study/wall_design.hpp"

namespace enamel::python {

using Delays = std::pair<int, int>;  // smallest and largest, ticks

/// Makes a renderer. Each run makes its own, so that runs share no state.
struct RendererRecipe {
  std::string name;
  MakeRenderer make;
};

/// Keeps the first exception of the Python renderers during one call, because they cannot throw in a tick. Any thread.
class Failure {
 public:
  void keep(std::exception_ptr error);
  void rethrow();

 private:
  std::mutex mutex_;
  std::exception_ptr first_;
};

/// Return a maker of renderers from the user's argument: a RendererRecipe, or a callable that returns a recipe or a
/// PythonRenderer. Throws TypeError: anything else.
MakeRenderer makerOf(const py::object& renderer, const std::shared_ptr<Failure>& failure);

}  // namespace enamel::python
