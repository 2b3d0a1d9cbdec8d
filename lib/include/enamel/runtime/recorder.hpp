// Record haptic ticks while they run, to replay them bit for bit.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/runtime/recording.hpp"

namespace enamel {

/// Result of a recording.
struct RecordingResult {
  std::uint64_t ticks = 0;  ///< ticks in the file
  /// Ticks that are not in the file because the buffer was full. The file could not be written fast enough.
  std::uint64_t lost = 0;
  /// Why the end of the recording could not be written. Empty: the file has all ticks that were not lost.
  std::string problem;
};

/// Write a recording from a separate thread. The tick's thread only copies into preallocated chunks: room for 4 s, at
/// least 8 and at most 256 chunks. If they are full, because the disk is full or slow, ticks are lost and counted.
/// Recording continues with a new chunk as soon as one is free.
class Recorder final : public TickSink {
 public:
  /// Write bytes and return how many were written. It may return fewer or 0 (errno has the reason); it is then called
  /// again. Must not throw.
  using Write = std::function<std::size_t(const char* bytes, std::size_t size)>;

  /// Begin a recording of the ticks of `tick`, and write its header. Throws Error with the file and the cause if the
  /// file exists already, or cannot be created or written. Realtime: no.
  Recorder(const std::string& path, RecordingHeader header, const HapticTick& tick);

  /// Record to another destination. `path` appears in messages only.
  Recorder(Write write, const std::string& path, RecordingHeader header, const HapticTick& tick);

  /// Calls close().
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  /// Record the tick that `tick` has just run. The caller numbers the ticks. `reset`: HapticTick::reset() was called
  /// before it. Realtime: yes (copies 320 bytes and hashes the renderer's state; copies the whole state at the start of
  /// a chunk).
  void add(std::uint64_t number, const Measurement& measurement, const HapticTick& tick, const Command& command,
           Status status, bool reset = false) noexcept;

  /// Record a tick of a loop, as HapticLoopOptions::sink. Realtime: yes.
  void tick(const LoopTick& tick, const HapticTick& haptics) noexcept override {
    add(tick.number, tick.measurement, haptics, tick.command, tick.status, tick.reset);
  }

  /// Return the number of ticks lost so far. Threads: any. Realtime: yes.
  std::uint64_t lost() const noexcept { return allLost_.load(std::memory_order_relaxed); }

  /// Wait until there is room for a tick, or until the file cannot be written. For simulations. Realtime: no.
  void makeRoom() const;

  /// Write the remaining ticks and end the recording. add() must not run at the same time or later. If the file cannot
  /// be written, it ends with the last complete chunk. Only the first call has an effect. Realtime: no.
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

  // Used by the tick's thread.
  std::uint64_t lostNow_ = 0, sequence_ = 0;
  std::size_t ticks_ = 0;  // of the chunk being filled
  std::string rendererState_;

  // Chunk i of the file is at i % room_. The tick's thread fills chunks; the other thread writes them.
  std::size_t room_ = 0, chunkSize_ = 0;
  std::string chunks_;
  std::atomic<std::uint64_t> allLost_{0};
  alignas(64) std::atomic<std::uint64_t> filled_{0};
  alignas(64) std::atomic<std::uint64_t> written_{0};
  std::atomic<bool> stop_{false}, failing_{false};

  // Used by the writing thread.
  std::size_t done_ = 0;  // bytes of the present chunk
  std::uint64_t bytes_ = 0, ticksWritten_ = 0;
  int error_ = 0;
  std::thread thread_;
};

}  // namespace enamel
