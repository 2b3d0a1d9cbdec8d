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

std::vector<Measurement> measureAll(const std::string& filter, double scale) {
  std::vector<Measurement> all;
  for (const auto& [group, measure] :
       {std::pair{"device", &measureDevice}, std::pair{"control", &measureControl}, std::pair{"tick", &measureTick}}) {
    std::vector<Measurement> rows = measure(scale);
    for (Measurement& row : rows) {
      row.group = group;
      if ((row.group + " " + row.name).find(filter) != std::string::npos) all.push_back(std::move(row));
    }
  }
  return all;
}

}  // namespace enamel::bench
