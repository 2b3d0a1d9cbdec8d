#include "support/json.hpp"

#include <fstream>
#include <map>

namespace enamel::test {

nlohmann::json parseJson(const std::string& text) { return nlohmann::json::parse(text); }

const nlohmann::json& referenceFile(const std::string& name) {
  static std::map<std::string, nlohmann::json> files;
  nlohmann::json& file = files[name];
  if (file.is_null()) file = nlohmann::json::parse(std::ifstream(ENAMEL_SOURCE_DIR "/data/reference/" + name));
  return file;
}

Eigen::VectorXd vectorFrom(const nlohmann::json& list) {
  Eigen::VectorXd v(list.size());
  for (int i = 0; i < v.size(); ++i) v[i] = list.at(static_cast<std::size_t>(i)).get<double>();
  return v;
}

Eigen::MatrixXd matrixFrom(const nlohmann::json& rows) {
  Eigen::MatrixXd m(rows.size(), rows.at(0).size());
  for (int i = 0; i < m.rows(); ++i)
    for (int j = 0; j < m.cols(); ++j)
      m(i, j) = rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(j)).get<double>();
  return m;
}

}  // namespace enamel::test
