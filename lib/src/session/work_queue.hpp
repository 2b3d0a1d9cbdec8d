// Changes on their way from the callers' threads to the loop.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

#include "enamel/core/spsc_ring.hpp"

namespace enamel::session {

/// One change. The loop runs it; a caller's thread creates and destroys it with all that it holds.
class Work {
 public:
  Work() = default;
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;
  virtual ~Work() = default;
  virtual void run() noexcept = 0;
};

template <typename Function>
class WorkOf final : public Work {
 public:
  explicit WorkOf(Function function) : function_(std::move(function)) {}
  void run() noexcept override { function_(); }

 private:
  Function function_;
};

/// A queue of changes. One caller at a time: callers hold a mutex. Function objects must be Realtime: yes.
class WorkQueue {
 public:
  static constexpr std::size_t kCapacity = 1024;

  WorkQueue() : rings_(std::make_unique<Rings>()) {}
  WorkQueue(const WorkQueue&) = delete;
  WorkQueue& operator=(const WorkQueue&) = delete;
  ~WorkQueue();

  /// Return whether post() has room for another change. It may change after collect(). Caller.
  bool hasRoom() const noexcept;

  /// Return whether the loop has made all changes, by the last collect(). Caller.
  bool isEmpty() const noexcept { return posted_ == collected_; }

  /// Append a change, or run it at once if no loop runs. There must be room. Caller. Realtime: no.
  template <typename Function>
  void post(Function function, bool isRunning) {
    std::unique_ptr<Work> work = std::make_unique<WorkOf<Function>>(std::move(function));
    collect();
    if (!isRunning)
      work->run();
    else if (rings_->waiting.push(work.get()))
      ++posted_, work.release();
  }

  /// Destroy the changes that were made. Caller. Realtime: no.
  void collect() noexcept;

  /// Make all waiting changes. Loop. Realtime: yes, if the changes are.
  void run() noexcept;

 private:
  struct Rings {
    SpscRing<Work*, kCapacity> waiting, done;
  };
  std::unique_ptr<Rings> rings_;
  std::size_t posted_ = 0, collected_ = 0;
};

}  // namespace enamel::session
