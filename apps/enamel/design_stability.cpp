#include "design_stability.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "enamel/core/file.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/stability.hpp"
#include "study/page.hpp"

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

// --- the maps -------------------------------------------------------------------------------------------------------

constexpr int kColumns = 40, kRows = 30;                                  // cells of a map
constexpr unsigned kColours[] = {0xBDBDBD, viewer::kSky, viewer::kBlue};  // by level
constexpr const char* kLevelNames[] = {"not stable", "stable without jumps", "stable without and with jumps"};

enum Level : char { unstable, quiet, all, impossible };

Level levelOf(const LinearLoop& loop, const DeviceErrors& errors) {
  if (loop.delay() + errors.delay < 0.0) return impossible;
  if (!loop.isStable(errors, Scope::quiet)) return unstable;
  return loop.isStable(errors, Scope::all) ? all : quiet;
}

// Return the edges of cells over the values of an error: wider than its ranges at all delays.
std::vector<double> edgesOf(const DeviceLoops& device, std::size_t error, int cells) {
  constexpr double kLatest = 1.0;  // tick: errors that are plausible
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (const auto& ranges : device.ranges)
    for (const double end : {ranges[0][error].low, ranges[0][error].high}) {
      const double value = error == 2 ? std::clamp(end, -kLatest, kLatest) : end;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  const double margin = high > low ? 0.1 * (high - low) : 0.05;
  std::vector<double> edges;
  for (int i = 0; i <= cells; ++i) edges.push_back(low - margin + i * (high - low + 2.0 * margin) / cells);
  return edges;
}

// Return a map of mass and another error for each delay.
Json mapsOf(const DeviceLoops& device, std::size_t error, const std::string& title, int threads) {
  const std::vector<double> mass = edgesOf(device, 0, kColumns), other = edgesOf(device, error, kRows);
  std::vector<Level> levels(device.loops.size() * kRows * kColumns);
  parallelFor(device.loops.size() * kRows, threads, [&](std::size_t i) {
    DeviceErrors errors;
    errors.*kErrors[error] = 0.5 * (other[i % kRows] + other[i % kRows + 1]);
    for (std::size_t column = 0; column < kColumns; ++column) {
      errors.mass = 0.5 * (mass[column] + mass[column + 1]);
      levels[i * kColumns + column] = levelOf(device.loops[i / kRows], errors);
    }
  });
  Json panels = Json::array(), legend = Json::array();
  for (std::size_t d = 0; d < device.loops.size(); ++d) {
    Json cells = Json::array();
    for (std::size_t row = 0; row < kRows; ++row)
      for (std::size_t from = 0, to = 0; from < kColumns; from = to) {  // cells of one level are one box
        const Level* line = &levels[(d * kRows + row) * kColumns];
        while (to < kColumns && line[to] == line[from]) ++to;
        if (line[from] == impossible) continue;
        cells.push_back(rectangle(mass[from], mass[to], other[row], other[row + 1]));
        cells.back()["colour"] = colourText(kColours[line[from]]);
        cells.back()["text"] = kLevelNames[line[from]];
      }
    Json y = axis(title, other.front(), other.back());
    y["numbers"] = d == 0;
    const Json asInFile = numbers({DeviceErrors().*kErrors[error]});
    panels.push_back(panel(fmt::format("delay {}", d),
                           std::max(100.0, 680.0 / static_cast<double>(device.loops.size())), 150,
                           axis("mass over the file's", mass.front(), mass.back()), y,
                           {{{"type", "cells"}, {"cells", cells}},
                            {{"type", "points"},
                             {"x", Json::array({1.0})},
                             {"y", asInFile},
                             {"texts", Json::array({"as in the file"})},
                             {"colour", colourText(viewer::kVermilion)}}}));
    panels.back()["grid"] = false;
  }
  for (int level = all; level >= unstable; --level)
    legend.push_back(entry(kLevelNames[level], {kColours[level]}, true));
  legend.push_back(entry("as in the file", {viewer::kVermilion}, true));
  return figure("mass and " + title, static_cast<int>(device.loops.size()), legend, panels);
}

std::string pageOf(const DeviceLoops& device, const std::string& name, int threads) {
  Page page;
  const std::string caption =
      "Errors of the device at which the linear loop is stable, for each delay in ticks: its "
      "mass, and ";
  page.figure("delay-errors", mapsOf(device, 2, "delay error, ticks", threads), caption + "an error of its delay.");
  if (device.hasCables())
    page.figure("cable-errors", mapsOf(device, 1, "cable over the file's", threads),
                caption + "the stiffness of its cables.");
  return page.whole("Stability of position control on " + escape(name), "Linear loops; no hardware was involved.");
}

}  // namespace

void writeStability(const DeviceParameters& parameters, double period, int largestDelay, int threads,
                    const std::string& path) {
  const DeviceLoops device = analyse(parameters, period, largestDelay, threads);
  print(device);
  writeFile(path, pageOf(device, nameOf(parameters), threads));
}

}  // namespace enamel::app
