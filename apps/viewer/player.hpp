// Plays a recording: a source of frames and samples beside the running experiment. Knows no window.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "enamel/render/tick.hpp"
#include "enamel/runtime/recording.hpp"
#include "runner.hpp"

namespace enamel::viewer {

/// A chunk of a recording, as the index has it. Positions are ticks from the first, with those that are not there.
struct Stretch {
  std::uint64_t begin = 0;                 ///< position of its first tick
  std::uint64_t lost = 0;                  ///< ticks missing just before it, lost or in chunks that cannot be read
  std::uint64_t chunk = 0;                 ///< its number in the file
  std::uint32_t ticks = 0;                 ///< at least 1
  bool contact = false;                    ///< a wall was rendered
  GuardReason reason = GuardReason::none;  ///< of the first tick that the guard changed; a fault before any other
};

/// Looks at a recording tick by tick, at any place. The index (40 bytes a chunk of 128 ticks) and the charts' samples
/// of the last chunks are kept, nothing else: memory does not depend on where one looks. Poses and contacts are
/// computed as HapticTick does, from the state that each chunk begins with.
class Player {
 public:
  static constexpr double kSlowest = 0.01, kFastest = 10.0;  // of real time

  /// Reads the whole file once, to check it and to make the index. Throws Error: as RecordingReader, parseDevice() and
  /// parseScene(); other joints than the device's; no tick can be read. Realtime: no.
  explicit Player(const std::string& path);

  const std::string& path() const noexcept { return path_; }
  const RecordingHeader& header() const noexcept { return reader_.header(); }
  const DeviceParameters& parameters() const noexcept { return parameters_; }
  const SceneFile& scene() const noexcept { return scene_; }

  const std::vector<Stretch>& stretches() const noexcept { return stretches_; }
  std::uint64_t size() const noexcept { return size_; }    ///< positions, missing ones too
  std::uint64_t ticks() const noexcept { return ticks_; }  ///< that can be read
  /// What is wrong with the recording, a line each: cut off, damaged, with ticks lost or values that are not finite.
  const std::vector<std::string>& notes() const noexcept { return notes_; }

  std::uint64_t position() const noexcept { return static_cast<std::uint64_t>(place_); }
  double seconds() const noexcept { return place_ * header().guard.period; }  ///< from the first tick
  bool playing() const noexcept { return playing_; }
  double speed() const noexcept { return speed_; }
  /// Ticks missing about the position; 0: it has one, and frame() is of it.
  std::uint64_t gap() const noexcept;

  /// At the end, playing begins anew.
  void setPlaying(bool playing) noexcept;
  /// Times real time, kSlowest to kFastest.
  void setSpeed(double speed) noexcept;
  /// For so many seconds of a clock; stops at the last tick.
  void advance(double seconds) noexcept;
  /// To a position, or the nearest end.
  void seek(double position) noexcept;
  /// So many ticks on or back, over those that are missing; pauses.
  void step(std::int64_t ticks) noexcept;

  /// The tick at the position, in a gap the one before it. `paused` is filled in. Realtime: no.
  const Frame& frame();

  /// What the charts show of `count` positions from `from` on: NaN where there is no tick, or no finite value.
  /// Realtime: no.
  const std::vector<Sample>& samples(std::int64_t from, std::size_t count);

 private:
  // Asks for nothing; HapticTick needs one.
  class Watcher final : public Renderer {
    void prepare(double) override {}
    Status render(const TickInput& input, TickOutput& output) noexcept override {
      output.torque = input.kinematics.gravity;
      output.mode = RenderMode::free;
      return Status::ok;
    }
    void resetState() noexcept override {}
    StateBlock stateBlock() noexcept override { return {nullptr, 0}; }
  };
  struct Seen {
    std::size_t stretch;
    std::vector<Sample> samples;
  };

  void makeIndex();
  std::size_t stretchAt(std::uint64_t position) const noexcept;  // the last that begins there or before
  const RecordedChunk& chunkOf(std::size_t stretch);
  template <typename Function>
  void watch(std::size_t stretch, std::size_t end, const Function& each);
  const std::vector<Sample>& seen(std::size_t stretch);

  std::string path_;
  RecordingReader reader_;
  DeviceParameters parameters_;
  std::shared_ptr<const Mechanism> device_;
  SceneFile scene_;
  Watcher watcher_;
  HapticTick tick_;
  ToolCache cache_;
  bool restores_;

  std::vector<Stretch> stretches_;
  std::uint64_t size_ = 0, ticks_ = 0;
  std::vector<std::string> notes_;

  double place_ = 0.0, speed_ = 1.0;
  bool playing_ = false;

  RecordedChunk chunk_;
  std::size_t loaded_ = SIZE_MAX;  // whose chunk that is
  Frame frame_;
  std::uint64_t framed_ = UINT64_MAX;  // position of frame_
  std::vector<Seen> seen_;             // a ring
  std::size_t oldest_ = 0;
  std::vector<Sample> samples_;
};

}  // namespace enamel::viewer
