#include "identify/path_dynamics.hpp"

#include <algorithm>
#include <vector>

#include "core/message.hpp"
#include "enamel/study/parallel.hpp"

namespace enamel::identify {
namespace {

constexpr double kDifference = 1e-4;    // rad or m, for derivatives of M and g
constexpr Eigen::Index kTogether = 64;  // knots that a thread computes together

// [g; M] at a place. `kinematics` is a state near it, and becomes that of the place.
Status termsAt(const Mechanism& mechanism, const JointVector& place, Kinematics& kinematics, Eigen::VectorXd& terms) {
  const JointVector rest = JointVector::Zero(place.size());
  if (const Status status = mechanism.track(place, rest, true, kinematics); status != Status::ok) return status;
  terms << kinematics.gravity, kinematics.inertia.reshaped();
  return Status::ok;
}

// Derivatives of C(v) with respect to q at constant v, a column for each joint. `here`, `after` and `before` are [g; M]
// at the place of `kinematics` and kDifference from it along each joint.
Eigen::MatrixXd coriolisSlopes(const Mechanism& mechanism, const Kinematics& kinematics, const JointVector& rates,
                               const Eigen::VectorXd& here, const Eigen::MatrixXd& before,
                               const Eigen::MatrixXd& after) {
  const Eigen::Index n = rates.size();
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd both(here.size());
  for (Eigen::Index k = 0; k < n; ++k)
    for (Eigen::Index l = 0; l <= k; ++l) {
      both = before.col(k) + 3.0 * (after.col(k) - here);  // makes the difference below the central one
      Kinematics moved = kinematics;
      const JointVector place = kinematics.q + kDifference * (JointVector::Unit(n, k) + JointVector::Unit(n, l));
      if (k != l && termsAt(mechanism, place, moved, both) != Status::ok) continue;
      const Eigen::VectorXd second = (both - after.col(k) - after.col(l) + here) / (kDifference * kDifference);
      const JointVector torque = second.tail(n * n).reshaped(n, n) * rates;  // d^2 M/(dq_k dq_l) v
      const double power = 0.5 * rates.dot(torque);
      slopes.col(l) += rates[k] * torque;
      slopes(k, l) -= power;
      if (k == l) continue;
      slopes.col(k) += rates[l] * torque;
      slopes(l, k) -= power;
    }
  return slopes;
}

// Fill the column of a knot, without the derivative of C if `rates` is empty. Derivatives are zero along joints that
// cannot move.
bool fillKnot(const Mechanism& mechanism, const JointVector& place, const JointVector& rates, Kinematics& kinematics,
              Eigen::Ref<Eigen::VectorXd> knot) {
  const Eigen::Index n = place.size(), size = n + n * n;
  Eigen::VectorXd here(size);
  if (termsAt(mechanism, place, kinematics, here) != Status::ok) return false;
  Eigen::MatrixXd before = here.replicate(1, n), after = before;
  for (Eigen::Index k = 0; k < n; ++k) {
    Kinematics moved = kinematics;
    const JointVector step = kDifference * JointVector::Unit(n, k);
    Eigen::VectorXd low = here, high = here;
    if (termsAt(mechanism, place - step, moved, low) != Status::ok ||
        termsAt(mechanism, place + step, moved, high) != Status::ok)
      continue;
    before.col(k) = low;
    after.col(k) = high;
  }
  Vec6 falling;
  if (mechanism.accelerate(kinematics.pose, Vec6::Zero(), JointVector::Zero(n), Vec6::Zero(), falling) != Status::ok)
    return false;
  knot << place, here, ((after - before) / (2.0 * kDifference)).reshaped();
  knot.segment(n, n) =
      -kinematics.inertia * (kinematics.inverseTransposed.transpose() * falling);  // also without motors
  if (rates.size() == 0) return true;
  const Eigen::MatrixXd slopes = coriolisSlopes(mechanism, kinematics, rates, here, before, after);
  for (Eigen::Index k = 0; k < n; ++k) knot.segment(n + size * (k + 1), n) += slopes.col(k);
  return true;
}

}  // namespace

PathDynamics dynamicsAlong(const Mechanism& mechanism, const Eigen::MatrixXd& route, double period, int interval,
                           int threads) {
  const Eigen::Index n = route.rows(), last = route.cols() - 1, count = std::max<Eigen::Index>(4, last / interval + 2);
  PathDynamics path;
  path.interval = interval;
  path.knots.resize(n + n * (n + 1) * (n + 1), count);
  std::vector<char> isReached(static_cast<std::size_t>(count), 0);
  parallelFor(static_cast<std::size_t>((count + kTogether - 1) / kTogether), threads, [&](std::size_t part) {
    const auto begin = static_cast<Eigen::Index>(part) * kTogether;
    Kinematics kinematics = mechanism.home();
    for (Eigen::Index k = begin; k < std::min(count, begin + kTogether); ++k) {
      const Eigen::Index at = std::min(k * interval, last), from = std::max<Eigen::Index>(0, at - interval),
                         to = std::min(last, at + interval);
      JointVector rates;
      if (period > 0.0) rates = (route.col(to) - route.col(from)) / (period * static_cast<double>(to - from));
      isReached[static_cast<std::size_t>(k)] =
          fillKnot(mechanism, route.col(at), rates, kinematics, path.knots.col(k)) ? 1 : 0;
    }
  });
  require(isReached[0] != 0, "the recorded joints are out of the reach of \"" + mechanism.name() + "\"");
  for (Eigen::Index k = 1; k < count; ++k) {
    if (isReached[static_cast<std::size_t>(k)] != 0) continue;
    path.knots.col(k) = path.knots.col(k - 1);
    ++path.outside;
  }
  return path;
}

}  // namespace enamel::identify
