// The quadratic program of the contact forces, checked by its optimality conditions and a closed form.
#include "render/contact_forces.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"

namespace enamel::test_contact_forces {

namespace {

// `rank` below `contacts`: dependent contacts, regularised as in the servo.
ContactProblem randomProblem(test::Random& random, int contacts, int rank) {
  Eigen::MatrixXd N(contacts, rank);
  for (Eigen::Index i = 0; i < N.size(); ++i) N.data()[i] = random.uniform(-1.0, 1.0);
  Eigen::MatrixXd G = N * N.transpose();
  G.diagonal() *= 1.001;
  G.diagonal().array() += 1e-6;
  ContactProblem p;
  p.contacts = contacts;
  p.motors = 6;
  for (int i = 0; i < contacts; ++i) {
    p.r[i] = random.uniform(-20.0, 40.0);
    for (int j = 0; j < contacts; ++j) p.G[i][j] = G(i, j);
  }
  for (int m = 0; m < p.motors; ++m) {
    for (int i = 0; i < contacts; ++i) p.motor[m][i] = random.uniform(-0.1, 0.1);
    p.low[m] = -random.uniform(0.1, 2.0);
    p.high[m] = random.uniform(0.1, 2.0);
  }
  return p;
}

// Worst violation of a bound, and of the optimality conditions: G x - r = sum of multipliers (>= 0) times the normals
// of the active bounds. The multipliers come from non-negative least squares (projected Gauss-Seidel on its normal
// equations).
struct Violation {
  double bound = 0.0, optimality = 0.0;
};
Violation violationOf(const ContactProblem& p, const ContactSolution& s) {
  const int n = p.contacts;
  Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(s.force, n), slope(n);
  for (int i = 0; i < n; ++i) {
    slope[i] = -p.r[i];
    for (int j = 0; j < n; ++j) slope[i] += p.G[i][j] * x[j];
  }
  Violation v;
  std::vector<Eigen::VectorXd> normals;
  const auto bound = [&](const Eigen::VectorXd& normal, double low) {
    const double slack = normal.dot(x) - low;
    v.bound = std::max(v.bound, -slack);
    if (slack < 1e-7) normals.push_back(normal);
  };
  for (int i = 0; i < n; ++i) {
    bound(Eigen::VectorXd::Unit(n, i), 0.0);
    bound(-Eigen::VectorXd::Unit(n, i), -p.most);
  }
  for (int m = 0; m < p.motors; ++m) {
    const Eigen::VectorXd row = Eigen::Map<const Eigen::VectorXd>(p.motor[m], n);
    bound(row, p.low[m]);
    bound(-row, -p.high[m]);
  }
  Eigen::VectorXd rest = slope, multipliers = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(normals.size()));
  for (int sweep = 0; sweep < 20000 && rest.norm() > 1e-9; ++sweep)
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      const double next = std::max(0.0, multipliers[at] + rest.dot(normals[i]) / normals[i].squaredNorm());
      rest -= (next - multipliers[at]) * normals[i];
      multipliers[at] = next;
    }
  v.optimality = rest.norm();
  return v;
}

}  // namespace

TEST_CASE("contact forces keep to all bounds and are the best that do", "[contact_forces]") {
  test::Random random(4);
  int limited = 0;
  for (int i = 0; i < test::count(3000, 100000); ++i) {
    const int contacts = 1 + i % kMaxActiveContacts;
    const ContactProblem p = randomProblem(random, contacts, contacts);
    const ContactSolution s = solveContacts(p);
    REQUIRE(s.exact);
    const Violation v = violationOf(p, s);
    CHECK(v.bound < 1e-9);
    CHECK(v.optimality < 1e-5);  // slopes are about 10; the multipliers' iteration is less exact than the solver
    limited += s.limited;
  }
  CHECK(limited > 100);
}

TEST_CASE("dependent contacts share, and none is inverted blindly", "[contact_forces]") {
  test::Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const int contacts = 2 + i % 5;
    const ContactProblem p = randomProblem(random, contacts, 1 + i % std::min(contacts - 1, 3));
    const ContactSolution s = solveContacts(p);
    CHECK(violationOf(p, s).bound < 1e-9);  // even if the search was cut short
    for (int k = 0; k < contacts; ++k) CHECK((s.force[k] >= 0.0 && s.force[k] <= p.most));
  }
  // The same contact twice: half of the force each.
  ContactProblem p;
  p.contacts = 2;
  for (auto& row : p.G) row[0] = row[1] = 4.0;
  p.G[0][0] = p.G[1][1] = 4.004;
  p.r[0] = p.r[1] = 8.0;
  const ContactSolution s = solveContacts(p);
  CHECK(s.force[0] == Approx(s.force[1]));
  CHECK(s.force[0] + s.force[1] == Approx(2.0).epsilon(1e-3));
}

TEST_CASE("a motor's limit makes one force smaller and never turns it", "[contact_forces]") {
  ContactProblem p;
  p.contacts = 1;
  p.motors = 2;
  p.G[0][0] = 2.0;
  p.r[0] = 100.0;
  p.motor[0][0] = 0.1;
  p.motor[1][0] = -0.2;
  p.low[0] = p.low[1] = -1.0;
  p.high[0] = p.high[1] = 3.0;
  const ContactSolution s = solveContacts(p);
  CHECK(s.limited);
  CHECK(s.force[0] == Approx(5.0));
  p.r[0] = -1.0;
  CHECK(solveContacts(p).force[0] == 0.0);
  CHECK_FALSE(solveContacts(p).limited);
  p.r[0] = 100.0;
  p.most = 4.0;  // below the motors' limits: none of them saturates
  CHECK(solveContacts(p).force[0] == Approx(4.0));
  CHECK_FALSE(solveContacts(p).limited);
}

}  // namespace enamel::test_contact_forces
