// The projection onto the free space, checked by its optimality conditions.
#include "render/contact_projection.hpp"

#include <Eigen/Dense>
#include <algorithm>

#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"

namespace enamel::test_contact_projection {

namespace {

using Square = double[kMaxWalls][kMaxWalls];

// Largest violation of: l >= 0, slope h - G l <= 0, and one of both is zero. Relative to the size of the rows.
double violation(const Square& G, const double* h, int n, const double* l) {
  double worst = 0.0;
  for (int i = 0; i < n; ++i) {
    double slope = h[i], size = std::abs(h[i]);
    for (int j = 0; j < n; ++j) {
      slope -= G[i][j] * l[j];
      size += std::abs(G[i][j] * l[j]);
    }
    worst = std::max({worst, -l[i], (l[i] > 0.0 ? std::abs(slope) : slope) / size});
  }
  return worst;
}

}  // namespace

TEST_CASE("the projection is optimal", "[contact_projection]") {
  test::Random random(test::seed() + 4);
  for (int round = 0; round < test::count(3000, 300000); ++round) {
    const int n = 1 + round % 10, rank = 1 + round % 7;
    Eigen::MatrixXd g(n, rank);
    for (Eigen::Index i = 0; i < g.size(); ++i) g.data()[i] = random.uniform(-1.0, 1.0);
    Eigen::MatrixXd product = g * g.transpose();
    product.diagonal().array() += round % 3 == 0 ? 1e-3 : 0.3;  // of materials
    Square G;
    double h[kMaxWalls], l[kMaxWalls];
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) G[i][j] = product(i, j);
      h[i] = random.uniform(-1.0, 2.0);
    }
    REQUIRE(solveNonNegative(G, h, n, l));
    CHECK(violation(G, h, n, l) < 1e-9);
  }
}

}  // namespace enamel::test_contact_projection
