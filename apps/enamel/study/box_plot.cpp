#include "study/box_plot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace enamel::app {
namespace {

constexpr std::array<const char*, 10> kColours = {kBlue, kVermilion, kGreen, kPurple, kOrange,
                                                 kSky,  kBrown,     kMuted, kInk,    kRed};

// Return a quantile, interpolated linearly between order statistics.
double quantile(const std::vector<double>& sorted, double share) {
  const double at = share * static_cast<double>(sorted.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (at - static_cast<double>(low)) * (sorted[high] - sorted[low]);
}

std::vector<double> drawable(const std::vector<double>& values) {
  std::vector<double> sorted;
  for (const double value : values)
    if (std::isfinite(value) && value > 0.0) sorted.push_back(value);
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

}  // namespace

std::string svgOf(const BoxPlot& plot) {
  constexpr double kLeft = 70.0, kHeight = 300.0, kGap = 24.0, kWidth = Svg::kWidth - kLeft - 4.0;
  Extent extent = plot.extent;
  if (plot.line > 0.0) extent.see(plot.line);
  for (const auto& group : plot.values)
    for (const auto& values : group)
      for (const double value : drawable(values)) extent.see(value);
  const Axis y = extent.axis(plot.yLabel, 0.05, true);

  Svg svg;
  std::vector<LegendEntry> entries;
  for (std::size_t s = 0; s < plot.series.size(); ++s)
    entries.push_back({plot.series[s], {kColours[s % kColours.size()]}, true});
  const double top = addLegend(svg, {kLeft, 0.0}, kWidth, entries) + 8.0, base = top + kHeight;
  Panel panel(svg, {kLeft, top}, kWidth, kHeight, {"", 0.0, 1.0, false, false}, y, "", false);
  for (const double tick : y.ticks(7)) panel.level(tick, {kLine, 1.0});
  if (plot.line > 0.0) panel.level(plot.line, {kInk, 1.0, true});
  const double wide = kWidth / static_cast<double>(plot.groups.size()),
               each = std::min(22.0, (wide - kGap) / static_cast<double>(plot.series.size()));
  for (std::size_t g = 0; g < plot.groups.size(); ++g) {
    const double middle = kLeft + wide * (static_cast<double>(g) + 0.5),
                 begin = middle - 0.5 * each * static_cast<double>(plot.series.size());
    svg.text({middle, base + 18.0}, plot.groups[g], Anchor::middle);
    for (std::size_t s = 0; s < plot.series.size(); ++s) {
      const double x = begin + each * (static_cast<double>(s) + 0.5), half = 0.38 * each;
      const Style style{kColours[s % kColours.size()], 1.2};
      const std::vector<double> sorted = drawable(plot.values[g][s]);
      if (sorted.empty()) {
        svg.text({x + 4.0, base - 4.0}, "none", Anchor::start, style.colour, true);
        continue;
      }
      const auto at = [&](double value) { return panel.at(0.0, value).y; };
      const double q1 = quantile(sorted, 0.25), q3 = quantile(sorted, 0.75), reach = 1.5 * (q3 - q1);
      double from = q1, to = q3;
      for (const double value : sorted) {
        if (value >= q1 - reach) from = std::min(from, value);
        if (value <= q3 + reach) to = std::max(to, value);
        if (value < q1 - reach || value > q3 + reach) svg.disc({x, at(value)}, 1.4, style.colour);
      }
      svg.line({x, at(from)}, {x, at(to)}, style);
      svg.box({x - half, at(q3)}, 2.0 * half, std::max(0.5, at(q1) - at(q3)), style.colour, "",
              "fill-opacity=\"0.35\" stroke=\"" + style.colour + "\"");
      const double median = at(quantile(sorted, 0.5));
      svg.line({x - half, median}, {x + half, median}, {style.colour, 2.2});
    }
  }
  return svg.whole(plot.yLabel, base + 28.0);
}

}  // namespace enamel::app
