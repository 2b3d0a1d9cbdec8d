#include "support/relative_error.hpp"

namespace enamel::test {

double relativeError(const Eigen::MatrixXd& value, const Eigen::MatrixXd& reference) {
  return (value - reference).cwiseAbs().maxCoeff() / reference.cwiseAbs().maxCoeff();
}

}  // namespace enamel::test
