#include "identify/fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "enamel/core/error.hpp"
#include "enamel/study/parallel.hpp"

namespace enamel::identify {
namespace {

constexpr double kTransient = 0.5;      // s, skipped at the beginning of each piece
constexpr double kShortestPiece = 1.0;  // s
constexpr double kStep = 0.003;         // of x, for differences
constexpr double kRelative = 0.05;      // residual that counts as noise, of the reading's power: far from the device
constexpr double kFloor = 0.3;          // of the power of rounding
constexpr double kBlock = 1.0;          // s, long against the observer's memory of 0.1 s
constexpr double kBandwidth = 8.0;      // independent frequencies in the narrowest band
constexpr double kIntegration = 0.05;   // largest error of the fine simulation, of the deviation of rounding
constexpr int kMostParts = 32;          // of a tick
constexpr double kExplained = 20.0;     // Hz, below which explained() compares
constexpr double kConverged = 0.01;     // expected change of the log likelihood in the next step
constexpr double kGood = 0.7;           // of the expected gain: the derivatives are still good
constexpr double kSlow = 0.02;          // least gain of a first step, of the cost
constexpr double kLongestStep = 1.5;    // of the spread of an unknown

// Replace the values of ticks without a sample by straight lines.
void interpolate(const RecordedMotion& motion, Eigen::Index first, Eigen::MatrixXd& rows) {
  Eigen::Index last = -1;
  for (Eigen::Index k = 0; k < rows.cols(); ++k) {
    if (motion.isSample[static_cast<std::size_t>(first + k)] == 0) continue;
    for (Eigen::Index i = last + 1; i < k; ++i) {
      const double share = last < 0 ? 1.0 : static_cast<double>(i - last) / static_cast<double>(k - last);
      rows.col(i) = last < 0 ? Eigen::VectorXd(rows.col(k))
                             : Eigen::VectorXd((1.0 - share) * rows.col(last) + share * rows.col(k));
    }
    last = k;
  }
  for (Eigen::Index i = last + 1; i < rows.cols() && last >= 0; ++i) rows.col(i) = rows.col(last);
}

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

Fit::Fit(DeviceModel reference, std::vector<Unknown> unknowns, const std::vector<RecordedMotion>& motions, int threads)
    : reference_(std::move(reference)), unknowns_(std::move(unknowns)), motions_(motions), threads_(threads) {
  x = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(unknowns_.size()));
  isFixed.assign(unknowns_.size(), 0);
  observer_ = coarse_ = observerFor(reference_, motions.front().period);
  const JointVector step = makeMechanism(reference_.device)->limits().encoderStep;
  floor_ = kFloor / 12.0 * step.array().square();
  use(0.0, std::numeric_limits<double>::infinity());
}

int Fit::find(const std::string& key) const noexcept {
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    if (unknowns_[i].key == key) return static_cast<int>(i);
  return -1;
}

void Fit::use(double begin, double end) {
  pieces_.clear();
  slopes_.clear();
  baseAt_.resize(0);
  double passed = 0.0;  // s, at the beginning of a motion
  for (const RecordedMotion& motion : motions_) {
    const auto tickAt = [&](double time) {
      return static_cast<Eigen::Index>(
          std::clamp((time - passed) / motion.period, 0.0, static_cast<double>(motion.ticks())));
    };
    const Eigen::Index start = tickAt(begin), first = start + static_cast<Eigen::Index>(kTransient / motion.period);
    const Eigen::Index count = tickAt(end) - first;
    passed += static_cast<double>(motion.ticks()) * motion.period;
    if (static_cast<double>(count) * motion.period < kShortestPiece) continue;
    const double bandwidth = kBandwidth / (static_cast<double>(count) * motion.period);
    pieces_.push_back({&motion, start, first, count, std::make_unique<Spectrum>(count, motion.period, bandwidth)});
  }
}

// Empty if no device has these numbers, for example a tensor that breaks the triangle inequality.
Fit::Residuals Fit::residuals(const Eigen::VectorXd& at, const Observer& observer, int& left) const {
  const DeviceModel model = modelAt(reference_, unknowns_, at);
  Residuals all;
  left = 0;
  try {
    for (const Piece& piece : pieces_) {
      const Simulated simulated =
          simulate(model, *piece.motion, observer, piece.start, piece.first - piece.start + piece.count);
      left += simulated.restarts;
      Eigen::MatrixXd rows =
          piece.motion->reading.middleCols(piece.first, piece.count) - simulated.reading.rightCols(piece.count);
      interpolate(*piece.motion, piece.first, rows);
      all.push_back(std::move(rows));
    }
  } catch (const ConfigurationError&) {
    return {};
  }
  return all;
}

void Fit::updateSlopes() {
  slopes_.assign(unknowns_.size(), {});
  int leftHere;
  const Residuals base = residuals(x, coarse_, leftHere);
  parallelFor(unknowns_.size(), threads_, [&](std::size_t i) {
    if (isFixed[i] != 0) return;
    for (const double step : {kStep, -kStep}) {  // backward at the limit of possible devices
      Eigen::VectorXd moved = x;
      moved[static_cast<Eigen::Index>(i)] += step;
      int left;
      const Residuals other = residuals(moved, coarse_, left);
      for (std::size_t p = 0; p < other.size(); ++p) slopes_[i].push_back(((base[p] - other[p]) / step).cast<float>());
      if (!other.empty()) return;
    }
    throw Error("the numbers of \"" + nameOf(reference_.device) + "\" are at the limit of possible devices");
  });
}

Fit::Powers Fit::powers(const Residuals& residuals, double corner) const {
  Powers all(pieces_.size());
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const Piece& piece = pieces_[p];
    const Spectrum& spectrum = *piece.spectrum;
    for (Eigen::Index joint = 0; joint < residuals[p].rows(); ++joint) {
      const bool isRelative = corner > 0.0;
      Eigen::VectorXd row = residuals[p].row(joint);
      if (isRelative) row = piece.motion->reading.row(joint).segment(piece.first, piece.count);
      if (isRelative) row.array() -= row.mean();
      Eigen::VectorXd power = spectrum.spread(spectrum.bands(spectrum.transform(row)).cwiseMax(floor_[joint]));
      if (isRelative) {
        const Eigen::ArrayXd share = kRelative * (1.0 + (spectrum.frequencies().array() / corner).square());
        power = share.square() * power.array() + floor_[joint] / kFloor;
      }
      all[p].push_back(std::move(power));
    }
  }
  return all;
}

