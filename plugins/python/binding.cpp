#include "binding.hpp"

#include <limits>
#include <sstream>

#include "enamel/core/error.hpp"

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
    if (!isRotation(pose.rotation)) throw py::value_error("rotation must be a right-handed orthonormal matrix to 1e-6");
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

void warnDeprecated(const std::string& text) {
  if (PyErr_WarnEx(PyExc_DeprecationWarning, text.c_str(), 1) != 0) throw py::error_already_set();
}

}  // namespace enamel::python
