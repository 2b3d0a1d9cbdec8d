// JSON files of the subcommands, and vectors and matrices in them.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

namespace enamel::app {

nlohmann::ordered_json listOf(const Eigen::VectorXd& v);

/// Throws ConfigurationError: as readJson(); it names the line that is not JSON.
nlohmann::ordered_json parseJson(const std::string& path);

/// Return the text of a file: one entry a line. Names that are not UTF-8 are converted.
std::string textOf(const nlohmann::ordered_json& json);

/// Return one list for each row.
nlohmann::ordered_json rowsOf(const Eigen::MatrixXd& m);

}  // namespace enamel::app
