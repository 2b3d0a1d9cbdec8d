#include "enamel/control/margins.hpp"

#include <cmath>
#include <complex>

#include "control/dense.hpp"
#include "enamel/control/servo_design.hpp"
#include "support/catch.hpp"
#include "support/control_systems.hpp"
#include "support/run_length.hpp"

namespace enamel::test_margins {

using namespace enamel::test;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// A loop with useful margins: a random plant with its own LQR servo.
struct Loop {
  StateSpace loop;
  MatrixXd K;
};

Loop servoLoop(const ServoWeights& weights) {
  const ServoDesign design = designServo(referencePlant(), 1e-3, weights);
  return {runningLoop(design), design.K};
}

std::vector<Loop> servoLoops() {
  return {servoLoop({}), servoLoop({0.1, 1e3, 2e6, 1.0}), servoLoop({10.0, 1e4, 1e6, 1.0}),
          servoLoop({0.0, 1e2, 1e5, 1.0})};
}

// Return a complex matrix as real numbers: with the eigenvalues and their conjugates, and each singular value twice.
MatrixXd inReals(const MatrixXd& real, const MatrixXd& imaginary) {
  MatrixXd m(2 * real.rows(), 2 * real.cols());
  m << real, -imaginary, imaginary, real;
  return m;
}

// Return the spectral radius when input i is multiplied by a complex factor.
double radiusWith(const Loop& l, Index i, std::complex<double> factor) {
  MatrixXd real = l.K, imaginary = MatrixXd::Zero(l.K.rows(), l.K.cols());
  real.row(i) *= factor.real();
  imaginary.row(i) = factor.imag() * l.K.row(i);
  return spectralRadius(inReals(l.loop.A - l.loop.B * real, -l.loop.B * imaginary));
}

}  // namespace

TEST_CASE("an integrator under proportional control has the margins of the textbook") {
  // x[j+1] = x[j] + u[j], u = -k x: pole 1 - k; L = k / (z - 1). |L| = 1 at 2 sin(w/2) = k with the phase -pi/2 - w/2;
  // |1 + L| is smallest at z = -1. With a delay of d samples it is stable for k < 2 sin(pi / (4 d + 2)).
  const StateSpace integrator{MatrixXd::Identity(1, 1), MatrixXd::Identity(1, 1)};
  const double period = 1e-3;
  for (const double k : {0.05, 0.3, 0.7, 1.1, 1.9}) {
    INFO("k = " << k);
    const MatrixXd K = MatrixXd::Constant(1, 1, k);
    const Margins m = measureMargins(integrator, K, period);
    CHECK(m.disk == Approx(1.0 - 0.5 * k).epsilon(1e-9));
    CHECK(m.diskFrequency == Approx(M_PI / period).epsilon(1e-3));
    CHECK(m.channel.at(0).gainUp == Approx(2.0 / k).epsilon(1e-9));
    CHECK(m.channel[0].gainDown == 0.0);
    CHECK(m.channel[0].phase == Approx(0.5 * M_PI - std::asin(0.5 * k)).epsilon(1e-9));
    const auto stableWith = [k](int d) { return k < 2.0 * std::sin(M_PI / (4 * d + 2)); };
    CHECK(stableWith(m.toleratedDelay));
    CHECK_FALSE(stableWith(m.toleratedDelay + 1));
    CHECK(m.radiusBeyond >= 1.0);
  }
  const Margins unstable = measureMargins(integrator, MatrixXd::Constant(1, 1, 2.1), period);
  CHECK(unstable.toleratedDelay == -1);
  CHECK(unstable.disk == 0.0);
  CHECK(unstable.channel.empty());
}