double Fit::priorCost(const Eigen::VectorXd& at) const {
  double sum = 0.0;
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    sum += 0.5 * std::pow(at[static_cast<Eigen::Index>(i)] / unknowns_[i].spread, 2);
  return sum;
}

double Fit::cost(const Residuals& residuals, const Powers& powers) const {
  double sum = 0.0;
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const Spectrum& spectrum = *pieces_[p].spectrum;
    for (Eigen::Index joint = 0; joint < residuals[p].rows(); ++joint) {
      const Eigen::VectorXd square = spectrum.transform(residuals[p].row(joint)).cwiseAbs2();
      const Eigen::VectorXd& power = powers[p][static_cast<std::size_t>(joint)];
      sum += 0.5 * spectrum.samples() * spectrum.mean(square.cwiseQuotient(power));
    }
  }
  return sum;
}

double Fit::misfit() {
  if (baseAt_.size() != x.size() || baseAt_ != x) {
    base_ = residuals(x, observer_, restarts);
    baseAt_ = x;
  }
  const Powers power = powers(base_, 0.0);
  double sum = cost(base_, power) + priorCost(x);
  for (std::size_t p = 0; p < pieces_.size(); ++p)
    for (const Eigen::VectorXd& row : power[p])
      sum += 0.5 * pieces_[p].spectrum->samples() * pieces_[p].spectrum->mean(row.array().log());
  return sum;
}

void Fit::normalEquations(const Residuals& residuals, const Powers& powers, Eigen::MatrixXd& A,
                          Eigen::VectorXd& b) const {
  std::vector<Eigen::Index> free;
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    if (isFixed[i] == 0) free.push_back(static_cast<Eigen::Index>(i));
  const auto count = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count + 1);
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const Spectrum& spectrum = *pieces_[p].spectrum;
    for (Eigen::Index joint = 0; joint < residuals[p].rows(); ++joint) {
      const Eigen::VectorXd weight = powers[p][static_cast<std::size_t>(joint)].cwiseSqrt().cwiseInverse();
      Eigen::MatrixXd rows(2 * weight.size(), count + 1);  // real and imaginary parts
      for (Eigen::Index i = 0; i <= count; ++i) {
        const Eigen::VectorXd signal =
            i == count ? Eigen::VectorXd(residuals[p].row(joint))
                       : Eigen::VectorXd(slopes_[static_cast<std::size_t>(free[static_cast<std::size_t>(i)])][p]
                                             .row(joint)
                                             .cast<double>());
        const Eigen::VectorXcd white = spectrum.transform(signal).cwiseProduct(weight);
        rows.col(i).head(weight.size()) = white.real();
        rows.col(i).tail(weight.size()) = white.imag();
      }
      // The mean over all frequencies: twice the positive ones. Zero and half of the sample rate hardly matter.
      const double scale = spectrum.samples() / static_cast<double>(weight.size());
      sum += scale * rows.leftCols(count).transpose() * rows;
    }
  }
  A = Eigen::MatrixXd::Zero(x.size(), x.size());
  b = Eigen::VectorXd::Zero(x.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    b[free[static_cast<std::size_t>(i)]] = sum(i, count);
    for (Eigen::Index k = 0; k < count; ++k)
      A(free[static_cast<std::size_t>(i)], free[static_cast<std::size_t>(k)]) = sum(i, k);
  }
}

