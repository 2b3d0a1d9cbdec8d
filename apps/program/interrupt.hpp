// Ctrl-C, and requests of the system to end.
#pragma once

namespace enamel::app {

/// While it exists, an interruption does not end the process but is reported by interruption(). Make one at a time.
class InterruptGuard {
 public:
  enum class Second { endsProcess, isIgnored };

  explicit InterruptGuard(Second second);
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  void (*before_[2])(int);
};

/// Return the number of the signal that arrived since the last guard was made; 0: none. Threads: any.
int interruption() noexcept;

}  // namespace enamel::app
