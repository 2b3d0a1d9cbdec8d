// Plays the sound of a bur on the default audio device (OpenAL), from a thread of its own.
#pragma once

#include <atomic>
#include <thread>

#include "bur_sound.hpp"
#include "enamel/runtime/triple_buffer.hpp"

namespace enamel::viewer {

/// From construction to destruction. Where there is no device, or it goes away, nothing is heard and nothing else
/// happens. One at a time.
class SoundOutput {
 public:
  SoundOutput();
  ~SoundOutput();
  SoundOutput(const SoundOutput&) = delete;
  SoundOutput& operator=(const SoundOutput&) = delete;

  /// What is heard from now on: some 50 ms later. Of one thread.
  void set(const BurLoad& load) noexcept;
  /// Why nothing is heard, or nullptr.
  const char* trouble() const noexcept { return trouble_.load(std::memory_order_relaxed); }

 private:
  void run() noexcept;
  const char* play() noexcept;

  TripleBuffer<BurLoad> load_;
  std::atomic<const char*> trouble_{nullptr};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace enamel::viewer
