// A device that pushes against a wall, and recordings of it.
#pragma once

#include <cstring>

#include "enamel/collision/scene_file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/runtime/recorder.hpp"
#include "enamel/runtime/replay.hpp"
#include "support/catch.hpp"
#include "support/mechanisms.hpp"
#include "support/temporary_folder.hpp"

namespace enamel::test::recording_rig {

inline constexpr std::size_t kHead = 24, kChunkHead = 32, kTick = 344;  // bytes, as on the page

inline std::uint32_t wordAt(const std::string& bytes, std::size_t at) {
  std::uint32_t word;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return word;
}

// Return the size of a chunk whose state has `state` bytes.
inline std::size_t chunkSize(std::size_t state) { return kChunkHead + (state + 7) / 8 * 8 + kChunkTicks * kTick; }

// A device, a wall and a spring.
struct Rig {
  std::shared_ptr<const Mechanism> device = makeMechanism(loadDevice(test::deviceFile("cartesian-6.toml")));
  Scene scene = flatWall();
  ImpedanceRenderer spring{{2000.0, 5.0}};
  HapticTick tick{*device, scene, Tool(), spring, 1e-3};
  std::uint64_t number = 0;
  Measurement measurement;
  Command command;

  Status step() {
    const double t = 1e-3 * static_cast<double>(number);
    Kinematics k;
    Pose pose;
    pose.position = {0.002 * std::sin(3.0 * t), 0.0, 1e-3 * std::sin(20.0 * t)};
    REQUIRE(device->reach(pose, Vec6::Zero(), false, k) == Status::ok);
    measurement.time = t;
    measurement.q = k.q;
    measurement.rates = k.rates;
    return tick(measurement, command);
  }
  void run(Recorder& recorder, int ticks) {
    for (int i = 0; i < ticks; ++i) {
      const Status status = step();
      recorder.add(number++, measurement, tick, command, status);
    }
  }
};

inline ReplayResult replayed(const std::string& file, std::uint64_t from = 0) {
  RecordingReader reader(file);
  Rig rig;
  HapticTick tick(*rig.device, rig.scene, Tool(), rig.spring, reader.header().guard, reader.header().start);
  return replay(reader, tick, from);
}

// Return a recording of a rig as bytes.
inline std::string recorded(const test::TemporaryFolder& folder, int ticks) {
  const std::string file = folder / "made.rec";
  std::filesystem::remove(file);
  Rig rig;
  Recorder recorder(file, {}, rig.tick);
  for (int left = ticks; left > 0; left -= 64) {
    recorder.makeRoom();
    rig.run(recorder, std::min(left, 64));
  }
  const RecordingResult result = recorder.close();
  REQUIRE(result.ticks == static_cast<std::uint64_t>(ticks));
  REQUIRE(result.problem.empty());
  return test::readFile(file);
}

}  // namespace enamel::test::recording_rig
