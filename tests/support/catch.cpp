#include "support/catch.hpp"

#include <sstream>

namespace enamel::test {

std::string describe(const double* values, Eigen::Index rows, Eigen::Index columns, bool rowMajor) {
  std::ostringstream text;
  for (Eigen::Index i = 0; i < rows; ++i) {
    if (i > 0) text << '\n';
    for (Eigen::Index j = 0; j < columns; ++j)
      text << (j > 0 ? " " : "") << values[rowMajor ? i * columns + j : j * rows + i];
  }
  return text.str();
}

}  // namespace enamel::test
