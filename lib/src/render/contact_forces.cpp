#include "render/contact_forces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "enamel/core/cholesky.hpp"

namespace enamel {
namespace {

constexpr int kN = kMaxActiveContacts;
constexpr int kMostSteps = 60;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

using Vector = double[kN];

double dot(const double* a, const double* b, int n) noexcept {
  double s = 0.0;
  for (int i = 0; i < n; ++i) s += a[i] * b[i];
  return s;
}

// A constraint normal^T x >= bound.
struct Constraint {
  Vector normal = {};
  double bound = 0.0;
};

int countOf(const ContactProblem& p) noexcept { return 2 * p.contacts + 2 * p.motors; }
bool isMotor(const ContactProblem& p, int number) noexcept { return number >= 2 * p.contacts; }

Constraint constraint(const ContactProblem& p, int number) noexcept {
  Constraint c;
  if (number < p.contacts) {
    c.normal[number] = 1.0;
  } else if (number < 2 * p.contacts) {
    c.normal[number - p.contacts] = -1.0;
    c.bound = -p.most;
  } else {
    const int motor = (number - 2 * p.contacts) / 2;
    const bool upper = number % 2 == 1;
    for (int k = 0; k < p.contacts; ++k) c.normal[k] = upper ? -p.motor[motor][k] : p.motor[motor][k];
    c.bound = upper ? -p.high[motor] : p.low[motor];
  }
  return c;
}

// Return the constraint that is violated by the largest distance, or -1 if all hold within rounding.
int mostViolated(const ContactProblem& p, const Vector& x) noexcept {
  int worst = -1;
  double distance = 0.0;
  for (int number = 0; number < countOf(p); ++number) {
    const Constraint c = constraint(p, number);
    const double slack = dot(c.normal, x, p.contacts) - c.bound;
    if (slack >= -1e-9 * (1.0 + std::abs(c.bound))) continue;
    const double size = std::sqrt(dot(c.normal, c.normal, p.contacts));
    if (slack < distance * size) {
      distance = slack / size;
      worst = number;
    }
  }
  return worst;
}

ContactSolution solveOne(const ContactProblem& p) noexcept {
  double most = p.most;
  for (int i = 0; i < p.motors; ++i) {
    const double t = p.motor[i][0];
    if (t > 0.0) most = std::min(most, p.high[i] / t);
    if (t < 0.0) most = std::min(most, p.low[i] / t);
  }
  const double wanted = p.r[0] / p.G[0][0];
  ContactSolution solution;
  solution.force[0] = std::max(0.0, std::min(wanted, most));
  solution.limited = wanted > most && most < p.most;
  return solution;
}

// Clamp each force to its bounds, then scale all forces by a common factor until the motor limits hold.
void makeFeasible(const ContactProblem& p, Vector& x) noexcept {
  for (int k = 0; k < p.contacts; ++k) x[k] = std::max(0.0, std::min(x[k], p.most));
  double share = 1.0;
  for (int i = 0; i < p.motors; ++i) {
    const double t = dot(p.motor[i], x, p.contacts);
    if (t > p.high[i]) share = std::min(share, p.high[i] / t);
    if (t < p.low[i]) share = std::min(share, p.low[i] / t);
  }
  for (int k = 0; k < p.contacts; ++k) x[k] *= share;
}

// The constraints that hold with equality, and their multipliers.
struct ActiveSet {
  int count = 0;
  int number[kN];
  Vector normal[kN];
  Vector step[kN];  // G^-1 normal
  double multiplier[kN];

  void remove(int at) noexcept {
    --count;
    for (int i = at; i < count; ++i) {
      number[i] = number[i + 1];
      std::copy(normal[i + 1], normal[i + 1] + kN, normal[i]);
      std::copy(step[i + 1], step[i + 1] + kN, step[i]);
      multiplier[i] = multiplier[i + 1];
    }
  }
};

// Algorithm 1 of Goldfarb and Idnani (1983). Returns false if it runs out of steps.
bool descend(const ContactProblem& p, const Cholesky<kN>& G, Vector& x, ActiveSet& active) noexcept {
  const int n = p.contacts;
  int steps = 0;
  for (int worst = mostViolated(p, x); worst >= 0; worst = mostViolated(p, x)) {
    const Constraint c = constraint(p, worst);
    Vector whole;
    std::copy(c.normal, c.normal + kN, whole);
    G.solve(whole);
    double added = 0.0;
    for (bool full = false; !full;) {
      if (++steps > kMostSteps) return false;
      // Derivatives of x and of the multipliers by the multiplier of this constraint.
      Vector z, change = {};
      std::copy(whole, whole + kN, z);
      if (active.count > 0) {
        double S[kN][kN];
        for (int i = 0; i < active.count; ++i) {
          for (int j = 0; j <= i; ++j) S[i][j] = dot(active.normal[i], active.step[j], n);
          change[i] = dot(active.step[i], c.normal, n);
        }
        Cholesky<kN> schur;
        if (!schur.factor(S, active.count)) return false;
        schur.solve(change);
        for (int i = 0; i < active.count; ++i)
          for (int k = 0; k < n; ++k) z[k] -= change[i] * active.step[i][k];
      }
      // Step until a multiplier reaches zero or the constraint holds.
      double partialStep = kInfinity;
      int dropped = -1;
      for (int i = 0; i < active.count; ++i)
        if (change[i] > 0.0 && active.multiplier[i] < partialStep * change[i]) {
          partialStep = active.multiplier[i] / change[i];
          dropped = i;
        }
      const double slope = dot(c.normal, z, n);
      const bool canMove = active.count < n && slope > 1e-12 * dot(c.normal, whole, n);
      const double fullStep = canMove ? (c.bound - dot(c.normal, x, n)) / slope : kInfinity;
      full = fullStep <= partialStep;
      const double step = std::min(fullStep, partialStep);
      if (step == kInfinity) return false;  // infeasible; cannot happen while low <= 0 <= high
      if (canMove)
        for (int k = 0; k < n; ++k) x[k] += step * z[k];
      for (int i = 0; i < active.count; ++i) active.multiplier[i] -= step * change[i];
      added += step;
      if (!full) active.remove(dropped);
    }
    const int last = active.count++;
    active.number[last] = worst;
    active.multiplier[last] = added;
    std::copy(c.normal, c.normal + kN, active.normal[last]);
    std::copy(whole, whole + kN, active.step[last]);
  }
  return true;
}

}  // namespace

ContactSolution solveContacts(const ContactProblem& p) noexcept {
  if (p.contacts == 1) return solveOne(p);
  ContactSolution solution;
  if (p.contacts <= 0 || p.contacts > kN) return solution;
  Cholesky<kN> G;
  if (!G.factor(p.G, p.contacts)) {
    solution.exact = false;
    return solution;
  }
  std::copy(p.r, p.r + p.contacts, solution.force);
  G.solve(solution.force);
  ActiveSet active;
  solution.exact = descend(p, G, solution.force, active);
  solution.limited = !solution.exact;
  for (int i = 0; i < active.count; ++i) solution.limited = solution.limited || isMotor(p, active.number[i]);
  makeFeasible(p, solution.force);  // removes rounding errors, and violations that an aborted search leaves
  return solution;
}

}  // namespace enamel
