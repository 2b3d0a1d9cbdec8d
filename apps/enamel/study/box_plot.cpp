#include "study/box_plot.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "study/page.hpp"

namespace enamel::app {
namespace {

// M. Okabe, K. Ito 2002, told apart by the colour-blind too.
constexpr std::array<const char*, 9> kColours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00",
                                                 "#56b4e9", "#8c6d1f", "#66707c", "#222222"};
constexpr double kLeft = 76.0, kTop = 12.0, kHeight = 300.0, kBox = 13.0, kGap = 26.0;

// A share of the way from one order statistic to the next.
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

std::string line(double x1, double y1, double x2, double y2, const std::string& style) {
  return fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" {}/>\n", x1, y1, x2, y2, style);
}

std::string words(double x, double y, const std::string& anchor, const std::string& text) {
  return fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", x, y, anchor, escape(text));
}

}  // namespace

std::string svgOf(const BoxPlot& plot) {
  double low = plot.line > 0.0 ? plot.line : 1e300, high = plot.line;
  for (const auto& group : plot.values)
    for (const auto& values : group)
      for (const double value : drawable(values)) low = std::min(low, value), high = std::max(high, value);
  if (!(low <= high)) low = high = 1.0;
  const double bottom = std::floor(std::log10(low) + 1e-9), top = std::max(bottom + 1.0, std::ceil(std::log10(high)));
  const auto y = [&](double value) { return kTop + kHeight * (top - std::log10(value)) / (top - bottom); };
  const double wide = kBox * static_cast<double>(plot.series.size()) + kGap;
  const double width = kLeft + wide * static_cast<double>(plot.groups.size()) + 8.0, base = kTop + kHeight;
  const double legend = base + 40.0;
  constexpr std::size_t kColumns = 3;
  const std::size_t rows = (plot.series.size() + kColumns - 1) / kColumns;

  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" style=\"max-width:100%\" "
      "font-family=\"system-ui, sans-serif\" font-size=\"12\" fill=\"#1f262e\">\n",
      std::max(width, 640.0), legend + 18.0 * static_cast<double>(rows));
  for (double decade = bottom; decade <= top + 0.5; ++decade) {
    const double at = y(std::pow(10.0, decade));
    svg += line(kLeft, at, width - 8.0, at, "stroke=\"#d3d9e0\"");
    svg += words(kLeft - 6.0, at + 4.0, "end", fmt::format("{:g}", std::pow(10.0, decade)));
  }
  svg += fmt::format("<text transform=\"translate(16,{:.0f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     kTop + 0.5 * kHeight, escape(plot.yLabel));
  if (plot.line > 0.0)
    svg += line(kLeft, y(plot.line), width - 8.0, y(plot.line), "stroke=\"#a84300\" stroke-dasharray=\"5 4\"");
  for (std::size_t g = 0; g < plot.groups.size(); ++g) {
    const double begin = kLeft + wide * static_cast<double>(g) + 0.5 * kGap;
    svg += words(begin + 0.5 * (wide - kGap), base + 18.0, "middle", plot.groups[g]);
    for (std::size_t s = 0; s < plot.series.size(); ++s) {
      const double x = begin + kBox * (static_cast<double>(s) + 0.5), half = 0.36 * kBox;
      const std::string colour = kColours[s % kColours.size()], stroke = "stroke=\"" + colour + "\"";
      const std::vector<double> sorted = drawable(plot.values[g][s]);
      if (sorted.empty()) {
        svg += fmt::format(
            "<text transform=\"translate({:.1f},{:.1f}) rotate(-90)\" fill=\"{}\" font-size=\"10\">"
            "none</text>\n",
            x + 3.5, base - 4.0, colour);
        continue;
      }
      const double q1 = quantile(sorted, 0.25), q3 = quantile(sorted, 0.75), reach = 1.5 * (q3 - q1);
      double from = q1, to = q3;
      for (const double value : sorted) {
        if (value >= q1 - reach) from = std::min(from, value);
        if (value <= q3 + reach) to = std::max(to, value);
        if (value < q1 - reach || value > q3 + reach)
          svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"1.4\" fill=\"{}\"/>\n", x, y(value), colour);
      }
      svg += line(x, y(from), x, y(to), stroke);
      svg += fmt::format(
          "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\" "
          "fill-opacity=\"0.35\" {}/>\n",
          x - half, y(q3), 2.0 * half, std::max(0.5, y(q1) - y(q3)), colour, stroke);
      const double middle = y(quantile(sorted, 0.5));
      svg += line(x - half, middle, x + half, middle, stroke + " stroke-width=\"2\"");
    }
  }
  for (std::size_t s = 0; s < plot.series.size(); ++s) {
    const double x = kLeft + 0.33 * std::max(width - kLeft, 640.0 - kLeft) * static_cast<double>(s % kColumns),
                 at = legend + 18.0 * static_cast<double>(s / kColumns);
    svg += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"10\" height=\"10\" fill=\"{}\"/>\n", x, at - 9.0,
                       kColours[s % kColours.size()]);
    svg += words(x + 15.0, at, "start", plot.series[s]);
  }
  return svg + "</svg>\n";
}

}  // namespace enamel::app
