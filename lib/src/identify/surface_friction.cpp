#include "enamel/identify/surface_friction.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"

namespace enamel {
namespace {

constexpr int kBlocks = 20;
constexpr double kStudent = 2.093;  // 95 % of Student's distribution with 19 degrees of freedom
constexpr std::size_t kLeastSlides = 100;
constexpr int kGrid = 40;
constexpr double kRange = 1e-4;  // of log v_s: end of the search

// Sums of products of the three columns and the force, of a block.
using Products = Eigen::Matrix4d;

struct Solution {
  Eigen::Vector3d x = Eigen::Vector3d::Zero();  // mu_k, mu_s - mu_k, viscosity
  double logSpeed = 0.0;                        // ln v_s
  double squares = std::numeric_limits<double>::infinity();
};

// Least squares with non-negative numbers: the best of all choices of numbers that are zero.
Solution solve(const Products& sums, bool hasStribeck) {
  Solution best;
  for (int free = 0; free < 8; ++free) {
    if (!hasStribeck && (free & 2) != 0) continue;
    std::array<Eigen::Index, 3> index{};
    Eigen::Index count = 0;
    for (Eigen::Index i = 0; i < 3; ++i)
      if ((free >> i & 1) != 0) index[static_cast<std::size_t>(count++)] = i;
    Eigen::Matrix3d A = Eigen::Matrix3d::Identity();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < count; ++i) {
      for (Eigen::Index j = 0; j < count; ++j)
        A(i, j) = sums(index[static_cast<std::size_t>(i)], index[static_cast<std::size_t>(j)]);
      b[i] = sums(index[static_cast<std::size_t>(i)], 3);
    }
    const Eigen::Vector3d y = A.ldlt().solve(b);
    if (!y.allFinite() || y.minCoeff() < 0.0) continue;
    const double squares = sums(3, 3) - b.dot(y);
    if (!(squares < best.squares)) continue;
    best.squares = squares;
    best.x.setZero();
    for (Eigen::Index i = 0; i < count; ++i) best.x[index[static_cast<std::size_t>(i)]] = y[i];
  }
  return best;
}

class Slides {
 public:
  explicit Slides(const std::vector<SlideSample>& slides) : slides_(slides) {
    double least = slides.front().speed, most = least;
    for (const SlideSample& s : slides) least = std::min(least, s.speed), most = std::max(most, s.speed);
    low_ = std::log(least);
    high_ = std::log(most);
    for (int i = 0; i <= kGrid; ++i) grid_.push_back(sumsAt(low_ + i * step()));
  }

  // The best solution without one block; -1: with all.
  Solution without(int block, bool hasStribeck) const {
    hasStribeck = hasStribeck && high_ > low_;
    Solution best = solutionOf(grid_[0], block, low_, hasStribeck);
    if (!hasStribeck) return best;
    const auto use = [&](const Sums& sums, double logSpeed) {
      const Solution next = solutionOf(sums, block, logSpeed, true);
      if (next.squares < best.squares) best = next;
    };
    for (int i = 1; i <= kGrid; ++i) use(grid_[static_cast<std::size_t>(i)], low_ + i * step());
    for (double way = step(); way > kRange; way *= 0.5)
      for (const double next : {best.logSpeed - way, best.logSpeed + way}) use(sumsAt(next), next);
    return best;
  }

  double low() const { return low_; }
  double high() const { return high_; }

 private:
  using Sums = std::array<Products, kBlocks>;

  double step() const { return (high_ - low_) / kGrid; }

  Sums sumsAt(double logSpeed) const {
    const double speed = std::exp(logSpeed);
    Sums sums;
    sums.fill(Products::Zero());
    for (std::size_t i = 0; i < slides_.size(); ++i) {
      const SlideSample& s = slides_[i];
      const double ratio = s.speed / speed;
      const Eigen::Vector4d row(s.normal, s.normal * std::exp(-ratio * ratio), s.speed, s.tangential);
      sums[i * kBlocks / slides_.size()] += row * row.transpose();
    }
    return sums;
  }

  static Solution solutionOf(const Sums& sums, int without, double logSpeed, bool hasStribeck) {
    Products all = Products::Zero();
    for (int b = 0; b < kBlocks; ++b)
      if (b != without) all += sums[static_cast<std::size_t>(b)];
    Solution solution = solve(all, hasStribeck);
    solution.logSpeed = logSpeed;
    return solution;
  }

