#include "identify/fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "enamel/study/parallel.hpp"

namespace enamel::identify {
namespace {

constexpr double kTransient = 0.5;      // s, skipped at the beginning of each piece
constexpr double kHeld = 1.0;           // s, skipped before: friction holds a device that begins to move
constexpr double kShortestPiece = 1.0;  // s
constexpr double kStep = 1e-3;          // of x, for the change of a model
constexpr double kRelative = 0.05;      // residual that counts as noise, of the reading's power: far from the device
constexpr double kFloor = 0.3;          // of the power of rounding
constexpr double kBlock = 1.0;          // s, long against the observer's memory of 0.1 s
constexpr double kBandwidth = 16.0;     // independent frequencies in the narrowest band
constexpr double kIntegration =
    0.01;  // error of the fine simulation before extrapolation, of the deviation of rounding
constexpr int kFineParts = 8, kMostParts = 128;  // of a tick
constexpr double kConverged = 0.01;              // expected change of the log likelihood in the next step
constexpr double kGood = 0.7;                    // of the expected gain: the derivatives are still good
constexpr double kSlow = 0.02;                   // least gain of a first step, of the cost
constexpr double kLongestStep = 1.5;             // of the spread of an unknown

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

}  // namespace

Fit::Fit(DeviceModel reference, std::vector<Unknown> unknowns, const std::vector<RecordedMotion>& motions,
         int mostThreads)
    : threads(mostThreads), reference_(std::move(reference)), unknowns_(std::move(unknowns)), motions_(motions) {
  x = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(unknowns_.size()));
  isFixed.assign(unknowns_.size(), 0);
  observer_ = observerFor(reference_, motions.front().period);
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
  correction_.clear();
  baseAt_.resize(0);
  pathsAt_.resize(0);
  const JointVector offset = deviceOf(model()).offset;
  double passed = 0.0;  // s, at the beginning of a motion
  for (const RecordedMotion& motion : motions_) {
    const auto tickAt = [&](double time) {
      return static_cast<Eigen::Index>(
          std::clamp((time - passed) / motion.period, 0.0, static_cast<double>(motion.ticks())));
    };
    const Eigen::Index start = tickAt(begin);
    const double skipped = kTransient + (start == 0 ? kHeld : 0.0);
    const Eigen::Index first = start + static_cast<Eigen::Index>(skipped / motion.period);
    const Eigen::Index count = tickAt(end) - first;
    passed += static_cast<double>(motion.ticks()) * motion.period;
    if (static_cast<double>(count) * motion.period < kShortestPiece) continue;
    const double bandwidth = kBandwidth / (static_cast<double>(count) * motion.period);
    pieces_.push_back({&motion, start, first, count,
                       motion.reading.middleCols(start, first - start + count).colwise() - Eigen::VectorXd(offset),
                       std::make_shared<Spectrum>(count, motion.period, bandwidth)});
  }
  require(!pieces_.empty(), "the recordings have no motion of " + formatNumber(kTransient + kShortestPiece) +
                                " s after the first " + formatNumber(begin) + " s: record longer");
}

// Throws ConfigurationError if no device has these numbers, for example a tensor that breaks the triangle inequality.
std::vector<PathDynamics> Fit::computePaths(const DeviceModel& model, double period, int interval) const {
  const std::shared_ptr<const Mechanism> bare = deviceOf(model).mechanism,
                                         weighted = model.weight > 0.0 ? weightedMechanism(model) : bare;
  std::vector<PathDynamics> paths;
  for (const Piece& piece : pieces_)
    paths.push_back(
        dynamicsAlong(piece.motion->weight > 0.0 ? *weighted : *bare, piece.route, period, interval, threads));
  return paths;
}

// They are kept while only numbers of the drives change.
const std::vector<PathDynamics>& Fit::pathsAt(const Eigen::VectorXd& at, const DeviceModel& model) {
  bool isSame = pathsAt_.size() > 0;
  for (std::size_t i = 0; i < unknowns_.size() && isSame; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    isSame = unknowns_[i].isOfDrives || at[k] == pathsAt_[k];
  }
  if (isSame) return paths_;
  pathsAt_.resize(0);
  paths_ = computePaths(model, period(), observer_.interval);
  pathsAt_ = at;
  return paths_;
}

std::vector<Simulated> Fit::simulateAll(const DeviceModel& model, const Observer& observer,
                                        const std::vector<PathDynamics>& paths) const {
  std::vector<Simulated> all(pieces_.size());
  parallelFor(pieces_.size(), threads, [&](std::size_t p) {
    all[p] = simulate(model, paths[p], *pieces_[p].motion, observer, pieces_[p].start, pieces_[p].route.cols());
  });
  return all;
}

