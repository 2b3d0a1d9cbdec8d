#include "identify/local_dynamics.hpp"

#include <Eigen/LU>

namespace enamel::identify {
namespace {

constexpr double kDifference = 1e-4;  // rad or m, for those of M and g
constexpr double kTurning = 1e-5;     // s, for the derivative of J

}  // namespace

Status dynamicsAt(const Mechanism& mechanism, const JointVector& place, const JointVector& rates,
                  Kinematics& kinematics, LocalDynamics& dynamics) {
  if (const Status status = mechanism.track(place, rates, true, kinematics); status != Status::ok) return status;
  Kinematics before = kinematics, after = kinematics;
  Vec6 free;
  for (const Status status : {mechanism.track(place - kTurning * rates, rates, false, before),
                              mechanism.track(place + kTurning * rates, rates, false, after),
                              mechanism.accelerate(kinematics.pose, kinematics.twist, 0.0 * rates, Vec6::Zero(), free)})
    if (status != Status::ok) return status;
  free -= (after.jacobian - before.jacobian) * rates / (2.0 * kTurning);  // J' q'
  dynamics.place = place;
  dynamics.rates = rates;
  dynamics.balance = -kinematics.inertia * (kinematics.inverseTransposed.transpose() * free);
  dynamics.mobility = kinematics.inertia.inverse();
  return Status::ok;
}

DynamicsSlopes slopesAt(const Mechanism& mechanism, const Kinematics& here) {
  const Eigen::Index n = here.q.size();
  DynamicsSlopes slopes{std::vector<Eigen::MatrixXd>(static_cast<std::size_t>(n), Eigen::MatrixXd::Zero(n, n)),
                        Eigen::MatrixXd::Zero(n, n)};
  const JointVector rest = JointVector::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    JointVector q = here.q;
    q[k] += kDifference;
    Kinematics there = here;
    if (mechanism.track(q, rest, true, there) != Status::ok) continue;
    slopes.inertia[static_cast<std::size_t>(k)] = (there.inertia - here.inertia) / kDifference;
    slopes.gravity.col(k) = (there.gravity - here.gravity) / kDifference;
  }
  return slopes;
}

}  // namespace enamel::identify
