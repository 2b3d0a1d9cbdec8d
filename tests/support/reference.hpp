// Rows of the reference files in data/reference, computed with two independent multibody engines (see the README
// there). JSON is included in reference.cpp only, because its templates take seconds to compile in every file.
#pragma once

#include <string>
#include <vector>

#include "enamel/core/types.hpp"
#include "support/relative_error.hpp"

namespace enamel::test {

/// A state of a TAU device and the engines' results: a row of tau-nominal.json or tau-detailed.json.
struct ReferenceState {
  Vec3 position, euler, elbow;
  Vec6 q, rates, torque, wrench, gravityTorque, accelerations;
  Eigen::MatrixXd jacobian, massMatrix;
};
std::vector<ReferenceState> referenceStates(const std::string& name);

/// A push against the wall: a row of runs-nominal.json.
struct ReferenceRun {
  bool servo;  ///< the paper's controller; false: impedance
  double force, duration;
  std::vector<double> z;  ///< of the TCP at each tick, m
  Vec6 largestTorque;
};
const std::vector<ReferenceRun>& referenceRuns();

/// Return a matrix of servo-nominal.json.
Eigen::MatrixXd referenceServo(const char* key);

}  // namespace enamel::test
