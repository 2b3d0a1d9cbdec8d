#include "enamel/runtime/recording.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <variant>

#include "core/message.hpp"
#include "core/system_file.hpp"
#include "enamel/core/file.hpp"
#include "recording_format.hpp"

namespace enamel {
namespace recording {
namespace {

using Json = nlohmann::json;  // ordered_json would search all keys for each lookup
using Written = nlohmann::ordered_json;

// Options of the guard, named as in the header.
const std::pair<const char*, double GuardOptions::*> kNumbers[] = {
    {"period", &GuardOptions::period},    {"force", &GuardOptions::force},
    {"moment", &GuardOptions::moment},    {"margin", &GuardOptions::margin},
    {"speed", &GuardOptions::speed},      {"stop_speed", &GuardOptions::stopSpeed},
    {"turn", &GuardOptions::turn},        {"stop_turn", &GuardOptions::stopTurn},
    {"brake", &GuardOptions::brake},      {"brake_turn", &GuardOptions::brakeTurn},
    {"energy", &GuardOptions::energy},    {"power", &GuardOptions::power},
    {"softest", &GuardOptions::softest},  {"oscillation", &GuardOptions::oscillation},
    {"engage", &GuardOptions::engage},    {"ramp_in", &GuardOptions::rampIn},
    {"ramp_out", &GuardOptions::rampOut},
};
const std::pair<const char*, JointVector GuardOptions::*> kVectors[] = {
    {"torque", &GuardOptions::torque},
    {"slew", &GuardOptions::slew},
    {"rate", &GuardOptions::rate},
    {"count", &GuardOptions::encoderStep},
};
const std::pair<const char*, double Drive::*> kDrive[] = {{"bandwidth", &Drive::bandwidth},
                                                          {"rotor_inertia", &Drive::rotorInertia},
                                                          {"stiffness", &Drive::stiffness},
                                                          {"damping", &Drive::damping}};
const std::pair<const char*, int GuardOptions::*> kCounts[] = {{"longest_gap", &GuardOptions::longestGap},
                                                               {"most_missed", &GuardOptions::mostMissed}};

template <typename Matrix>
Written listOf(const Matrix& m) {  // by columns; infinity becomes null
  Written list = Written::array();
  for (Eigen::Index i = 0; i < m.size(); ++i) list.push_back(m.data()[i]);
  return list;
}

// A JSON value of a file with its key, for messages.
class Reading {
 public:
  Reading(const Json& json, const std::string& file, const std::string& key) : json_(json), file_(file), key_(key) {}

  Reading at(const std::string& key) const {
    const auto found = json_.find(key);
    if (!json_.is_object() || found == json_.end()) Reading(json_, file_, path(key)).refuse("is missing");
    return {*found, file_, path(key)};
  }
  std::string text() const {
    if (!json_.is_string()) refuse("must be a string");
    return json_.get<std::string>();
  }
  double number() const {
    if (json_.is_null()) return kUnlimited;
    if (!json_.is_number()) refuse("must be a number");
    return json_.get<double>();
  }
  std::uint64_t whole(std::uint64_t most) const {
    if (!json_.is_number_unsigned() || json_.get<std::uint64_t>() > most)
      refuse("must be a whole number, at most " + std::to_string(most));
    return json_.get<std::uint64_t>();
  }
  bool flag() const {
    if (!json_.is_boolean()) refuse("must be true or false");
    return json_.get<bool>();
  }
  template <typename Matrix>
  void read(Matrix& m) const {  // m has the expected size
    if (!json_.is_array() || json_.size() != static_cast<std::size_t>(m.size()))
      refuse("must be a list of " + std::to_string(m.size()) + " numbers");
    for (Eigen::Index i = 0; i < m.size(); ++i)
      m.data()[i] = Reading(json_[static_cast<std::size_t>(i)], file_, key_).number();
  }
  const Json& json() const { return json_; }
  [[noreturn]] void refuse(const std::string& problem) const {
    throw ConfigurationError(file_, 0, "header: " + key_, problem);
  }

 private:
  std::string path(const std::string& key) const { return key_.empty() ? key : key_ + "." + key; }

