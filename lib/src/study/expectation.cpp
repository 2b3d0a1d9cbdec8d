#include "enamel/study/expectation.hpp"

#include <algorithm>
#include <utility>

#include "enamel/render/position_control.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/study/best_spring.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/wall_trials.hpp"

namespace enamel {
namespace {

constexpr int kRuns = 90, kSafeRuns = 3, kBisections = 5;
constexpr double kAfterStep = 0.15, kWithChatter = 1.2;  // s: for the depth; for the last second's chatter too

// A device and its loop.
struct Loop {
  DeviceParameters device;
  double period;
  int delay;
};

struct Pushes {
  double lowest, highest, share;  // N, N; share of all forces
  int runs;
  double duration;  // after the step, s
};

StudyPlan planOf(const Loop& loop, const Pushes& pushes) {
  const char* plant = plantOf(loop.device);
  StudyPlan plan;
  plan.scenarios = {1};
  plan.grid = 1;
  plan.runs = pushes.runs;
  plan.insideTick = true;
  plan.lowestForce = pushes.lowest;
  plan.highestForce = pushes.highest;
  plan.setup.period = loop.period;
  plan.setup.delay = {loop.delay, loop.delay};
  plan.setup.duration = 1.0 + pushes.duration;
  plan.setup.encoders = {true, RateSource::difference};
  plan.setup.hand.preload = pushes.share;
  plan.setup.hand.noise *= pushes.share;
  StudyColumn column;
  column.name = "position-control";
  column.plant = column.model = makeMechanism(modelFor(plant, loop.device));
  column.makePlant = plantMaker(plant, loop.device, {}, plan.setup);
  column.make = [options = positionControlFor(*column.model, loop.period, loop.delay, loop.delay)](std::size_t) {
    return std::make_unique<PositionControlRenderer>(options);
  };
  plan.columns = {column};
  return plan;
}

std::vector<StudyResult> perform(const StudyPlan& plan) {
  std::vector<StudyResult> results;
  for (std::size_t i = 0; i < plan.size(); ++i) results.push_back(performRun(plan, runAt(plan, i)));
  return results;
}

// K_d of the runs that were not lost.
Spread stiffnessOf(const std::vector<StudyResult>& runs) {
  std::vector<double> values;
  for (const StudyResult& run : runs)
    if (!isLost(run) && run.metrics.depthStiffness) values.push_back(*run.metrics.depthStiffness);
  return spreadOf(values);
}

bool isSafe(const Loop& loop, double force, double share) {
  const std::vector<StudyResult> runs = perform(planOf(loop, {force, force, share, kSafeRuns, kAfterStep}));
  return std::none_of(runs.begin(), runs.end(), [&](const StudyResult& run) {
    return isLost(run) || (run.metrics.depthStiffness && force / *run.metrics.depthStiffness > kSafeDepth);
  });
}

double largestSafePush(const Loop& loop, double share) {
  const auto mechanism = makeMechanism(loop.device);
  const Kinematics& home = mechanism->home();
  double safe = 0.0, beyond = largestForce(home, mechanism->limits().effort, home.pose.position, Vec3::UnitZ());
  for (int i = 0; i < kBisections; ++i) {
    const double force = 0.5 * (safe + beyond);
    (isSafe(loop, force, share) ? safe : beyond) = force;
  }
  return safe;
}

// Scale encoder steps and motor torques, which have other names in each kind of device.
void change(DeviceParameters& device, double encoderStep, double effort) {
  std::visit(
      [&](auto& d) {
        if constexpr (std::is_same_v<std::decay_t<decltype(d)>, CartesianParameters>) {
          d.positionStep *= encoderStep;
          d.angleStep *= encoderStep;
          d.maxForce *= effort;
          d.maxMoment *= effort;
        } else {
          d.motor.encoderCounts /= encoderStep;
          d.motor.maxTorque *= effort;
        }
      },
      device);
}

// Better devices and better loops.
std::vector<std::pair<std::string, Loop>> changesOf(const Loop& loop) {
  std::vector<std::pair<std::string, Loop>> changes;
  const auto add = [&](const char* name) -> Loop& { return changes.emplace_back(name, loop).second; };
  change(add("half the encoder step").device, 0.5, 1.0);
  change(add("twice the motors' torque").device, 1.0, 2.0);
  const auto mechanism = makeMechanism(loop.device);
  Kinematics home = mechanism->home();
  if (mechanism->reach(home.pose, Vec6::Zero(), true, home) == Status::ok)
    addMass(add("twice the effective mass").device, effectiveMass(home, home.pose.position, Vec3::UnitZ()));
  if (loop.delay > 0)
    --add("a tick less of delay").delay;
  else
    add("twice the rate").period *= 0.5;
  if (imperfectionsOf(loop.device).cableStiffness > 0.0)
    imperfectionsOf(add("cables twice as stiff").device).cableStiffness *= 2.0;
  return changes;
}

// Search the best spring, and let it perform the pushes of position control.
void addSpring(StudyPlan plan, WallExpectation& e) {
  const BestSpring best = findBestSpring(plan, 0, 1);
  if (!(best.stiffness > 0.0)) return;
  plan.columns[0].make = [&best](std::size_t) { return std::make_unique<ImpedanceRenderer>(best.spring); };
  const std::vector<StudyResult> runs = perform(plan);
  e.spring = best.spring;
  e.springStiffness = stiffnessOf(runs);
  e.springLost = static_cast<int>(std::count_if(runs.begin(), runs.end(), isLost));
}

WallExpectation expect(const Loop& loop, bool withSpring) {
  const double share = forceShare(*makeMechanism(loop.device));
  const Pushes pushes{8.0 * share, 15.0 * share, share, kRuns, kWithChatter};
  StudyPlan plan = planOf(loop, pushes);
  const std::vector<StudyResult> runs = perform(plan);
  WallExpectation e;
  e.delay = loop.delay;
  e.runs = kRuns;
  e.stiffness = stiffnessOf(runs);
  for (const StudyResult& run : runs) {
    e.lost += isLost(run);
    if (isLost(run)) continue;
    e.chatter = std::max(e.chatter, run.metrics.chatter);
    e.bounce = std::max(e.bounce, run.metrics.bounce);
  }
  e.safePush = largestSafePush(loop, share);
  if (withSpring) addSpring(plan, e);
  if (e.stiffness.count == 0) return e;
  const Pushes again{pushes.lowest, pushes.highest, share, kRuns, kAfterStep};  // the same
  for (const auto& [name, better] : changesOf(loop))
    if (const Spread changed = stiffnessOf(perform(planOf(better, again))); changed.count > 0)
      e.changes.push_back({name, changed.mean / e.stiffness.mean - 1.0});
  std::stable_sort(e.changes.begin(), e.changes.end(),
                   [](const DeviceChange& a, const DeviceChange& b) { return a.gain > b.gain; });
  return e;
}

}  // namespace

std::vector<WallExpectation> expectWall(const DeviceParameters& device, double period, int largestDelay, int threads,
                                        bool withSpring) {
  std::vector<WallExpectation> all(static_cast<std::size_t>(std::max(0, largestDelay)) + 1);
  parallelFor(all.size(), threads, [&](std::size_t i) {
    all[i] = expect({device, period, static_cast<int>(i)}, withSpring);
  });
  return all;
}

}  // namespace enamel
