#include "session/work_queue.hpp"

namespace enamel::session {

WorkQueue::~WorkQueue() {
  for (Work* work = nullptr; rings_->waiting.pop(work);) delete work;
  collect();
}

bool WorkQueue::hasRoom() const noexcept { return posted_ - collected_ < kCapacity; }

void WorkQueue::collect() noexcept {
  for (Work* work = nullptr; rings_->done.pop(work); ++collected_) delete work;
}

void WorkQueue::run() noexcept {
  for (Work* work = nullptr; rings_->waiting.pop(work);) {
    work->run();
    (void)rings_->done.push(work);  // never full: waiting and done hold at most kCapacity changes together
  }
}

}  // namespace enamel::session
