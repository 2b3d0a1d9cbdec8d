#include "enamel/control/linearise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "control/dense.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxHalvings = 48;
constexpr int kOrders = 7;  // columns of the extrapolation table: errors of order step^2 ... step^14

// Derivative of `function` with respect to one variable, entry by entry, and its estimated error.
struct Derivative {
  ArrayXd value, error;
};

template <typename Function>
Derivative differentiate(const Function& function, const VectorXd& at, Eigen::Index variable, Eigen::Index outputs) {
  Derivative best{ArrayXd::Zero(outputs), ArrayXd::Constant(outputs, std::numeric_limits<double>::infinity())};
  std::vector<ArrayXd> previous;  // last row of the table: order 0, 1, ...
  const double scale = std::max(std::abs(at[variable]), 1.0);
  double step = std::ldexp(1.0, std::ilogb(scale) - 4);
  for (int halving = 0; halving < kMaxHalvings; ++halving, step *= 0.5) {
    VectorXd above = at, below = at;
    above[variable] += step;
    below[variable] -= step;
    const double width = above[variable] - below[variable];  // after rounding
    if (width == 0.0) break;
    const VectorXd high = function(above), low = function(below);
    if (!high.allFinite() || !low.allFinite()) {
      previous.clear();
      continue;
    }
    std::vector<ArrayXd> row{(high - low).array() / width};
    // Rounding errors of the values and, inside f, of the variable. They grow as the step shrinks. The search ends when
    // they dominate the error.
    const ArrayXd floor = std::numeric_limits<double>::epsilon() / width *
                          (high.array().abs().max(low.array().abs()) + scale * row[0].abs());
    if ((floor >= best.error).all()) break;
    double power = 1.0;
    for (std::size_t order = 1; order <= previous.size() && order < kOrders; ++order) {
      power *= 4.0;
      row.push_back(row[order - 1] + (row[order - 1] - previous[order - 1]) / (power - 1.0));
      // After Ridders: the largest distance to the neighbours in the table, so that a lucky value does not count as
      // accurate.
      ArrayXd error = (row[order] - row[order - 1]).abs().max((row[order] - previous[order - 1]).abs()).max(floor);
      if (order < previous.size()) error = error.max((row[order] - previous[order]).abs());
      const auto better = (error < best.error).eval();
      best.value = better.select(row[order], best.value);
      best.error = better.select(error, best.error);
    }
    previous = std::move(row);
  }
  if (!best.error.allFinite()) throw DesignError("linearise: the plant is not finite near the operating point");
  return best;
}

template <typename Function>
MatrixXd jacobianOf(const Function& function, const VectorXd& at, Eigen::Index outputs, double& relativeError) {
  MatrixXd jacobian(outputs, at.size());
  double error = 0.0;
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const Derivative column = differentiate(function, at, i, outputs);
    jacobian.col(i) = column.value.matrix();
    if (outputs > 0) error = std::max(error, column.error.maxCoeff());
  }
  const double largest = jacobian.size() > 0 ? jacobian.cwiseAbs().maxCoeff() : 0.0;
  if (error > 0.0)
    relativeError = std::max(relativeError, error / std::max(largest, std::numeric_limits<double>::min()));
  return jacobian;
}

}  // namespace

Linearisation linearise(const PlantFunction& f, const OutputFunction& h, const VectorXd& x0, const VectorXd& u0) {
  if (!x0.allFinite() || !u0.allFinite()) throw DesignError("linearise: the operating point is not finite");
  Linearisation result;
  result.offset = f(x0, u0);
  const VectorXd y0 = h(x0);
  if (result.offset.size() != x0.size())
    throw DesignError("linearise: x' has " + std::to_string(result.offset.size()) + " entries and x has " +
                      std::to_string(x0.size()));
  if (!result.offset.allFinite() || !y0.allFinite())
    throw DesignError("linearise: the plant is not finite at the operating point");
  const auto ofState = [&](const VectorXd& x) { return f(x, u0); };
  const auto ofInput = [&](const VectorXd& u) { return f(x0, u); };
  result.model.A = jacobianOf(ofState, x0, x0.size(), result.error);
  result.model.B = jacobianOf(ofInput, u0, x0.size(), result.error);
  result.C = jacobianOf(h, x0, y0.size(), result.error);
  return result;
}

StateSpace outputsAsStates(const Linearisation& linearisation) {
  const MatrixXd& C = linearisation.C;
  if (C.rows() == 0 || C.rows() != C.cols() || C.rows() != linearisation.model.A.rows() ||
      C.rows() != linearisation.model.A.cols() || C.rows() != linearisation.model.B.rows())
    throw DesignError("eq. 5: C is " + std::to_string(C.rows()) + " x " + std::to_string(C.cols()) + " for " +
                      std::to_string(linearisation.model.A.rows()) + " states; it must be square");
  // The units must not decide whether C is singular. Scale every row and column to a largest entry of about 1.
  VectorXd rowScale(C.rows()), columnScale(C.cols());
  for (Eigen::Index i = 0; i < C.rows(); ++i) {
    const double largest = C.row(i).cwiseAbs().maxCoeff();
    if (!(largest > 0.0)) throw DesignError("eq. 5: C is singular: output " + std::to_string(i) + " ignores the state");
    rowScale[i] = std::ldexp(1.0, -std::ilogb(largest));
  }
  const MatrixXd rowsScaled = rowScale.asDiagonal() * C;
  for (Eigen::Index i = 0; i < C.cols(); ++i) {
    const double largest = rowsScaled.col(i).cwiseAbs().maxCoeff();
    if (!(largest > 0.0)) throw DesignError("eq. 5: C is singular: no output shows state " + std::to_string(i));
    columnScale[i] = std::ldexp(1.0, -std::ilogb(largest));
  }
  const MatrixXd scaled = rowsScaled * columnScale.asDiagonal();
  const MatrixXd solved = solve(scaled, rowScale.asDiagonal());  // scaled^-1 times the scales of the rows
  const double condition = norm1(scaled) * norm1(solved * rowScale.cwiseInverse().asDiagonal());
  if (!(condition < 1e12)) throw DesignError("eq. 5: C is singular: the outputs do not determine the state");
  const MatrixXd inverse = columnScale.asDiagonal() * solved;
  return {product(product(C, linearisation.model.A), inverse), product(C, linearisation.model.B)};
}

}  // namespace enamel
