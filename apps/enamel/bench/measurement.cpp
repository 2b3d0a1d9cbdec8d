#include "bench/measurement.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <iterator>

namespace enamel::bench {

double percentile(const std::vector<double>& times_us, double part) {
  const double rank = part * static_cast<double>(times_us.size() - 1);
  const double time_us = times_us[static_cast<std::size_t>(rank)];
  const auto [first, last] = std::equal_range(times_us.begin(), times_us.end(), time_us);
  // Interpolate between the midpoints to the neighbouring values, so that a larger part never gives a smaller time.
  const double low_us = first == times_us.begin() ? time_us : 0.5 * (*std::prev(first) + time_us),
               high_us = last == times_us.end() ? time_us : 0.5 * (time_us + *last);
  const double place = (rank - static_cast<double>(first - times_us.begin()) + 0.5) / static_cast<double>(last - first);
  return low_us + std::min(place, 1.0) * (high_us - low_us);
}

double relativeError(const Eigen::MatrixXd& value, const Eigen::MatrixXd& reference) {
  if (value.rows() != reference.rows() || value.cols() != reference.cols()) return HUGE_VAL;
  const double error = (value - reference).cwiseAbs().maxCoeff(), scale = reference.cwiseAbs().maxCoeff();
  return scale == 0.0 ? error : error / scale;
}

Timing timeCalls(int batches, int callsPerBatch, const std::function<void(int first, int count)>& run) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> perCall_us(static_cast<std::size_t>(std::max(batches, 1)));
  run(0, callsPerBatch);
  int first = 0;
  for (double& time_us : perCall_us) {
    const auto start = Clock::now();
    run(first, callsPerBatch);
    time_us = std::chrono::duration<double, std::micro>(Clock::now() - start).count() / callsPerBatch;
    first += callsPerBatch;
  }
  std::sort(perCall_us.begin(), perCall_us.end());
  return {percentile(perCall_us, 0.5), percentile(perCall_us, 0.99)};
}

std::vector<Timing> timeInTurns(int calls, int first, const std::vector<std::function<void(int i)>>& runs,
                                const std::function<void()>& between) {
  using Clock = std::chrono::steady_clock;
  constexpr int kTurn = 1000, kUncounted = 20;
  const int passes = runs.size() > 1 ? 5 : 1;
  const auto timeCall_us = [](const std::function<void(int)>& run, int i) {
    const auto start = Clock::now();
    run(i);
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  };
  std::vector<double> clock_us;
  const std::function<void(int)> nothing = [](int) {};
  for (int i = 0; i < 1001; ++i) clock_us.push_back(timeCall_us(nothing, i));
  std::sort(clock_us.begin(), clock_us.end());
  const double reading_us = percentile(clock_us, 0.5);
  std::vector<std::vector<double>> times_us(runs.size());
  for (int pass = 0; pass < passes; ++pass)
    for (int start = 0; start < calls; start += kTurn)
      for (std::size_t which = 0; which < runs.size(); ++which)
        for (int i = start; i < std::min(start + kTurn, calls); ++i) {
          if (between) between();
          const double time_us = timeCall_us(runs[which], i) - reading_us;
          if (i >= first && (runs.size() == 1 || i >= start + kUncounted)) times_us[which].push_back(time_us);
        }
  std::vector<Timing> timings;
  for (std::vector<double>& all : times_us) {
    std::sort(all.begin(), all.end());
    timings.push_back({percentile(all, 0.5), percentile(all, 0.99)});
  }
  return timings;
}

Measurement rowOf(const std::string& name, std::vector<double> times_us, double error, const std::string& errorOf) {
  std::sort(times_us.begin(), times_us.end());
  Measurement row;
  row.name = name;
  row.median_us = percentile(times_us, 0.5);
  row.p99_us = percentile(times_us, 0.99);
  row.p999_us = percentile(times_us, 0.999);
  row.error = error;
  row.errorOf = errorOf;
  return row;
}

Timing timeEachCall(int calls, int first, const std::function<void(int i)>& run) {
  return timeInTurns(calls, first, {run}).front();
}

std::vector<Measurement> measureAll(const std::string& filter, double scale) {
  const std::pair<std::string, std::vector<Measurement> (*)(double)> groups[] = {
      {"device", &measureDevice},       {"control", &measureControl}, {"tick", &measureTick},
      {"collision", &measureCollision}, {"scene", &measureScene},     {"session", &measureSession},
      {"solid", &measureSolid},         {"plant", &measurePlant}};
  // A filter that begins with the name of a group runs only that group. Any other filter runs all groups; rows are
  // filtered afterwards in both cases.
  const std::string first = filter.substr(0, filter.find(' '));
  const bool isGroup =
      std::any_of(std::begin(groups), std::end(groups), [&](const auto& g) { return g.first == first; });
  std::vector<Measurement> all;
  for (const auto& [group, measure] : groups) {
    if (isGroup && group != first) continue;
    std::vector<Measurement> rows = measure(scale);
    for (Measurement& row : rows) {
      row.group = group;
      if ((row.group + " " + row.name).find(filter) != std::string::npos) all.push_back(std::move(row));
    }
  }
  return all;
}

}  // namespace enamel::bench
