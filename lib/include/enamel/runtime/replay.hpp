// Runs a recording again.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "enamel/render/tick.hpp"
#include "enamel/runtime/recording.hpp"

namespace enamel {

/// The first number of a tick that came out otherwise.
struct ReplayDifference {
  std::uint64_t tick = 0;
  double time = 0.0;  ///< s
  std::string what;   ///< "requested torque", "command", ...
  int joint = -1;     ///< counted from 0; -1: not of a joint
  double recorded = 0.0, replayed = 0.0;
};

/// What a replay found.
struct ReplayResult {
  std::uint64_t ticks = 0;      ///< that were run and compared
  std::uint64_t different = 0;  ///< of them
  std::uint64_t restored = 0;   ///< taken from the recording: the first of what follows a gap
  std::uint64_t lost = 0;       ///< that the recording says it lost
  std::uint64_t damaged = 0;    ///< chunks that could not be read
  std::string damage;           ///< what is wrong with the first of them
  bool closed = false;          ///< the recording has its end
  bool states = false;          ///< the renderer's states were compared too: they are of one size
  std::optional<ReplayDifference> first;
  JointVector requested, command;  ///< largest differences, N m or N
};

/// Runs `tick` on the measurements of a recording, from chunk `from` on, and compares all that it answers bit for bit:
/// requested torque, command, normal force, mode, status, the guard's reason, and a hash of the renderer's state where
/// that has the size of the recorded one. `tick` is newly made, with the header's device, scene, start and guard
/// options, and with any renderer. Behind a gap (lost ticks, damaged chunks, `from` above 0) it goes on from the state
/// that the chunk has; with a renderer of another state size it starts again there, and differs while the guard lets it
/// in. A drill that is attached to `tick` spins as recorded, and cuts again: its solids are as they were before the
/// recording; what a gap took from them is missing. `each` sees every tick after it was run. Throws Error: the device's
/// joints are not as many as the recording's, or there is no chunk `from`. Realtime: no.
ReplayResult replay(RecordingReader& recording, HapticTick& tick, std::uint64_t from = 0,
                    const std::function<void(const RecordedTick&, const HapticTick&)>& each = {});

}  // namespace enamel
