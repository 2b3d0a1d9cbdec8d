#include "enamel/study/best_spring.hpp"

#include <atomic>
#include <cmath>
#include <map>
#include <utility>

#include "core/message.hpp"
#include "enamel/study/parallel.hpp"

namespace enamel {
namespace {

// Stiffness and damping as powers of 2^(1/8), over m / T^2 and m / T.
using Place = std::pair<int, int>;
constexpr int kOctave = 8;
constexpr Place kLowest{-8 * kOctave, -5 * kOctave}, kHighest{kOctave, kOctave};
constexpr std::uint32_t kOtherStreams = 0x80000000u;  // above those of a plan

class Search {
 public:
  Search(const StudyPlan& plan, std::size_t column, int threads) : plan_(plan), threads_(threads) {
    plan_.columns = {plan.columns.at(column)};
    plan_.setup.seed = ~plan.setup.seed;
    const StudyColumn& of = plan_.columns.front();
    Pose pose = plan.setup.start;
    pose.position = plan.middle;
    Kinematics k;
    require(of.plant->reach(pose, Vec6::Zero(), true, k) == Status::ok,
            "best spring: the device cannot reach the middle of the wall");
    period_ = of.period > 0.0 ? of.period : plan.setup.period;
    mass_ = effectiveMass(k, pose.position, plan.setup.hand.normal);
  }

  BestSpring best() {
    Place best = kLowest;
    for (int b = kLowest.second; b <= kHighest.second; b += kOctave)
      for (int k = kHighest.first; k >= kLowest.first; k -= kOctave) {
        take({k, b}, best);
        if (stiffnessAt({k, b}) > 0.0) break;  // softer ones are softer walls
      }
    for (int step = kOctave / 2; step > 0; step /= 2)
      for (bool moved = true; moved;) {
        const Place from = best;
        for (const int k : {-step, 0, step})
          for (const int b : {-step, 0, step}) take({from.first + k, from.second + b}, best);
        moved = best != from;
      }
    return {springAt(best), stiffnessAt(best)};
  }

 private:
  void take(const Place& place, Place& best) {
    if (stiffnessAt(place) > stiffnessAt(best)) best = place;
  }

  ImpedanceOptions springAt(const Place& place) const {
    const auto power = [](int n) { return std::exp2(static_cast<double>(n) / kOctave); };
    return {mass_ / (period_ * period_) * power(place.first), mass_ / period_ * power(place.second)};
  }

  // Mean K_d; 0 if a run is lost.
  double stiffnessAt(const Place& place) {
    const auto known = stiffness_.find(place);
    return known != stiffness_.end() ? known->second : stiffness_[place] = perform(springAt(place));
  }

  double perform(const ImpedanceOptions& spring) {
    plan_.columns.front().make = [spring](std::size_t) { return std::make_unique<ImpedanceRenderer>(spring); };
    std::vector<std::optional<double>> stiffness(plan_.size());
    std::atomic<bool> lost{false};
    parallelFor(stiffness.size(), threads_, [&](std::size_t i) {
      if (lost) return;
      StudyRun run = runAt(plan_, i);
      run.stream |= kOtherStreams;
      const StudyResult result = performRun(plan_, run);
      stiffness[i] = result.metrics.depthStiffness;
      if (isLost(result)) lost = true;
    });
    if (lost) return 0.0;
    std::vector<double> measured;
    for (const auto& value : stiffness)
      if (value) measured.push_back(*value);
    return measured.empty() ? 0.0 : spreadOf(measured).mean;
  }

  StudyPlan plan_;
  int threads_;
  double period_ = 0.0, mass_ = 0.0;
  std::map<Place, double> stiffness_;
};

}  // namespace

BestSpring findBestSpring(const StudyPlan& plan, std::size_t column, int threads) {
  return Search(plan, column, threads).best();
}

}  // namespace enamel
