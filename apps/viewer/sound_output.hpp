// Plays the sound of a bur on the default audio device (OpenAL) from its own thread.
#pragma once

#include <atomic>
#include <thread>

#include "bur_sound.hpp"
#include "enamel/runtime/triple_buffer.hpp"

namespace enamel::viewer {

/// Plays from construction to destruction. If the device is missing or disappears, nothing is heard, and nothing else
/// changes. Only one instance at a time.
class SoundOutput {
 public:
  SoundOutput();
  ~SoundOutput();
  SoundOutput(const SoundOutput&) = delete;
  SoundOutput& operator=(const SoundOutput&) = delete;

  /// Set the load for the sound, which changes about 50 ms later. Call it from one thread only.
  void set(const BurLoad& load) noexcept;
  /// Return the reason why nothing is heard, or nullptr.
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
