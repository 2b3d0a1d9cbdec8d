#include "identify/wiring.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/message.hpp"

namespace enamel::identify {
namespace {

constexpr double kWindow = 0.04;  // s, half of the smoothing window: about 15 Hz
constexpr double kEvery = 0.005;  // s, between two equations
constexpr double kDelay = 0.003;  // s, a typical delay of the loop
constexpr double kClearly = 0.3;  // another assignment must explain so much more of one joint's torque
constexpr double kLeastExplained = 0.3;
constexpr double kLargestScale = 20.0;

// Smooth rows by a Hann window, which delays nothing.
Eigen::MatrixXd smoothed(const Eigen::MatrixXd& rows, Eigen::Index half) {
  Eigen::VectorXd window(2 * half + 1);
  for (Eigen::Index k = -half; k <= half; ++k)
    window[k + half] = 1.0 + std::cos(M_PI * static_cast<double>(k) / static_cast<double>(half + 1));
  window /= window.sum();
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(rows.rows(), rows.cols());
  for (Eigen::Index i = half; i + half < rows.cols(); ++i)
    result.col(i) = rows.middleCols(i - half, 2 * half + 1) * window;
  return result;
}

// Equations of one joint: needed torque, commands, and what is known of the friction.
struct Equations {
  Eigen::MatrixXd needed, command, sign, rate;  // joints x equations
};

void append(Eigen::MatrixXd& all, const Eigen::MatrixXd& more) {
  Eigen::MatrixXd joined(more.rows(), all.cols() + more.cols());
  if (all.cols() > 0) joined.leftCols(all.cols()) = all;
  joined.rightCols(more.cols()) = more;
  all = std::move(joined);
}

void addEquations(const DeviceModel& model, const RecordedMotion& motion, Equations& equations) {
  const ImperfectDevice device = deviceOf(model);
  const auto half = static_cast<Eigen::Index>(kWindow / motion.period);
  const auto every = static_cast<Eigen::Index>(std::max(1.0, kEvery / motion.period));
  const Eigen::MatrixXd reading = smoothed(motion.reading, half), command = smoothed(motion.command, half);
  const auto delay = static_cast<Eigen::Index>(kDelay / motion.period);
  Kinematics kinematics = device.mechanism->home();
  Eigen::MatrixXd needed(reading.rows(), reading.cols() / every), commands = needed, signs = needed, turning = needed;
  Eigen::Index count = 0;
  for (Eigen::Index i = half + every; i + half + every < reading.cols(); i += every) {
    const JointVector rates =
        (reading.col(i + every) - reading.col(i - every)) / (2.0 * static_cast<double>(every) * motion.period);
    const JointVector acceleration = (reading.col(i + every) - 2.0 * reading.col(i) + reading.col(i - every)) /
                                     std::pow(static_cast<double>(every) * motion.period, 2);
    const auto torque =
        inverseDynamics(*device.mechanism, reading.col(i) - device.offset, rates, acceleration, kinematics);
    if (!torque) continue;
    needed.col(count) = *torque + device.rotorInertia * (model.hasCables() ? 1.0 : 0.0) * acceleration;
    commands.col(count) = command.col(std::max<Eigen::Index>(0, i - delay));
    signs.col(count) = rates.cwiseSign();
    turning.col(count++) = rates;
  }
  append(equations.needed, needed.leftCols(count));
  append(equations.command, commands.leftCols(count));
  append(equations.sign, signs.leftCols(count));
  append(equations.rate, turning.leftCols(count));
}

// Regression of the torque of joint i on the command of motor k, its friction, its damping and a constant.
struct Regression {
  double gain = 0.0;      // of the command
  double residual = 1.0;  // share of the variance of the needed torque
};

Regression regression(const Equations& equations, Eigen::Index i, Eigen::Index k, bool isReversed) {
  Eigen::MatrixXd terms(4, equations.needed.cols());
  terms.row(0) = (isReversed ? -1.0 : 1.0) * equations.command.row(k);
  terms.row(1) = -equations.sign.row(i);
  terms.row(2) = -equations.rate.row(i);
  terms.row(3).setOnes();
  Eigen::RowVectorXd needed = equations.needed.row(i);
  const Eigen::Matrix4d left = terms * terms.transpose();
  Eigen::Vector4d gains = left.ldlt().solve(terms * needed.transpose());
  if (!gains.allFinite()) gains.setZero();
  if (gains[0] < 0.0) gains.setZero();  // the other sign covers this
  const Eigen::RowVectorXd rest = needed - gains.transpose() * terms;
  needed.array() -= needed.mean();
  return {gains[0], std::min(1.0, rest.squaredNorm() / std::max(1e-300, needed.squaredNorm()))};
}

struct Assignment {
  std::vector<int> motor;        // of each joint
  std::vector<char> isReversed;  // of each joint
  double residual = 0.0;         // mean over the joints
};

// Regressions of each joint on each motor: [joint][motor][sign].
using Table = std::vector<std::vector<std::array<Regression, 2>>>;

Assignment bestOf(const Table& table) {
  Assignment best;
  best.residual = 2.0;
  std::vector<int> motor(table.size());
  std::iota(motor.begin(), motor.end(), 0);
  do {
    Assignment trial{motor, std::vector<char>(motor.size(), 0), 0.0};
    for (std::size_t i = 0; i < motor.size(); ++i) {
      const auto& both = table[i][static_cast<std::size_t>(motor[i])];
      trial.isReversed[i] = both[1].residual < both[0].residual ? 1 : 0;
      trial.residual += std::min(both[0].residual, both[1].residual) / static_cast<double>(motor.size());
    }
    if (trial.residual < best.residual) best = trial;
  } while (std::next_permutation(motor.begin(), motor.end()));
  return best;
}

std::string textOf(const Assignment& best, const DeviceParameters& device) {
  std::string text;
  for (std::size_t i = 0; i < best.motor.size(); ++i) {
    if (best.motor[i] == static_cast<int>(i) && best.isReversed[i] == 0) continue;
    text += text.empty() ? "" : "; ";
    text += jointName(device, static_cast<int>(i)) + " follows " + (best.isReversed[i] != 0 ? "minus " : "") +
            "the command of " + jointName(device, best.motor[i]);
  }
  return text;
}

}  // namespace

std::optional<JointVector> inverseDynamics(const Mechanism& mechanism, const JointVector& q, const JointVector& rates,
                                           const JointVector& accelerations, Kinematics& kinematics) {
  constexpr double kAhead = 1e-4;  // s, for the derivative of J
  const JointVector none = JointVector::Zero(q.size());
  Kinematics next = kinematics;
  if (mechanism.track(q, rates, true, kinematics) != Status::ok) return std::nullopt;
  if (mechanism.track(q + kAhead * rates, rates, false, next) != Status::ok) return std::nullopt;
  Vec6 free;
  if (mechanism.accelerate(kinematics.pose, kinematics.twist, none, Vec6::Zero(), free) != Status::ok)
    return std::nullopt;
  const Vec6 turning = (next.jacobian - kinematics.jacobian) * rates / kAhead;  // J' q'
  const JointVector falling = kinematics.inverseTransposed.transpose() * (free - turning);
  return JointVector(kinematics.inertia * (accelerations - falling));
}

Wiring checkWiring(const DeviceModel& model, const std::vector<RecordedMotion>& motions) {
  Wiring wiring;
  Equations equations;
  Eigen::Index asked = 0;
  for (const RecordedMotion& motion : motions) {
    if (motion.weight > 0.0) continue;  // not in the file
    addEquations(model, motion, equations);
    asked += motion.ticks();
  }
  if (static_cast<double>(equations.needed.cols()) * kEvery < 0.5 * static_cast<double>(asked) * motions[0].period) {
    wiring.problems.push_back("at more than half of the ticks \"" + nameOf(model.device) +
                              "\" cannot have these joint coordinates: check units, offsets and lengths");
    return wiring;
  }
  const auto joints = static_cast<std::size_t>(equations.needed.rows());
  Table table(joints, std::vector<std::array<Regression, 2>>(joints));
  for (std::size_t i = 0; i < joints; ++i)
    for (std::size_t k = 0; k < joints; ++k)
      for (const bool isReversed : {false, true})
        table[i][k][isReversed ? 1 : 0] =
            regression(equations, static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k), isReversed);
  double residual = 0.0;
  std::vector<double> gains;
  for (std::size_t i = 0; i < joints; ++i) {
    residual += table[i][i][0].residual / static_cast<double>(joints);
    gains.push_back(table[i][i][0].gain);
  }
  const Assignment best = bestOf(table);
  if (best.residual < residual - kClearly / static_cast<double>(joints) && !textOf(best, model.device).empty()) {
    wiring.problems.push_back("the motors are not wired as the device file says: " + textOf(best, model.device));
    return wiring;
  }
  if (residual > 1.0 - kLeastExplained) {
    wiring.problems.push_back(
        "the commands explain only " + formatNumber(std::round(100.0 * (1.0 - residual))) +
        " % of the torque that the motion needs: was the tool held, or are numbers in the wrong unit?");
    return wiring;
  }
  std::nth_element(gains.begin(), gains.begin() + static_cast<std::ptrdiff_t>(joints / 2), gains.end());
  wiring.scale = gains[joints / 2];
  if (!(wiring.scale < kLargestScale && wiring.scale > 1.0 / kLargestScale))
    wiring.problems.push_back(
        "the device file needs " + formatNumber(wiring.scale) +
        " times the commanded torque: check the units of readings (m and rad), masses and torques");
  return wiring;
}

}  // namespace enamel::identify
