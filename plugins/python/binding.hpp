// Shared by the files of the Python module: checks of arrays, tables and views.
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <array>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/renderer.hpp"

namespace enamel::python {

namespace py = pybind11;

/// A device file and its mechanism.
struct Device {
  DeviceParameters parameters;
  std::shared_ptr<const Mechanism> mechanism;
};

/// Numbers; other types and memory layouts are converted to double, row by row.
using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::string shapeOf(const Array& array);

/// Check the shape of an array (-1: any size). Throws ValueError, which names the given shape.
void requireShape(const Array& array, const char* name, std::initializer_list<py::ssize_t> shape, const char* unit);

/// Convert to vectors of fixed size. Throws ValueError: another shape.
Vec3 vec3(const Array& array, const char* name, const char* unit);
Vec6 vec6(const Array& array, const char* name, const char* unit);
JointVector joints(const Array& array, int count, const char* name, const char* unit);
/// Make a pose from position and rotation matrix (default: the axes of W). Throws ValueError: another shape; not a
/// rotation.
Pose poseOf(const Array& position, const std::optional<Array>& rotation);

/// Check a status. Throws Error, which names `what`, unless the status is ok.
void require(Status status, const std::string& what);

/// Issue a DeprecationWarning. Throws error_already_set if warnings are errors. Needs the GIL.
void warnDeprecated(const std::string& text);

/// Return an array over memory that `owner` keeps alive, without a copy.
template <typename T>
py::array view(const T* data, std::vector<py::ssize_t> shape, const py::handle& owner) {
  py::array array(py::dtype::of<T>(), std::move(shape), data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// Owns a value that arrays refer to.
template <typename T>
py::capsule keep(std::unique_ptr<T> value) {
  T* const raw = value.release();
  return py::capsule(raw, [](void* pointer) { delete static_cast<T*>(pointer); });
}

/// A row of the result of contact queries. In W.
struct ContactRow {
  std::int64_t pose;                               // number of the queried pose
  std::int32_t obstacle, part, triangle, feature;  // as in Contact
  double gap, point[3], normal[3], velocity[3];
};
ContactRow rowOf(std::int64_t pose, const Contact& contact) noexcept;

/// Return a structured NumPy array over rows, without a copy.
py::array arrayOf(std::vector<ContactRow> rows);

/// A table with named columns that becomes a structured NumPy array without a copy. Rows consist of 8-byte numbers.
class Table {
 public:
  /// Add a column of numbers, or of arrays of a shape; `kind` is "f8", "i8" or "u8".
  void column(const char* name, std::vector<int> shape = {}, const char* kind = "f8");
  void add(double number) { numbers_.push_back(number); }
  void add(std::int64_t number) { addBits(number); }
  void add(std::uint64_t number) { addBits(number); }
  template <typename Derived>
  void add(const Eigen::MatrixBase<Derived>& m) {  // row by row
    for (Eigen::Index i = 0; i < m.rows(); ++i)
      for (Eigen::Index j = 0; j < m.cols(); ++j) numbers_.push_back(m(i, j));
  }
  /// Add a joint vector to a column of `width`; missing entries are NaN.
  void addJoints(const JointVector& v, int width);
  /// Complete the table. Needs the GIL.
  py::array finish();

 private:
  template <typename T>
  void addBits(T number) {
    double bits;
    std::memcpy(&bits, &number, sizeof bits);
    numbers_.push_back(bits);
  }
  struct Column {
    const char* name;
    std::vector<int> shape;
    int width;
    const char* kind;
  };
  std::vector<Column> columns_;
  std::vector<double> numbers_;
};

// Each file adds its parts. Classes must be added before functions that use them.
void addDevice(py::module_& m);
void addScene(py::module_& m);
void addRenderers(py::module_& m);
void addDesign(py::module_& m);
void addPush(py::module_& m);
void addStudy(py::module_& m);
void addWall(py::module_& m);
void addRecording(py::module_& m);

}  // namespace enamel::python
