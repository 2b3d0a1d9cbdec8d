#include "evaluate_rows.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"
#include "json_matrices.hpp"

namespace enamel::app {
namespace {

template <int n>
Eigen::Matrix<double, n, 1> vectorAt(const Json& row, const char* key) {
  const Json& list = row.at(key);
  if (!list.is_array() || list.size() != n)
    throw Error(std::string(key) + " must be a list of " + std::to_string(n) + " numbers");
  Eigen::Matrix<double, n, 1> v;
  for (int i = 0; i < n; ++i) {
    if (!list[static_cast<std::size_t>(i)].is_number())
      throw Error(std::string(key) + "[" + std::to_string(i) + "] must be a finite number");
    v[i] = list[static_cast<std::size_t>(i)].get<double>();
  }
  return v;
}

TauConfiguration configurationOf(const TauModel& model, const Json& row) {
  TauConfiguration configuration;
  Status status = Status::ok;
  std::string what;
  if (row.contains("position") || row.contains("euler_xyz")) {
    if (!row.contains("position") || !row.contains("euler_xyz"))
      throw Error("position and euler_xyz must be given together");
    Pose pose;
    pose.position = vectorAt<3>(row, "position");
    pose.rotation = rotationFromEuler(vectorAt<3>(row, "euler_xyz"));
    status = inverseKinematics(model, pose, configuration);
    what = "the pose is ";
  } else if (row.contains("q")) {
    status = forwardKinematicsFromHome(model, vectorAt<6>(row, "q"), configuration).status;
    what = "q on the branch of home is ";
  } else {
    throw Error("position and euler_xyz, or q, are missing");
  }
  if (status != Status::ok) throw Error(what + toString(status));
  return configuration;
}

Json evaluateRow(const TauModel& model, const Json& row) {
  if (!row.is_object()) throw Error("must be an object");
  const TauConfiguration c = configurationOf(model, row);
  Json out;
  out["q"] = listOf(jointAngles(c));
  out["elbow"] = listOf(elbowAngles(c));
  out["position"] = listOf(c.pose.position);
  out["euler_xyz"] = listOf(eulerFromRotation(c.pose.rotation));
  out["jacobian"] = rowsOf(jacobian(model, c));
  out["mass_matrix"] = rowsOf(massMatrix(model, c));
  out["gravity_torque"] = listOf(gravityTorque(model, c));
  if (row.contains("qdot") && row.contains("torque") && row.contains("tcp_wrench")) {
    const Vec6 twist = twistFromRates(model, c, vectorAt<6>(row, "qdot"));
    const Vec6 acceleration =
        forwardDynamics(model, c, twist, vectorAt<6>(row, "torque"), vectorAt<6>(row, "tcp_wrench"));
    out["qddot"] = listOf(jointAccelerations(model, c, twist, acceleration));
  }
  return out;
}

}  // namespace

void evaluateRows(const std::string& devicePath, const std::string& inputPath, const std::string& outputPath) {
  const TauParameters device = loadTau(devicePath);
  const TauModel model = makeModel(device);

  const Json input = parseJson(inputPath);
  const Json* rows = input.is_object() && input.contains("rows") ? &input.at("rows") : &input;
  if (!rows->is_array()) throw Error(inputPath + ": must be a list of rows, or an object with the list \"rows\"");

  Json output;
  output["model"] = device.name;
  output["rows"] = Json::array();
  for (const Json& row : *rows) {
    try {
      output["rows"].push_back(evaluateRow(model, row));
    } catch (const std::exception& error) {
      output["rows"].push_back({{"status", error.what()}});
    }
  }
  writeFile(outputPath, textOf(output));
}

}  // namespace enamel::app
