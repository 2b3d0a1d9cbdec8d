#include "json_matrices.hpp"

#include <vector>

namespace enamel::app {

nlohmann::ordered_json listOf(const Eigen::VectorXd& v) { return std::vector<double>(v.data(), v.data() + v.size()); }

nlohmann::ordered_json rowsOf(const Eigen::MatrixXd& m) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) rows.push_back(listOf(m.row(i)));
  return rows;
}

}  // namespace enamel::app
