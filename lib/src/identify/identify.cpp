#include "enamel/identify/identify.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/message.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/study/parallel.hpp"
#include "identify/cogging.hpp"
#include "identify/diagnosis.hpp"
#include "identify/fit.hpp"
#include "identify/wiring.hpp"

namespace enamel {
namespace {

using namespace identify;

constexpr double kFirstDelay = 1.5;                        // ticks, where the search begins
constexpr double kCorners[] = {20.0, 60.0, 150.0, 400.0};  // Hz, of the first steps: slow motion first
constexpr double kFirstData = 4.0;                         // s, for them
constexpr double kCoarseData = 8.0;                        // s, for the first steps
constexpr double kMostData = 40.0;                         // s, for the last ones
constexpr double kAlternation = 10.0;                      // s, of a motion without and with a weight
constexpr double kShare = 0.8;                             // of the data for the fit; the rest tests it
constexpr double kLeastExplained = 0.9;                    // of the variance of each torque
constexpr double kCertain = 30.0;                          // difference of the log likelihood to the second best delay
constexpr double kLongestLag = 2e-3;                       // s, of slideDelay()
constexpr double kSlide = 0.15;                            // ticks, its steps
constexpr int kMostSpread = 3;                             // ticks, of a random delay
constexpr double kCoggingEvidence = 30.0;                  // gain of the log likelihood that shows cogging
constexpr double kSeen = 0.3;  // largest deviation of a seen number, of the one before the recording

// A delay and how well it explains the recording.
struct Candidate {
  int low, high;
  double misfit;
  Eigen::VectorXd x;
};

Eigen::VectorXd startOf(const Fit& fit, double scale) {
  Eigen::VectorXd x = fit.x;
  for (std::size_t i = 0; i < fit.unknowns().size(); ++i)
    if (fit.unknowns()[i].unit.rfind("kg", 0) == 0 && fit.unknowns()[i].key != kWeight)
      x[static_cast<Eigen::Index>(i)] = -std::log(scale);
  const Unknown& delay = fit.unknowns()[static_cast<std::size_t>(fit.find("loop delay"))];
  x[fit.find("loop delay")] = kFirstDelay / delay.scale;
  return x;
}

// Fit with a whole delay, from the place where delay and lag are free. Derivatives are those of the last step there.
Candidate tryDelay(Fit fit, int low, int high) {
  const int delayAt = fit.find("loop delay"), lagAt = fit.find("motor lag");
  const Unknown& delay = fit.unknowns()[static_cast<std::size_t>(delayAt)];
  const Unknown& lag = fit.unknowns()[static_cast<std::size_t>(lagAt)];
  const double period = fit.period();
  const double whole = delay.at(fit.x[delayAt]) * period + lag.at(fit.x[lagAt]);  // s
  fit.threads = 1;                                                                // candidates run in parallel
  fit.reference().spread = high - low;
  fit.x[delayAt] = (low - delay.reference) / delay.scale;
  const double rest = std::max(0.0, whole - 0.5 * (low + high) * period);
  fit.x[lagAt] = (rest - lag.reference) / lag.scale;
  fit.forget();
  fit.improve(4, 0.0, true);
  return {low, high, fit.misfit(), fit.x};
}

// Delay and lag have nearly the same effect. Move along their constant sum to the place that fits best. Returns whether
// there is a better one.
bool slideDelay(Fit& fit) {
  const int delayAt = fit.find("loop delay"), lagAt = fit.find("motor lag");
  const Unknown& delay = fit.unknowns()[static_cast<std::size_t>(delayAt)];
  const Unknown& lag = fit.unknowns()[static_cast<std::size_t>(lagAt)];
  const double whole = delay.at(fit.x[delayAt]) + lag.at(fit.x[lagAt]) / fit.period();  // ticks
  const Eigen::VectorXd here = fit.x;
  Eigen::VectorXd best = here;
  double least = fit.misfit();
  for (double rest = 0.1; rest < std::min(whole, kLongestLag / fit.period()); rest += kSlide) {
    fit.x[delayAt] = (whole - rest - delay.reference) / delay.scale;
    fit.x[lagAt] = (rest * fit.period() - lag.reference) / lag.scale;
    if (const double misfit = fit.misfit(); misfit < least) {
      least = misfit;
      best = fit.x;
    }
  }
  fit.x = best;
  return best != here;
}

DelayEstimate chooseDelay(Fit& fit) {
  const int delayAt = fit.find("loop delay"), lagAt = fit.find("motor lag");
  const double value = fit.unknowns()[static_cast<std::size_t>(delayAt)].at(fit.x[delayAt]);
  const double whole = value + fit.unknowns()[static_cast<std::size_t>(lagAt)].at(fit.x[lagAt]) / fit.period();
  fit.isFixed[static_cast<std::size_t>(delayAt)] = 1;
  std::vector<Candidate> all;
  for (int spread = 0; spread <= kMostSpread; ++spread) {
    const double margin = spread > 0 ? 0.0 : 1.0;
    for (int low = 0; low + 0.5 * spread <= whole + 0.3 + margin; ++low)
      if (low + 0.5 * spread >= value - 0.8 - margin) all.push_back({low, low + spread, 0.0, {}});
  }
  parallelFor(all.size(), fit.threads, [&](std::size_t i) { all[i] = tryDelay(fit, all[i].low, all[i].high); });
  std::sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) { return a.misfit < b.misfit; });
  fit.reference().spread = all[0].high - all[0].low;
  fit.x = all[0].x;
  fit.forget();
  DelayEstimate result{all[0].low, all[0].high, true, std::numeric_limits<double>::infinity(), ""};
  if (all.size() > 1) {
    result.evidence = all[1].misfit - all[0].misfit;
    result.isCertain = result.evidence > kCertain;
    result.second = toText({all[1].low, all[1].high});
  }
  return result;
}

