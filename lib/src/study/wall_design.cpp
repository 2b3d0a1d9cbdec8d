#include "enamel/study/wall_design.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/message.hpp"
#include "enamel/control/first_impact.hpp"
#include "enamel/control/tuning.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/push.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "enamel/study/metrics.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/wall_trials.hpp"

namespace enamel {
namespace {

constexpr const char* kNoPlant = "wall design: the device is missing";
constexpr int kPoints = 5, kChildren = 8;
constexpr double kSettling = 0.5, kAfter = 0.4, kRampTime = 0.05;  // s
constexpr double kQuiet = 0.25;                                    // s at the end of both parts, for the chatter
constexpr double kLost = 0.02;                                     // m from the wall: the run is lost
constexpr double kScenePush = 2.0, kOff = 4e-3;                    // s; m: the tool has left its obstacle

// A device whose model has a wrong mass.
class WrongInertia final : public Mechanism {
 public:
  WrongInertia(std::shared_ptr<const Mechanism> mechanism, double factor)
      : Mechanism(mechanism->name(), mechanism->limits()), mechanism_(std::move(mechanism)), factor_(factor) {
    setHome();
  }
  Status track(const JointVector& q, const JointVector& rates, bool withInertia,
               Kinematics& k) const noexcept override {
    return wrong(mechanism_->track(q, rates, withInertia, k), k);
  }
  Status reach(const Pose& pose, const Vec6& twist, bool withInertia, Kinematics& k) const noexcept override {
    return wrong(mechanism_->reach(pose, twist, withInertia, k), k);
  }
  Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                    Vec6& acceleration) const noexcept override {
    return mechanism_->accelerate(pose, twist, torque, wrench, acceleration);
  }
  std::vector<Bar> bars(const Pose& pose) const override { return mechanism_->bars(pose); }

