// Runs an experiment beside the drawing thread: commands in, frames and samples out, nobody waits.
#pragma once

#include <memory>

#include "enamel/core/spsc_ring.hpp"
#include "enamel/runtime/periodic_thread.hpp"
#include "enamel/runtime/triple_buffer.hpp"
#include "experiment.hpp"

namespace enamel::viewer {

/// One tick, for the charts.
struct Sample {
  Vec3 position = Vec3::Zero();  ///< of the TCP, m
  double gap = 0.0;              ///< m
  double normalForce = 0.0;      ///< N
  JointVector torque;            ///< N m or N
};
inline Sample sampleOf(const TickRecord& record) noexcept {
  return {record.pose.position, record.nearest.gap, record.normalForce, record.torque};
}

/// A change between two ticks.
struct RunnerCommand {
  enum class Kind : std::uint8_t {
    handTo,
    handBy,
    select,
    grip,
    testPush,
    spin,
    undo,
    restore,
    pause,
    resume,
    step,
    slowdown,
    replace
  } kind;
  Vec3 target = Vec3::Zero();        ///< of handTo and, relative, of handBy, m
  int number = 0;                    ///< RendererSlot of select, 1 or 0 of spin, ticks of step, factor of slowdown
  Grip grip = kFirmGrip;             ///< of grip
  Experiment* experiment = nullptr;  ///< of replace; owned by the runner from here on
};

/// The haptic side is period(), called once per kPeriod of wall time by a PeriodicThread, or by a loop on simulated
/// time: the same code. Everything else belongs to the drawing thread.
class Runner {
 public:
  explicit Runner(std::unique_ptr<Experiment> experiment);
  ~Runner();
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;

  /// Takes the waiting commands, then ticks as pause and slow motion allow, and publishes. Realtime: yes.
  void period() noexcept;

  /// False if the queue is full (the haptic side stands still). Realtime: yes.
  bool send(const RunnerCommand& command) noexcept { return commands_.push(command); }

  /// Replaces the experiment between two ticks; the old one is destroyed by collect(). Realtime: no.
  void replace(std::unique_ptr<Experiment> experiment);
  void collect() noexcept;

  /// The newest frame, and the samples since the last call.
  const Frame& frame() noexcept;
  bool nextSample(Sample& sample) noexcept { return samples_.pop(sample); }

 private:
  void obey(const RunnerCommand& command) noexcept;
  void tick() noexcept;

  Experiment* experiment_;  // of the haptic side
  bool paused_ = false;
  int steps_ = 0, slowdown_ = 1, waited_ = 0;
  std::uint64_t dropped_ = 0;
  SpscRing<RunnerCommand, 256> commands_;
  SpscRing<Experiment*, 256> retired_;
  SpscRing<Sample, 8192> samples_;
  TripleBuffer<Frame> frames_;
};

}  // namespace enamel::viewer
