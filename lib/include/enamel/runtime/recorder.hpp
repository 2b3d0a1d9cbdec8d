// Records haptic ticks while they run, so that they can be replayed bit for bit.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/runtime/recording.hpp"

namespace enamel {

/// How a recording ended.
struct RecordingResult {
  std::uint64_t ticks = 0;  ///< that are in the file
  std::uint64_t lost = 0;   ///< that are not: there was no room left while the file could not be written fast enough
  std::string problem;  ///< why the end of the recording could not be written; empty: all that is not lost stands there
};

/// Writes a recording from a thread of its own. The tick's side only copies into chunks that were allocated before:
/// room for 4 s, at least 8 and at most 256 chunks. Where that is full, because the disk is or because it is slow,
/// ticks are lost and counted, and recording goes on with a new chunk as soon as one is free.
class Recorder final : public TickSink {
 public:
  /// Writes bytes and returns how many of them, fewer or none where it cannot (errno tells why): then it is asked
  /// again. Must not throw.
  using Write = std::function<std::size_t(const char* bytes, std::size_t size)>;

  /// Begins a recording of `tick`'s ticks, and writes its header. Throws Error with the file and the cause: there is
  /// such a file already, it cannot be made or written. Realtime: no.
  Recorder(const std::string& path, RecordingHeader header, const HapticTick& tick);

  /// The same to somewhere else. `path` stands in messages.
  Recorder(Write write, const std::string& path, RecordingHeader header, const HapticTick& tick);

  /// close().
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Records a tick that `tick` has just done, numbered by the caller; `reset`: HapticTick::reset() came before it.
  /// Realtime: yes (copies 320 bytes, hashes the renderer's state; where a chunk begins, copies the whole state).
  void add(std::uint64_t number, const Measurement& measurement, const HapticTick& tick, const Command& command,
           Status status, bool reset = false) noexcept;

  /// The same for a loop: HapticLoopOptions::sink. Realtime: yes.
  void tick(const LoopTick& tick, const HapticTick& haptics) noexcept override {
    add(tick.number, tick.measurement, haptics, tick.command, tick.status, tick.reset);
  }

  /// Ticks that were lost so far. Any thread. Realtime: yes.
  std::uint64_t lost() const noexcept { return allLost_.load(std::memory_order_relaxed); }

  /// For simulations, which can wait: returns once there is room for a tick, or the file cannot be written. Realtime:
  /// no.
  void makeRoom() const;

  /// Writes what is left and ends the recording; no add() may be under way or follow. Where the file cannot be written,
  /// it ends with the last whole chunk. The first call counts. Realtime: no.
  RecordingResult close();

 private:
  void start(const HapticTick& tick);
  char* chunkAt(std::uint64_t i) noexcept { return &chunks_[(i % room_) * chunkSize_]; }
  void begin(const HapticTick& tick) noexcept;
  void run() noexcept;
  bool writeOut(const char* bytes, std::size_t size) noexcept;

  Write write_;
  std::string path_;
  RecordingHeader header_;
  int file_ = -1;
  RecordingResult result_;
  bool open_ = true;

  // Of the tick's thread.
  std::uint64_t lostNow_ = 0, sequence_ = 0;
  std::size_t ticks_ = 0;  // of the chunk being filled
  std::string rendererState_;

  // Chunk i, as it stands in the file, lies at i % room_. The tick's thread fills, the other one writes.
  std::size_t room_ = 0, chunkSize_ = 0;
  std::string chunks_;
  std::atomic<std::uint64_t> allLost_{0};
  alignas(64) std::atomic<std::uint64_t> filled_{0};
  alignas(64) std::atomic<std::uint64_t> written_{0};
  std::atomic<bool> stop_{false}, failing_{false};

  // Of the writing thread.
  std::size_t done_ = 0;  // bytes of the chunk under way
  std::uint64_t bytes_ = 0, ticksWritten_ = 0;
  int error_ = 0;
  std::thread thread_;
};

}  // namespace enamel
