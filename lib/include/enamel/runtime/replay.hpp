// Replay of a recording.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "enamel/render/tick.hpp"
#include "enamel/runtime/recording.hpp"

namespace enamel {

/// The first number of a tick that differs.
struct ReplayDifference {
  std::uint64_t tick = 0;
  double time = 0.0;  ///< s
  std::string what;   ///< "requested torque", "command", ...
  int joint = -1;     ///< from 0; -1: the number is not one of a joint
  double recorded = 0.0, replayed = 0.0;
};

/// Result of a replay.
struct ReplayResult {
  std::uint64_t ticks = 0;      ///< ticks that were run and compared
  std::uint64_t different = 0;  ///< ticks that differ
  std::uint64_t restored = 0;   ///< ticks whose state came from the recording: the first ones after gaps
  std::uint64_t lost = 0;       ///< ticks lost while recording
  std::uint64_t damaged = 0;    ///< chunks that could not be read
  std::string damage;           ///< what is wrong with the first of them
  bool closed = false;          ///< the recording is complete
  bool states = false;          ///< the renderer's states were also compared, because their sizes are equal
  std::optional<ReplayDifference> first;
  JointVector requested, command;  ///< largest differences, N m or N
};

/// Run `tick` on the measurements of a recording, from chunk `from` on, and compare its outputs bit for bit. It
/// compares requested torque, command, normal force, mode, status, saturation and the guard's reason. If the renderer's
/// state has the recorded size, it also compares a hash of that state, and the whole state at the first tick of each
/// chunk.
///
/// - `tick` must be new, with the header's device, scene, start and guard options, and may have any renderer.
/// - After a gap (lost ticks, damaged chunks, `from` above 0) the replay continues from the state in the chunk. A
///   renderer with another state size restarts there. Its output differs while the guard admits it again.
/// - A drill attached to `tick` spins as recorded and cuts again. Its solids must be as before the recording. The
///   material removed during a gap is not removed.
/// - `each` is called after every tick.
///
/// Throws Error if the number of joints differs from the recording's, or chunk `from` does not exist. Realtime: no.
ReplayResult replay(RecordingReader& recording, HapticTick& tick, std::uint64_t from = 0,
                    const std::function<void(const RecordedTick&, const HapticTick&)>& each = {});

}  // namespace enamel
