// Runs an experiment beside the drawing thread: commands in, frames and samples out, without waiting.
#pragma once

#include <memory>

#include "compare.hpp"
#include "enamel/core/spsc_ring.hpp"
#include "enamel/runtime/periodic_thread.hpp"
#include "enamel/runtime/triple_buffer.hpp"
#include "experiment.hpp"

namespace enamel::viewer {

/// One tick for the charts.
struct Sample {
  Vec3 position = Vec3::Zero();  ///< of the TCP, m
  double gap = 0.0;              ///< m
  double normalForce = 0.0;      ///< of deliveredOf(), N
  JointVector torque;            ///< N m or N
};
inline Sample sampleOf(const TickRecord& record) noexcept {
  return {record.pose.position, record.nearest.gap, deliveredOf(record).normal, record.torque};
}

/// Combine two experiments under one hand.
PairSample pairOf(const TickRecord& left, const TickRecord& right) noexcept;

/// A change between two ticks.
struct RunnerCommand {
  enum class Kind : std::uint8_t {
    handTo,
    handBy,
    select,
    selectRight,
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
  Vec3 target = Vec3::Zero();  ///< handTo: absolute, handBy: relative, m
  int number = 0;         ///< RendererSlot of select and selectRight, 1 or 0 of spin, ticks of step, factor of slowdown
  Grip grip = kFirmGrip;  ///< of grip
  /// replace: the runner owns them from here on. `second`: the right tool under the same hand, or nullptr.
  Experiment *experiment = nullptr, *second = nullptr;
};

/// The haptic side is period(). A PeriodicThread calls it once per kPeriod of wall time, or a loop calls it in
/// simulated time: the code is the same. Everything else belongs to the drawing thread.
class Runner {
 public:
  explicit Runner(std::unique_ptr<Experiment> experiment);
  ~Runner();
  Runner(const Runner&) = delete;
  Runner& operator=(const Runner&) = delete;

  /// Process waiting commands, run ticks as pause and slow motion permit, and publish. Realtime: yes.
  void period() noexcept;

  /// Send a command. Return false if the queue is full because the haptic side has stopped. Realtime: yes.
  bool send(const RunnerCommand& command) noexcept { return commands_.push(command); }

  /// Replace the experiments between two ticks; collect() destroys the old ones. With `second`, both tick together with
  /// Experiment::tickTogether(): the first receives commands of the hand, both receive test pushes. Realtime: no.
  void replace(std::unique_ptr<Experiment> experiment, std::unique_ptr<Experiment> second = nullptr);
  void collect() noexcept;

  /// Return the newest frame; then the second experiment's in the same tick, or nullptr; then the samples since the
  /// last call.
  const Frame& frame() noexcept;
  const Frame* secondFrame() const noexcept { return frames_.latest().pair ? &frames_.latest().second : nullptr; }
  bool nextSample(Sample& sample) noexcept { return samples_.pop(sample); }
  bool nextPair(PairSample& sample) noexcept { return pairs_.pop(sample); }

 private:
  void obey(const RunnerCommand& command) noexcept;
  void tick() noexcept;

  struct Frames {
    Frame first, second;
    bool pair = false;
  };

  Experiment* experiment_;        // belongs to the haptic side
  Experiment* second_ = nullptr;  // under the same hand, or nullptr
  bool paused_ = false;
  int steps_ = 0, slowdown_ = 1, waited_ = 0;
  std::uint64_t dropped_ = 0;
  SpscRing<RunnerCommand, 256> commands_;
  SpscRing<Experiment*, 512> retired_;
  SpscRing<Sample, 8192> samples_;
  SpscRing<PairSample, 8192> pairs_;
  TripleBuffer<Frames> frames_;
};

}  // namespace enamel::viewer
