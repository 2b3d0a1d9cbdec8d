// Vectors and matrices in the files that subcommands write.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>

namespace enamel::app {

nlohmann::ordered_json listOf(const Eigen::VectorXd& v);

/// A list a row.
nlohmann::ordered_json rowsOf(const Eigen::MatrixXd& m);

}  // namespace enamel::app
