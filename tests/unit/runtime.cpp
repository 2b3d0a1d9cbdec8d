// Exchange of data between threads, and the periodic thread. Also run with the thread sanitizer (preset tsan).
#include <chrono>
#include <cmath>
#include <thread>

#include "enamel/core/error.hpp"
#include "enamel/core/spsc_ring.hpp"
#include "enamel/runtime/periodic_thread.hpp"
#include "enamel/runtime/triple_buffer.hpp"
#include "support/catch.hpp"
#include "support/eventually.hpp"
#include "support/run_length.hpp"

namespace enamel::test_runtime {

namespace {

// Large enough that a torn copy is visible.
struct Message {
  std::uint64_t words[64] = {};
};

void fill(Message& message, std::uint64_t number) {
  for (auto& word : message.words) word = number;
}

double secondsNow() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Let the other thread run. Beside other programs, a thread that sleeps runs sooner again than one that yields.
void giveWay() { std::this_thread::sleep_for(std::chrono::microseconds(20)); }

bool whole(const Message& message) {
  for (const auto word : message.words)
    if (word != message.words[0]) return false;
  return true;
}

}  // namespace

TEST_CASE("triple buffer: the newest whole value, never an older one", "[runtime]") {
  TripleBuffer<Message> buffer;
  CHECK_FALSE(buffer.refresh());
  const std::uint64_t last = static_cast<std::uint64_t>(test::count(200000, 5000000));
  std::thread writer([&buffer, last] {
    for (std::uint64_t i = 1; i <= last; ++i) {
      fill(buffer.next(), i);
      buffer.publish();
    }
  });
  std::uint64_t seen = 0, torn = 0, older = 0;
  while (seen < last) {
    if (!buffer.refresh()) continue;
    const Message& message = buffer.latest();
    torn += !whole(message);
    older += message.words[0] <= seen;
    seen = message.words[0];
  }
  writer.join();
  CHECK(torn == 0);
  CHECK(older == 0);
  CHECK_FALSE(buffer.refresh());
  CHECK(buffer.latest().words[0] == last);
}

TEST_CASE("ring: everything in order, nothing twice, full and empty are told", "[runtime]") {
  SpscRing<int, 4> small;
  int value = 0;
  CHECK_FALSE(small.pop(value));
  for (int i = 0; i < 4; ++i) CHECK(small.push(i));
  CHECK_FALSE(small.push(4));
  for (int i = 0; i < 4; ++i) {
    REQUIRE(small.pop(value));
    CHECK(value == i);
  }
  CHECK_FALSE(small.pop(value));

  SpscRing<Message, 64> ring;
  const std::uint64_t last = static_cast<std::uint64_t>(test::count(200000, 5000000));
  std::thread producer([&ring, last] {
    Message message;
    for (std::uint64_t i = 1; i <= last;) {
      fill(message, i);
      if (ring.push(message))
        ++i;
      else
        giveWay();
    }
  });
  std::uint64_t expected = 1, wrong = 0;
  Message message;
  while (expected <= last) {
    if (!ring.pop(message)) {
      giveWay();
      continue;
    }
    wrong += !whole(message) || message.words[0] != expected;
    ++expected;
  }
  producer.join();
  CHECK(wrong == 0);
}

TEST_CASE("histogram: quantiles to within a class of 9 %", "[runtime]") {
  DurationHistogram histogram;
  CHECK(histogram.quantile(0.5) == 0.0);
  for (int i = 1; i <= 1000; ++i) histogram.add(1e-6 * i);
  CHECK(histogram.count() == 1000);
  for (const double p : {0.1, 0.5, 0.9, 0.999}) {
    CHECK(histogram.quantile(p) >= p * 1e-3 * (1.0 - 1e-9));
    CHECK(histogram.quantile(p) <= p * 1e-3 * std::exp2(0.125) * (1.0 + 1e-9));
  }
  CHECK(histogram.largest() == 1e-3);
  CHECK(histogram.count(0.0, 1.0) == 1000);
  CHECK(histogram.count(1e-4, 2e-4) + histogram.count(2e-4, 1.0) == histogram.count(1e-4, 1.0));
  CHECK(std::abs(static_cast<double>(histogram.count(1e-4, 2e-4)) - 100.0) <= 19.0);  // half a class at each end
  histogram.add(-1.0);
  histogram.add(1e9);
  CHECK(histogram.count() == 1002);
  CHECK(histogram.largest() == 1e9);
}

TEST_CASE("periodic thread: one call a period, late deadlines skipped and counted", "[runtime]") {
  CHECK_THROWS_WITH(PeriodicThread(0.0, [] {}), "periodic thread: the period is 0 s, must be in 1e-05 to 10 s");
  constexpr double period = 2e-3;
  std::atomic<int> calls{0};
  std::atomic<const PeriodicThread*> self{nullptr};
  struct Call {
    double begin = 0.0;           // s
    std::uint64_t deadlines = 0;  // deadlines that the thread had met or missed
  } first, last;
  {
    PeriodicThread thread(period, [&] {
      const PeriodicThread* const own = self;
      if (own == nullptr || calls >= 100) return;
      last = {secondsNow(), own->timing().periods + own->timing().missed};
      if (calls == 0) first = last;
      // Every 20th call misses two deadlines.
      if (++calls % 20 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    });
    self = &thread;
    const PeriodicTiming& timing = thread.timing();
    REQUIRE(test::eventually([&] { return timing.missed >= 5 * 2 && timing.periods >= 100 && calls == 100; }));
    CHECK(timing.compute.largest() >= 5e-3);
    // Calls and missed deadlines account for the time, except for the lateness of the two calls. A burst would have
    // more calls, and uncounted deadlines would be missing.
    const double passed = period * static_cast<double>(last.deadlines - first.deadlines);
    const double latest = timing.wakeUp.largest() + timing.compute.largest() + 1e-9;
    CHECK(last.begin - first.begin >= passed - latest);
    CHECK(last.begin - first.begin <= passed + latest);
    CHECK(last.deadlines - first.deadlines >= 99 + 4 * 2);
  }
  const int after = calls;
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  CHECK(calls == after);
}

TEST_CASE("periodic thread: ended within a long period, it makes no call any more", "[runtime]") {
  constexpr double period = 10.0;
  const double begin = secondsNow();
  int calls = 0;
  {
    const PeriodicThread thread(period, [&calls] { ++calls; });
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // it is asleep by now
  }
  const double passed = secondsNow() - begin;
  CHECK(passed < period);  // it ends within 50 ms
  CHECK(calls <= passed / period);
}

}  // namespace enamel::test_runtime
