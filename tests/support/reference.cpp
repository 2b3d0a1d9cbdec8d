#include "support/reference.hpp"

#include "support/json.hpp"

namespace enamel::test {

std::vector<ReferenceState> referenceStates(const std::string& name) {
  std::vector<ReferenceState> states;
  for (const nlohmann::json& row : referenceFile(name + ".json").at("rows")) {
    ReferenceState s;
    s.position = vectorFrom(row.at("position"));
    s.euler = vectorFrom(row.at("euler_xyz"));
    s.elbow = vectorFrom(row.at("elbow"));
    s.q = vectorFrom(row.at("q"));
    s.rates = vectorFrom(row.at("qdot"));
    s.torque = vectorFrom(row.at("torque"));
    s.wrench = vectorFrom(row.at("tcp_wrench"));
    s.gravityTorque = vectorFrom(row.at("gravity_torque"));
    s.accelerations = vectorFrom(row.at("qddot"));
    s.jacobian = matrixFrom(row.at("jacobian"));
    s.massMatrix = matrixFrom(row.at("mass_matrix"));
    states.push_back(s);
  }
  return states;
}

const std::vector<ReferenceRun>& referenceRuns() {
  static const std::vector<ReferenceRun> runs = [] {
    std::vector<ReferenceRun> all;
    for (const nlohmann::json& row : referenceFile("runs-nominal.json").at("rows"))
      all.push_back({row.at("controller") == "pc", row.at("force"), row.at("duration"), row.at("z"),
                     vectorFrom(row.at("torque_max"))});
    return all;
  }();
  return runs;
}

Eigen::MatrixXd referenceServo(const char* key) { return matrixFrom(referenceFile("servo-nominal.json").at(key)); }

}  // namespace enamel::test