  const Json& json_;
  const std::string& file_;
  std::string key_;
};

}  // namespace

std::string headerText(const RecordingHeader& h) {
  Written json;
  json["device"] = {{"file", h.deviceFile}, {"text", h.deviceText}};
  json["scene"] = {{"file", h.sceneFile}, {"text", h.sceneText}};
  json["files"] = h.files;
  json["renderer"] = {{"name", h.renderer}, {"plugin", h.plugin}, {"parameters", Written::object()}};
  for (const auto& [key, value] : h.parameters) json["renderer"]["parameters"][key] = value;
  json["start"] = {{"position", listOf(h.start.position)}, {"rotation", listOf(h.start.rotation)}};
  json["joints"] = h.joints;
  json["state_size"] = h.stateSize;
  json["renderer_state"] = h.rendererState;
  Written& guard = json["guard"];
  guard["on"] = h.guard.on;
  for (const auto& [name, value] : kNumbers) guard[name] = h.guard.*value;
  for (const auto& [name, value] : kVectors) guard[name] = listOf(h.guard.*value);
  for (const auto& [name, value] : kCounts) guard[name] = h.guard.*value;
  guard["workspace"] = listOf(h.guard.workspace);
  guard["damping"] = listOf(h.guard.damping);
  if (h.guard.delay > 0) guard["delay"] = h.guard.delay;
  if (h.guard.drive.stiffness > 0.0) {  // a rigid drive has no effect
    Written& drive = guard["drive"];
    for (const auto& [name, value] : kDrive) drive[name] = h.guard.drive.*value;
    drive["encoder_on_link"] = h.guard.drive.encoderOnLink;
  }
  return json.dump(2, ' ', false, Written::error_handler_t::replace) + "\n";
}

RecordingHeader parseHeader(const std::string& text, const std::string& file) {
  checkNesting(text, file);
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) throw ConfigurationError(file, 0, "header", "is not JSON");
  const Reading all(json, file, "");
  RecordingHeader h;
  h.deviceFile = all.at("device").at("file").text();
  h.deviceText = all.at("device").at("text").text();
  h.sceneFile = all.at("scene").at("file").text();
  h.sceneText = all.at("scene").at("text").text();
  h.files = static_cast<std::uint32_t>(all.at("files").whole(UINT32_MAX));
  h.renderer = all.at("renderer").at("name").text();
  h.plugin = all.at("renderer").at("plugin").text();
  const Reading parameters = all.at("renderer").at("parameters");
  if (!parameters.json().is_object()) parameters.refuse("must be an object of strings");
  for (const auto& entry : parameters.json().items()) h.parameters[entry.key()] = parameters.at(entry.key()).text();
  all.at("start").at("position").read(h.start.position);
  all.at("start").at("rotation").read(h.start.rotation);
  h.joints = static_cast<int>(all.at("joints").whole(kMaxJoints));
  h.stateSize = all.at("state_size").whole(kLargestState);
  h.rendererState = all.at("renderer_state").whole(kLargestState);
  const Reading guard = all.at("guard");
  h.guard.on = guard.at("on").flag();
  for (const auto& [name, value] : kNumbers) h.guard.*value = guard.at(name).number();
  for (const auto& [name, value] : kVectors) {
    (h.guard.*value).resize(h.joints);
    guard.at(name).read(h.guard.*value);
  }
  for (const auto& [name, value] : kCounts) h.guard.*value = static_cast<int>(guard.at(name).whole(INT32_MAX));
  guard.at("workspace").read(h.guard.workspace);
  guard.at("damping").read(h.guard.damping);
  if (guard.json().contains("delay")) h.guard.delay = static_cast<int>(guard.at("delay").whole(kMostGuardDelay));
  if (guard.json().contains("drive")) {
    const Reading drive = guard.at("drive");
    for (const auto& [name, value] : kDrive) h.guard.drive.*value = drive.at(name).number();
    h.guard.drive.encoderOnLink = drive.at("encoder_on_link").flag();
  }
  return h;
}

}  // namespace recording

using namespace recording;

