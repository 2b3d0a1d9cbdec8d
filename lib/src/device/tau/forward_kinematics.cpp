// Forward kinematics: solve the loop equations for the elevations, from a near start or along a path from home.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/trigonometry.hpp"
#include "enamel/device/tau/kinematics.hpp"
#include "loop.hpp"

namespace enamel {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kNearShare = 0.25;  // of the length of link 2

// The knees, which depend on the driven angles only.
struct Knees {
  std::array<double, 3> sinYaw, cosYaw, sinLift, cosLift;
  std::array<Vec3, 3> point;  // K_i, m
};

// Elevations of the three links 2, as points on the unit circle.
struct Elevations {
  std::array<double, 3> cosine, sine;
};

Knees kneesAt(const TauModel& model, const Vec6& q) noexcept {
  Knees k;
  Eigen::Array<double, 6, 1> sine, cosine;
  sinCos<6>(q.array(), sine, cosine);
  for (int i = 0; i < 3; ++i) {
    k.sinYaw[i] = sine[2 * i];
    k.cosYaw[i] = cosine[2 * i];
    k.sinLift[i] = sine[2 * i + 1];
    k.cosLift[i] = cosine[2 * i + 1];
    const double l1 = model.chain[i].length1;
    const double horizontal = l1 * k.cosLift[i];
    k.point[i] = model.chain[i].base + Vec3(horizontal * k.sinYaw[i], l1 * k.sinLift[i], horizontal * k.cosYaw[i]);
  }
  return k;
}

// Project the directions from the knees to the tips of a start onto the planes of the legs. Returns false if a tip
// would move by more than kNearShare of link 2; the start is then too far away.
bool project(const TauModel& model, const Knees& knees, const TauConfiguration& start, Elevations& e) noexcept {
  bool near = true;
  for (int i = 0; i < 3; ++i) {
    const double length = model.chain[i].length2;
    const Vec3 d = start.chain[i].tip - knees.point[i];
    const double horizontal = d.x() * knees.sinYaw[i] + d.z() * knees.cosYaw[i];
    const double lateral = d.x() * knees.cosYaw[i] - d.z() * knees.sinYaw[i];
    const double norm = std::sqrt(horizontal * horizontal + d.y() * d.y());
    const double radial = norm - length;
    near = near && norm > 0.0 && lateral * lateral + radial * radial < kNearShare * kNearShare * length * length;
    e.cosine[i] = horizontal / norm;
    e.sine[i] = d.y() / norm;
  }
  return near;
}

// Rotate the elevations by small angles, to third order. The result is exactly on the circle and needs no trigonometry.
void turn(Elevations& e, const Vec3& angle) noexcept {
  for (int i = 0; i < 3; ++i) {
    const double half = angle[i] * (0.5 + angle[i] * angle[i] * (1.0 / 24.0));  // tan(angle / 2)
    const double scale = 1.0 / (1.0 + half * half);
    const double c = (1.0 - half * half) * scale, s = 2.0 * half * scale;
    const double cosine = e.cosine[i] * c - e.sine[i] * s;
    e.sine[i] = e.sine[i] * c + e.cosine[i] * s;
    e.cosine[i] = cosine;
  }
}

// One evaluation of the loop equations: residuals, matrix, and the data of the second-order term.
struct Loop {
  std::array<Vec3, 3> tip, slope, side;
  Vec3 residual;  // m^2
  LoopMatrix matrix;
  double determinant;
};

Loop evaluate(const TauModel& model, const Knees& knees, const Elevations& e) noexcept {
  Loop loop;
  for (int i = 0; i < 3; ++i) {
    const double l2 = model.chain[i].length2;
    const double c = l2 * e.cosine[i], s = l2 * e.sine[i];
    loop.tip[i] = knees.point[i] + Vec3(c * knees.sinYaw[i], s, c * knees.cosYaw[i]);
    loop.slope[i] = Vec3(-s * knees.sinYaw[i], c, -s * knees.cosYaw[i]);
  }
  for (int k = 0; k < 3; ++k) {
    loop.side[k] = loop.tip[k] - loop.tip[(k + 1) % 3];
    loop.residual[k] = 0.5 * (loop.side[k].squaredNorm() - model.side[k] * model.side[k]);
  }
  loop.matrix = loopMatrix(loop.side, loop.slope);
  loop.determinant = loop.matrix.determinant();
  return loop;
}

struct Correction {
  Vec3 step;      // the whole step, rad
  double newton;  // largest element of its Newton part, rad
};

// Newton's step plus Chebyshev's term -J^-1 f''(d, d) / 2.
Correction correction(const Knees& knees, const Loop& loop) noexcept {
  const double inverse = 1.0 / loop.determinant;
  const Vec3 d = -inverse * loop.matrix.solveScaled(loop.residual);
  Vec3 curvature;
  for (int k = 0; k < 3; ++k) {
    const int j = (k + 1) % 3;
    const double own = (loop.tip[k] - knees.point[k]).dot(loop.tip[j] - knees.point[k]);
    const double next = (loop.tip[j] - knees.point[j]).dot(loop.tip[k] - knees.point[j]);
    curvature[k] = 0.5 * (d[k] * d[k] * own + d[j] * d[j] * next) - d[k] * d[j] * loop.slope[k].dot(loop.slope[j]);
  }
  return {d - inverse * loop.matrix.solveScaled(curvature), d.cwiseAbs().maxCoeff()};
}

// The iteration converges cubically: after a smaller Newton step the error is below 1e-14 rad.
constexpr double kLastStep = 2e-6;  // rad
constexpr int kMaxIterations = 8;
constexpr double kContraction = 0.3;   // largest ratio of successive steps; cubic convergence is far better
constexpr double kLargestFirst = 0.2;  // rad: a larger first step means that the start is too far away

struct Solution {
  bool converged = false;
  int iterations = 0;
  double firstStep = 0.0;         // rad
  double firstDeterminant = 0.0;  // at the start, m^6
  double determinant = 0.0;       // at the last evaluation
};

// Iterate from `e` while the steps contract and the determinant keeps the sign of the home branch.
Solution iterate(const TauModel& model, const Knees& knees, double smallestDeterminant, double largestFirst,
                 Elevations& e) noexcept {
  Solution solution;
  double limit = largestFirst;
  while (solution.iterations < kMaxIterations) {
    const Loop loop = evaluate(model, knees, e);
    solution.determinant = loop.determinant;
    if (solution.iterations == 0) solution.firstDeterminant = loop.determinant;
    if (!(loop.determinant * model.homeSign > smallestDeterminant)) return solution;
    const Correction c = correction(knees, loop);
    ++solution.iterations;
    if (!(c.newton <= limit && c.step.cwiseAbs().maxCoeff() <= 2.0 * limit)) return solution;
    if (solution.iterations == 1) solution.firstStep = c.newton;
    turn(e, c.step);
    if (c.newton <= kLastStep) {
      solution.converged = true;
      return solution;
    }
    limit = std::max(kContraction * c.newton, kLastStep);
  }
  return solution;
}

// Whether two near configurations are on the same side of all singularities: the determinant hardly changes.
bool sameSide(double determinant, double other) noexcept {
  const double ratio = other / determinant;
  return ratio > 0.6 && ratio < 1.6;
}

// Whether the elbows have the signs of the home branch and the tips are in front of their yaw axes.
bool chainsOnBranch(const TauModel& model, const Knees& knees, const Elevations& e) noexcept {
  for (int i = 0; i < 3; ++i) {
    const ChainModel& chain = model.chain[i];
    const double sinElbow = e.sine[i] * knees.cosLift[i] - e.cosine[i] * knees.sinLift[i];
    const double radius = chain.length1 * knees.cosLift[i] + chain.length2 * e.cosine[i];
    if (!(sinElbow * chain.elbow > kSingular)) return false;
    if (!(radius > kSingular * (chain.length1 + chain.length2))) return false;
  }
  return true;
}

// Fill the configuration from a solution and return its residual, m.
double fill(const TauModel& model, const Knees& knees, const Elevations& e, TauConfiguration& configuration) noexcept {
  for (int i = 0; i < 3; ++i) {
    const ChainModel& chain = model.chain[i];
    ChainConfiguration& c = configuration.chain[i];
    c.sinYaw = knees.sinYaw[i];
    c.cosYaw = knees.cosYaw[i];
    c.sinLift = knees.sinLift[i];
    c.cosLift = knees.cosLift[i];
    c.sinLink2 = e.sine[i];
    c.cosLink2 = e.cosine[i];
    c.sinElbow = c.sinLink2 * c.cosLift - c.cosLink2 * c.sinLift;
    c.radius = chain.length1 * c.cosLift + chain.length2 * c.cosLink2;
    c.tip = knees.point[i] + chain.length2 * link2Direction(c);
  }
  const Vec3 &p0 = configuration.chain[0].tip, &p1 = configuration.chain[1].tip, &p2 = configuration.chain[2].tip;
  const Vec3 side1 = p1 - p0, side2 = p2 - p0;
  Mat3 triad;
  triad.col(0) = side1;
  triad.col(1) = side2;
  triad.col(2) = side1.cross(side2);
  Mat3& rotation = configuration.pose.rotation;
  rotation.noalias() = triad.lazyProduct(model.triadInverse);
  configuration.pose.position = (p0 + p1 + p2) * (1.0 / 3.0) - rotation * model.platformCentre;
  for (int i = 0; i < 3; ++i) configuration.chain[i].arm = rotation * model.chain[i].platform;
  // |d| - side to first order in the error, without a square root.
  const auto error = [&model](const Vec3& d, int k) {
    return std::abs(d.squaredNorm() - model.side[k] * model.side[k]) / (2.0 * model.side[k]);
  };
  return std::max({error(side1, 0), error(p2 - p1, 1), error(side2, 2)});
}

// A necessary condition: the distances between the knees permit those between the tips.
bool tipsCanMeet(const TauModel& model, const Knees& knees) noexcept {
  for (int k = 0; k < 3; ++k) {
    const int j = (k + 1) % 3;
    const double reach = model.chain[k].length2 + model.chain[j].length2 + model.side[k];
    if ((knees.point[k] - knees.point[j]).norm() > reach) return false;
  }
  return true;
}

double wrapped(double angle) noexcept { return std::remainder(angle, 2.0 * kPi); }

}  // namespace

