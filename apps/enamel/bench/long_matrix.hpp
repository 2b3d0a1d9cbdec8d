// References in 80 bits, in one file: one more kind of number costs Eigen seconds of compiling.
#pragma once

#include <Eigen/Core>

namespace enamel::bench {

using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

LongMatrix times(const LongMatrix& A, const LongMatrix& B);

/// A^-1 B; A is square and regular.
LongMatrix solved(const LongMatrix& A, const LongMatrix& B);

}  // namespace enamel::bench
