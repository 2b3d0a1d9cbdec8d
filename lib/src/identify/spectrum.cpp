#include "identify/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/FFT>

namespace enamel::identify {
namespace {

constexpr double kTaper = 0.25;  // s, at each end

Eigen::FFT<double> halfTransform() {
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  return fft;
}

}  // namespace

Spectrum::Spectrum(Eigen::Index count, double period, double bandwidth) : window_(Eigen::VectorXd::Ones(count)) {
  const auto taper = std::min<Eigen::Index>(count / 4, static_cast<Eigen::Index>(kTaper / period));
  for (Eigen::Index i = 0; i < taper; ++i)
    window_[i] = window_[count - 1 - i] =
        0.5 - 0.5 * std::cos(M_PI * (static_cast<double>(i) + 0.5) / static_cast<double>(taper));
  energy_ = window_.squaredNorm();
  for (size_ = 1; size_ < count;) size_ *= 2;
  line_ = 1.0 / (static_cast<double>(size_) * period);
  double begin = 0.0;
  inBand_.assign(1, 0);
  for (Eigen::Index k = 0; k <= size_ / 2; ++k) {
    const double f = static_cast<double>(k) * line_;
    const double width = std::max(bandwidth, 0.06 * begin);
    const double end = 0.5 / period;
    if (f > begin + width && f + 0.5 * width < end) {
      begin = f;
      inBand_.push_back(0);
    }
    band_.push_back(static_cast<int>(inBand_.size()) - 1);
    ++inBand_.back();
  }
}

Eigen::VectorXcd Spectrum::transform(const Eigen::VectorXd& signal) const {
  Eigen::VectorXd padded = Eigen::VectorXd::Zero(size_);
  padded.head(count()) = signal.cwiseProduct(window_);
  Eigen::VectorXcd spectrum(size_ / 2 + 1);
  halfTransform().fwd(spectrum.data(), padded.data(), size_);
  return spectrum / std::sqrt(energy_);
}

Eigen::VectorXd Spectrum::inverse(const Eigen::VectorXcd& spectrum) const {
  Eigen::VectorXd padded(size_);
  halfTransform().inv(padded.data(), spectrum.data(), size_);
  return std::sqrt(energy_) * padded.head(count());
}

Eigen::VectorXd Spectrum::frequencies() const {
  return Eigen::VectorXd::LinSpaced(size_ / 2 + 1, 0.0, line_ * static_cast<double>(size_ / 2));
}

double Spectrum::mean(const Eigen::VectorXd& values) const {
  return (2.0 * values.sum() - values[0] - values[values.size() - 1]) / static_cast<double>(size_);
}

Eigen::VectorXd Spectrum::bands(const Eigen::VectorXd& power) const {
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(inBand_.size()));
  for (std::size_t k = 0; k < band_.size(); ++k)
    mean[band_[k]] += power[static_cast<Eigen::Index>(k)] / inBand_[static_cast<std::size_t>(band_[k])];
  return mean;
}

Eigen::VectorXd Spectrum::spread(const Eigen::VectorXd& bands) const {
  const Eigen::VectorXd height = bands.array().log();
  Eigen::VectorXd power(static_cast<Eigen::Index>(band_.size()));
  double begin = 0.0, middle = 0.0, before = 0.0;  // lines: of the band, its middle, that of the band before
  Eigen::Index k = 0;
  for (Eigen::Index i = 0; i < height.size(); ++i, before = middle) {
    const double count = inBand_[static_cast<std::size_t>(i)], low = height[std::max<Eigen::Index>(0, i - 1)];
    middle = begin + 0.5 * (count - 1.0);
    begin += count;
    const double last = i + 1 < height.size() ? middle : begin;
    for (; static_cast<double>(k) <= last && k < power.size(); ++k) {
      const double share = std::min(1.0, (static_cast<double>(k) - before) / std::max(1.0, middle - before));
      power[k] = std::exp(low + share * (height[i] - low));
    }
  }
  return power;
}

}  // namespace enamel::identify