void addCogging(Fit& fit) {
  const CoggingSearch found = findCogging(fit);
  if (found.evidence < kCoggingEvidence) return;
  fit.reference().drive.periods = found.periods;
  const std::vector<Unknown> unknowns = coggingUnknowns(fit.reference(), fit.residualReading());
  const Eigen::Index first = fit.x.size();
  fit.add(unknowns);
  for (Eigen::Index k = 0; k < found.parts.size(); ++k)
    fit.x[first + k] = found.parts(k / 2, k % 2) / unknowns[static_cast<std::size_t>(k)].scale;
  fit.improve(8);
}

Estimate estimateOf(const Unknown& unknown, double x, double deviation, double before) {
  Estimate estimate{unknown.key, unknown.unit, before, unknown.at(x)};
  estimate.low = unknown.at(std::max(x - kNormal * deviation, unknown.least()));
  estimate.high = unknown.at(x + kNormal * deviation);
  estimate.isInFile = unknown.isInFile;
  estimate.isSeen = deviation < kSeen * unknown.spread;
  return estimate;
}

// Replace the ratios before normalisation by torqueRatios(), with the deviations of linear propagation.
void addRatios(const Fit& fit, const Eigen::MatrixXd& covariance, std::vector<Estimate>& estimates) {
  const JointVector value = torqueRatios(fit.model());
  Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(value.size(), fit.x.size());
  constexpr double kStep = 1e-4;
  for (Eigen::Index i = 0; i < fit.x.size(); ++i) {
    if (fit.unknowns()[static_cast<std::size_t>(i)].key.rfind("torque ratio", 0) != 0) continue;
    const Eigen::VectorXd moved = fit.x + kStep * Eigen::VectorXd::Unit(fit.x.size(), i);
    slopes.col(i) = (torqueRatios(modelAt(fit.model(), fit.unknowns(), moved)) - value) / kStep;
  }
  const Eigen::VectorXd deviation = (slopes * covariance * slopes.transpose()).diagonal().cwiseSqrt();
  for (Eigen::Index i = 0; i < value.size(); ++i) {
    const double d = kNormal * deviation[i];
    const std::string name = "torque ratio of " + jointName(fit.model().device, static_cast<int>(i));
    estimates.push_back({name, "", 1.0, value[i], value[i] - d, value[i] + d, false, d < 0.1});
  }
}

// A known weight shows the scale of all forces: it seems heavier if the motors are weaker than commanded.
void addScale(const Fit& fit, const Eigen::MatrixXd& covariance, double weight, std::vector<Estimate>& estimates) {
  const int at = fit.find(kWeight);
  if (at < 0) return;
  const Unknown& unknown = fit.unknowns()[static_cast<std::size_t>(at)];
  const double deviation = std::sqrt(covariance(at, at));
  const auto scaleAt = [&](double x) { return weight / unknown.at(x); };
  estimates.push_back({"torque of all motors over the command", "", 1.0, scaleAt(fit.x[at]),
                       scaleAt(fit.x[at] + kNormal * deviation), scaleAt(fit.x[at] - kNormal * deviation), false,
                       deviation < kSeen * unknown.spread});
}