// An unknown at its bound stays there if it would leave.
bool Fit::isHeld(std::size_t i, const Eigen::VectorXd& b) const {
  const auto k = static_cast<Eigen::Index>(i);
  return isFixed[i] != 0 || (x[k] <= unknowns_[i].least() && b[k] <= 0.0);
}

// An unknown that would pass its bound stops there, and the others are solved again.
Eigen::VectorXd Fit::stepOf(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double damping) const {
  Eigen::VectorXd held = Eigen::VectorXd::Constant(x.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    if (isHeld(i, b)) held[static_cast<Eigen::Index>(i)] = 0.0;
  Eigen::VectorXd step;
  for (int again = 0; again < 8; ++again) {
    Eigen::MatrixXd left = A;
    left.diagonal() *= 1.0 + damping;
    Eigen::VectorXd right = b;
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      if (std::isnan(held[k])) continue;
      right -= held[k] * A.col(k);
      left.row(k).setZero();
      left.col(k).setZero();
      left(k, k) = 1.0;
    }
    for (Eigen::Index k = 0; k < x.size(); ++k)
      if (!std::isnan(held[k])) right[k] = held[k];
    step = left.ldlt().solve(right);
    bool isInside = true;
    for (std::size_t i = 0; i < unknowns_.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      if (step[k] >= unknowns_[i].least() - x[k]) continue;
      held[k] = unknowns_[i].least() - x[k];
      isInside = false;
    }
    if (isInside) break;
  }
  double longest = 1.0;
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    longest = std::max(longest, std::abs(step[static_cast<Eigen::Index>(i)]) / (kLongestStep * unknowns_[i].spread));
  step /= longest;
  for (std::size_t i = 0; i < unknowns_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    step[k] = std::max(step[k], unknowns_[i].least() - x[k]);
  }
  return step;
}

void Fit::improve(int steps, double corner, bool keepsSlopes) {
  bool isOld = true;
  for (int taken = 0; taken < steps; ++taken) {
    (void)misfit();  // updates base_
    const bool isFresh = slopes_.empty() || (isOld && !keepsSlopes);
    if (isFresh) updateSlopes();
    isOld = false;
    const Powers power = powers(base_, corner);
    Eigen::MatrixXd A;
    Eigen::VectorXd b;
    normalEquations(base_, power, A, b);
    const Eigen::MatrixXd prior = priorInformation();
    A += prior;
    b -= prior * x;
    const double before = cost(base_, power) + priorCost(x);
    Eigen::VectorXd step;
    double gain = 0.0;
    for (double damping = 0.0; damping < 200.0 && !(gain > 0.0); damping = std::max(0.01, 10.0 * damping)) {
      step = stepOf(A, b, damping);
      const Eigen::VectorXd next = x + step;
      int left = 0;
      Residuals there = residuals(next, observer_, left);
      if (there.empty()) continue;
      gain = before - cost(there, power) - priorCost(next);
      if (!(gain > 0.0)) continue;
      x = baseAt_ = next;
      base_ = std::move(there);
      restarts = left;
    }
    const double expected = step.dot(b - 0.5 * A * step);
    isOld = gain < kGood * expected;
    if (expected < std::max(kConverged, corner > 0.0 ? kSlow * before : 0.0) ||
        (!(gain > 0.0) && (isFresh || keepsSlopes)))
      return;
  }
}

Eigen::MatrixXd Fit::priorInformation() const {
  Eigen::VectorXd diagonal(x.size());
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    diagonal[static_cast<Eigen::Index>(i)] = 1.0 / (unknowns_[i].spread * unknowns_[i].spread);
  return diagonal.asDiagonal();
}