 private:
  Status wrong(Status status, Kinematics& k) const noexcept {
    if (status == Status::ok) k.inertia *= factor_;
    return status;
  }
  std::shared_ptr<const Mechanism> mechanism_;
  double factor_;
};

// One run against the wall.
struct Trial {
  int point = 0;
  bool ramp = false;
  double force = 0.0, instant = 0.0;  // N; share of the tick at which the step comes
  std::size_t model = 0;
  std::uint32_t stream = 0;
};

struct TrialResult {
  bool lost = false;
  double stiffness = std::numeric_limits<double>::quiet_NaN(), share = stiffness;
  double chatter = 0.0, bounce = 0.0, deepest = 0.0;
};

// A person who presses along -z.
struct Pressing {
  Pose start;
  double force;  // N
  Vec6 operator()(double, const Pose& pose, const Vec6& twist) const noexcept {
    Vec6 wrench = guidingWrench(pose, twist, start, Vec3::UnitZ());
    wrench[2] -= force;
    return wrench;
  }
};

Pose pointOf(const WallDesignSetup& setup, int point) {
  static constexpr double x[kPoints] = {0, 1, -1, 1, -1}, y[kPoints] = {0, 1, 1, -1, -1};
  Pose pose;
  pose.position = setup.halfWidth * Vec3(x[point], y[point], 0.0);
  return pose;
}

Kinematics kinematicsAt(const WallDesignSetup& setup, const Pose& pose) {
  Kinematics k = setup.plant->home();
  require(setup.plant->reach(pose, Vec6::Zero(), true, k) == Status::ok,
          "wall design: the device cannot reach a corner of the wall; make its half width of " +
              formatNumber(setup.halfWidth) + " m smaller");
  return k;
}

double limitAt(const WallDesignSetup& setup, const Pose& pose, double force) {
  const Kinematics k = kinematicsAt(setup, pose);
  return firstImpactLimit(effectiveMass(k, pose.position, Vec3::UnitZ()), setup.period, setup.delay.high, force,
                          largestForce(k, setup.plant->limits().effort, pose.position, Vec3::UnitZ()), setup.preload);
}

void setLoop(const WallDesignSetup& setup, std::uint32_t stream, LoopSetup& loop) {
  loop.encoders = {true, RateSource::difference};
  loop.delay = setup.delay;
  loop.period = setup.period;
  loop.jitter = setup.jitter;
  loop.lostSamples = setup.lostSamples;
  loop.seed = setup.seed;
  loop.run = stream;
  loop.guarded = false;  // controllers must run to the end
}

std::unique_ptr<Plant> plantOf(const WallDesignSetup& setup, const LoopSetup& loop) {
  return setup.makePlant ? setup.makePlant(loop.run)
                         : std::make_unique<ClosedFormPlant>(*setup.plant, loop.integrator, loop.substeps);
}

TrialResult perform(const WallDesignSetup& setup, const Mechanism& model, const MakeRenderer& make,
                    const Trial& trial) {
  LoopSetup loopSetup;
  setLoop(setup, trial.stream, loopSetup);
  loopSetup.start = pointOf(setup, trial.point);
  const std::unique_ptr<Renderer> renderer = make();
  VirtualLoop loop(plantOf(setup, loopSetup), model, *renderer, loopSetup);
  const RandomStream random(setup.seed, trial.stream);

  const auto ticks = [&](double time) { return static_cast<int>(std::lround(time / setup.period)); };
  const int onset = ticks(kSettling), end = onset + ticks(kAfter), quiet = ticks(kQuiet),
            watched = ticks(ImpactMonitor::kRestWindow);
  ImpactMonitor watch(setup.period);
  std::vector<JointVector> before, after;  // commands
  double restSum = 0.0;
  TrialResult result;
  TickRecord tick;
  for (int i = 0; i < end; ++i) {
    const double noise = setup.noise * random.normal(RandomStream::Purpose::noise, static_cast<std::uint64_t>(i));
    const double ramped = setup.ramp * std::min(1.0, (i - onset) * setup.period / kRampTime);
    const double push = i <= onset ? setup.preload : trial.ramp ? setup.preload + ramped : trial.force;
    const Pressing now{loopSetup.start, push + noise};
    const bool steps = i == onset && !trial.ramp;
    const Status status =
        steps ? loop.tick(now, trial.instant * setup.period, Pressing{loopSetup.start, trial.force + noise}, tick)
              : loop.tick(now, tick);
    if (status != Status::ok || tick.status != Status::ok || std::abs(tick.nearest.gap) > kLost) {
      result.lost = true;
      return result;
    }
    const ImpactTick seen{tick.nearest.gap, tick.gapRate, now.force, 0.0, tick.saturated, {}};
    // The step cannot cause a reversal in its own tick.
    if (i >= onset - watched && i < onset) {
      watch.rest(seen);
      restSum += seen.gap;
    }
    if (i > onset) watch.push(seen);
    if (i >= onset) {
      const double height = seen.gap - restSum / watched;
      result.deepest = std::max(result.deepest, -height);
    }
    if (i >= onset - quiet && i < onset) before.push_back(tick.command);
    if (i >= end - quiet) after.push_back(tick.command);
  }
  result.chatter = std::max(chatterOf(before), chatterOf(after));
  if (!trial.ramp) result.bounce = watch.bounce();
  if (!trial.ramp && watch.verdict() == FirstImpactVerdict::measured) {
    result.stiffness = watch.stiffness();
    result.share = result.stiffness / limitAt(setup, loopSetup.start, trial.force);
  }
  return result;
}

// Drift of the tool over a push in the scene. Every second push has no preload, so that the tool hovers first.
double driftInScene(const WallDesignSetup& setup, const Mechanism& model, const MakeRenderer& make, int number,
                    std::uint32_t stream) {
  PushSetup push;
  setLoop(setup, stream, push);
  push.duration = kScenePush;
  push.hand.force = setup.highestForce;
  push.hand.preload = number % 2 == 0 ? 1.0 : 0.0;  // N; on a weak device a hand trembles as much
  push.hand.instant = randomInstant(push.seed, push.run);
  setScene(*setup.scene, push);
  const std::unique_ptr<Renderer> renderer = make();
  MetricsCollector metrics(push);
  const PushResult result = runPush(plantOf(setup, push), model, *renderer, push,
                                    [&](const TickRecord& tick, const VirtualLoop&) { metrics.add(tick); });
  return result.status == Status::ok ? std::min(metrics.metrics().drift, kOff) : kOff;
}

// Relative excess of a value over a limit. From twice the limit on it grows with the logarithm, so that an impossible
// requirement does not dominate the others.
double beyond(double value, double limit) {
  const double excess = std::max(0.0, value / limit - 1.0);
  return excess > 1.0 ? 1.0 + std::log(excess) : excess;
}

// With constant delay: the share of the limit at the worst point, plus a little of the worst run, minus all excess over
// limits. Each limit has a small reserve. With random delay: low depths, and little chatter.
double valueOf(const WallDesignSetup& setup, const WallScore& s) {
  constexpr double kClear = 0.93;
  const Kinematics& home = setup.plant->home();
  const double mass = effectiveMass(home, home.pose.position, Vec3::UnitZ()), T = setup.period;
  const double late = setup.delay.high + 1.0;
  if (setup.delay.low < setup.delay.high) {
    const double least = setup.highestForce / limitAt(setup, pointOf(setup, 0), setup.highestForce);
    return -(s.deepest + 0.5 * s.ramp + 0.3 * s.bounce) / least - 0.1 * beyond(s.chatter, setup.chatter) - 0.1 * s.lost;
  }
  // A ramp of jerk j moves a device that answers after t by at least j t^3 / 6. An observer needs a little more.
  const double jerk = setup.ramp / kRampTime / mass, ramp = (10.0 + 18.0 * late * late) * jerk * T * T * T;
  return std::min(s.share, 1.0) + 0.15 * std::min(s.lowestShare, 1.0) -
         0.6 * beyond(s.chatter, kClear * setup.chatter) - 0.35 * beyond(s.bounce, kClear * setup.bounce) -
         0.5 * beyond(s.ramp, ramp) - 0.2 * beyond(s.impact, 2.0 * kClear * setup.bounce) -
         0.5 * beyond(s.drift, setup.drift) - 0.5 * s.lost - 0.02 * s.unmeasured;
}

std::vector<double> varied(const ControllerSpec& spec, const std::vector<double>& parent, double sigma,
                           const RandomStream& random) {
  std::vector<double> child = parent;
  for (std::size_t i = 0; i < child.size(); ++i) {
    if (random.uniform(RandomStream::Purpose::test, 2 * i) > 0.35) continue;
    const ControllerParameter& p = spec.parameters[i];
    const double step = sigma * p.step * random.normal(RandomStream::Purpose::test, 2 * i + 1);
    child[i] = std::clamp(p.logarithmic ? child[i] * std::exp(step) : child[i] + step, p.low, p.high);
  }
  return child;
}

int rampsOf(const WallDesignSetup& setup) { return std::max(1, setup.runs / 3); }

// Steps and ramps at every point, with the random numbers of `number`.
std::vector<Trial> trialsOf(const WallDesignSetup& setup, std::uint32_t number, std::size_t models) {
  std::vector<Trial> trials;
  for (int point = 0; point < kPoints; ++point)
    for (int i = 0; i < setup.runs + rampsOf(setup); ++i) {
      Trial trial;
      trial.point = point;
      trial.ramp = i >= setup.runs;
      trial.model = static_cast<std::size_t>(i) % models;
      trial.stream = number * 100003u + static_cast<std::uint32_t>(trials.size());
      const RandomStream random(setup.seed, trial.stream);
      trial.force = setup.lowestForce +
                    (setup.highestForce - setup.lowestForce) * random.uniform(RandomStream::Purpose::force, 0);
      trial.instant = random.uniform(RandomStream::Purpose::force, 1);
      trials.push_back(trial);
    }
  return trials;
}

// Score of steps and ramps. `results` are in the order of `trials`.
WallScore scoreOf(const std::vector<Trial>& trials, const TrialResult* results) {
  WallScore score;
  score.stiffness = score.share = score.lowestShare = std::numeric_limits<double>::infinity();
  double stiffness[kPoints] = {}, share[kPoints] = {};
  int measured[kPoints] = {};
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const Trial& trial = trials[i];
    const TrialResult& r = results[i];
    score.lost += r.lost;
    score.chatter = std::max(score.chatter, r.chatter);
    score.bounce = std::max(score.bounce, r.bounce);
    score.deepest = std::max(score.deepest, r.deepest);
    if (trial.ramp) {
      score.ramp = std::max(score.ramp, r.deepest);
    } else if (std::isnan(r.stiffness)) {
      ++score.unmeasured;
    } else {
      stiffness[trial.point] += r.stiffness;
      share[trial.point] += r.share;
      ++measured[trial.point];
      score.lowestShare = std::min(score.lowestShare, r.share);
    }
  }
  for (int point = 0; point < kPoints; ++point) {
    const double count = std::max(1, measured[point]);
    score.stiffness = std::min(score.stiffness, stiffness[point] / count);
    score.share = std::min(score.share, share[point] / count);
  }
  score.lowestShare = std::min(score.lowestShare, score.share);
  return score;
}

