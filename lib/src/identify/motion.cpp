#include "enamel/identify/motion.hpp"

#include <algorithm>

#include "core/message.hpp"

namespace enamel {
namespace {

// Fill readings of ticks without a sample by straight lines. Their times are those of the loop.
void interpolate(RecordedMotion& motion) {
  Eigen::Index last = 0;
  for (Eigen::Index i = 1; i < motion.ticks(); ++i) {
    if (motion.isSample[static_cast<std::size_t>(i)] == 0) continue;
    for (Eigen::Index k = last + 1; k < i; ++k) {
      const double share = static_cast<double>(k - last) / static_cast<double>(i - last);
      motion.reading.col(k) = (1.0 - share) * motion.reading.col(last) + share * motion.reading.col(i);
    }
    last = i;
  }
}

bool isUsable(const RecordedTick& tick) {
  return tick.measurement.enabled && !tick.measurement.failed && tick.reason != GuardReason::disabled;
}

RecordedMotion motionOf(const RecordedTick* begin, const RecordedTick* end, double period, int joints) {
  while (begin < end && begin->measurement.age > 0) ++begin;
  while (begin < end && end[-1].measurement.age > 0) --end;
  RecordedMotion motion;
  motion.period = period;
  const Eigen::Index count = end - begin;
  motion.command.resize(joints, count);
  motion.reading.resize(joints, count);
  for (const RecordedTick* tick = begin; tick < end; ++tick) {
    const Measurement& m = tick->measurement;
    require(m.q.size() == joints && tick->command.size() == joints,
            "tick " + std::to_string(tick->number) + " has " + std::to_string(m.q.size()) +
                " joints, the device file has " + std::to_string(joints));
    motion.time.push_back(m.time);
    motion.command.col(tick - begin) = tick->command;
    motion.reading.col(tick - begin) = m.q;
    motion.isSample.push_back(m.age == 0 ? 1 : 0);
    motion.isLimited = motion.isLimited || tick->reason == GuardReason::torque;
  }
  interpolate(motion);
  return motion;
}

}  // namespace

std::vector<RecordedMotion> motionsOf(const std::vector<RecordedTick>& ticks, double period, int joints) {
  std::vector<RecordedMotion> motions;
  const auto shortest = static_cast<std::size_t>(kShortestMotion / period);
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= ticks.size(); ++i) {
    const bool follows = i < ticks.size() && isUsable(ticks[i]) &&
                         (i == begin || (ticks[i].number == ticks[i - 1].number + 1 &&
                                         ticks[i].measurement.time > ticks[i - 1].measurement.time));
    if (follows) continue;
    if (i - begin >= shortest) motions.push_back(motionOf(&ticks[begin], &ticks[begin] + (i - begin), period, joints));
    begin = i < ticks.size() && isUsable(ticks[i]) ? i : i + 1;
  }
  return motions;
}

std::vector<RecordedMotion> loadMotions(const std::string& path, int joints) {
  RecordingReader reader(path);
  require(reader.header().joints == joints, path + ": has " + std::to_string(reader.header().joints) +
                                                " joints, the device file has " + std::to_string(joints));
  std::vector<RecordedTick> ticks;
  RecordedChunk chunk;
  for (std::uint64_t i = 0; i < reader.chunks(); ++i)
    if (reader.read(i, chunk).empty()) ticks.insert(ticks.end(), chunk.ticks.begin(), chunk.ticks.end());
  return motionsOf(ticks, reader.header().guard.period, joints);
}

}  // namespace enamel
