#include "enamel/study/parallel.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/parallel_pipeline.h>
#include <oneapi/tbb/task_arena.h>

#include <string>

#include "enamel/core/error.hpp"

namespace enamel {
namespace {

// Run a body in an arena of exactly `threads`, even if the machine has fewer.
template <typename Body>
void onThreads(int threads, const Body& body) {
  if (threads < 1 || threads > kMaxThreads)
    throw Error("threads is " + std::to_string(threads) + ", must be in 1 to " + std::to_string(kMaxThreads));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena(threads).execute(body);
}

}  // namespace

int availableThreads() { return std::min(kMaxThreads, std::max(1, tbb::info::default_concurrency())); }

void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  onThreads(threads, [&] {
    tbb::parallel_for(
        std::size_t{0}, count, [&body](std::size_t i) { body(i); }, tbb::simple_partitioner());
  });
}

std::size_t parallelInOrder(std::size_t first, std::size_t count, int threads,
                            const std::function<void(std::size_t)>& work, const std::function<void(std::size_t)>& done,
                            const std::function<bool()>& stop) {
  std::size_t next = first, finished = first;
  onThreads(threads, [&] {
    const auto begin = [&](tbb::flow_control& flow) {
      if (next < count && !stop()) return next++;
      flow.stop();
      return count;
    };
    const auto perform = [&work](std::size_t i) {
      work(i);
      return i;
    };
    const auto finish = [&](std::size_t i) {
      done(i);
      finished = i + 1;
    };
    tbb::parallel_pipeline(4 * static_cast<std::size_t>(threads),
                           tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, begin) &
                               tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, perform) &
                               tbb::make_filter<std::size_t, void>(tbb::filter_mode::serial_in_order, finish));
  });
  return finished;
}

}  // namespace enamel
