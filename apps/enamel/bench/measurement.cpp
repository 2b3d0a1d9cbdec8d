#include "bench/measurement.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace enamel::bench {

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
  const std::size_t last = perCall_us.size() - 1;
  return {perCall_us[last / 2], perCall_us[static_cast<std::size_t>(0.99 * static_cast<double>(last))]};
}

Timing timeEachCall(int calls, int first, const std::function<void(int i)>& run) {
  using Clock = std::chrono::steady_clock;
  const auto sortedTimes = [](int begin, int end, const auto& work) {
    std::vector<double> times_us;
    times_us.reserve(static_cast<std::size_t>(end - begin));
    for (int i = begin; i < end; ++i) {
      const auto start = Clock::now();
      work(i);
      times_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    }
    std::sort(times_us.begin(), times_us.end());
    return times_us;
  };
  const std::function<void(int)> nothing = [](int) {};
  const double clock_us = sortedTimes(0, 1001, nothing)[500];
  for (int i = 0; i < first; ++i) run(i);
  const std::vector<double> times_us = sortedTimes(first, calls, run);
  const std::size_t last = times_us.size() - 1;
  return {times_us[last / 2] - clock_us,
          times_us[static_cast<std::size_t>(0.99 * static_cast<double>(last))] - clock_us};
}

std::vector<Measurement> measureAll(const std::string& filter, double scale) {
  const std::pair<std::string, std::vector<Measurement> (*)(double)> groups[] = {{"device", &measureDevice},
                                                                                 {"control", &measureControl},
                                                                                 {"tick", &measureTick},
                                                                                 {"collision", &measureCollision}};
  // The name of a group alone measures only that one; any other text measures all and keeps what fits.
  const bool isGroup =
      std::any_of(std::begin(groups), std::end(groups), [&](const auto& g) { return g.first == filter; });
  std::vector<Measurement> all;
  for (const auto& [group, measure] : groups) {
    if (isGroup && group != filter) continue;
    std::vector<Measurement> rows = measure(scale);
    for (Measurement& row : rows) {
      row.group = group;
      if (isGroup || (row.group + " " + row.name).find(filter) != std::string::npos) all.push_back(std::move(row));
    }
  }
  return all;
}

}  // namespace enamel::bench
