// Exponential e^A of small matrices.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace enamel {

template <int kRows, int kColumns = kRows>
using Matrix = Eigen::Matrix<double, kRows, kColumns>;

// Compute e^A by scaling and squaring of its Taylor series. lazyProduct() is ten times as fast here as Eigen's product
// for large matrices.
template <int kSize>
Matrix<kSize> exponential(const Matrix<kSize>& A) {
  const double size = A.cwiseAbs().rowwise().sum().maxCoeff();
  const int squarings = std::max(0, static_cast<int>(std::ceil(std::log2(std::max(1e-9, size)))) + 2);
  const Matrix<kSize> scaled = A * std::ldexp(1.0, -squarings);
  Matrix<kSize> term = Matrix<kSize>::Identity(), sum = term;
  for (int i = 1; i <= 14; ++i) {
    term = (term.lazyProduct(scaled) / i).eval();
    sum += term;
  }
  for (int i = 0; i < squarings; ++i) sum = sum.lazyProduct(sum).eval();
  return sum;
}

}  // namespace enamel
