// Mistakes in calls of the functions of control and study: impossible sizes, counts and numbers.
#include "enamel/control/device_plant.hpp"
#include "enamel/control/discretise.hpp"
#include "enamel/control/impedance_map.hpp"
#include "enamel/control/margins.hpp"
#include "enamel/control/servo_simulation.hpp"
#include "enamel/control/tuning.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/sim/push.hpp"
#include "enamel/study/monte_carlo.hpp"
#include "support/catch.hpp"
#include "support/pushes.hpp"

namespace enamel::test_control_slips {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::ContainsSubstring;

namespace {

const double kNan = std::nan("");

// One joint: a mass of 1 kg with the servo.
ServoDesign smallDesign() {
  StateSpace plant{MatrixXd::Zero(2, 2), MatrixXd::Zero(2, 1)};
  plant.A(1, 0) = plant.B(0, 0) = 1.0;
  return designServo(plant, 1e-3, ServoWeights{});
}

}  // namespace

TEST_CASE("matrices of no size, of other sizes, of numbers that are none", "[control_slips]") {
  const MatrixXd none(0, 0), wide = MatrixXd::Ones(2, 3), huge = MatrixXd::Constant(3, 3, 1e308),
                             bad = MatrixXd::Constant(2, 2, kNan);
  CHECK(matrixExponential(none).size() == 0);
  CHECK_THROWS_WITH(matrixExponential(wide), ContainsSubstring("2 x 3"));
  CHECK_THROWS_WITH(matrixExponential(bad), ContainsSubstring("is not finite"));
  CHECK_THROWS_WITH(matrixExponential(huge), ContainsSubstring("overflows"));
  CHECK_THROWS_WITH(matrixExponential(MatrixXd::Constant(1, 1, 1e308)), ContainsSubstring("overflows"));
  CHECK(matrixExponential(MatrixXd::Constant(1, 1, -1e308))(0, 0) == 0.0);
  const StateSpace large{huge, MatrixXd::Constant(3, 1, 1e308)};
  CHECK_THROWS_AS(zeroOrderHold(large, 1.0), DesignError);
  CHECK_THROWS_AS(zeroOrderHold(large, 1e308), DesignError);
  CHECK(zeroOrderHold({MatrixXd::Zero(2, 2), MatrixXd::Ones(2, 1)}, 1e-300).A == MatrixXd::Identity(2, 2));
  for (const double period : {0.0, -1.0, kNan, HUGE_VAL})
    CHECK_THROWS_WITH(zeroOrderHold({MatrixXd::Zero(2, 2), MatrixXd::Ones(2, 1)}, period), ContainsSubstring("period"));

  for (const MatrixXd& A : {none, wide, bad})
    CHECK_THROWS_WITH(spectralRadius(A), ContainsSubstring("eigenvalues: the matrix"));
  CHECK_THROWS_AS(continuousPoles(none, 1e-3), DesignError);
  CHECK_THROWS_AS(continuousPoles(MatrixXd::Identity(2, 2), 0.0), DesignError);
  const StateSpace loop{0.5 * MatrixXd::Identity(3, 3), MatrixXd::Ones(3, 1)};
  const MatrixXd K = MatrixXd::Zero(1, 3);
  for (const StateSpace& l : {StateSpace{none, none}, StateSpace{wide, none}, StateSpace{loop.A, wide},
                              StateSpace{wide, loop.B}, StateSpace{loop.A, MatrixXd(3, 0)}})
    CHECK_THROWS_WITH(closedLoop(l, K, 1), ContainsSubstring("sizes do not fit: A "));
  for (const MatrixXd& gain : {none, MatrixXd(MatrixXd::Zero(2, 3)), MatrixXd(MatrixXd::Zero(1, 2))}) {
    CHECK_THROWS_WITH(toleratedDelay(loop, gain), ContainsSubstring("sizes do not fit"));
    CHECK_THROWS_WITH(measureMargins(loop, gain, 1e-3), ContainsSubstring("sizes do not fit"));
    CHECK_THROWS_WITH(diskMargin(loop, gain, 1e-3, 0), ContainsSubstring("sizes do not fit"));
  }
  for (const int delay : {-1, -(1 << 30), 66, 1 << 30})
    CHECK_THROWS_WITH(closedLoop(loop, K, delay), ContainsSubstring("must be in 0 to 65 ticks"));
  CHECK_THROWS_WITH(diskMargin(loop, K, 0.0, 0), ContainsSubstring("period"));
  CHECK_THROWS_WITH(measureMargins(loop, K, kNan), ContainsSubstring("period"));
  Linearisation empty;
  CHECK_THROWS_AS(outputsAsStates(empty), DesignError);
  empty.C = MatrixXd::Identity(2, 2);
  empty.model = {MatrixXd::Zero(2, 3), MatrixXd::Zero(2, 1)};
  CHECK_THROWS_AS(outputsAsStates(empty), DesignError);
}

TEST_CASE("servos, simulations and limits of nothing", "[control_slips]") {
  const ServoDesign design = smallDesign();
  const MatrixXd jacobian = MatrixXd::Ones(6, 1);
  ServoDesign without = design, wrong = design;
  without.K.resize(0, 0);
  wrong.K = MatrixXd::Zero(1, 2);
  const SampledPlant plant = linearPlant(design, jacobian);
  ServoExperiment good;
  good.reference = VectorXd::Zero(1);
  good.wrench = VectorXd::Zero(6);
  good.ticks = 3;
  CHECK(simulateServo(design, plant, good).y.cols() == 4);
  for (const ServoDesign& d : {without, wrong}) {
    CHECK_THROWS_AS(linearPlant(d, jacobian), DesignError);
    CHECK_THROWS_AS(simulateServo(d, plant, good), DesignError);
    CHECK_THROWS_AS(measureRequirements(d, plant, jacobian), DesignError);
    CHECK_THROWS_AS(runningLoop(d), DesignError);
  }
  CHECK_THROWS_AS(linearPlant(design, MatrixXd::Ones(6, 2)), DesignError);
  CHECK_THROWS_AS(linearPlant(design, MatrixXd(0, 0)), DesignError);
  const auto refuse = [&](auto change) {
    ServoExperiment experiment = good;
    change(experiment);
    CHECK_THROWS_WITH(simulateServo(design, plant, experiment), ContainsSubstring("servo simulation"));
  };
  refuse([](ServoExperiment& e) { e.ticks = -1; });
  refuse([](ServoExperiment& e) { e.ticks = 2000000000; });
  refuse([](ServoExperiment& e) { e.delay = -1; });
  refuse([](ServoExperiment& e) { e.wrench.resize(0); });
  refuse([](ServoExperiment& e) { e.reference.resize(0); });
  refuse([](ServoExperiment& e) { e.maxTorque.setZero(2); });
  const SampledPlant silent = [](const VectorXd&, const VectorXd&, const VectorXd&) { return VectorXd(); };
  CHECK_THROWS_WITH(simulateServo(design, silent, good), ContainsSubstring("the plant must return 2n numbers"));
  const ServoTrace trace = simulateServo(design, plant, good);
  CHECK_THROWS_AS(firstImpactStiffness(trace, Eigen::RowVectorXd::Ones(2), 1.0, 1e-3), DesignError);
  CHECK_THROWS_AS(firstImpactStiffness(trace, Eigen::RowVectorXd::Ones(1), 1.0, 1e-300), DesignError);
  CHECK_THROWS_AS(torqueDeviation(trace, 0), DesignError);
  CHECK_THROWS_AS(torqueDeviation(trace, -5), DesignError);
  CHECK_THROWS_AS(torqueDeviation(ServoTrace{}, 5), DesignError);
  ServoDesign tiny = design;
  tiny.period = 1e-300;
  CHECK_THROWS_WITH(measureRequirements(tiny, plant, jacobian),
                    ContainsSubstring("the period is 1e-300 s, must be positive and a run at most 1e7 ticks"));
  CHECK(firstImpactLimit(1.0, 1e-3, -1, 1.0, 10.0) == 0.0);
  CHECK(firstImpactLimit(1.0, 0.0, 0, 1.0, 10.0) == 0.0);
  CHECK_THROWS_WITH(isWallStable({1.0, 0.0, 1e-300}, {1000.0, 0.0, 0}), ContainsSubstring("1e8 periods"));
  CHECK_THROWS_AS(isWallStable({1.0, 0.0, 1e-3}, {1000.0, 0.0, -1}), DesignError);
  CHECK_THROWS_AS(isWallStable({1.0, 0.0, 1e-3}, {1000.0, 0.0, 2000000000}), DesignError);
  CHECK_THROWS_AS(devicePlant(nullptr, Pose{}), DesignError);
  const auto device = makeMechanism(test::nominal());
  CHECK_THROWS_AS(devicePlant(device, Pose{Vec3::Zero(), Mat3::Zero()}), DesignError);
}

TEST_CASE("gains of 1e308 become no torque", "[control_slips]") {
  const TauMechanism device(test::nominal());
  ServoGain gain = test::referenceGain();
  gain *= 1e308 / gain.cwiseAbs().maxCoeff();
  HoldRenderer hold(gain, 1e-3, test::asInThePaper());
  ImpedanceRenderer spring({1e308, 1e308});
  for (Renderer* renderer : {static_cast<Renderer*>(&hold), static_cast<Renderer*>(&spring)}) {
    renderer->activate(1e-3);
    int refused = 0;
    for (int i = 1; i < 20; ++i) {
      TickOutput output;
      const Status status = renderer->step(test::frameAt(device, test::poseAtDepth(1e-4 * i), 1e-3 * i), output);
      refused += status != Status::ok;
      CHECK((output.torque.cwiseAbs() - device.limits().effort).maxCoeff() <= 0.0);
      if (status != Status::ok) CHECK(output.torque == JointVector::Zero(6));
    }
    CHECK(refused > 0);
  }
}

TEST_CASE("pushes and studies of nothing", "[control_slips]") {
  const auto refuse = [](auto change, const std::string& reason) {
    PushSetup setup;
    change(setup);
    CHECK_THROWS_WITH(checkPush(setup), ContainsSubstring(reason));
  };
  for (const double period : {1e-300, -1.0, kNan, 1e308})
    refuse([period](PushSetup& s) { s.period = period; }, "must be in 1e-05 to 0.1 s");
  for (const Mat3& matrix : {Mat3(Mat3::Zero()), Mat3(-Mat3::Identity()), Mat3(Mat3::Constant(kNan))})
    refuse([&](PushSetup& s) { s.start.rotation = matrix; }, "not a right-handed orthonormal matrix");
  refuse([](PushSetup& s) { s.start.position[0] = kNan; }, "the start pose is not finite");
  refuse([](PushSetup& s) { s.substeps = -1; }, "substeps is -1");
  refuse([](PushSetup& s) { s.delay = {-1, 0}; }, "delay is -1..0");
  const TauMechanism device(test::nominal());
  HoldRenderer renderer = test::holdRenderer();
  for (const int count : {-1, 9}) {
    PushSetup setup;
    setup.tool.count = count;
    CHECK_THROWS_WITH(VirtualLoop(device, renderer, setup), ContainsSubstring("0 to 8 parts"));
  }

  StudyPlan plan;
  plan.grid = 2;
  plan.runs = 3;
  plan.columns.push_back({"hold", makeMechanism(test::nominal()), [](std::size_t) {
                            return std::make_unique<HoldRenderer>(test::referenceGain(), 1e-3, HoldOptions{});
                          }});
  REQUIRE(plan.size() == 2 * 4 * 3);
  CHECK(runAt(plan, 23).run == 2);
  CHECK_THROWS_WITH(runAt(plan, 24), "run 24 does not exist, the study has 24 runs");
  CHECK_THROWS_WITH(runAt(plan, static_cast<std::size_t>(-1)), ContainsSubstring("the study has 24"));
  StudyRun run = runAt(plan, 0);
  run.column = 1;
  CHECK_THROWS_WITH(performRun(plan, run), ContainsSubstring("column 1 or point 0 does not exist"));
  run.column = 0;
  run.point = 4;
  CHECK_THROWS_WITH(performRun(plan, run), ContainsSubstring("the study has 1 columns and 4 points"));
  for (const int runs : {0, -1}) {
    plan.runs = runs;
    CHECK_THROWS_WITH(runAt(plan, 0), ContainsSubstring("the study has 0"));
    CHECK_THROWS_WITH(pointStatistics(plan, {}), ContainsSubstring("must be at least 1"));
  }
  plan.grid = 0;
  CHECK_THROWS_WITH(summarise(plan, {}), ContainsSubstring("must be at least 1"));
}

}  // namespace enamel::test_control_slips