  const std::vector<SlideSample>& slides_;
  double low_, high_;
  std::vector<Sums> grid_;
};

using Numbers = Eigen::Vector4d;  // mu_s, mu_k, ln v_s, viscosity

Numbers numbersOf(const Solution& s) { return {s.x[0] + s.x[1], s.x[0], s.logSpeed, s.x[2]}; }

// Half widths of the intervals, by the jackknife. The difference mu_s - mu_k has the last one.
Eigen::Matrix<double, 5, 1> halfWidths(const Slides& slides, bool hasStribeck) {
  using Column = Eigen::Matrix<double, 5, 1>;
  std::array<Column, kBlocks> each;
  Column mean = Column::Zero();
  for (int b = 0; b < kBlocks; ++b) {
    const Solution s = slides.without(b, hasStribeck);
    Column& values = each[static_cast<std::size_t>(b)];
    values << numbersOf(s), s.x[1];
    mean += values / kBlocks;
  }
  Column square = Column::Zero();
  for (const Column& values : each) square += (values - mean).cwiseAbs2();
  return kStudent * ((kBlocks - 1.0) / kBlocks * square).cwiseSqrt();
}

void enter(Estimate& estimate, double value, double half) {
  estimate.value = value;
  estimate.low = std::max(0.0, value - half);
  estimate.high = value + half;
}

}  // namespace

SurfaceFriction fitFriction(const std::vector<SlideSample>& slides) {
  if (slides.size() < kLeastSlides)
    throw Error("there are " + std::to_string(slides.size()) + " samples of slides, must be at least " +
                std::to_string(kLeastSlides));
  for (std::size_t i = 0; i < slides.size(); ++i) {
    const SlideSample& s = slides[i];
    if (!(s.speed > 0.0 && s.normal > 0.0 && std::isfinite(s.speed) && std::isfinite(s.normal) &&
          std::isfinite(s.tangential)))
      throw Error("sample " + std::to_string(i + 1) + " of the slides has a speed of " + formatNumber(s.speed) +
                  " m/s and forces of " + formatNumber(s.normal) + " N and " + formatNumber(s.tangential) +
                  " N; speed and normal force must be above 0, and all finite");
  }
  const Slides data(slides);
  Solution best = data.without(-1, true);
  Eigen::Matrix<double, 5, 1> half = halfWidths(data, true);
  SurfaceFriction result;
  const bool isInside = best.logSpeed > data.low() && best.logSpeed < data.high();
  result.stribeck.isSeen = isInside && best.x[1] > half[4];
  if (!result.stribeck.isSeen) {
    best = data.without(-1, false);
    half = halfWidths(data, false);
    result.hidden = "the friction does not depend visibly on the speed between " + formatNumber(std::exp(data.low())) +
                    " and " + formatNumber(std::exp(data.high())) +
                    " m/s; slower slides would show whether it is larger near rest";
  }
  const Numbers x = numbersOf(best);
  enter(result.rest, x[0], half[0]);
  enter(result.sliding, x[1], half[1]);
  enter(result.viscosity, x[3], half[3]);
  if (result.stribeck.isSeen) {
    result.stribeck.value = std::exp(x[2]);
    result.stribeck.low = std::exp(x[2] - half[2]);
    result.stribeck.high = std::exp(x[2] + half[2]);
  }
  result.error = std::sqrt(std::max(0.0, best.squares) / static_cast<double>(slides.size()));
  return result;
}

std::vector<SlideSample> loadSlides(const std::string& file) {
  const std::string text = readFile(file);
  std::vector<SlideSample> slides;
  std::size_t line = 0;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    const char *at = text.data() + from, *const stop = text.data() + end;
    from = end + 1;
    ++line;
    const auto skip = [&] {
      while (at < stop && (std::isspace(static_cast<unsigned char>(*at)) != 0 || *at == ',' || *at == ';')) ++at;
    };
    skip();
    const bool isHeading = slides.empty() && at < stop && std::isalpha(static_cast<unsigned char>(*at)) != 0;
    if (at == stop || *at == '#' || isHeading) continue;
    std::array<double, 3> numbers{};
    for (double& number : numbers) {
      const auto [rest, error] = std::from_chars(at, stop, number);
      if (error != std::errc())
        throw Error(file + ":" + std::to_string(line) +
                    ": must have three numbers: speed (m/s), normal and tangential " + "force (N)");
      at = rest;
      skip();
    }
    if (at != stop) throw Error(file + ":" + std::to_string(line) + ": has more than three numbers");
    slides.push_back({numbers[0], numbers[1], numbers[2]});
  }
  return slides;
}

}  // namespace enamel
