// Reference computations in 80 bits. They are in one file because each further number type costs Eigen seconds of
// compile time.
#pragma once

#include <Eigen/Core>

namespace enamel::bench {

using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

LongMatrix times(const LongMatrix& A, const LongMatrix& B);

/// Return A^-1 B; A must be square and regular.
LongMatrix solved(const LongMatrix& A, const LongMatrix& B);

}  // namespace enamel::bench
