// Files of devices, scenes, keys and recordings.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "enamel/collision/scene_file.hpp"
#include "enamel/collision/solid_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/runtime/device_link.hpp"
#include "enamel/runtime/recording.hpp"
#include "memory_file.hpp"
#include "surfaces.hpp"

namespace enamel::attack {

namespace {

void attackDevice(std::string_view bytes) {
  try {
    const std::shared_ptr<const Mechanism> device = makeMechanism(parseDevice(bytes, "a.toml"));
    const Kinematics& home = device->home();
    require(home.q.allFinite() && home.jacobian.allFinite() && home.gravity.allFinite(), "home is finite");
    Kinematics k = home;
    require(device->track(home.q, JointVector::Zero(device->joints()), true, k) == Status::ok, "home can be reached");
  } catch (const Error&) {
  }
}

void attackScene(std::string_view bytes) {
  try {
    const SceneFile file = parseScene(bytes, ENAMEL_SOURCE_DIR "/data/a.toml");
    require(file.start.allFinite(), "the start is finite");
    ContactSnapshot contacts;
    Pose pose;
    pose.position = file.start;
    require(findContacts(file.scene, file.tool, pose, 1e-3, nullptr, contacts) == Status::ok, "contacts are found");
  } catch (const Error&) {
  }
}

// The checksum is corrected, so that the fuzzer reaches the values.
void attackSolid(std::string_view bytes) {
  constexpr std::size_t kPreamble = 24;
  std::string content(bytes);
  if (content.size() >= kPreamble) {
    const std::uint32_t crc = crc32(bytes.substr(kPreamble));
    const std::uint64_t size = content.size() - kPreamble;
    std::memcpy(content.data() + 12, &crc, sizeof crc);
    std::memcpy(content.data() + 16, &size, sizeof size);
  }
  try {
    Solid solid = parseSolid(content, "a.solid", 4);
    for (const double volume : solid.volume()) require(volume >= 0.0 && std::isfinite(volume), "a volume is finite");
    const Vec3 middle = 0.5 * (solid.low() + solid.high());
    solid.cut({middle, middle}, {middle, middle}, std::min(3.0 * solid.cell(), Solid::kLargestBur));
    (void)solid.undo();
    const SolidPoint nearest = signedDistance(solid, middle);
    require(!nearest.found || std::isfinite(nearest.distance), "a distance is finite");
  } catch (const Error&) {
  }
}

void attackKey(std::string_view bytes) {
  try {
    (void)readKey(MemoryFile(bytes).path());
  } catch (const Error&) {
  }
}

void attackRecording(std::string_view bytes) {
  try {
    const MemoryFile file(bytes);
    RecordingReader reader(file.path());
    RecordedChunk chunk;
    for (std::uint64_t i = 0; i < reader.chunks(); ++i) {
      if (!reader.read(i, chunk).empty()) continue;
      require(chunk.ticks.size() <= kChunkTicks, "a chunk has its ticks");
      require(chunk.state.empty() || chunk.state.size() == reader.header().stateSize, "a state has its size");
    }
  } catch (const Error&) {
  }
}

const Registration kFiles[] = {{"device", attackDevice},
                               {"scene", attackScene},
                               {"solid", attackSolid},
                               {"key", attackKey},
                               {"recording", attackRecording}};

}  // namespace

}  // namespace enamel::attack
