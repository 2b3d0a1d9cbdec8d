// References in 80 bits. Plain loops: Eigen's products and decompositions compile for seconds for one more kind of number.
#pragma once

#include <Eigen/Core>

namespace enamel::bench {

using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

LongMatrix times(const LongMatrix& A, const LongMatrix& B);

/// A^-1 B, by elimination with partial pivoting; A is square and regular.
LongMatrix solved(LongMatrix A, LongMatrix B);

}  // namespace enamel::bench