void addImpacts(const WallDesignSetup& setup, const MakeRenderer& make, std::uint32_t number, int threads,
                WallScore& score) {
  WallTrialSetup impacts;
  impacts.plant = impacts.model = setup.plant;
  impacts.makePlant = setup.makePlant;
  impacts.renderer = make;
  impacts.delay = setup.delay;
  impacts.period = setup.period;
  impacts.runs = rampsOf(setup);
  impacts.seed = setup.seed + number;
  for (const WallFigure& f : runWallTrials(impacts, "impact", threads)) {
    if (f.figure == "bounce") score.impact = std::max(score.impact, 1e-6 * f.value);
    score.lost += f.lost;
  }
}

// An empty candidate has no renderer.
std::vector<WallScore> evaluateAll(const WallDesignSetup& setup, const std::vector<MakeRenderer>& candidates,
                                   std::uint32_t trialNumber, int threads) {
  require(setup.plant != nullptr, kNoPlant);
  require(setup.runs >= 1 && setup.runs <= 10000,
          "wall design: the runs are " + std::to_string(setup.runs) + ", must be in 1 to 10000");
  std::vector<std::shared_ptr<const Mechanism>> models = {setup.plant};
  if (setup.inertiaError > 0.0)
    for (const double sign : {-1.0, 1.0}) models.push_back(withInertia(setup.plant, 1.0 + sign * setup.inertiaError));
  const std::vector<Trial> trials = trialsOf(setup, trialNumber, models.size());
  for (const Trial& trial : trials) limitAt(setup, pointOf(setup, trial.point), trial.force);  // throws here

  std::vector<TrialResult> results(trials.size() * candidates.size());
  parallelFor(results.size(), threads, [&](std::size_t i) {
    const Trial& trial = trials[i % trials.size()];
    const MakeRenderer& make = candidates[i / trials.size()];
    if (make) results[i] = perform(setup, *models[trial.model], make, trial);
  });

  const auto pushes = static_cast<std::size_t>(setup.scene ? setup.runs : 0);
  std::vector<double> drifts(pushes * candidates.size());
  parallelFor(drifts.size(), threads, [&](std::size_t i) {
    const auto number = static_cast<int>(i % pushes);
    const MakeRenderer& make = candidates[i / pushes];
    if (make)
      drifts[i] = driftInScene(setup, *models[i % pushes % models.size()], make, number,
                               trialNumber * 100003u + static_cast<std::uint32_t>(trials.size()) + number);
  });

  std::vector<WallScore> scores(candidates.size());
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    if (!candidates[c]) {
      scores[c].value = -std::numeric_limits<double>::infinity();
      continue;
    }
    scores[c] = scoreOf(trials, &results[c * trials.size()]);
    for (std::size_t i = 0; i < pushes; ++i) scores[c].drift += drifts[c * pushes + i] / static_cast<double>(pushes);
    addImpacts(setup, candidates[c], trialNumber, threads, scores[c]);
    scores[c].value = valueOf(setup, scores[c]);
  }
  return scores;
}

}  // namespace