Fit::Residuals Fit::residuals(const std::vector<Simulated>& simulated) const {
  Residuals all;
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const Piece& piece = pieces_[p];
    all.emplace_back(piece.motion->reading.middleCols(piece.first, piece.count) -
                     simulated[p].reading.rightCols(piece.count));
    interpolate(*piece.motion, piece.first, all.back());
  }
  return all;
}

// Residuals with the correction of refine(). Empty if no device has these numbers.
Fit::Residuals Fit::corrected(const Eigen::VectorXd& at, int& left) {
  const DeviceModel model = modelAt(reference_, unknowns_, at);
  std::vector<Simulated> simulated;
  try {
    simulated = simulateAll(model, observer_, pathsAt(at, model));
  } catch (const ConfigurationError&) {
    return {};
  }
  left = 0;
  for (const Simulated& each : simulated) left += each.restarts;
  Residuals all = residuals(simulated);
  for (std::size_t p = 0; p < correction_.size(); ++p) all[p] += correction_[p];
  return all;
}

// The change with an unknown: on both sides of x if both are possible devices, and from x if the mechanism changes.
ModelChange Fit::changeOf(std::size_t i) const {
  ModelChange change{model(), model(), 0.0};
  for (const double step : {kStep, -kStep}) {
    Eigen::VectorXd moved = x;
    moved[static_cast<Eigen::Index>(i)] += step;
    if (moved[static_cast<Eigen::Index>(i)] < unknowns_[i].least() || (!unknowns_[i].isOfDrives && change.width > 0.0))
      continue;
    DeviceModel model = modelAt(reference_, unknowns_, moved);
    try {
      (void)deviceOf(model);
    } catch (const ConfigurationError&) {
      continue;
    }
    const bool isBefore = step < 0.0 && unknowns_[i].isOfDrives;
    (isBefore ? change.before : change.after) = std::move(model);
    change.width += isBefore ? -step : step;
  }
  if (change.width == 0.0)
    throw Error("the numbers of \"" + nameOf(reference_.device) + "\" are at the limit of possible devices");
  return change;
}

