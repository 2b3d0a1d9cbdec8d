// The dynamics of a mechanism near a recorded path. Private to identify.
//
// Near a place q0 of the path, with d = q - q0, the equations of motion are those of Lagrange:
//
//   M q'' = torque - g - C(q'),  M = M0 + sum_k dM/dq_k d_k,  g = g0 + sum_k (dg/dq_k + dC(v0)/dq_k) d_k,
//   C_i(v) = sum_jk (dM_ij/dq_k - 1/2 dM_jk/dq_i) v_j v_k,
//
// with the path's rates v0. q0, M0, g0 and the derivatives are computed at knots of equal distance in time. Between
// knots each of these numbers f is the cubic polynomial through four of them. Its error is at most 3/128 T^4 max|d^4
// f/dt^4|, T s between knots.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "enamel/device/mechanism.hpp"

namespace enamel::identify {

/// The numbers at all knots, or their derivatives with respect to a parameter of the mechanism.
struct PathDynamics {
  int interval = 1;  ///< between knots, ticks
  /// A column for each knot: q0, then [g0; M0], [dg/dq_0 + dC/dq_0; dM/dq_0], ... Matrices are in columns.
  Eigen::MatrixXd knots;
  int outside = 0;  ///< knots out of reach: they have the numbers of the one before
};

/// Compute the dynamics along a route: joint coordinates at each tick, `period` s apart. With a period of 0 C has no
/// derivatives. Throws Error if the first is out of reach.
PathDynamics dynamicsAlong(const Mechanism& mechanism, const Eigen::MatrixXd& route, double period, int interval,
                           int threads);

/// The dynamics at one place of the path of a mechanism with N joints.
template <int N>
struct PlaceDynamics {
  static constexpr int kTerms = N + N * N;
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  Eigen::Matrix<double, N + kTerms*(N + 1), 1> numbers = decltype(numbers)::Zero();
  Eigen::Matrix<double, kTerms, 1> sum = decltype(sum)::Zero();  // [g; M]

  /// Interpolate, `ticks` ticks after the first knot.
  void interpolate(const PathDynamics& path, double ticks) {
    const double knot = ticks / path.interval;
    const auto last = static_cast<double>(path.knots.cols() - 4);
    const double begin = std::min(std::max(0.0, std::floor(knot) - 1.0), last), s = knot - begin;
    const auto k = static_cast<Eigen::Index>(begin);
    numbers = -(s - 1.0) * (s - 2.0) * (s - 3.0) / 6.0 * path.knots.col(k) +
              s * (s - 2.0) * (s - 3.0) / 2.0 * path.knots.col(k + 1) -
              s * (s - 1.0) * (s - 3.0) / 2.0 * path.knots.col(k + 2) +
              s * (s - 1.0) * (s - 2.0) / 6.0 * path.knots.col(k + 3);
  }
  /// Move from q0 to q0 + d.
  void moveTo(const Vector& d) {
    sum = numbers.template segment<kTerms>(N);
    for (int k = 0; k < N; ++k) sum += d[k] * numbers.template segment<kTerms>(N + kTerms * (k + 1));
  }

  auto place() const { return numbers.template head<N>(); }
  auto gravity() const { return sum.template head<N>(); }
  auto inertia() const { return Eigen::Map<const Matrix>(sum.data() + N); }
  auto gravitySlope(int k) const { return numbers.template segment<N>(N + kTerms * (k + 1)); }
  auto inertiaSlope(int k) const { return Eigen::Map<const Matrix>(numbers.data() + 2 * N + kTerms * (k + 1)); }
  /// Return the torque g + C(v). Column k of `pushed` becomes dM/dq_k v.
  Vector bias(const Vector& v, Matrix& pushed) const {
    for (int k = 0; k < N; ++k) pushed.col(k).noalias() = inertiaSlope(k) * v;
    return gravity() + pushed * v - 0.5 * pushed.transpose() * v;
  }
};

}  // namespace enamel::identify
