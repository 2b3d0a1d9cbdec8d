// Plays a recording: a source of frames and samples, like a running experiment. Independent of any window.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "enamel/render/tick.hpp"
#include "enamel/runtime/recording.hpp"
#include "runner.hpp"

namespace enamel::viewer {

/// A readable chunk. Positions count ticks from the first readable one; missing ticks count as well.
struct Stretch {
  std::uint64_t begin = 0;  ///< position of its first tick
  std::uint64_t end = 0;    ///< position after its last tick; less than the next `begin` if ticks are missing
  std::uint64_t chunk = 0;  ///< its number in the file
  bool contact = false;     ///< it contains ticks with contact
};

/// An event in a recording: a contact begins, or the guard changes the command.
struct PlayerEvent {
  std::uint64_t position = 0;
  GuardReason reason = GuardReason::none;  ///< none: a contact
};

/// Shows a recording tick by tick, at any position. It keeps only the index, the events and the charts' samples of the
/// last chunks: memory does not depend on the position. Poses and contacts are computed as in HapticTick, from the
/// state at the beginning of each chunk.
class Player {
 public:
  static constexpr double kSlowest = 0.01, kFastest = 10.0;  // relative to real time

  /// Read the whole file once, to check it and to make the index. Throws Error: as RecordingReader, parseDevice() and
  /// parseScene(); the number of joints is not the device's; the states have another size; no tick can be read.
  /// Realtime: no.
  explicit Player(const std::string& path);

  const std::string& path() const noexcept { return path_; }
  const RecordingHeader& header() const noexcept { return reader_.header(); }
  const DeviceParameters& parameters() const noexcept { return parameters_; }
  const SceneFile& scene() const noexcept { return scene_; }

  const std::vector<Stretch>& stretches() const noexcept { return stretches_; }
  const std::vector<PlayerEvent>& events() const noexcept { return events_; }
  std::uint64_t size() const noexcept { return stretches_.back().end; }  ///< number of positions
  /// Return the problems of the recording, one line each: cut off, damaged, lost ticks, values that are not finite.
  const std::vector<std::string>& notes() const noexcept { return notes_; }

  std::uint64_t position() const noexcept { return static_cast<std::uint64_t>(place_); }
  double seconds() const noexcept { return place_ * header().guard.period; }  ///< since the first position
  bool playing() const noexcept { return playing_; }
  double speed() const noexcept { return speed_; }
  /// Return the number of missing ticks around the position; 0: the tick exists, and frame() shows it.
  std::uint64_t gap() const noexcept;

  /// Start or stop playing. At the end, playing starts from the beginning.
  void setPlaying(bool playing) noexcept;
  /// Set the speed relative to real time, kSlowest to kFastest.
  void setSpeed(double speed) noexcept;
  /// Advance by `seconds` of a clock; stop at the last tick.
  void advance(double seconds) noexcept;
  /// Go to a position, or to the nearest end.
  void seek(double position) noexcept;
  /// Move by a number of ticks, skip missing ticks, and pause.
  void step(std::int64_t ticks) noexcept;
  /// Go to the next or previous event and pause. Return false after the last one.
  bool jump(bool forward) noexcept;

  /// Return the tick at the position; if it is missing, the previous one. Sets `paused`. Throws Error: the file was
  /// changed. Realtime: no.
  const Frame& frame();

  /// Return the samples of the charts for `count` positions from `from` on; NaN for missing ticks and values that are
  /// not finite. Throws Error: as frame(). Realtime: no.
  std::vector<Sample> samples(std::int64_t from, std::size_t count);

 private:
  // A renderer without output, because HapticTick needs one.
  class Watcher final : public Renderer {
    void prepare(double) override {}
    Status render(const TickFrame& input, TickOutput& output) noexcept override {
      output.torque = input.kinematics.gravity;
      output.mode = RenderMode::free;
      return Status::ok;
    }
    void resetState() noexcept override {}
    StateBlock stateBlock() noexcept override { return {nullptr, 0}; }
  };

  void makeIndex();
  std::size_t stretchAt(std::uint64_t position) const noexcept;  // last stretch that begins at or before `position`
  template <typename Function>
  void watch(std::size_t stretch, std::uint64_t end, Frame& frame, const Function& each);
  const std::vector<Sample>& samplesOf(std::size_t stretch);

  std::string path_;
  RecordingReader reader_;
  DeviceParameters parameters_;
  std::shared_ptr<const Mechanism> device_;
  SceneFile scene_;
  Watcher watcher_;
  HapticTick tick_;
  ToolCache cache_;

  std::vector<Stretch> stretches_;
  std::vector<PlayerEvent> events_;
  std::vector<std::string> notes_;

  double place_ = 0.0, speed_ = 1.0;
  bool playing_ = false;

  RecordedChunk chunk_;
  Frame frame_;
  std::uint64_t framed_ = UINT64_MAX;                   // position of frame_
  std::map<std::size_t, std::vector<Sample>> samples_;  // by stretch
};

}  // namespace enamel::viewer
