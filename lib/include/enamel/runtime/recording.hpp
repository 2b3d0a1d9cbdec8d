// Recordings of haptic ticks: what stands in one, and how it is read. The format, byte by byte: lib/docs/recording.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "enamel/collision/scene.hpp"
#include "enamel/device/haptic_device.hpp"
#include "enamel/render/guard.hpp"
#include "enamel/render/renderer.hpp"

namespace enamel {

/// Ticks of a chunk; the last chunk may have fewer.
inline constexpr std::size_t kChunkTicks = 128;

/// What a recording is of: enough to build its HapticTick again.
struct RecordingHeader {
  std::string deviceFile, deviceText;             ///< of the device file: where it was, its TOML
  std::string sceneFile, sceneText;               ///< the same of the scene file; empty: the wall z = 0 and a point
  std::uint32_t files = 0;                        ///< CRC-32 of what it only names: meshes, the file of a servo
  std::string renderer, plugin;                   ///< its name; the plugin's file, empty where it was linked
  std::map<std::string, std::string> parameters;  ///< of the renderer, by the names that plugins give them
  Pose start;                                     ///< that HapticTick was made with

  // The Recorder fills in what follows.
  GuardOptions guard;             ///< with the period
  int joints = 0;                 ///< of the device
  std::size_t stateSize = 0;      ///< HapticTick::stateSize(), bytes: at every chunk's first tick
  std::size_t rendererState = 0;  ///< Renderer::stateSize(), bytes: of it, a hash at every tick
};

/// CRC-32 of the corners and triangles of all meshes of a scene; 0 where there is none. Realtime: no.
std::uint32_t meshChecksum(const Scene& scene);

/// CRC-32 of IEEE 802.3 of `bytes`, continued from that of what stood before. Realtime: yes.
std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0) noexcept;

/// A tick as it was recorded.
struct RecordedTick {
  std::uint64_t number = 0;     ///< counted by the loop; what it missed is missing
  Measurement measurement;      ///< joint vectors as the device gave them, also of a wrong size
  JointVector requested;        ///< by the renderer, N m or N
  JointVector command;          ///< what the guard made of it, N m or N
  double normalForce = 0.0;     ///< as the renderer reports it, N
  std::uint64_t stateHash = 0;  ///< of the renderer's state after the tick
  Status status = Status::ok;   ///< of the haptic tick
  GuardReason reason = GuardReason::none;
  RenderMode mode = RenderMode::free;
  bool saturated = false;
  bool reset = false;  ///< HapticTick::reset() came before it
  bool spins = false;  ///< the bur did: Drill::spins()
};

/// What was written at once.
struct RecordedChunk {
  std::uint64_t sequence = 0;  ///< counted from 0
  std::uint64_t lost = 0;      ///< ticks that could not be recorded, just before this chunk
  bool fresh = false;          ///< its first tick was the HapticTick's first
  bool last = false;           ///< the recording was closed behind it
  std::string state;           ///< HapticTick::saveState() after its first tick; empty where it has none
  std::vector<RecordedTick> ticks;
};

/// Reads a recording, one chunk at a time: memory does not grow with the file. A file that was cut off, by a crash or
/// while it is being written, is read to its last whole chunk.
class RecordingReader {
 public:
  /// Throws ConfigurationError: the file cannot be opened, is no plain file, no recording or of another version; its
  /// header is damaged or has values that no recording can have. Realtime: no.
  explicit RecordingReader(const std::string& path);
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  const RecordingHeader& header() const noexcept { return header_; }

  /// Chunks that the file has bytes of; the last one may be cut off.
  std::uint64_t chunks() const noexcept { return chunks_; }

  /// Reads chunk `number`. Returns what is wrong with it, or "" where all of it could be read; only then `chunk` is
  /// that chunk. Throws Error: no such number. Realtime: no.
  std::string read(std::uint64_t number, RecordedChunk& chunk);

 private:
  std::string path_;
  int file_;
  RecordingHeader header_;
  std::uint64_t begin_ = 0, size_ = 0, chunkSize_ = 0, chunks_ = 0;  // bytes; of a whole chunk
  std::string buffer_;
};

}  // namespace enamel