std::vector<Fit::Block> Fit::blocks(const Powers& powers) const {
  std::vector<Block> all;
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const Spectrum& spectrum = *pieces_[p].spectrum;
    const auto length = static_cast<Eigen::Index>(kBlock / pieces_[p].motion->period);
    const auto first = all.size(), count = static_cast<std::size_t>(pieces_[p].count / length);
    all.resize(first + count, {Eigen::MatrixXd::Zero(x.size(), x.size()), Eigen::VectorXd::Zero(x.size())});
    for (Eigen::Index joint = 0; joint < base_[p].rows(); ++joint) {
      const Eigen::VectorXd weight = powers[p][static_cast<std::size_t>(joint)].cwiseSqrt().cwiseInverse();
      const auto white = [&](const Eigen::VectorXd& signal) {
        return spectrum.inverse(spectrum.transform(signal).cwiseProduct(weight));
      };
      const Eigen::VectorXd e = white(base_[p].row(joint));
      Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(e.size(), x.size());
      for (Eigen::Index i = 0; i < x.size(); ++i)
        if (isFixed[static_cast<std::size_t>(i)] == 0)
          slopes.col(i) = white(slopes_[static_cast<std::size_t>(i)][p].row(joint).cast<double>());
      for (std::size_t k = 0; k < count; ++k) {
        const auto part = slopes.middleRows(static_cast<Eigen::Index>(k) * length, length);
        all[first + k].information += part.transpose() * part;
        all[first + k].score += part.transpose() * e.segment(static_cast<Eigen::Index>(k) * length, length);
      }
    }
  }
  return all;
}

Eigen::MatrixXd Fit::covariance() {
  (void)misfit();
  if (slopes_.empty()) updateSlopes();
  const Powers power = powers(base_, 0.0);
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  normalEquations(base_, power, A, b);
  const Eigen::MatrixXd prior = priorInformation();
  A += prior;
  const auto solve = [this](const Eigen::MatrixXd& left, const Eigen::MatrixXd& right) {
    Eigen::MatrixXd free = left;
    for (std::size_t i = 0; i < isFixed.size(); ++i)
      if (isFixed[i] != 0) free(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) = 1e30;
    return Eigen::MatrixXd(free.ldlt().solve(right));
  };
  const std::vector<Block> blocks = this->blocks(power);
  const auto count = static_cast<double>(blocks.size());
  Eigen::MatrixXd jackknife = Eigen::MatrixXd::Zero(x.size(), x.size());
  for (const Block& block : blocks) {
    const Eigen::VectorXd change = solve(A - block.information, block.score);
    jackknife += (count - 1.0) / count * change * change.transpose();
  }
  jackknife *= std::pow(1.0 + (kNormal * kNormal + 1.0) / (4.0 * std::max(1.0, count - 1.0)), 2);
  const Eigen::MatrixXd inverse = solve(A, Eigen::MatrixXd::Identity(x.size(), x.size()));
  jackknife += inverse * prior * inverse;
  // Blocks do not show errors that are slower than they are, such as that of a constant force: the fit takes these from
  // the residual. The spectrum does show them, so that the larger variance counts.
  const Eigen::VectorXd scale = (inverse.diagonal().array() / jackknife.diagonal().array().max(1e-300)).max(1.0).sqrt();
  return scale.asDiagonal() * jackknife * scale.asDiagonal();
}

void Fit::refine() {
  const double steps = std::max<double>(coarse_.substeps, period() / kFineStep);
  const Eigen::VectorXd allowed = kIntegration * (floor_ / kFloor).cwiseSqrt();
  for (int parts = kFineParts, isFine = 0; isFine == 0 && parts <= kMostParts; parts *= 2) {
    (void)misfit();
    const Residuals before = base_;
    observer_.parts = parts;
    observer_.substeps = parts * std::max(2, static_cast<int>(std::ceil(steps / parts - 1e-9)));
    forget();
    (void)misfit();
    isFine = 1;
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      const double samples = static_cast<double>(pieces_[p].count);
      const Eigen::VectorXd change = ((base_[p] - before[p]).rowwise().squaredNorm() / samples).cwiseSqrt();
      // The error is of second order in the length of a part, so that it is a third of the change, or less.
      if (((change / 3.0).array() > allowed.array()).any()) isFine = 0;
    }
  }
}

void Fit::add(const std::vector<Unknown>& unknowns) {
  unknowns_.insert(unknowns_.end(), unknowns.begin(), unknowns.end());
  const Eigen::Index before = x.size();
  x.conservativeResize(static_cast<Eigen::Index>(unknowns_.size()));
  x.tail(x.size() - before).setZero();
  isFixed.resize(unknowns_.size(), 0);
  slopes_.clear();
  baseAt_.resize(0);
}

// Torque of a residual e at each frequency: M (e'' + 2 w e' + w^2 e), with inertia M and observer w.
Eigen::VectorXd Fit::torquePerReading(const Spectrum& spectrum, Eigen::Index joint) const {
  const double rate = 2.0 * M_PI * kObserverRate, inertia = observer_.stiffness[joint] / (rate * rate);
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
  traces.frequency = spectrum.bands(frequencies.cwiseSqrt().cast<std::complex<double>>());
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
    traces.residual.row(joint) = (density * spectrum.bands(residual)).cwiseSqrt();
  }
  return traces;
}

}  // namespace enamel::identify
