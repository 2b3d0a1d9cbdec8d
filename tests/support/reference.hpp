// Rows of the reference files in data/reference (computed with two independent multibody engines; see the README
// there). JSON stays in reference.cpp: its templates take seconds of compiler in every file that sees them.
#pragma once

#include <string>
#include <vector>

#include "enamel/core/types.hpp"
#include "support/relative_error.hpp"

namespace enamel::test {

/// A state of a TAU device and what the engines answer: a row of tau-nominal.json or tau-detailed.json.
struct ReferenceState {
  Vec3 position, euler, elbow;
  Vec6 q, rates, torque, wrench, gravityTorque, accelerations;
  Eigen::MatrixXd jacobian, massMatrix;
};
std::vector<ReferenceState> referenceStates(const std::string& name);

/// A push against the wall: a row of runs-nominal.json.
struct ReferenceRun {
  bool servo;  ///< the paper's controller, else impedance
  double force, duration;
  std::vector<double> z;  ///< of the TCP at the ticks, m
  Vec6 largestTorque;
};
const std::vector<ReferenceRun>& referenceRuns();

/// A matrix of servo-nominal.json.
Eigen::MatrixXd referenceServo(const char* key);

}  // namespace enamel::test
