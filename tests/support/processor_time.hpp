// Processor time of this thread, independent of other work on the machine.
#pragma once

#include <algorithm>
#include <ctime>

namespace enamel::test {

inline double processorTime() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Return the least processor time of `count` runs, s. `prepare` runs before each of them and does not count.
template <typename Work, typename Prepare>
double leastTime(int count, const Work& work, const Prepare& prepare) {
  double least = 1e9;
  for (int i = 0; i < count; ++i) {
    prepare();
    const double begin = processorTime();
    work();
    least = std::min(least, processorTime() - begin);
  }
  return least;
}

template <typename Work>
double leastTime(int count, const Work& work) {
  return leastTime(count, work, [] {});
}

}  // namespace enamel::test
