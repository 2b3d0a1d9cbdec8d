// The delta on many poses, on invalid joint vectors, and at the edge of its workspace.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <iostream>

#include "enamel/device/delta/mechanism.hpp"
#include "support/catch.hpp"
#include "support/deltas.hpp"
#include "support/relative_error.hpp"
#include "support/run_length.hpp"

namespace enamel::test_delta {

namespace {

// The loops of a leg, computed independently: how much the distance of the bars' ends differs from b, m.
struct Loops {
  const DeltaGeometry g;
  const double homeDistance;
  const Vec3 q;

  struct At {
    Vec3 error;        // (|far - near|^2 - b^2) / (2 b)
    Mat3 bars;         // rows: directions from near to far
    Vec3 elbow, lean;  // sin of t2 - t1; z of the lower link
    bool outer;        // all parallelograms opened the right way
  };

  At operator()(const Vec3& position) const {
    At at;
    at.outer = true;
    for (int i = 0; i < 3; ++i) {
      const Vec3 u(std::cos(g.phi[i]), std::sin(g.phi[i]), 0.0), v(-u.y(), u.x(), 0.0), z = Vec3::UnitZ();
      const Vec3 upper = std::cos(q[i]) * u + std::sin(q[i]) * z;
      const Vec3 elbow = g.r * u + g.s * v - homeDistance * z + g.a * upper;
      const Vec3 span = position + g.c * u + g.f * v - elbow;
      const Vec3 lower = (span - span.dot(v) * v).normalized();
      const Vec3 bar = span - (g.d + g.e) * lower;
      at.error[i] = (bar.squaredNorm() - g.b * g.b) / (2.0 * g.b);
      at.bars.row(i) = bar.transpose() / g.b;
      at.elbow[i] = -upper.cross(lower).dot(v);
      at.lean[i] = lower.z();
      at.outer = at.outer && bar.dot(lower) > 0.0;
    }
    return at;
  }
};

// Return poses on the branch of home (sign `order` of the determinant) that Newton's method finds from random starts.
std::vector<Vec3> posesFound(const Loops& loops, double order, int starts, test::Random& random) {
  std::vector<Vec3> found;
  for (int k = 0; k < starts; ++k) {
    Vec3 p = random.vector(0.2);
    bool converged = false;
    for (int i = 0; i < 60 && !converged; ++i) {
      const Loops::At at = loops(p);
      Vec3 step = -at.bars.inverse() * at.error;
      if (!step.allFinite()) break;
      if (step.norm() > 0.05) step *= 0.05 / step.norm();
      p += step;
      converged = step.norm() < 1e-12;
    }
    const Loops::At at = loops(p);
    if (!converged || !at.outer || !(at.elbow.minCoeff() > kSmallestDeltaMeasure) || !(at.lean.minCoeff() > 0.0) ||
        !(order * at.bars.determinant() > kSmallestDeltaMeasure))
      continue;
    bool known = false;
    for (const Vec3& other : found) known = known || (p - other).norm() < 1e-7;
    if (!known) found.push_back(p);
  }
  return found;
}

}  // namespace

TEST_CASE("delta: forward undoes inverse kinematics, and J is the derivative, on the whole cube", "[hard]") {
  constexpr std::uint64_t seed = 20261122;
  const int poses = test::count(20000, 200000);
  for (const auto& [device, cube] : test::someDeltas()) {
    const DeltaModel model = makeModel(device);
    test::Random random(seed);
    double worstNear_m = 0.0, worstCold_m = 0.0, worstJacobian = 0.0;
    int failures = 0;
    DeltaConfiguration home;
    REQUIRE(inverseKinematics(model, Vec3::Zero(), home) == Status::ok);
    const auto anglesAt = [&](const Vec3& p) {
      DeltaConfiguration c;
      if (inverseKinematics(model, p, c) != Status::ok) ++failures;
      return jointAngles(c);
    };
    for (int i = 0; i < poses; ++i) {
      const Vec3 position = random.vector(cube);
      DeltaConfiguration c, near, cold = home;
      if (inverseKinematics(model, position, c) != Status::ok) ++failures;
      const Vec3 q = jointAngles(c);
      near.position = position + 0.005 * random.direction();
      if (forwardKinematics(model, q, near) != Status::ok || forwardKinematics(model, q, cold) != Status::ok)
        ++failures;
      worstNear_m = std::max(worstNear_m, (near.position - position).norm());
      worstCold_m = std::max(worstCold_m, (cold.position - position).norm());
      // As in tests/unit/mechanism.cpp: truncation 1e-10 in the corners, rounding 1e-16 / h = 3e-12.
      const double h = 3e-5;
      Mat3 rows, differences;
      for (int k = 0; k < 3; ++k) {
        const Vec3 e = Vec3::Unit(k);
        rows.row(k) = c.leg[k].row.transpose();
        differences.col(k) = (8.0 * (anglesAt(position + h * e) - anglesAt(position - h * e)) -
                              (anglesAt(position + 2 * h * e) - anglesAt(position - 2 * h * e))) /
                             (12.0 * h);
      }
      worstJacobian = std::max(worstJacobian, test::relativeError(rows, differences));
      worstJacobian = std::max(worstJacobian, (jacobian(c) * differences - Mat3::Identity()).cwiseAbs().maxCoeff());
    }
    std::cout << device.name << ", " << poses << " poses, seed " << seed << ": failures " << failures
              << "; worst error near " << worstNear_m << " m, cold " << worstCold_m << " m; J " << worstJacobian
              << "\n";
    CHECK(failures == 0);
    CHECK(worstNear_m < 1e-12);  // limit of the specification
    CHECK(worstCold_m < 1e-12);
    CHECK(worstJacobian < 5e-9);  // 1e-10 times the condition number of J in the corners (20)
  }
}

TEST_CASE("delta: any joint vector gets a status, and ok means the one pose on the branch of home", "[hard]") {
  constexpr std::uint64_t seed = 42;
  const int vectors = test::count(2000, 20000);
  for (const auto& [device, cube] : test::someDeltas()) {
    const DeltaModel model = makeModel(device);
    test::Random random(seed);
    DeltaConfiguration home;
    REQUIRE(inverseKinematics(model, Vec3::Zero(), home) == Status::ok);
    const Vec3 q0 = jointAngles(home);
    int ok = 0, unreachable = 0, singular = 0, notFinite = 0, missed = 0, wrong = 0, several = 0;
    for (int i = 0; i < vectors; ++i) {
      Vec3 q = q0 + random.vector(i % 2 == 0 ? M_PI : 1.2);
      if (i % 50 == 0) q[i / 50 % 3] = i % 100 == 0 ? std::nan("") : HUGE_VAL;
      DeltaConfiguration c = home;
      const Status status = forwardKinematics(model, q, c);
      REQUIRE((status == Status::notFinite) == !q.allFinite());
      switch (status) {
        case Status::ok: ++ok; break;
        case Status::unreachable: ++unreachable; break;
        case Status::singular: ++singular; break;
        default: ++notFinite; break;
      }
      if (status != Status::ok) REQUIRE(c.position == home.position);
      if (status == Status::notFinite) continue;
      const Loops loops{device.geometry, device.homeDistance, q};
      if (status == Status::ok) {
        const Loops::At at = loops(c.position);
        REQUIRE(at.error.cwiseAbs().maxCoeff() < 1e-14);  // m: rounding of lengths of 0.2 m
        REQUIRE(at.outer);
        REQUIRE(at.elbow.minCoeff() > 0.0);
        REQUIRE(at.lean.minCoeff() > 0.0);
        REQUIRE(model.order * at.bars.determinant() > 0.0);
        // Inverse kinematics returns the joint vector, except for whole turns.
        DeltaConfiguration back;
        REQUIRE(inverseKinematics(model, c.position, back) == Status::ok);
        const Vec3 again = jointAngles(back);
        // Near the elbow's singularity the error of angles is the square root: 1e-16 / kSmallestDeltaMeasure^2.
        for (int k = 0; k < 3; ++k) REQUIRE(std::abs(std::remainder(again[k] - q[k], 2.0 * M_PI)) < 1e-9);
      }
      const std::vector<Vec3> found = posesFound(loops, model.order, 30, random);
      if (found.size() > 1) ++several;
      if (status != Status::ok && !found.empty()) ++missed;
      for (const Vec3& p : found)
        if (status == Status::ok && (p - c.position).norm() > 1e-7) ++wrong;
    }
    std::cout << device.name << ", " << vectors << " vectors, seed " << seed << ": ok " << ok << ", unreachable "
              << unreachable << ", singular " << singular << ", not finite " << notFinite << "; missed " << missed
              << ", several poses " << several << ", another pose " << wrong << "\n";
    CHECK(ok > vectors / 10);
    CHECK(unreachable > vectors / 20);
    // The search uses two starts only. Of 1e5 vectors far outside the workspace, it refused one that has a pose. A
    // refusal is safe; a wrong pose would not be.
    CHECK(missed <= vectors / 10000);
    CHECK(several == 0);
    CHECK(wrong == 0);
  }
}

}  // namespace enamel::test_delta
