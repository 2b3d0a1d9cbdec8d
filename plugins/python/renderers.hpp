// Renderers for runs from Python: linked ones, plugins, and those that are written in Python.
#pragma once

#include <exception>
#include <mutex>

#include "binding.hpp"
#include "enamel/study/wall_design.hpp"

namespace enamel::python {

using Delays = std::pair<int, int>;  // smallest and largest, ticks

/// How to make a renderer: a run makes its own, so that runs share no state.
struct RendererRecipe {
  std::string name;
  MakeRenderer make;
};

/// Keeps the first exception of the Python renderers of one call: they cannot throw in a tick. Any thread.
class Failure {
 public:
  void keep(std::exception_ptr error);
  void rethrow();

 private:
  std::mutex mutex_;
  std::exception_ptr first_;
};

/// Makes renderers from what a user handed over: a RendererRecipe, or a callable that makes one or a PythonRenderer.
/// Throws TypeError: neither.
MakeRenderer makerOf(const py::object& renderer, const std::shared_ptr<Failure>& failure);

}  // namespace enamel::python
