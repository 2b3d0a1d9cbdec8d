// Rows of the reference files in data/reference (computed with two independent multibody engines; see the README
// there) and small helpers to compare with them.
#pragma once

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "enamel/core/types.hpp"
#include "support/relative_error.hpp"

namespace enamel::test {

/// A reference file; it is read once and stays.
inline const nlohmann::json& referenceFile(const std::string& name) {
  static std::map<std::string, nlohmann::json> files;
  nlohmann::json& file = files[name];
  if (file.is_null()) file = nlohmann::json::parse(std::ifstream(ENAMEL_SOURCE_DIR "/data/reference/" + name));
  return file;
}

template <int rows>
Eigen::Matrix<double, rows, 1> vectorFrom(const nlohmann::json& list) {
  Eigen::Matrix<double, rows, 1> v;
  for (int i = 0; i < rows; ++i) v[i] = list.at(static_cast<std::size_t>(i)).get<double>();
  return v;
}

inline Eigen::MatrixXd matrixFrom(const nlohmann::json& rows) {
  Eigen::MatrixXd m(rows.size(), rows.at(0).size());
  for (int i = 0; i < m.rows(); ++i)
    for (int j = 0; j < m.cols(); ++j)
      m(i, j) = rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(j)).get<double>();
  return m;
}

}  // namespace enamel::test
