// A connected device: a source of frames and samples, like a running experiment. Its loop is that of a session, so the
// viewer renders and guards as every other host does, and only draws what the loop reports.
#pragma once

#include <memory>
#include <vector>

#include "enamel/runtime/triple_buffer.hpp"
#include "enamel/session/session.hpp"
#include "runner.hpp"

namespace enamel::viewer {

class LiveDevice {
 public:
  /// Connect the device of `def`, and start its loop. `def` must have a device and a scene; beforeTick is overwritten.
  /// `slot` is shown as the renderer. Throws Error as Session and its startOpened().
  LiveDevice(SessionDef def, RendererSlot slot);
  LiveDevice(const LiveDevice&) = delete;
  LiveDevice& operator=(const LiveDevice&) = delete;

  const std::string& url() const noexcept { return def_.device; }
  const std::string& renderer() const noexcept { return def_.renderer; }
  const DeviceParameters& parameters() const noexcept { return parameters_; }
  const SceneFile& scene() const noexcept { return scene_; }
  const PeriodicTiming& timing() const noexcept { return session_->loop()->timing(); }
  bool isPolled() const noexcept { return session_->opened().poll > 0.0; }  ///< several periods of timing() a tick
  double period() const noexcept { return 1.0 / def_.rate; }                ///< of the ticks, s
  Snapshot snapshot() const { return session_->snapshot(); }

  /// Return the newest frame; then the samples since the last call. A frame has no force of the hand, because no device
  /// measures it.
  const Frame& frame() noexcept;
  bool nextSample(Sample& sample) noexcept { return samples_.pop(sample); }

  /// Record every tick, as Session::record(), and end the recording.
  void record(const std::string& path) { session_->record(path); }
  RecordingResult stopRecording() { return session_->stopRecording(); }

  /// Let the bur of the scene spin. The first button of the device does the same while it is pressed.
  void spin(bool on) { session_->spin(on); }

  /// Take a changed brick of an obstacle of scene(), as Session::takeChange().
  bool takeChange(std::size_t obstacle, BrickChange& change) {
    return session_->takeChange(obstacles_[obstacle], change);
  }

  /// Continue after a fault of the guard.
  void reset() { session_->reset(); }

 private:
  void look(const TickFrame& tick) noexcept;

  SessionDef def_;
  SceneFile scene_;  // a copy for the nearest contact and the picture
  std::vector<ObstacleId> obstacles_;
  ToolCache cache_;
  DeviceParameters parameters_;
  JointVector largest_;  // of each motor, N m or N; 1 without a motor, whose torque is 0
  // Of the loop's thread:
  bool isPressed_ = false;  // the first button
  Frame frame_;
  ConditionWatch conditions_;
  ReadoutFilter readouts_;
  std::uint64_t dropped_ = 0;
  SpscRing<Sample, 8192> samples_;
  TripleBuffer<Frame> frames_;
  std::unique_ptr<Session> session_;  // last: its loop ends before the members that it uses
};

}  // namespace enamel::viewer
