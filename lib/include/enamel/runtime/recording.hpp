// Recordings of haptic ticks: contents and reader. The format, byte by byte: lib/docs/recording.md.
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

/// Number of ticks of a chunk. The last chunk may have fewer.
inline constexpr std::size_t kChunkTicks = 128;

/// Subject of a recording: all data needed to build its HapticTick again.
struct RecordingHeader {
  std::string deviceFile, deviceText;             ///< device file: its path, its TOML text
  std::string sceneFile, sceneText;               ///< the same for the scene file; empty: the wall z = 0 and a point
  std::uint32_t files = 0;                        ///< CRC-32 of the referenced files: meshes, a servo's file
  std::string renderer, plugin;                   ///< name of the renderer; path of the plugin, empty if linked
  std::map<std::string, std::string> parameters;  ///< of the renderer, by the names in plugins
  Pose start;                                     ///< start pose of the HapticTick

  // The Recorder sets the following fields.
  GuardOptions guard;             ///< includes the period
  int joints = 0;                 ///< number of joints of the device
  std::size_t stateSize = 0;      ///< HapticTick::stateSize(), bytes; the state is recorded at each chunk's first tick
  std::size_t rendererState = 0;  ///< Renderer::stateSize(), bytes; a hash of the state is recorded at each tick
};

/// Name the renderer in a header (`plugin`: its file, or empty). Add the checksum of the files that the header only
/// names: the meshes of the scene, and the file of the parameter `gain`. Throws Error if that file cannot be read.
/// Realtime: no.
void nameRenderer(const std::string& renderer, const std::string& plugin,
                  const std::map<std::string, std::string>& parameters, const Scene& scene, RecordingHeader& header);

/// Return whether one of these files has changed. Throws Error as nameRenderer(). Realtime: no.
bool filesHaveChanged(const RecordingHeader& header, const Scene& scene);

/// Return the CRC-32 of corners and triangles of all meshes of a scene; 0 without meshes. Realtime: no.
std::uint32_t meshChecksum(const Scene& scene);

/// A recorded tick.
struct RecordedTick {
  std::uint64_t number = 0;     ///< counted by the loop; missed ticks leave gaps
  Measurement measurement;      ///< joint vectors from the device, even with a wrong size
  JointVector requested;        ///< torque requested by the renderer, N m or N
  JointVector command;          ///< as the guard changed it, N m or N
  double normalForce = 0.0;     ///< as the renderer reports it, N
  std::uint64_t stateHash = 0;  ///< of the renderer's state after the tick
  Status status = Status::ok;   ///< of the haptic tick
  GuardReason reason = GuardReason::none;
  RenderMode mode = RenderMode::free;
  bool saturated = false;
  bool reset = false;  ///< HapticTick::reset() was called before this tick
  bool spins = false;  ///< the bur spins: Drill::spins()
};

/// A group of ticks written together.
struct RecordedChunk {
  std::uint64_t sequence = 0;  ///< number of the chunk, from 0
  std::uint64_t lost = 0;      ///< ticks lost just before this chunk
  bool fresh = false;          ///< its first tick was the first tick of the HapticTick
  bool last = false;           ///< the recording was closed after it
  std::string state;           ///< HapticTick::saveState() after its first tick; empty: not recorded
  std::vector<RecordedTick> ticks;
};

/// Read a recording one chunk at a time. Memory use does not grow with the file. A truncated file is read up to its
/// last complete chunk, for example after a crash or while it is being written.
class RecordingReader {
 public:
  /// Throws ConfigurationError if the file cannot be opened, is not a regular file or a recording, or has another
  /// version. Throws it also if the header is damaged or contains invalid values. Realtime: no.
  explicit RecordingReader(const std::string& path);
  ~RecordingReader();
  RecordingReader(const RecordingReader&) = delete;
  RecordingReader& operator=(const RecordingReader&) = delete;

  const RecordingHeader& header() const noexcept { return header_; }

  /// Return the number of chunks in the file. The last one may be truncated.
  std::uint64_t chunks() const noexcept { return chunks_; }

  /// Read chunk `number`. Return an empty text if it is complete, else what is wrong with it; `chunk` is then invalid.
  /// Throws Error if the file does not have that chunk. Realtime: no.
  std::string read(std::uint64_t number, RecordedChunk& chunk);

 private:
  std::string path_;
  int file_;
  RecordingHeader header_;
  std::uint64_t begin_ = 0, size_ = 0, chunkSize_ = 0, chunks_ = 0;  // bytes; chunkSize_: of a complete chunk
  std::size_t tickSize_ = 0;                                         // bytes
  std::string buffer_;
};

}  // namespace enamel