void Fit::updateSlopes() {
  const DeviceModel here = model();
  const std::vector<PathDynamics>& paths = pathsAt(x, here);
  slopes_.assign(unknowns_.size(), {});
  std::vector<std::size_t> free;
  std::vector<ModelChange> changes;
  std::vector<std::vector<PathDynamics>> slopes;  // of the paths; they are small, so that half the knots do
  const std::vector<PathDynamics> straight = computePaths(here, 0.0, 2 * observer_.interval);
  for (std::size_t i = 0; i < unknowns_.size(); ++i) {
    if (isFixed[i] != 0) continue;
    free.push_back(i);
    changes.push_back(changeOf(i));
    slopes.emplace_back();
    slopes_[i].resize(pieces_.size());
    if (unknowns_[i].isOfDrives) continue;
    slopes.back() = computePaths(changes.back().after, 0.0, 2 * observer_.interval);
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      slopes.back()[p].knots = (slopes.back()[p].knots - straight[p].knots) / changes.back().width;
  }
  const std::size_t groups = (free.size() + kLanes - 1) / kLanes;
  parallelFor(groups * pieces_.size(), threads, [&](std::size_t task) {
    const std::size_t p = task % pieces_.size(), begin = task / pieces_.size() * kLanes;
    const std::size_t end = std::min(free.size(), begin + kLanes);
    const Piece& piece = pieces_[p];
    std::vector<ModelChange> group(changes.begin() + static_cast<std::ptrdiff_t>(begin),
                                   changes.begin() + static_cast<std::ptrdiff_t>(end));
    for (std::size_t k = begin; k < end; ++k)
      if (!slopes[k].empty()) group[k - begin].path = &slopes[k][p];
    Simulated simulated = simulate(here, paths[p], *piece.motion, observer_, piece.start, piece.route.cols(), group);
    for (std::size_t k = begin; k < end; ++k) {
      Eigen::MatrixXd change = simulated.slopes[k - begin].rightCols(piece.count);
      interpolate(*piece.motion, piece.first, change);
      Eigen::MatrixXcf& slope = slopes_[free[k]][p];
      slope.resize(piece.spectrum->frequencies().size(), change.rows());
      for (Eigen::Index joint = 0; joint < slope.cols(); ++joint)
        slope.col(joint) = piece.spectrum->transform(change.row(joint)).cast<std::complex<float>>();
    }
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
      Eigen::VectorXd power =
          spectrum.spread(spectrum.bands(spectrum.transform(row).cwiseAbs2()).cwiseMax(floor_[joint]));
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
    base_ = corrected(x, restarts);
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
  std::vector<std::size_t> free;
  for (std::size_t i = 0; i < unknowns_.size(); ++i)
    if (isFixed[i] == 0) free.push_back(i);
  const auto count = static_cast<Eigen::Index>(free.size());
  const auto joints = static_cast<std::size_t>(residuals.front().rows());
  std::vector<Eigen::MatrixXd> sums(pieces_.size() * joints);
  parallelFor(sums.size(), threads, [&](std::size_t task) {
    const std::size_t p = task / joints;
    const auto joint = static_cast<Eigen::Index>(task % joints);
    const Spectrum& spectrum = *pieces_[p].spectrum;
    Eigen::VectorXd weight = powers[p][task % joints].cwiseSqrt().cwiseInverse();
    const Eigen::Index last = weight.size() - 1;
    for (const Eigen::Index i : {Eigen::Index{0}, last})
      weight[i] *= M_SQRT1_2;                            // no negative frequency has this power
    Eigen::MatrixXd rows(2 * weight.size(), count + 1);  // real and imaginary parts
    for (Eigen::Index i = 0; i <= count; ++i) {
      const Eigen::VectorXcd signal =
          i == count ? spectrum.transform(residuals[p].row(joint)) : slope(free[static_cast<std::size_t>(i)], p, joint);
      const Eigen::VectorXcd white = signal.cwiseProduct(weight);
      rows.col(i).head(weight.size()) = white.real();
      rows.col(i).tail(weight.size()) = white.imag();
    }
    const double scale = spectrum.samples() / static_cast<double>(last);
    sums[task] = scale * rows.leftCols(count).transpose() * rows;
  });
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(count, count + 1);
  for (const Eigen::MatrixXd& part : sums) sum += part;
  A = Eigen::MatrixXd::Zero(x.size(), x.size());
  b = Eigen::VectorXd::Zero(x.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto row = static_cast<Eigen::Index>(free[static_cast<std::size_t>(i)]);
    b[row] = sum(i, count);
    for (Eigen::Index k = 0; k < count; ++k)
      A(row, static_cast<Eigen::Index>(free[static_cast<std::size_t>(k)])) = sum(i, k);
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
      Residuals there = corrected(next, left);
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
      const auto white = [&](const Eigen::VectorXcd& signal) { return spectrum.inverse(signal.cwiseProduct(weight)); };
      const Eigen::VectorXd e = white(spectrum.transform(base_[p].row(joint)));
      Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(e.size(), x.size());
      for (Eigen::Index i = 0; i < x.size(); ++i)
        if (isFixed[static_cast<std::size_t>(i)] == 0)
          slopes.col(i) = white(slope(static_cast<std::size_t>(i), p, joint));
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

// The error is of second order in the length of a part and of fourth order in the distance of knots. When both are
// halved, at most a third of the change remains.
void Fit::refine() {
  const Eigen::VectorXd allowed = kIntegration * (floor_ / kFloor).cwiseSqrt();
  const DeviceModel here = model();
  const std::vector<Simulated> rough = simulateAll(here, observer_, pathsAt(x, here));
  const Residuals gap = residuals(rough);
  for (std::size_t p = 0; p < pieces_.size(); ++p) {  // recorded rotors, simulated stretch of cables
    pieces_[p].route = rough[p].joints;
    pieces_[p].route.rightCols(pieces_[p].count) += gap[p];
  }
  pathsAt_.resize(0);
  const Residuals coarse = residuals(simulateAll(here, observer_, pathsAt(x, here)));
  Residuals before;
  bool isFine = false;
  Observer fine = observer_;
  for (fine.parts = kFineParts; !isFine && fine.parts <= kMostParts; fine.parts *= 2) {
    fine.substeps = 2 * fine.parts;
    fine.interval = std::max(1, observer_.interval * kFineParts / (2 * fine.parts));
    Residuals now = residuals(simulateAll(here, fine, computePaths(here, period(), fine.interval)));
    isFine = !before.empty();
    for (std::size_t p = 0; p < before.size(); ++p) {
      const Eigen::MatrixXd error = (now[p] - before[p]) / 3.0;
      const Eigen::ArrayXd size = (error.rowwise().squaredNorm() / static_cast<double>(pieces_[p].count)).cwiseSqrt();
      if ((size > allowed.array()).any()) isFine = false;
      before[p] = now[p] + error - coarse[p];
    }
    correction_ = std::exchange(before, std::move(now));
  }
  forget();
}

void Fit::add(const std::vector<Unknown>& unknowns) {
  unknowns_.insert(unknowns_.end(), unknowns.begin(), unknowns.end());
  const Eigen::Index before = x.size();
  x.conservativeResize(static_cast<Eigen::Index>(unknowns_.size()));
  x.tail(x.size() - before).setZero();
  isFixed.resize(unknowns_.size(), 0);
  slopes_.clear();
  baseAt_.resize(0);
  pathsAt_.resize(0);
}

}  // namespace enamel::identify
