#include "identify/cogging.hpp"

#include <algorithm>
#include <cmath>

namespace enamel::identify {
namespace {

constexpr double kCoggingSpread = 0.02;  // amplitude of the largest effort
constexpr double kRippleSpread = 0.02;   // of the torque
constexpr double kFastest = 0.25;        // of the tick rate: frequency of the cogging at the typical rate

double rangeOf(const Eigen::MatrixXd& reading) {
  return (reading.rowwise().maxCoeff() - reading.rowwise().minCoeff()).minCoeff();
}

// Regress a residual on two terms. Returns the gain of the log likelihood of white noise.
double regress(const Eigen::VectorXd& residual, const Eigen::VectorXd& sine, const Eigen::VectorXd& cosine,
               Eigen::Ref<Eigen::RowVectorXd> parts) {
  const double ss = sine.squaredNorm(), cc = cosine.squaredNorm(), sc = sine.dot(cosine);
  const double s = sine.dot(residual), c = cosine.dot(residual), determinant = ss * cc - sc * sc;
  if (!(determinant > 1e-9 * ss * cc)) return 0.0;
  parts << (cc * s - sc * c) / determinant, (ss * c - sc * s) / determinant;
  return 0.5 * (parts[0] * s + parts[1] * c);
}

}  // namespace

CoggingSearch findCogging(Fit& fit) {
  const std::vector<Eigen::VectorXd> torque = fit.whiteTorque();
  const Eigen::MatrixXd& reading = fit.residualReading();
  const double range = rangeOf(reading);
  double fastest = 0.0;
  for (Eigen::Index joint = 0; joint < reading.rows(); ++joint) {
    const Eigen::Index count = reading.cols();
    const double rate =
        std::sqrt((reading.row(joint).tail(count - 10) - reading.row(joint).head(count - 10)).squaredNorm() /
                  static_cast<double>(count)) /
        (10.0 * fit.period());
    fastest = std::max(fastest, rate);
  }
  const double first = 1.0 * 2.0 * M_PI / range, last = 2.0 * M_PI * kFastest / fit.period() / std::max(1e-9, fastest);
  CoggingSearch best;
  for (double periods = first; periods < last; periods += 0.3 * first) {
    double gain = 0.0;
    Eigen::MatrixXd parts = Eigen::MatrixXd::Zero(reading.rows(), 2);
    for (Eigen::Index joint = 0; joint < reading.rows(); ++joint) {
      const Eigen::VectorXd angle = periods * reading.row(joint).transpose();
      Eigen::RowVectorXd part = parts.row(joint);
      gain += regress(torque[static_cast<std::size_t>(joint)], fit.whitenTorque(joint, angle.array().sin()),
                      fit.whitenTorque(joint, angle.array().cos()), part);
      parts.row(joint) = part;
    }
    if (gain > best.evidence) best = {periods, gain, parts};
  }
  return best;
}

std::vector<Unknown> coggingUnknowns(const DeviceModel& model, const Eigen::MatrixXd& reading) {
  std::vector<Unknown> unknowns;
  const JointVector effort = makeMechanism(model.device)->limits().effort;
  const double range = rangeOf(reading);
  for (int i = 0; i < effort.size(); ++i)
    for (JointVector DeviceModel::*const part : {&DeviceModel::sine, &DeviceModel::cosine}) {
      Unknown amplitude{"cogging of " + jointName(model.device, i), "N m",
                        [part, i](DeviceModel& m) -> double& { return (m.*part)[i]; }};
      amplitude.scale = kCoggingSpread * effort[i];
      amplitude.reference = 0.0;
      amplitude.isInFile = false;
      unknowns.push_back(amplitude);
    }
  Unknown periods{"imperfections.periods", "", [](DeviceModel& m) -> double& { return m.drive.periods; }};
  periods.scale = 0.3 * 2.0 * M_PI / range;
  periods.reference = model.drive.periods;
  unknowns.push_back(periods);
  Unknown ripple{"imperfections.torque_ripple", "", [](DeviceModel& m) -> double& { return m.drive.torqueRipple; }};
  ripple.scale = kRippleSpread;
  ripple.reference = 0.0;
  ripple.isNonNegative = true;
  unknowns.push_back(ripple);
  return unknowns;
}

}  // namespace enamel::identify
