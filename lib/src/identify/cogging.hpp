// Search for the period of cogging in the residual of a fit. Private to identify.
#pragma once

#include "identify/fit.hpp"

namespace enamel::identify {

/// Periods of cogging in one turn of the joint (or 2 pi m), and how much it explains.
struct CoggingSearch {
  double periods = 0.0;
  double evidence = 0.0;  ///< gain of the log likelihood at that period
  Eigen::MatrixXd parts;  ///< amplitudes of sine and cosine, one row per joint, N m or N
};

/// Regress the residual's torque on sine and cosine of each number of periods that the motion can show.
CoggingSearch findCogging(Fit& fit);

/// Return the unknowns of cogging with about `periods` periods: two amplitudes a joint, and the periods.
std::vector<Unknown> coggingUnknowns(const DeviceModel& model, const Eigen::MatrixXd& reading);

}  // namespace enamel::identify
