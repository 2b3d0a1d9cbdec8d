// JSON for tests of the commands' output. Only these tests include it, because its templates take seconds to compile.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

namespace enamel::test {

/// Throws if the text is not JSON.
nlohmann::json parseJson(const std::string& text);

/// Return a file of data/reference; it is read once and kept.
const nlohmann::json& referenceFile(const std::string& name);

Eigen::VectorXd vectorFrom(const nlohmann::json& list);
Eigen::MatrixXd matrixFrom(const nlohmann::json& rows);

}  // namespace enamel::test
