#include "bench/long_matrix.hpp"

#include <Eigen/LU>

namespace enamel::bench {

LongMatrix times(const LongMatrix& A, const LongMatrix& B) { return A * B; }

LongMatrix solved(const LongMatrix& A, const LongMatrix& B) { return A.partialPivLu().solve(B); }

}  // namespace enamel::bench