// Amplitude of cogging in each joint, from its two parts.
void addCoggingAmplitudes(const Fit& fit, const Eigen::MatrixXd& covariance, std::vector<Estimate>& estimates) {
  const DeviceModel model = fit.model();
  for (int i = 0; i < model.sine.size(); ++i) {
    const std::string key = "cogging of " + jointName(model.device, i);
    const int at = fit.find(key);
    if (at < 0) return;
    const Unknown& part = fit.unknowns()[static_cast<std::size_t>(at)];
    const double amplitude = std::hypot(model.sine[i], model.cosine[i]);
    const Eigen::Vector2d slope(model.sine[i] / amplitude, model.cosine[i] / amplitude);
    const double deviation = part.scale * std::sqrt(slope.dot(covariance.block<2, 2>(at, at) * slope));
    estimates.push_back({key, part.unit, 0.0, amplitude, std::max(0.0, amplitude - kNormal * deviation),
                         amplitude + kNormal * deviation, false, deviation < kSeen * part.scale});
  }
}

void addEstimates(Fit& fit, const DeviceModel& before, Identification& result) {
  const Eigen::MatrixXd covariance = fit.covariance();
  DeviceModel file = before;
  for (std::size_t i = 0; i < fit.unknowns().size(); ++i) {
    const Unknown& unknown = fit.unknowns()[i];
    const auto k = static_cast<Eigen::Index>(i);
    if (unknown.key == "loop delay" || unknown.key.rfind("torque ratio", 0) == 0 ||
        unknown.key.rfind("cogging", 0) == 0 || unknown.key == kWeight)
      continue;
    result.estimates.push_back(estimateOf(unknown, fit.x[k], std::sqrt(covariance(k, k)), unknown.value(file)));
  }
  addRatios(fit, covariance, result.estimates);
  addScale(fit, covariance, before.weight, result.estimates);
  addCoggingAmplitudes(fit, covariance, result.estimates);
}

double durationOf(const std::vector<RecordedMotion>& motions) {
  double sum = 0.0;
  for (const RecordedMotion& motion : motions) sum += static_cast<double>(motion.ticks()) * motion.period;
  return sum;
}

// The weight of the motions that have one; 0 if none has.
double weightOf(const std::vector<RecordedMotion>& motions) {
  double weight = 0.0;
  int with = 0;
  for (const RecordedMotion& motion : motions) {
    require(motion.weight >= 0.0 && std::isfinite(motion.weight),
            "the attached weight is " + formatNumber(motion.weight) + " kg, must be at least 0 kg");
    if (motion.weight == 0.0) continue;
    require(with++ == 0 || motion.weight == weight, "the recordings have different weights");
    weight = motion.weight;
  }
  require(with == 0 || with < static_cast<int>(motions.size()),
          "all recordings have the weight attached: one without it is needed as well");
  return weight;
}

RecordedMotion part(const RecordedMotion& motion, Eigen::Index begin, Eigen::Index end) {
  return {motion.period,
          {motion.time.begin() + begin, motion.time.begin() + end},
          motion.command.middleCols(begin, end - begin),
          motion.reading.middleCols(begin, end - begin),
          {motion.isSample.begin() + begin, motion.isSample.begin() + end},
          motion.isLimited,
          motion.weight};
}

// Motions without and with the weight take turns of kAlternation, so that the fit and its test see both.
std::vector<RecordedMotion> inTurn(const std::vector<RecordedMotion>& motions) {
  std::vector<RecordedMotion> parts[2], all;  // without and with the weight
  for (const RecordedMotion& motion : motions) {
    const auto turn = static_cast<Eigen::Index>(kAlternation / motion.period);
    for (Eigen::Index begin = 0; begin < motion.ticks(); begin += turn) {
      const bool isLast = motion.ticks() - begin < 2 * turn;
      parts[motion.weight > 0.0 ? 1 : 0].push_back(part(motion, begin, isLast ? motion.ticks() : begin + turn));
      if (isLast) break;
    }
  }
  for (std::size_t i = 0; i < std::max(parts[0].size(), parts[1].size()); ++i)
    for (const auto& kind : parts)
      if (i < kind.size()) all.push_back(kind[i]);
  return all;
}

// `end` is the end of the data of the fit, s.
void addStatistics(Fit& fit, const std::vector<RecordedMotion>& motions, double end, Identification& result) {
  double lost = 0.0, ticks = 0.0;
  for (const RecordedMotion& motion : motions) {
    ticks += static_cast<double>(motion.ticks());
    lost += static_cast<double>(std::count(motion.isSample.begin(), motion.isSample.end(), 0));
  }
  result.lostSamples = lost / ticks;
  result.noise = fit.noise();
  fit.use(end, std::numeric_limits<double>::infinity());
  result.explained = fit.explained();
  result.traces = fit.traces();
  for (Eigen::Index i = 0; i < result.explained.size() && result.problems.empty(); ++i)
    if (!(result.explained[i] > kLeastExplained))
      result.problems.push_back("the result explains only " + formatNumber(std::round(100.0 * result.explained[i])) +
                                " % of the torque of " + jointName(result.device, static_cast<int>(i)) +
                                " in the last part of the recording: something else moved the tool, such as a hand");
  if (fit.restarts > 0)
    result.problems.push_back("the fitted device leaves its workspace: the recording and the device file do not fit");
}