std::shared_ptr<const Mechanism> withInertia(std::shared_ptr<const Mechanism> mechanism, double factor) {
  require(mechanism != nullptr, kNoPlant);
  require(factor >= 0.01 && factor <= 100.0,
          "the inertia is " + formatNumber(factor) + " times the device's, must be 0.01 to 100 times");
  return std::make_shared<WrongInertia>(std::move(mechanism), factor);
}

WallDesignSetup withinMotors(WallDesignSetup setup) {
  require(setup.plant != nullptr, kNoPlant);
  constexpr double kShare = 0.3;
  double share = 1.0;
  for (int point = 0; point < kPoints; ++point) {
    const Kinematics k = kinematicsAt(setup, pointOf(setup, point));
    const double most = largestForce(k, setup.plant->limits().effort, k.pose.position, Vec3::UnitZ());
    share = std::min(share, kShare * most / setup.highestForce);
  }
  for (double* force : {&setup.preload, &setup.lowestForce, &setup.highestForce, &setup.noise, &setup.ramp})
    *force *= share;
  return setup;
}

WallScore evaluateWall(const WallDesignSetup& setup, const MakeRenderer& make, std::uint32_t trial, int threads) {
  require(make != nullptr, "wall design: the renderer is missing");
  return evaluateAll(setup, {make}, trial, threads).front();
}

