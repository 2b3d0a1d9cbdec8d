// A grid of light and heavy devices: mass, encoder step, delay and cables. Position control holds on all of them.
#include <array>
#include <cstdio>
#include <memory>

#include "enamel/render/position_control.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/study/monte_carlo.hpp"
#include "enamel/study/parallel.hpp"
#include "support/catch.hpp"
#include "support/run_length.hpp"

namespace enamel::test_grid {

namespace {

constexpr double kPeriod = 1e-3;  // s
constexpr int kDelays = 3;

struct Weight {
  double mass, push, preload, noise, largest;  // kg, N
};
constexpr Weight kWeights[] = {{0.33, 12.0, 1.0, 0.5, 60.0}, {0.15, 5.0, 0.6, 0.2, 20.0}, {0.045, 1.0, 0.3, 0.05, 3.3}};
constexpr double kSteps[] = {1e-6, 1e-5, 5.5e-5};  // m, of the encoders
constexpr double kCables[] = {0.0, 1.0, 0.3};      // stiffness, of 480 N/m per 0.33 g; 0: rigid

// Mean K_d, kN/m, of 20 pushes that a prototype of the same equations reached on plants of its own. A row is a weight
// and a step. It has a group for each cable, with one number for each delay.
constexpr double kPrototype[9][3][kDelays] = {
    {{278.34, 91.5, 44.09}, {129.67, 59.6, 34.22}, {83.13, 43.77, 26.5}},
    {{173.04, 66.83, 35.5}, {106.44, 53.97, 31.83}, {67.45, 37.21, 23.63}},
    {{64.42, 36.94, 23.27}, {56.85, 32.34, 20.52}, {43.26, 26.85, 18.3}},
    {{124.01, 40.96, 19.98}, {59.43, 27.16, 15.44}, {36.33, 19.15, 11.69}},
    {{72.4, 28.18, 14.93}, {48.96, 22.95, 13.85}, {30.27, 16.99, 10.57}},
    {{26.79, 15.7, 9.96}, {24.77, 14.17, 9}, {19.56, 11.73, 7.88}},
    {{38.5, 14.09, 6.8}, {18.52, 8.75, 5.03}, {9.33, 5.79, 3.7}},
    {{19.11, 8.53, 4.9}, {13.37, 7.02, 4.25}, {8.62, 5.11, 3.31}},
    {{7.56, 4.17, 2.74}, {6.78, 3.69, 2.63}, {5.62, 3.38, 2.32}},
};

struct Cell {
  const Weight& weight;
  std::size_t row, cable;
  int delay;
};

CartesianParameters deviceOf(const Cell& cell) {
  CartesianParameters device;
  device.name = "cell of the grid";
  device.mass = cell.weight.mass;
  device.rotorMass = 0.2 * device.mass;
  device.halfWidths = Vec3::Constant(0.1);
  device.maxForce = cell.weight.largest;
  device.positionStep = kSteps[cell.row % std::size(kSteps)];
  device.imperfections.currentBandwidth = 1000.0;
  device.imperfections.cableStiffness = kCables[cell.cable] * 480e3 * device.mass / 0.33;
  if (kCables[cell.cable] > 0.0) device.imperfections.cableDamping = 17.8 * device.mass / 0.33;
  return device;
}

StudyPlan planOf(const Cell& cell, int runs) {
  const DeviceParameters device = deviceOf(cell);
  StudyPlan plan;
  plan.scenarios = {1};
  plan.grid = 1;
  plan.runs = runs;
  plan.insideTick = true;
  plan.lowestForce = plan.highestForce = cell.weight.push;
  plan.setup.period = kPeriod;
  plan.setup.delay = {cell.delay, cell.delay};
  plan.setup.duration = 2.2;
  plan.setup.encoders = {true, RateSource::difference};
  plan.setup.hand.preload = cell.weight.preload;
  plan.setup.hand.noise = cell.weight.noise;
  plan.setup.seed = test::seed() + 1;
  StudyColumn column;
  column.name = "position-control";
  column.plant = column.model = makeMechanism(modelFor(kImperfect, device));
  column.makePlant = plantMaker(kImperfect, device, {}, plan.setup);
  column.make = [options = positionControlFor(*column.model, kPeriod, cell.delay, cell.delay)](std::size_t) {
    return std::make_unique<PositionControlRenderer>(options);
  };
  plan.columns = {column};
  return plan;
}

}  // namespace

TEST_CASE("position control loses no run on a grid of devices", "[hard]") {
  std::vector<Cell> cells;
  for (std::size_t row = 0; row < std::size(kPrototype); ++row)
    for (std::size_t cable = 0; cable < std::size(kCables); ++cable)
      for (int delay = 0; delay < kDelays; ++delay)
        cells.push_back({kWeights[row / std::size(kSteps)], row, cable, delay});
  const int runs = test::count(1, 20);
  std::vector<StudyResult> results(cells.size() * static_cast<std::size_t>(runs));
  parallelFor(cells.size(), availableThreads(), [&](std::size_t i) {
    const StudyPlan plan = planOf(cells[i], runs);
    for (std::size_t k = 0; k < plan.size(); ++k) results[i * plan.size() + k] = performRun(plan, runAt(plan, k));
  });
  std::vector<double> shares;
  int shaking = 0;  // runs whose chatter is more than a quarter of the motors' force
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = cells[i];
    std::vector<double> stiffness, chatter;
    for (int k = 0; k < runs; ++k) {
      const StudyResult& result = results[i * static_cast<std::size_t>(runs) + static_cast<std::size_t>(k)];
      INFO(cell.weight.mass << " kg, step " << kSteps[cell.row % std::size(kSteps)] << " m, cable "
                            << kCables[cell.cable] << ", delay " << cell.delay << ", run " << k);
      CHECK(result.status == Status::ok);  // neither left nor stopped
      shaking += isLost(result);
      REQUIRE(result.metrics.depthStiffness);
      stiffness.push_back(1e-3 * *result.metrics.depthStiffness);
      chatter.push_back(result.metrics.chatter);
    }
    const double mean = spreadOf(stiffness).mean,
                 share = mean / kPrototype[cell.row][cell.cable][static_cast<std::size_t>(cell.delay)];
    shares.push_back(share);
    if (test::longRun())
      std::printf(
          "%5.3f kg, step %2.0f um, cable %3.1f, delay %d: K_d %6.2f kN/m, %3.0f %% of the prototype, chatter %5.3f "
          "N\n",
          cell.weight.mass, 1e6 * kSteps[cell.row % std::size(kSteps)], kCables[cell.cable], cell.delay, mean,
          100.0 * share, spreadOf(chatter).mean);
    if (test::longRun()) CHECK(share > 0.85);
  }
  CHECK(spreadOf(shares).mean > 1.0);
  CHECK(shaking < 1e-3 * static_cast<double>(results.size()) + 1.0);
}

}  // namespace enamel::test_grid
