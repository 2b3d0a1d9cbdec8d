#include "json_matrices.hpp"

#include <algorithm>
#include <vector>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"

namespace enamel::app {

Json parseJson(const std::string& path) {
  const std::string text = readJson(path);
  try {
    return Json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(error.byte, text.size()));
    throw ConfigurationError(path, 1 + static_cast<int>(std::count(text.begin(), end, '\n')), "", "is not valid JSON");
  } catch (const nlohmann::json::exception&) {
    throw ConfigurationError(path, 0, "", "has a number outside the range of double precision");
  }
}

std::string textOf(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

Json listOf(const Eigen::VectorXd& v) { return std::vector<double>(v.data(), v.data() + v.size()); }

Json rowsOf(const Eigen::MatrixXd& m) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < m.rows(); ++i) rows.push_back(listOf(m.row(i)));
  return rows;
}

}  // namespace enamel::app
