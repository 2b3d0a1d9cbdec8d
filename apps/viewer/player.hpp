// Plays a recording: a source of frames and samples beside the running experiment. Knows no window.
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

/// A chunk that can be read. Positions count ticks from the first one that can, also those that are missing.
struct Stretch {
  std::uint64_t begin = 0;  ///< position of its first tick
  std::uint64_t end = 0;    ///< behind its last one; before the next one's begin where ticks are missing
  std::uint64_t chunk = 0;  ///< its number in the file
  bool contact = false;     ///< a wall was rendered
};

/// What one may want to look at: a contact begins, or the guard changes the command.
struct PlayerEvent {
  std::uint64_t position = 0;
  GuardReason reason = GuardReason::none;  ///< none: a contact
};

/// Looks at a recording tick by tick, at any place. The index, the events and the charts' samples of the last chunks
/// are kept, nothing else: memory does not depend on where one looks. Poses and contacts are computed as HapticTick
/// does, from the state that each chunk begins with.
class Player {
 public:
  static constexpr double kSlowest = 0.01, kFastest = 10.0;  // of real time

  /// Reads the whole file once, to check it and to make the index. Throws Error: as RecordingReader, parseDevice() and
  /// parseScene(); other joints than the device's; states of another size; no tick can be read. Realtime: no.
  explicit Player(const std::string& path);

  const std::string& path() const noexcept { return path_; }
  const RecordingHeader& header() const noexcept { return reader_.header(); }
  const DeviceParameters& parameters() const noexcept { return parameters_; }
  const SceneFile& scene() const noexcept { return scene_; }

  const std::vector<Stretch>& stretches() const noexcept { return stretches_; }
  const std::vector<PlayerEvent>& events() const noexcept { return events_; }
  std::uint64_t size() const noexcept { return stretches_.back().end; }  ///< positions
  /// What is wrong with the recording, a line each: cut off, damaged, with ticks lost or values that are not finite.
  const std::vector<std::string>& notes() const noexcept { return notes_; }

  std::uint64_t position() const noexcept { return static_cast<std::uint64_t>(place_); }
  double seconds() const noexcept { return place_ * header().guard.period; }  ///< from the first position
  bool playing() const noexcept { return playing_; }
  double speed() const noexcept { return speed_; }
  /// Ticks missing about the position; 0: it has one, and frame() is of it.
  std::uint64_t gap() const noexcept;

  /// At the end, playing starts from the beginning.
  void setPlaying(bool playing) noexcept;
  /// Times real time, kSlowest to kFastest.
  void setSpeed(double speed) noexcept;
  /// For so many seconds of a clock; stops at the last tick.
  void advance(double seconds) noexcept;
  /// To a position, or the nearest end.
  void seek(double position) noexcept;
  /// So many ticks on or back, where ticks are missing over them; pauses.
  void step(std::int64_t ticks) noexcept;
  /// To the next event, or the one before; pauses. False: there is no such event.
  bool jump(bool forward) noexcept;

  /// The tick at the position, where it is missing the one before. `paused` is filled in. Throws Error: the file was
  /// changed since. Realtime: no.
  const Frame& frame();

  /// What the charts show of `count` positions from `from` on: NaN where there is no tick, or no finite value. Throws
  /// Error: as frame(). Realtime: no.
  std::vector<Sample> samples(std::int64_t from, std::size_t count);

 private:
  // Asks for nothing; HapticTick needs one.
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
  std::size_t stretchAt(std::uint64_t position) const noexcept;  // the last that begins there or before
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
