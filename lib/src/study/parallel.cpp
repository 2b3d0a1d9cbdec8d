#include "enamel/study/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/message.hpp"
#include "core/system_process.hpp"

namespace enamel {
namespace {

std::size_t checked(int threads) {
  require(threads >= 1 && threads <= kMaxThreads,
          "threads is " + std::to_string(threads) + ", must be in 1 to " + std::to_string(kMaxThreads));
  return static_cast<std::size_t>(threads);
}

// Call work() on `wanted` threads, this one among them. After its first exception, which is rethrown, call stop().
template <typename Work, typename Stop>
void onThreads(std::size_t wanted, const Work& work, const Stop& stop) {
  std::exception_ptr problem;
  std::mutex first;
  const auto guarded = [&] {
    try {
      work();
    } catch (...) {
      const std::lock_guard<std::mutex> lock(first);
      if (!problem) problem = std::current_exception();
      stop();
    }
  };
  std::vector<std::thread> others;
  try {
    while (others.size() + 1 < wanted) others.emplace_back(guarded);
  } catch (const std::exception&) {  // no memory or too many threads: fewer give the same result
  }
  guarded();
  for (std::thread& other : others) other.join();
  if (problem) std::rethrow_exception(problem);
}

// State that the threads of parallelInOrder() share.
struct Line {
  std::mutex mutex;
  std::condition_variable changed;
  std::size_t next, finished;
  std::vector<char> isReady;  // for done(), a ring
  bool isOver = false, isFinishing = false;
};

}  // namespace

int availableThreads() { return std::clamp(system::processors(), 1, kMaxThreads); }

void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body) {
  std::atomic<std::size_t> next{0};
  onThreads(
      std::min(checked(threads), count),
      [&] {
        for (std::size_t i = 0; (i = next++) < count;) body(i);
      },
      [&] { next = count; });
}

std::size_t parallelInOrder(std::size_t first, std::size_t count, int threads,
                            const std::function<void(std::size_t)>& work, const std::function<void(std::size_t)>& done,
                            const std::function<bool()>& stop) {
  const std::size_t most = checked(threads), ahead = 4 * most;
  Line line{{}, {}, first, first, std::vector<char>(ahead, 0)};
  const auto serve = [&] {
    std::unique_lock<std::mutex> lock(line.mutex);
    for (;;) {
      line.changed.wait(lock, [&] { return line.isOver || line.next >= count || line.next < line.finished + ahead; });
      line.isOver = line.isOver || line.next >= count || stop();
      if (line.isOver) break;
      const std::size_t i = line.next++;
      lock.unlock();
      work(i);
      lock.lock();
      line.isReady[i % ahead] = 1;
      if (line.isFinishing) continue;
      line.isFinishing = true;
      for (char* ready; *(ready = &line.isReady[line.finished % ahead]) != 0; ++line.finished) {
        *ready = 0;
        lock.unlock();
        done(line.finished);
        lock.lock();
        line.changed.notify_all();
      }
      line.isFinishing = false;
    }
    line.changed.notify_all();
  };
  onThreads(std::min(most, count - std::min(first, count)), serve, [&line] {
    const std::lock_guard<std::mutex> lock(line.mutex);
    line.isOver = true;
    line.changed.notify_all();
  });
  return line.finished;
}

}  // namespace enamel