std::vector<double> designController(const WallDesignSetup& setup, const ControllerSpec& spec,
                                     const std::vector<double>& start, int generations, int threads,
                                     const std::function<void(int, const WallScore&)>& progress) {
  require(start.size() == spec.parameters.size(), "wall design: " + spec.name + " has " +
                                                      std::to_string(spec.parameters.size()) + " parameters, " +
                                                      std::to_string(start.size()) + " are given");
  const ControllerUse use{setup.plant, setup.period, setup.delay};
  (void)spec.with(use, start);  // throws here if the start is invalid
  const auto made = [&](const std::vector<double>& values) -> MakeRenderer {
    try {
      return spec.with(use, values);
    } catch (const Error&) {  // no servo has these numbers
      return {};
    }
  };
  std::vector<double> parent = start;
  double sigma = 1.0;
  for (int generation = 0; generation < generations; ++generation) {
    const auto number = static_cast<std::uint32_t>(generation);
    std::vector<std::vector<double>> family = {parent};
    for (std::uint32_t child = 0; child < kChildren; ++child)
      family.push_back(varied(spec, parent, sigma, RandomStream(setup.seed, number * kChildren + child)));
    std::vector<MakeRenderer> candidates(family.size());
    parallelFor(family.size(), threads, [&](std::size_t i) { candidates[i] = made(family[i]); });
    const std::vector<WallScore> scores = evaluateAll(setup, candidates, number, threads);
    std::size_t best = 0;
    for (std::size_t i = 1; i < family.size(); ++i)
      if (scores[i].value > scores[best].value) best = i;
    sigma = std::clamp(best == 0 ? 0.85 * sigma : 1.1 * sigma, 0.15, 2.0);
    parent = family[best];
    if (progress) progress(generation, scores[best]);
  }
  return parent;
}

}  // namespace enamel