namespace {

bool isWhole(const TickBytes& t) noexcept {
  return *std::max_element(std::begin(t.sizes), std::end(t.sizes)) <= kMaxJoints && t.status < kStatuses &&
         t.reason < kGuardReasons && t.mode <= static_cast<int>(RenderMode::fault) &&
         (t.flags & ~(kEnabled | kSaturated | kReset | kSpins | kFailed)) == 0;
}

RecordedTick tickOf(const TickBytes& t, int joints) {
  const auto vector = [](const double* values, int size) {
    return JointVector(Eigen::Map<const JointVector>(values, size));
  };
  RecordedTick tick;
  tick.number = t.number;
  tick.measurement.time = t.time;
  tick.measurement.q = vector(t.q, t.sizes[0]);
  tick.measurement.rates = vector(t.rates, t.sizes[1]);
  if (t.sizes[2] > 0) tick.measurement.applied = vector(t.applied, t.sizes[2]);
  tick.measurement.enabled = (t.flags & kEnabled) != 0;
  tick.measurement.age = t.age;
  tick.measurement.failed = (t.flags & kFailed) != 0;
  if (!std::isnan(t.gripper)) tick.measurement.gripper = t.gripper;
  tick.measurement.heat = t.heat;
  tick.measurement.buttons = t.buttons;
  tick.measurement.conditions = t.conditions;
  tick.requested = vector(t.requested, joints);
  tick.command = vector(t.command, joints);
  tick.normalForce = t.normalForce;
  tick.stateHash = t.stateHash;
  tick.status = static_cast<Status>(t.status);
  tick.reason = static_cast<GuardReason>(t.reason);
  tick.mode = static_cast<RenderMode>(t.mode);
  tick.saturated = (t.flags & kSaturated) != 0;
  tick.reset = (t.flags & kReset) != 0;
  tick.spins = (t.flags & kSpins) != 0;
  return tick;
}

// Read `size` bytes, or fewer at the end of the file.
std::size_t readAt(int file, std::uint64_t at, char* bytes, std::size_t size, const std::string& path) {
  std::size_t done = 0;
  while (done < size) {
    const std::int64_t got = system::readAt(file, at + done, bytes + done, size - done);
    if (got < 0) throw ConfigurationError(path, 0, "", std::string("cannot read the file: ") + std::strerror(errno));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return done;
}

std::uint32_t filesChecksum(const std::map<std::string, std::string>& parameters, const Scene& scene) {
  const std::uint32_t meshes = meshChecksum(scene);
  const auto gain = parameters.find("gain");
  if (gain == parameters.end() || gain->second == "designed") return meshes;
  return crc32(readFile(gain->second), meshes);
}

}  // namespace

void nameRenderer(const std::string& renderer, const std::string& plugin,
                  const std::map<std::string, std::string>& parameters, const Scene& scene, RecordingHeader& header) {
  header.renderer = renderer;
  header.plugin = plugin.empty() ? "" : std::filesystem::absolute(plugin).string();
  header.parameters = parameters;
  header.files = filesChecksum(parameters, scene);
}

bool filesHaveChanged(const RecordingHeader& header, const Scene& scene) {
  return filesChecksum(header.parameters, scene) != header.files;
}

std::uint32_t meshChecksum(const Scene& scene) {
  std::uint32_t crc = 0;
  const auto add = [&crc](const auto& values) {
    crc = crc32({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])}, crc);
  };
  for (const Obstacle& obstacle : scene.obstacles())
    if (const auto* mesh = std::get_if<std::shared_ptr<const MeshModel>>(&obstacle.shape)) {
      add((*mesh)->mesh().vertices);
      add((*mesh)->mesh().triangles);
    } else if (const auto* solid = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape)) {
      for (int brick = 0; brick < (*solid)->bricks(); ++brick) add((*solid)->samples(brick));
    }
  return crc;
}

