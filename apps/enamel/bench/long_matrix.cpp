#include "bench/long_matrix.hpp"

#include <cmath>
#include <utility>

namespace enamel::bench {

using Eigen::Index;

LongMatrix times(const LongMatrix& A, const LongMatrix& B) {
  LongMatrix product(A.rows(), B.cols());
  for (Index i = 0; i < A.rows(); ++i)
    for (Index j = 0; j < B.cols(); ++j) {
      long double sum = 0.0L;
      for (Index k = 0; k < A.cols(); ++k) sum += A(i, k) * B(k, j);
      product(i, j) = sum;
    }
  return product;
}

LongMatrix solved(LongMatrix A, LongMatrix B) {
  const Index n = A.rows();
  // Row `to` minus a multiple of row `from`.
  const auto subtract = [&](Index to, Index from, long double factor) {
    for (Index j = 0; j < n; ++j) A(to, j) -= factor * A(from, j);
    for (Index j = 0; j < B.cols(); ++j) B(to, j) -= factor * B(from, j);
  };
  for (Index k = 0; k < n; ++k) {
    Index pivot = k;
    for (Index i = k + 1; i < n; ++i)
      if (std::abs(A(i, k)) > std::abs(A(pivot, k))) pivot = i;
    for (Index j = 0; j < n; ++j) std::swap(A(k, j), A(pivot, j));
    for (Index j = 0; j < B.cols(); ++j) std::swap(B(k, j), B(pivot, j));
    for (Index i = k + 1; i < n; ++i) subtract(i, k, A(i, k) / A(k, k));
  }
  for (Index k = n; k-- > 0;) {
    for (Index j = 0; j < B.cols(); ++j) B(k, j) /= A(k, k);
    for (Index i = 0; i < k; ++i)
      for (Index j = 0; j < B.cols(); ++j) B(i, j) -= A(i, k) * B(k, j);
  }
  return B;
}

}  // namespace enamel::bench
