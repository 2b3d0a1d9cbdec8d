#include "design_stability.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "enamel/core/file.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/stability.hpp"
#include "study/svg.hpp"

namespace enamel::app {
namespace {

constexpr std::array kScopes{Scope::quiet, Scope::all};
constexpr double DeviceErrors::*kErrors[] = {&DeviceErrors::mass, &DeviceErrors::cable, &DeviceErrors::delay};

// Ranges of mass, cable and delay for one delay and scope.
using Ranges = std::array<StableRange, 3>;

struct DeviceLoops {
  std::vector<LinearLoop> loops;              // one for each delay
  std::vector<std::array<Ranges, 2>> ranges;  // the same, for each of kScopes
  bool hasCables() const { return loops.front().drive().stiffness > 0.0; }
};

DeviceLoops analyse(const DeviceParameters& parameters, double period, int largestDelay, int threads) {
  DeviceLoops device;
  for (int delay = 0; delay <= largestDelay; ++delay) device.loops.emplace_back(parameters, period, delay);
  device.ranges.resize(device.loops.size());
  parallelFor(6 * device.loops.size(), threads, [&](std::size_t i) {
    const std::size_t delay = i / 6, scope = i / 3 % 2, error = i % 3;
    StableRange& range = device.ranges[delay][scope][error];
    range = {1.0, 1.0};
    if (error != 1 || device.hasCables()) range = stableRange(device.loops[delay], kErrors[error], kScopes[scope]);
  });
  return device;
}

void print(const DeviceLoops& device) {
  fmt::print(
      "Position control at home, walls across x, y and z: spectral radius of the linear loop, and the errors of "
      "the device,\none at a time, at which it is at most {:g}\n",
      kStableRadius);
  fmt::print("{:>5} {:<16} {:>7} {:>14} {:>16} {:>18}\n", "delay", "observer", "radius", "mass, factor",
             device.hasCables() ? "cable, factor" : "", "delay error, ticks");
  for (std::size_t d = 0; d < device.loops.size(); ++d)
    for (std::size_t s = 0; s < kScopes.size(); ++s) {
      const auto& [mass, cable, delay] = device.ranges[d][s];
      fmt::print("{:>5} {:<16} {:>7.3f} {:>14} {:>16} {:>18}\n", d,
                 kScopes[s] == Scope::quiet ? "without jumps" : "and with jumps",
                 device.loops[d].radius({}, kScopes[s]), fmt::format("{:.2f} to {:.2f}", mass.low, mass.high),
                 device.hasCables() ? fmt::format("{:.3f} to {:.3f}", cable.low, cable.high) : "",
                 fmt::format("{:.3f} to {:.3f}", delay.low, delay.high));
    }
}

// --- the picture ----------------------------------------------------------------------------------------------------

constexpr int kColumns = 40, kRows = 30;  // cells of a map
constexpr double kLeft = 74.0, kTop = 34.0, kGap = 12.0, kHeight = 150.0, kBelow = 70.0;
constexpr const char* kColours[] = {kNoValue, kSky, kBlue};  // by level

enum Level : char { unstable, quiet, all, impossible };

Level levelOf(const LinearLoop& loop, const DeviceErrors& errors) {
  if (loop.delay() + errors.delay < 0.0) return impossible;
  if (!loop.isStable(errors, Scope::quiet)) return unstable;
  return loop.isStable(errors, Scope::all) ? all : quiet;
}

// The axis of an error: wider than its ranges at all delays.
Axis axisOf(const DeviceLoops& device, std::size_t error, const std::string& title) {
  constexpr double kLatest = 1.0;  // tick: errors that are plausible
  Extent extent;
  for (const auto& ranges : device.ranges)
    for (const double end : {ranges[0][error].low, ranges[0][error].high})
      extent.see(error == 2 ? std::clamp(end, -kLatest, kLatest) : end);
  return extent.axis(title, 0.1);
}

double valueAt(const Axis& axis, int cell, int cells) {
  return axis.low + (cell + 0.5) / cells * (axis.high - axis.low);
}

// Draw a map of mass and another error for each delay.
void addMaps(Svg& svg, const DeviceLoops& device, const Axis& mass, std::size_t error, const Axis& other, double top,
             int threads) {
  const std::size_t count = device.loops.size();
  std::vector<Level> levels(count * kRows * kColumns);
  parallelFor(count * kRows, threads, [&](std::size_t i) {
    DeviceErrors errors;
    errors.*kErrors[error] = valueAt(other, static_cast<int>(i % kRows), kRows);
    for (int column = 0; column < kColumns; ++column) {
      errors.mass = valueAt(mass, column, kColumns);
      levels[i * kColumns + static_cast<std::size_t>(column)] = levelOf(device.loops[i / kRows], errors);
    }
  });
  const double width = (Svg::kWidth - kLeft - kGap * static_cast<double>(count)) / static_cast<double>(count),
               cell = width / kColumns, height = kHeight / kRows;
  for (std::size_t d = 0; d < count; ++d) {
    const Place corner{kLeft + static_cast<double>(d) * (width + kGap), top};
    for (int row = 0; row < kRows; ++row)
      for (int from = 0, to = 0; from < kColumns; from = to) {  // cells of one level are one box
        const Level* line = &levels[(d * kRows + static_cast<std::size_t>(row)) * kColumns];
        while (to < kColumns && line[to] == line[from]) ++to;
        if (line[from] != impossible)
          svg.box({corner.x + from * cell, corner.y + (kRows - 1 - row) * height}, (to - from) * cell, height + 0.5,
                  kColours[line[from]]);
      }
    Axis y = other;
    y.numbers = d == 0;
    const Panel panel(svg, corner, width, kHeight, mass, y, fmt::format("delay {}", d), false);
    svg.disc(panel.at(1.0, DeviceErrors().*kErrors[error]), 3.5, kVermilion);
  }
}

std::string pictureOf(const DeviceLoops& device, const std::string& name, int threads) {
  Svg svg;
  const Axis mass = axisOf(device, 0, "mass over the file's");
  double top = kTop;
  addMaps(svg, device, mass, 2, axisOf(device, 2, "delay error, ticks"), top, threads);
  top += kHeight + kBelow;
  if (device.hasCables()) {
    addMaps(svg, device, mass, 1, axisOf(device, 1, "cable over the file's"), top, threads);
    top += kHeight + kBelow;
  }
  top += addLegend(svg, {kLeft, top - 20.0}, Svg::kWidth - kLeft,
                   {{"stable without and with jumps", {kBlue}, true},
                    {"stable without jumps", {kSky}, true},
                    {"not stable", {kNoValue}, true},
                    {"as in the file", {kVermilion}, true}});
  return svg.whole("Stability of position control on " + name, top - 10.0);
}

}  // namespace

void writeStability(const DeviceParameters& parameters, double period, int largestDelay, int threads,
                    const std::string& path) {
  const DeviceLoops device = analyse(parameters, period, largestDelay, threads);
  print(device);
  writeFile(path, pictureOf(device, nameOf(parameters), threads));
}

}  // namespace enamel::app