RecordingReader::RecordingReader(const std::string& path) : path_(path), file_(system::openToRead(path)) {
  const auto refuse = [this](const std::string& problem) { throw ConfigurationError(path_, 0, "", problem); };
  if (file_ < 0) refuse(std::string("cannot open the file: ") + std::strerror(errno));
  try {
    const system::FileStatus status = system::statusOf(file_);
    if (status.kind != system::FileKind::regular) refuse("is not a regular file");
    size_ = status.size;
    char preamble[kPreamble] = {};
    if (size_ < kPreamble || readAt(file_, 0, preamble, kPreamble, path_) != kPreamble ||
        std::memcmp(preamble, kMagic, sizeof(kMagic)) != 0)
      refuse("is not a recording");
    std::uint32_t words[4];
    std::memcpy(words, preamble + sizeof(kMagic), sizeof(words));
    if (words[0] < 1 || words[0] > kVersion)
      refuse("is a recording of version " + std::to_string(words[0]) + ", this program reads 1 to " +
             std::to_string(kVersion));
    tickSize_ = words[0] == 1 ? kFirstTickBytes : sizeof(TickBytes);
    if (words[1] > kLargestHeader || words[1] > size_ - kPreamble)
      refuse("has a header of " + std::to_string(words[1]) + " bytes, the file is too short for it");
    std::string text(words[1], '\0');
    if (readAt(file_, kPreamble, text.data(), text.size(), path_) != text.size() || crc32(text) != words[2])
      refuse("its header is damaged");
    header_ = parseHeader(text, path_);
    begin_ = kPreamble + text.size();
    chunkSize_ = sizeof(ChunkHead) + padded(header_.stateSize) + kChunkTicks * tickSize_;
    chunks_ = (size_ - begin_ + chunkSize_ - 1) / chunkSize_;
  } catch (...) {
    system::close(file_);
    throw;
  }
}

RecordingReader::~RecordingReader() { system::close(file_); }

std::string RecordingReader::read(std::uint64_t number, RecordedChunk& chunk) {
  require(number < chunks_,
          path_ + ": has " + std::to_string(chunks_) + " chunks, chunk " + std::to_string(number) + " does not exist");
  const std::uint64_t at = begin_ + number * chunkSize_;
  buffer_.resize(static_cast<std::size_t>(std::min(chunkSize_, size_ - at)));
  const auto damaged = [number, at](const std::string& problem) {
    return "chunk " + std::to_string(number) + " at byte " + std::to_string(at) + " " + problem;
  };
  const std::string cutOff = damaged("is cut off");
  ChunkHead head;
  const std::size_t states = padded(header_.stateSize);
  if (readAt(file_, at, buffer_.data(), buffer_.size(), path_) != buffer_.size() || buffer_.size() < sizeof(head))
    return cutOff;
  std::memcpy(&head, buffer_.data(), sizeof(head));
  if (head.mark != kChunkMark || head.ticks > kChunkTicks) return damaged("is damaged");
  const std::size_t size = sizeof(head) + states + head.ticks * tickSize_;
  if (buffer_.size() < size) return cutOff;
  const std::string_view content = std::string_view(buffer_).substr(kChunkCrcBegin, size - kChunkCrcBegin);
  if (crc32(content) != head.crc) return damaged("is damaged");
  const bool isLast = (head.flags & kLast) != 0;
  if (head.sequence != number || (head.flags & ~(kFresh | kLast)) != 0 || (head.ticks < kChunkTicks && !isLast) ||
      (isLast && (number + 1 != chunks_ || buffer_.size() != size)))
    return damaged("is not the one expected there");
  RecordedChunk read;
  read.sequence = head.sequence;
  read.lost = head.lost;
  read.fresh = (head.flags & kFresh) != 0;
  read.last = isLast;
  if (head.ticks > 0) read.state = buffer_.substr(sizeof(head), header_.stateSize);
  read.ticks.reserve(head.ticks);
  for (std::size_t i = 0; i < head.ticks; ++i) {
    TickBytes tick{};
    tick.gripper = std::numeric_limits<double>::quiet_NaN();
    std::memcpy(&tick, buffer_.data() + sizeof(head) + states + i * tickSize_, tickSize_);
    if (!isWhole(tick)) return damaged("has an invalid tick");
    read.ticks.push_back(tickOf(tick, header_.joints));
  }
  chunk = std::move(read);
  return "";
}

}  // namespace enamel
