// JSON files that subcommands read and write; vectors and matrices in them.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>

namespace enamel::app {

nlohmann::ordered_json listOf(const Eigen::VectorXd& v);

/// Throws ConfigurationError: as readJson(); the line that is no JSON.
nlohmann::ordered_json parseJson(const std::string& path);

/// As it stands in a file: an entry a line; names that are not UTF-8 are made so.
std::string textOf(const nlohmann::ordered_json& json);

/// A list a row.
nlohmann::ordered_json rowsOf(const Eigen::MatrixXd& m);

}  // namespace enamel::app