// The device with the numbers of its drives that a file can have: one for all joints.
DeviceParameters withDrive(DeviceModel model) {
  Imperfections e = model.drive;
  e.coulombFriction = model.coulomb.mean();
  e.cogging = (model.sine.array().square() + model.cosine.array().square()).sqrt().mean();
  const double bandwidth = 1.0 / (2.0 * M_PI * model.lag);
  e.currentBandwidth = bandwidth <= kLargestBandwidth ? bandwidth : 0.0;
  if (auto* tau = std::get_if<TauParameters>(&model.device)) scaleLinks(model.links, *tau);
  if (auto* cartesian = std::get_if<CartesianParameters>(&model.device); cartesian != nullptr && cartesian->axes > 3)
    e.coulombFriction = e.cogging = 0.0;  // the file has one number for forces and moments
  imperfectionsOf(model.device) = e;
  return model.device;
}

}  // namespace

Identification identifyDevice(const std::vector<RecordedMotion>& recorded, const DeviceParameters& device,
                              const IdentifyOptions& options) {
  require(!recorded.empty(), "the recordings have no motion of " + formatNumber(kShortestMotion) +
                                 " s without a gap and with the enable switch on");
  for (const RecordedMotion& motion : recorded)
    require(motion.period == recorded[0].period, "the recordings have different periods");
  Identification result;
  result.device = device;
  DeviceModel file = modelOf(device);
  file.weight = weightOf(recorded);
  std::vector<RecordedMotion> parts;
  if (file.weight > 0.0) parts = inTurn(recorded);
  const std::vector<RecordedMotion>& motions = file.weight > 0.0 ? parts : recorded;
  const Wiring wiring = checkWiring(file, motions);
  result.problems = wiring.problems;
  if (!result.isUsable()) return result;
  Fit fit(file, unknownsOf(file), motions, options.threads > 0 ? options.threads : availableThreads());
  fit.x = startOf(fit, wiring.scale);
  fit.use(0.0, kFirstData);
  for (const double corner : kCorners) fit.improve(8, corner);
  fit.use(0.0, kCoarseData);
  fit.improve(8);
  for (int round = 0; round < 3 && slideDelay(fit); ++round) fit.improve(8);
  addCogging(fit);
  result.delay = chooseDelay(fit);
  const double end = std::min(kMostData, kShare * durationOf(motions));
  for (const double data : {kCoarseData, end}) {
    fit.use(0.0, data);
    fit.refine();
    fit.improve(8, 0.0, true);
  }
  addEstimates(fit, file, result);
  result.problems = diagnose(fit, result.delay.low);
  addStatistics(fit, motions, end, result);
  result.device = withDrive(fit.model());
  return result;
}

std::vector<Estimate> expectedPrecision(const Excitation& excitation, const DeviceParameters& device,
                                        const IdentifyOptions& options) {
  const std::shared_ptr<const Mechanism> mechanism = makeMechanism(device);
  VirtualDeviceSetup setup;
  setup.period = excitation.period;
  setup.encoders = {true, RateSource::difference, 100.0};
  const MakePlant makePlant = plantMaker(plantOf(device), device, {}, setup);
  VirtualDevice plant(makePlant ? makePlant(0) : std::make_unique<ClosedFormPlant>(*mechanism), setup);
  std::vector<RecordedTick> ticks;
  const auto nothing = [](double, const Pose&, const Vec6&) { return Vec6(Vec6::Zero()); };
  const auto each = [&ticks](std::uint64_t number, const Measurement& measurement, const HapticTick&,
                             const Command& command, Status) {
    RecordedTick tick;
    tick.number = number;
    tick.measurement = measurement;
    tick.command = command.effort;
    ticks.push_back(tick);
  };
  const GuardReason reason = runExcitation(excitation, *mechanism, plant, nothing, each);
  require(reason == GuardReason::none, std::string("the guard stops the simulated excitation: ") + toString(reason));
  const std::vector<RecordedMotion> motions = motionsOf(ticks, excitation.period, mechanism->joints());
  const DeviceModel model = modelOf(device);
  Fit fit(model, unknownsOf(model), motions, options.threads > 0 ? options.threads : availableThreads());
  fit.use(0.0, kMostData);
  Identification result;
  result.device = device;
  addEstimates(fit, model, result);
  return result.estimates;
}

}  // namespace enamel
