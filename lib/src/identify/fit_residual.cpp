// Torques and noise that follow from the residual of a fit.
#include <cmath>
#include <complex>

#include "identify/fit.hpp"

namespace enamel::identify {
namespace {

constexpr double kExplained = 20.0;  // Hz, below which explained() compares

// Phase of the torque that explains a residual e: that of e'' + 2 w e' + w^2 e, or (i f + w)^2.
Eigen::VectorXcd phaseOf(const Eigen::VectorXd& frequencies) {
  Eigen::VectorXcd phase(frequencies.size());
  for (Eigen::Index k = 0; k < phase.size(); ++k) {
    const std::complex<double> turn(kObserverRate, frequencies[k]);
    phase[k] = turn * turn / std::norm(turn);
  }
  return phase;
}

}  // namespace

// Torque of a residual e at each frequency: M (e'' + 2 w e' + w^2 e), with inertia M and observer w.
Eigen::VectorXd Fit::torquePerReading(const Spectrum& spectrum, Eigen::Index joint) const {
  const double rate = 2.0 * M_PI * kObserverRate, inertia = observer_.inertia(joint, joint);
  Eigen::VectorXd gain = spectrum.frequencies();
  return inertia * (gain.array().square() * (4.0 * M_PI * M_PI) + rate * rate);
}

std::vector<Eigen::VectorXd> Fit::whiteTorque() {
  (void)misfit();
  const Piece& piece = pieces_.front();
  const Spectrum& spectrum = *piece.spectrum;
  reading_ = piece.motion->reading.middleCols(piece.first, piece.count);
  torqueGain_.clear();
  std::vector<Eigen::VectorXd> torques;
  const Powers power = powers(base_, 0.0);
  for (Eigen::Index joint = 0; joint < reading_.rows(); ++joint) {
    const Eigen::VectorXd gain = torquePerReading(spectrum, joint);
    const Eigen::VectorXd deviation = power[0][static_cast<std::size_t>(joint)].cwiseSqrt();
    torqueGain_.push_back(gain.cwiseProduct(deviation).cwiseInverse());
    const Eigen::VectorXcd white = spectrum.transform(base_[0].row(joint)).cwiseQuotient(deviation);
    torques.push_back(spectrum.inverse(white.cwiseProduct(phaseOf(spectrum.frequencies()))));
  }
  return torques;
}

Eigen::MatrixXd Fit::residualCommand(int delay) const {
  const Piece& piece = pieces_.front();
  Eigen::MatrixXd commands(piece.motion->command.rows(), piece.count);
  for (Eigen::Index i = 0; i < piece.count; ++i)
    commands.col(i) = piece.motion->command.col(std::max<Eigen::Index>(0, piece.first + i - delay));
  return commands;
}

Eigen::VectorXd Fit::whitenTorque(Eigen::Index joint, const Eigen::VectorXd& torque) const {
  const Spectrum& spectrum = *pieces_.front().spectrum;
  return spectrum.inverse(spectrum.transform(torque).cwiseProduct(torqueGain_[static_cast<std::size_t>(joint)]));
}

Eigen::VectorXd Fit::noise() {
  (void)misfit();
  const Spectrum& spectrum = *pieces_.front().spectrum;
  const Eigen::VectorXd isFast = (spectrum.frequencies().array() > kNoiseBegin).cast<double>();
  Eigen::VectorXd deviation(base_.front().rows());
  for (Eigen::Index joint = 0; joint < deviation.size(); ++joint)
    deviation[joint] =
        std::sqrt(spectrum.mean(spectrum.transform(base_.front().row(joint)).cwiseProduct(isFast).cwiseAbs2()));
  return deviation;
}

Eigen::VectorXd Fit::explained() {
  (void)misfit();
  const Eigen::Index joints = base_.front().rows();
  Eigen::VectorXd error = Eigen::VectorXd::Zero(joints), whole = error;
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const Piece& piece = pieces_[p];
    const Spectrum& spectrum = *piece.spectrum;
    const Eigen::VectorXd isSlow = (spectrum.frequencies().array() < kExplained).cast<double>();
    for (Eigen::Index joint = 0; joint < joints; ++joint) {
      Eigen::VectorXd command = piece.motion->command.row(joint).segment(piece.first, piece.count);
      command.array() -= command.mean();
      const Eigen::VectorXd gain = torquePerReading(spectrum, joint).cwiseProduct(isSlow);
      error[joint] += spectrum.mean(spectrum.transform(base_[p].row(joint)).cwiseProduct(gain).cwiseAbs2());
      whole[joint] += spectrum.mean(spectrum.transform(command).cwiseProduct(isSlow).cwiseAbs2());
    }
  }
  return 1.0 - (error.array() / whole.array().max(1e-300));
}

IdentificationTraces Fit::traces() {
  (void)misfit();
  const Piece& piece = pieces_.front();
  const Spectrum& spectrum = *piece.spectrum;
  const Eigen::VectorXd frequencies = spectrum.frequencies(),
                        isSlow = (frequencies.array() < kExplained).cast<double>();
  const Eigen::VectorXcd phase = phaseOf(frequencies);
  const double density = 2.0 * piece.motion->period;  // of one-sided power, per mean square of a line
  IdentificationTraces traces;
  traces.period = piece.motion->period;
  // The mean frequency of each band.
  traces.frequency = spectrum.bands(frequencies);
  const Eigen::Index joints = base_.front().rows();
  traces.torque.resize(joints, piece.count);
  traces.explained = traces.torque;
  traces.residual.resize(joints, traces.frequency.size());
  for (Eigen::Index joint = 0; joint < joints; ++joint) {
    Eigen::VectorXd command = piece.motion->command.row(joint).segment(piece.first, piece.count);
    command.array() -= command.mean();
    const Eigen::VectorXcd residual = spectrum.transform(base_.front().row(joint));
    const Eigen::VectorXcd slow = spectrum.transform(command).cwiseProduct(isSlow);
    traces.joint.push_back(jointName(reference_.device, static_cast<int>(joint)));
    traces.torque.row(joint) = spectrum.inverse(slow);
    const Eigen::VectorXcd missing =
        residual.cwiseProduct(torquePerReading(spectrum, joint).cwiseProduct(isSlow)).cwiseProduct(phase);
    traces.explained.row(joint) = spectrum.inverse(slow + missing);
    traces.residual.row(joint) = (density * spectrum.bands(residual.cwiseAbs2())).cwiseSqrt();
  }
  return traces;
}

}  // namespace enamel::identify
