#include "enamel/runtime/replay.hpp"

#include <cmath>
#include <cstring>

#include "core/message.hpp"
#include "recording_format.hpp"

namespace enamel {

using namespace recording;

namespace {

bool sameBits(double a, double b) noexcept { return std::memcmp(&a, &b, sizeof(a)) == 0; }

// Compares the output of a tick with the recorded one.
class Comparison {
 public:
  Comparison(ReplayResult& result, const RecordedTick& tick) : result_(result), tick_(tick) {}

  void numbers(const char* what, int joint, double recorded, double replayed) {
    if (!sameBits(recorded, replayed)) tell(what, joint, recorded, replayed);
  }
  void vectors(const char* what, const JointVector& recorded, const JointVector& replayed, JointVector& largest) {
    for (int i = 0; i < recorded.size(); ++i) {
      numbers(what, i, recorded[i], replayed[i]);
      const double difference = std::abs(recorded[i] - replayed[i]);
      if (!(difference <= largest[i])) largest[i] = difference;
    }
  }
  void tell(const char* what, int joint, double recorded, double replayed) {
    if (!isDifferent_) ++result_.different;
    isDifferent_ = true;
    if (!result_.first)
      result_.first = ReplayDifference{tick_.number, tick_.measurement.time, what, joint, recorded, replayed};
  }

 private:
  ReplayResult& result_;
  const RecordedTick& tick_;
  bool isDifferent_ = false;
};

template <typename Enum>
double numberOf(Enum value) {
  return static_cast<double>(value);
}

}  // namespace

ReplayResult replay(RecordingReader& recording, HapticTick& tick, std::uint64_t from,
                    const std::function<void(const RecordedTick&, const HapticTick&)>& each) {
  const RecordingHeader& header = recording.header();
  const int joints = static_cast<int>(tick.frame().output.torque.size());
  require(joints == header.joints, "the device has " + std::to_string(joints) + " joints, that of the recording has " +
                                       std::to_string(header.joints));
  ReplayResult result;
  result.requested = result.command = JointVector::Zero(joints);
  result.states = tick.renderer().stateSize() == header.rendererState;
  const bool restores = tick.stateSize() == header.stateSize;
  std::string state(tick.stateSize(), '\0');
  RecordedChunk chunk;
  bool isGap = from > 0;
  if (isGap) (void)recording.read(from, chunk);  // throws if the chunk does not exist
  for (std::uint64_t i = from; i < recording.chunks(); ++i) {
    if (const std::string problem = recording.read(i, chunk); !problem.empty()) {
      if (result.damaged++ == 0) result.damage = problem;
      isGap = true;
      continue;
    }
    result.lost += chunk.lost;
    result.closed = chunk.last;
    isGap = isGap || chunk.lost > 0 || (i == 0 && !chunk.fresh);
    for (const RecordedTick& recorded : chunk.ticks) {
      if (recorded.reset || (isGap && !restores)) tick.reset();
      if (tick.drill() != nullptr) tick.drill()->spin(recorded.spins);
      Command command;
      const Status status = tick(recorded.measurement, command);
      if (isGap && restores) {
        tick.loadState(chunk.state.data());
        ++result.restored;
      } else {
        Comparison with(result, recorded);
        ++result.ticks;
        with.vectors("requested torque", recorded.requested, tick.frame().output.torque, result.requested);
        with.vectors("command", recorded.command, command.effort, result.command);
        with.numbers("normal force", -1, recorded.normalForce, tick.frame().output.normalForce);
        with.numbers("status", -1, numberOf(recorded.status), numberOf(status));
        with.numbers("guard's reason", -1, numberOf(recorded.reason), numberOf(tick.frame().reason));
        with.numbers("mode", -1, numberOf(recorded.mode), numberOf(tick.frame().output.mode));
        with.numbers("saturated", -1, recorded.saturated, tick.frame().output.saturated);
        if (restores && &recorded == chunk.ticks.data()) {
          tick.saveState(state.data());
          if (state != chunk.state) with.tell("state of the tick", -1, std::nan(""), std::nan(""));
        }
        if (result.states) {
          tick.renderer().saveState(state.data());
          if (hashOf(state.data(), header.rendererState) != recorded.stateHash)
            with.tell("state of the renderer", -1, std::nan(""), std::nan(""));
        }
      }
      isGap = false;
      if (each) each(recorded, tick);
    }
  }
  return result;
}

}  // namespace enamel
