// The fit of a model to recorded motions. Private to identify.
//
// The residual is the recorded reading minus the simulated one (output error). Whittle's likelihood weights it: the
// power of the residual in each band of frequencies is its variance there. The minus log likelihood is
//
//   L = 1/2 sum over joints and frequencies of [log S(f) + |e(f)|^2 / S(f)],  S: power of e in bands.
//
// Source: P. Whittle, "The analysis of multiple stationary time series", 1953. Gauss and Newton's step with the
// damping of Levenberg (1944) and Marquardt (1963) reduces it. Derivatives are those of the linearised simulation.
#pragma once

#include <complex>
#include <memory>
#include <vector>

#include "enamel/identify/identify.hpp"
#include "identify/simulation.hpp"
#include "identify/spectrum.hpp"

namespace enamel::identify {

inline constexpr double kNormal = 1.96;       // 95 % of the normal distribution
inline constexpr double kNoiseBegin = 100.0;  // Hz

class Fit {
 public:
  /// `motions` must outlive the fit. It starts at x = 0.
  Fit(DeviceModel reference, std::vector<Unknown> unknowns, const std::vector<RecordedMotion>& motions, int threads);

  const std::vector<Unknown>& unknowns() const noexcept { return unknowns_; }
  /// Return the index of an unknown, or -1.
  int find(const std::string& key) const noexcept;
  DeviceModel model() const { return modelAt(reference_, unknowns_, x); }
  DeviceModel& reference() noexcept { return reference_; }

  /// Use the data from `begin` s to `end` s, counted over all motions. Infinite: to their end.
  void use(double begin, double end);

  /// Take at most `steps` steps of Gauss and Newton. Derivatives are computed again if they predict a step badly, or
  /// never with `keepsSlopes`. `corner` is for a model that is far from the device: an error of 5 % of the reading
  /// counts as noise, and more above that frequency, Hz. With 0 the residual is the noise.
  void improve(int steps, double corner = 0.0, bool keepsSlopes = false);

  /// Return the minus log likelihood L at x, with its prior. Comparable for the same data.
  double misfit();

  /// Return the covariance of x, such that kNormal deviations are a 95 % interval. It is that of the jackknife: the
  /// spread of the estimates without one block of kBlock s each, plus that of the prior. It holds for residuals of any
  /// spectrum and changing variance, and for numbers that few blocks show (R. Bell and D. McCaffrey, "Bias reduction in
  /// standard errors for linear regression with multi-stage samples", 2002). Student's distribution is wider than the
  /// normal one: with R. Fisher's expansion (1925) by (kNormal^2 + 1) / (4 (blocks - 1)). A variance below the inverse
  /// of the information is replaced by it. A fixed unknown has zero rows.
  Eigen::MatrixXd covariance();

  /// Return the share of the variance of the torque that the model explains below 20 Hz, for each joint.
  Eigen::VectorXd explained();

  /// Return the traces of the first piece.
  IdentificationTraces traces();

  /// Return the torque that would explain the residual of the first piece, for each joint, whitened. whitenTorque()
  /// applies the same filter to another torque. residualReading() is the reading there, one row per joint.
  std::vector<Eigen::VectorXd> whiteTorque();
  Eigen::VectorXd whitenTorque(Eigen::Index joint, const Eigen::VectorXd& torque) const;
  const Eigen::MatrixXd& residualReading() const noexcept { return reading_; }
  /// Return the commands that acted there after a delay, ticks, one row per joint.
  Eigen::MatrixXd residualCommand(int delay) const;
  /// Return the period of the ticks, s.
  double period() const noexcept { return motions_.front().period; }

  /// Return the deviation of each residual above kNoiseBegin, rad or m.
  Eigen::VectorXd noise();

  /// Compute the error of the simulation's steps at x: the difference to much shorter ones, extrapolated to zero length
  /// (L. Richardson, 1911). From now on residuals are corrected by it, until use(). It hardly changes with x.
  void refine();

  /// Forget the simulation at x: reference() was changed.
  void forget() { baseAt_.resize(0); }

  /// Add unknowns, at their references.
  void add(const std::vector<Unknown>& unknowns);

  Eigen::VectorXd x;          ///< coordinates of the unknowns
  std::vector<char> isFixed;  ///< unknowns that improve() does not change
  int threads;                ///< of simulations; results do not depend on it
  int restarts = 0;           ///< of the last simulation at x; above 0: the model left the workspace

 private:
  struct Piece {
    const RecordedMotion* motion;
    Eigen::Index start;         // tick where the simulation begins
    Eigen::Index first, count;  // ticks whose residuals count; those before are transient
    Eigen::MatrixXd route;      // joint coordinates near the motion, from `start`: a column for each tick
    std::shared_ptr<const Spectrum> spectrum;
  };
  struct Block {
    Eigen::MatrixXd information;
    Eigen::VectorXd score;
  };
  using Residuals = std::vector<Eigen::MatrixXd>;            // per piece, joints x ticks
  using Powers = std::vector<std::vector<Eigen::VectorXd>>;  // per piece and joint, at each frequency

  std::vector<PathDynamics> computePaths(const DeviceModel& model, double period, int interval) const;
  const std::vector<PathDynamics>& pathsAt(const Eigen::VectorXd& at, const DeviceModel& model);
  std::vector<Simulated> simulateAll(const DeviceModel& model, const Observer& observer,
                                     const std::vector<PathDynamics>& paths) const;
  Residuals residuals(const std::vector<Simulated>& simulated) const;
  Residuals corrected(const Eigen::VectorXd& at, int& left);
  ModelChange changeOf(std::size_t i) const;
  void updateSlopes();
  Powers powers(const Residuals& residuals, double corner) const;
  double cost(const Residuals& residuals, const Powers& powers) const;
  Eigen::MatrixXd priorInformation() const;
  std::vector<Block> blocks(const Powers& powers) const;
  double priorCost(const Eigen::VectorXd& at) const;
  void normalEquations(const Residuals& residuals, const Powers& powers, Eigen::MatrixXd& A, Eigen::VectorXd& b) const;
  Eigen::VectorXd stepOf(const Eigen::MatrixXd& A, const Eigen::VectorXd& b, double damping) const;
  Eigen::VectorXd torquePerReading(const Spectrum& spectrum, Eigen::Index joint) const;
  Eigen::VectorXcd slope(std::size_t i, std::size_t p, Eigen::Index joint) const {
    return slopes_[i][p].col(joint).cast<std::complex<double>>();
  }
  bool isHeld(std::size_t i, const Eigen::VectorXd& b) const;

  DeviceModel reference_;
  std::vector<Unknown> unknowns_;
  const std::vector<RecordedMotion>& motions_;
  Observer observer_;
  std::vector<PathDynamics> paths_;  // of the pieces
  Eigen::VectorXd pathsAt_;          // x of paths_
  Residuals correction_;
  Eigen::VectorXd floor_;  // least power of a residual in each joint: a part of the encoder's rounding
  std::vector<Piece> pieces_;
  std::vector<std::vector<Eigen::MatrixXcf>> slopes_;  // per unknown and piece: spectra of d reading / d x, by column
  Residuals base_;
  Eigen::MatrixXd reading_;                  // of the first piece
  std::vector<Eigen::VectorXd> torqueGain_;  // of the filter of whitenTorque(), per joint
  Eigen::VectorXd baseAt_;                   // x of base_
};

}  // namespace enamel::identify
