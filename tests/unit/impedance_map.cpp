#include "enamel/control/impedance_map.hpp"

#include <cmath>

#include "enamel/control/discretise.hpp"
#include "enamel/control/margins.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/control_systems.hpp"
#include "support/run_length.hpp"

namespace enamel::test_impedance_map {

using namespace enamel::test;
using Eigen::MatrixXd;
using Eigen::Vector2d;

namespace {

// Return the spectral radius of the wall while the tool stays in contact: states [z', z, z one tick ago, pending
// forces].
double contactRadius(const WallDevice& device, const SpringWall& wall) {
  const MatrixXd A = (MatrixXd(2, 2) << -device.damping / device.mass, 0, 1, 0).finished();
  const StateSpace held = zeroOrderHold({A, Vector2d(1.0 / device.mass, 0.0)}, device.period);
  const Eigen::Index n = 3 + wall.delay;
  MatrixXd closed = MatrixXd::Zero(n, n);
  closed.topLeftCorner(2, 2) = held.A;
  closed(2, 1) = 1.0;
  Eigen::RowVectorXd force = Eigen::RowVectorXd::Zero(n);
  force[1] = -wall.stiffness - wall.damping / device.period;
  force[2] = wall.damping / device.period;
  if (wall.delay == 0) {
    closed.topRows(2) += held.B * force;
  } else {
    closed.block(0, n - 1, 2, 1) += held.B;
    closed.row(3) += force;
    for (Eigen::Index i = 4; i < n; ++i) closed(i, i - 1) = 1.0;
  }
  return spectralRadius(closed);
}

}  // namespace

TEST_CASE("simulated stability is that of the eigenvalues in contact") {
  // If the motion in contact decays, the tool comes to rest in the wall; if it grows, the tool bounces for ever.
  std::mt19937_64 random(20260201);
  int stable = 0, unstable = 0;
  for (int i = 0; i < (longRun() ? 5000 : 200); ++i) {
    const auto draw = [&random](double low, double high) {
      const double share = 0.5 + 0.5 * randomMatrix(random, 1, 1)(0, 0);
      return low * std::pow(high / low, share);
    };
    const WallDevice device{draw(0.05, 1.0), draw(1.0, 10.0), 1e-3};
    const SpringWall wall{draw(500.0, 50000.0), draw(0.1, 100.0), static_cast<int>(random() % 4)};
    const double radius = contactRadius(device, wall);
    // Near the border, growth or decay within a third of 3 s is less than a half: radius^1000 = 1/2 at 1 - 7e-4.
    if (std::abs(radius - 1.0) < 3e-3) continue;
    INFO("draw " << i << ": m " << device.mass << " b " << device.damping << " K " << wall.stiffness << " B "
                 << wall.damping << " d " << wall.delay << " radius " << radius);
    CHECK(isWallStable(device, wall) == (radius < 1.0));
    ++(radius < 1.0 ? stable : unstable);
  }
  CHECK(stable > 20);
  CHECK(unstable > 20);
}

TEST_CASE("eq. 16 is kept: a passive wall without delay is stable; the paper's numbers") {
  const WallDevice device{0.273, 4.0, 1e-3};  // the nominal TAU along z with the paper's damping
  // "stiffness less than 8000 N/m": simulation agrees with the bound within a few per cent.
  CHECK(isWallStable(device, {7000.0, 0.0, 0}));
  CHECK_FALSE(isWallStable(device, {9000.0, 0.0, 0}));
  const auto map = mapWallStability(device, {1e3, 3e3, 5e3, 7e3, 2e4, 1e5}, {0.0, 0.4, 2.0, 10.0}, {0, 1, 2});
  REQUIRE(map.size() == 72);
  int passive = 0, broken = 0;
  for (const WallStability& entry : map) {
    const bool isPassive = device.damping > 0.5 * entry.wall.stiffness * device.period + entry.wall.damping;  // eq. 16
    if (isPassive && entry.wall.delay == 0) {
      ++passive;
      CHECK(entry.stable);
    }
    broken += isPassive && entry.wall.delay > 0 && !entry.stable;
  }
  CHECK(passive > 5);
  CHECK(broken > 0);  // the bound does not consider delay
}

TEST_CASE("walls and devices that do not exist are refused") {
  const WallDevice device{0.273, 4.0, 1e-3};
  const SpringWall wall{1000.0, 1.0, 0};
  CHECK_THROWS_AS(isWallStable({0.0, 4.0, 1e-3}, wall), DesignError);
  CHECK_THROWS_AS(isWallStable({0.1, -4.0, 1e-3}, wall), DesignError);
  CHECK_THROWS_AS(isWallStable({0.1, 4.0, 0.0}, wall), DesignError);
  CHECK_THROWS_AS(isWallStable({0.1, 4.0, NAN}, wall), DesignError);
  CHECK_THROWS_AS(isWallStable(device, {-1.0, 1.0, 0}), DesignError);
  CHECK_THROWS_AS(isWallStable(device, {1000.0, NAN, 0}), DesignError);
  CHECK_THROWS_AS(isWallStable(device, {1000.0, 1.0, -1}), DesignError);
}

}  // namespace enamel::test_impedance_map
