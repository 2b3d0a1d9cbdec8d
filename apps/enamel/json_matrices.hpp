// JSON files of the subcommands, and vectors and matrices in them.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

namespace enamel::app {

using Json = nlohmann::ordered_json;

Json listOf(const Eigen::VectorXd& v);

/// Throws ConfigurationError: as readJson(); it names the line that is not JSON.
Json parseJson(const std::string& path);

/// Return the text of a file: one entry a line. Names that are not UTF-8 are converted.
std::string textOf(const Json& json);

/// Return one list for each row.
Json rowsOf(const Eigen::MatrixXd& m);

}  // namespace enamel::app