TEST_CASE("every gain and phase margin is where the closed loop becomes unstable") {
  for (const Loop& l : servoLoops()) {
    const Margins m = measureMargins(l.loop, l.K, 1e-3);
    REQUIRE(m.channel.size() == 6);
    for (Index i = 0; i < 6; ++i) {
      INFO("input " << i);
      const ChannelMargins& c = m.channel[static_cast<std::size_t>(i)];
      REQUIRE(std::isfinite(c.gainUp));
      CHECK(radiusWith(l, i, 0.999 * c.gainUp) < 1.0);
      CHECK(radiusWith(l, i, 1.001 * c.gainUp) > 1.0);
      if (c.gainDown > 0.0) {
        CHECK(radiusWith(l, i, 1.001 * c.gainDown) < 1.0);
        CHECK(radiusWith(l, i, 0.999 * c.gainDown) > 1.0);
      }
      for (const double sign : {1.0, -1.0}) CHECK(radiusWith(l, i, std::polar(1.0, 0.999 * sign * c.phase)) < 1.0);
      // One of the two directions is that of the measured margin; the other is its mirror image.
      CHECK(radiusWith(l, i, std::polar(1.0, -1.001 * c.phase)) > 1.0);
      CHECK(radiusWith(l, i, std::polar(1.0, 1.001 * c.phase)) > 1.0);
    }
  }
}

TEST_CASE("the disk margin is the smallest singular value over a fine grid") {
  for (const Loop& l : servoLoops())
    for (const int delay : {0, 1}) {
      const double margin = diskMargin(l.loop, l.K, 1e-3, delay);
      if (!(spectralRadius(closedLoop(l.loop, l.K, delay)) < 1.0)) {
        CHECK(margin == 0.0);
        continue;
      }
      double smallest = HUGE_VAL;
      for (int i = 1; i <= (longRun() ? 50000 : 2000); ++i) {
        const double angle = M_PI * i / (longRun() ? 50000 : 2000);
        const MatrixXd identity = MatrixXd::Identity(18, 18);
        const MatrixXd pencil = inReals(std::cos(angle) * identity - l.loop.A, std::sin(angle) * identity);
        const MatrixXd late = inReals(std::cos(delay * angle) * l.K, -std::sin(delay * angle) * l.K);
        const MatrixXd across = solve(pencil, inReals(l.loop.B, 0.0 * l.loop.B));
        const MatrixXd F = MatrixXd::Identity(12, 12) + product(late, across);
        smallest = std::min(smallest, std::sqrt(eigenvalues(product(F.transpose(), F)).real().minCoeff()));
      }
      // The grid is not finer than the minimum: it may be above by the square of half a grid step.
      CHECK(margin <= smallest * (1.0 + 1e-9));
      CHECK(margin > smallest * (1.0 - 1e-3));
    }
}

TEST_CASE("the delay that is tolerated is where simulations start to grow") {
  for (const Loop& l : servoLoops()) {
    const int tolerated = toleratedDelay(l.loop, l.K);
    REQUIRE(tolerated >= 0);
    for (const int delay : {tolerated, tolerated + 1}) {
      INFO("delay " << delay);
      VectorXd x = VectorXd::Ones(18);
      std::vector<VectorXd> underWay(static_cast<std::size_t>(delay), VectorXd::Zero(6));
      double early = 0.0, late = 0.0;
      for (int j = 0; j < 6000; ++j) {
        underWay.push_back(-l.K * x);
        x = l.loop.A * x + l.loop.B * underWay.front();
        underWay.erase(underWay.begin());
        if (j >= 1000 && j < 1100) early = std::max(early, x.norm());
        if (j >= 5900) late = std::max(late, x.norm());
        if (!(x.norm() < 1e100)) break;
      }
      CHECK((x.norm() < 1e100 && late < early) == (delay == tolerated));
    }
  }
}

TEST_CASE("the reference servo: known numbers") {
  const Loop l = servoLoop({});
  const ServoDesign design = designServo(referencePlant(), 1e-3, {});
  const auto poles = continuousPoles(closedLoop(design.augmented, design.K, 0), 1e-3);
  REQUIRE(poles.size() == 18);
  CHECK(std::abs(poles[0]) == Approx(1957.0).margin(0.5));  // rad/s: from the note of the reference file
  for (const auto& pole : poles) CHECK(pole.real() < 0.0);
  CHECK(toleratedDelay(l.loop, l.K) == 1);
  CHECK(spectralRadius(closedLoop(l.loop, l.K, 2)) == Approx(1.145).margin(1e-3));  // from an independent prototype
}

}  // namespace enamel::test_margins