ForwardKinematicsReport forwardKinematics(const TauModel& model, const Vec6& q,
                                          TauConfiguration& configuration) noexcept {
  if (!q.allFinite()) return {Status::notFinite, 0, 0.0};
  const Knees knees = kneesAt(model, q);
  Elevations e;
  Solution solution;
  if (project(model, knees, configuration, e))
    solution = iterate(model, knees, kSingular * loopScale(model), kLargestFirst, e);
  if (solution.converged && sameSide(solution.firstDeterminant, solution.determinant) &&
      chainsOnBranch(model, knees, e))
    return {Status::ok, solution.iterations, fill(model, knees, e, configuration)};
  ForwardKinematicsReport report = forwardKinematicsFromHome(model, q, configuration);
  report.iterations += solution.iterations;
  return report;
}

ForwardKinematicsReport forwardKinematicsFromHome(const TauModel& model, const Vec6& q,
                                                  TauConfiguration& configuration) noexcept {
  if (!q.allFinite()) return {Status::notFinite, 0, 0.0};
  const Knees target = kneesAt(model, q);
  if (!tipsCanMeet(model, target)) return {Status::unreachable, 0, 0.0};

  Vec6 way;
  for (int i = 0; i < 6; ++i) way[i] = wrapped(q[i] - model.homeAngles[i]);
  const double smallest = kSingular * loopScale(model);
  const double length = way.cwiseAbs().maxCoeff();

  TauConfiguration current = model.home;
  Vec3 tangent = Vec3::Zero();  // derivative of the elevations for the whole path; zero before the first step
  double done = 0.0;            // share of the path that is done
  double share = length > 0.0 ? std::min(1.0, 0.05 / length) : 1.0;
  double determinant = model.homeSign * std::abs(loopMeasure(model, model.home)) * loopScale(model);
  int iterations = 0;
  while (iterations < kMaxWalkIterations) {
    const double next = std::min(1.0, done + share);
    const Knees knees = next < 1.0 ? kneesAt(model, model.homeAngles + next * way) : target;
    Elevations e;
    for (int i = 0; i < 3; ++i) {
      e.cosine[i] = current.chain[i].cosLink2;
      e.sine[i] = current.chain[i].sinLink2;
    }
    const Vec3 predicted = (next - done) * tangent;
    const bool shortEnough = predicted.cwiseAbs().maxCoeff() <= 0.1;
    Solution solution;
    if (shortEnough) {
      turn(e, predicted);
      solution = iterate(model, knees, smallest, 0.05, e);
      iterations += solution.iterations;
    }
    if (shortEnough && solution.converged && sameSide(determinant, solution.firstDeterminant) &&
        sameSide(determinant, solution.determinant) && chainsOnBranch(model, knees, e)) {
      const double residual = fill(model, knees, e, current);
      if (next >= 1.0) {
        configuration = current;
        return {Status::ok, iterations, residual};
      }
      // Derivative of the elevations along the path, from the derivative of the loop equations.
      const auto sides = sidesOf(current);
      std::array<Vec3, 3> velocity;  // of the tips at fixed elevations
      for (int i = 0; i < 3; ++i) {
        const ChainConfiguration& c = current.chain[i];
        const double yaw = way[2 * i], lift = model.chain[i].length1 * way[2 * i + 1];
        velocity[i] = Vec3(yaw * c.radius * c.cosYaw - lift * c.sinLift * c.sinYaw, lift * c.cosLift,
                           -yaw * c.radius * c.sinYaw - lift * c.sinLift * c.cosYaw);
      }
      Vec3 drift;
      for (int k = 0; k < 3; ++k) drift[k] = sides[k].dot(velocity[k] - velocity[(k + 1) % 3]);
      const LoopMatrix matrix = loopMatrix(sides, slopesOf(model, current));
      tangent = matrix.solveScaled(drift) / -matrix.determinant();
      determinant = solution.determinant;
      done = next;
      share *= 2.0;
    } else {
      share *= 0.5;
      ++iterations;  // limits the walk even if a step needs no iteration
      if (share * length < 1e-4) return {Status::singular, iterations, 0.0};
    }
  }
  return {Status::notConverged, iterations, 0.0};
}

}  // namespace enamel
