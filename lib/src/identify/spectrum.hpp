// Spectra of residuals, and their whitening. Private to identify.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace enamel::identify {

/// Transforms signals of one length. They are tapered at both ends.
class Spectrum {
 public:
  /// `bandwidth` is the width of the narrowest band, Hz.
  Spectrum(Eigen::Index count, double period, double bandwidth);

  Eigen::Index count() const noexcept { return window_.size(); }
  /// Number of independent samples that the window leaves.
  double samples() const noexcept { return energy_; }

  /// Return the spectrum at 0 to half of the sample rate, scaled so that mean(|.|^2) is the mean square of the signal.
  Eigen::VectorXcd transform(const Eigen::VectorXd& signal) const;
  /// Return the signal of a spectrum, times the window.
  Eigen::VectorXd inverse(const Eigen::VectorXcd& spectrum) const;

  /// Return the frequencies of a spectrum, Hz.
  Eigen::VectorXd frequencies() const;

  /// Return the mean of values at all frequencies, positive and negative.
  double mean(const Eigen::VectorXd& values) const;

  /// Return the mean power in each band from that at each frequency, and back. Between the middles of bands the
  /// logarithm of the power is linear.
  Eigen::VectorXd bands(const Eigen::VectorXd& power) const;
  Eigen::VectorXd spread(const Eigen::VectorXd& bands) const;

 private:
  Eigen::VectorXd window_;
  double energy_ = 0.0;
  Eigen::Index size_;        // of the transform
  double line_ = 0.0;        // between two frequencies, Hz
  std::vector<int> band_;    // of each frequency
  std::vector<int> inBand_;  // frequencies in each band
};

}  // namespace enamel::identify
