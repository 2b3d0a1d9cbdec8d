// JSON for the tests of what commands write. Its templates take seconds of compiler: only these tests include it.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

namespace enamel::test {

/// Throws where it is not JSON.
nlohmann::json parseJson(const std::string& text);

/// A file of data/reference; it is read once and stays.
const nlohmann::json& referenceFile(const std::string& name);

Eigen::VectorXd vectorFrom(const nlohmann::json& list);
Eigen::MatrixXd matrixFrom(const nlohmann::json& rows);

}  // namespace enamel::test
