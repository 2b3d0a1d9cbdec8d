#include "enamel/runtime/recorder.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <limits>
#include <system_error>

#include "core/message.hpp"
#include "core/system_file.hpp"
#include "enamel/core/file.hpp"
#include "recording_format.hpp"
#include "runtime/system_thread.hpp"

namespace enamel {

using namespace recording;

namespace {

constexpr double kRoom = 4.0;                             // s
constexpr std::uint64_t kLeastRoom = 8, kMostRoom = 256;  // chunks
constexpr auto kLook = std::chrono::milliseconds(5), kAgain = std::chrono::milliseconds(50);

// Do not overwrite an existing recording. A pipe or a device exists already.
int openNew(const std::string& path) {
  const system::FileKind kind = system::statusOf(path).kind;
  const bool isPlain = kind == system::FileKind::missing || kind == system::FileKind::regular;
  const int file = isPlain ? system::openNew(path) : system::openPipe(path);
  if (file < 0) throw Error(path + ": cannot make the recording: " + std::strerror(errno));
  return file;
}

void copy(const JointVector& from, double (&to)[kMaxJoints]) noexcept {
  std::copy_n(from.data(), from.size(), to);
  std::fill(to + from.size(), to + kMaxJoints, 0.0);
}

}  // namespace

Recorder::Recorder(const std::string& path, RecordingHeader header, const HapticTick& tick)
    : path_(path), header_(std::move(header)), file_(openNew(path)) {
  write_ = [this](const char* bytes, std::size_t size) {
    return static_cast<std::size_t>(std::max<std::int64_t>(0, system::writeSome(file_, bytes, size)));
  };
  try {
    start(tick);
  } catch (...) {
    system::close(file_);
    if (system::statusOf(path_).kind == system::FileKind::regular) system::remove(path_);
    throw;
  }
}

Recorder::Recorder(Write write, const std::string& path, RecordingHeader header, const HapticTick& tick)
    : write_(std::move(write)), path_(path), header_(std::move(header)) {
  start(tick);
}

void Recorder::start(const HapticTick& tick) {
  header_.guard = tick.guard().options();
  header_.joints = static_cast<int>(tick.guard().options().torque.size());
  header_.stateSize = tick.stateSize();
  header_.rendererState = tick.renderer().stateSize();
  require(header_.stateSize <= kLargestState, path_ + ": the state of a tick is " + std::to_string(header_.stateSize) +
                                                  " bytes, at most " + std::to_string(kLargestState) + " are recorded");
  rendererState_.resize(header_.rendererState);
  chunkSize_ = sizeof(ChunkHead) + padded(header_.stateSize) + kChunkTicks * sizeof(TickBytes);
  const double chunks = kRoom / (header_.guard.period * static_cast<double>(kChunkTicks));
  room_ = std::clamp(static_cast<std::uint64_t>(chunks), kLeastRoom, kMostRoom) + 1;  // one for the end
  chunks_.assign(room_ * chunkSize_, '\0');

  const std::string text = headerText(header_);
  require(text.size() <= kLargestHeader, path_ + ": the recording's header is " + std::to_string(text.size()) +
                                             " bytes, at most " + std::to_string(kLargestHeader) + " are recorded");
  const std::uint32_t words[4] = {kVersion, static_cast<std::uint32_t>(text.size()), crc32(text), 0};
  std::string bytes(kMagic, sizeof(kMagic));
  bytes.append(reinterpret_cast<const char*>(words), sizeof(words)).append(text);
  if (!writeOut(bytes.data(), bytes.size()))
    throw Error(path_ + ": cannot write the recording: " + std::strerror(error_));
  done_ = 0;
  try {
    thread_ = std::thread(&Recorder::run, this);
  } catch (const std::system_error& error) {
    throw Error(path_ + ": cannot start the thread that records: " + error.what());
  }
}

Recorder::~Recorder() { close(); }

// Functions of the tick's thread.

void Recorder::begin(const HapticTick& tick) noexcept {
  char* chunk = chunkAt(filled_.load(std::memory_order_relaxed));
  ChunkHead head;
  head.sequence = sequence_++;
  head.lost = lostNow_;
  head.flags = tick.guard().kept() == 1 ? kFresh : 0;
  lostNow_ = 0;
  std::memcpy(chunk, &head, sizeof(head));
  tick.saveState(chunk + sizeof(head));
}

void Recorder::add(std::uint64_t number, const Measurement& measurement, const HapticTick& tick, const Command& command,
                   Status status, bool reset) noexcept {
  const std::uint64_t now = filled_.load(std::memory_order_relaxed);
  if (ticks_ == 0) {
    if (now - written_.load(std::memory_order_acquire) + 1 >= room_) {
      ++lostNow_;
      allLost_.fetch_add(1, std::memory_order_relaxed);
      return;
    }
    begin(tick);
  }
  const TickOutput& output = tick.frame().output;
  TickBytes t;
  t.number = number;
  t.time = measurement.time;
  copy(measurement.q, t.q);
  copy(measurement.rates, t.rates);
  copy(measurement.applied.value_or(JointVector()), t.applied);
  copy(output.torque, t.requested);
  copy(command.effort, t.command);
  t.normalForce = output.normalForce;
  tick.renderer().saveState(rendererState_.data());
  t.stateHash = hashOf(rendererState_.data(), rendererState_.size());
  t.sizes[0] = static_cast<std::uint8_t>(measurement.q.size());
  t.sizes[1] = static_cast<std::uint8_t>(measurement.rates.size());
  t.sizes[2] = static_cast<std::uint8_t>(measurement.applied ? measurement.applied->size() : 0);
  t.status = static_cast<std::uint8_t>(status);
  t.reason = static_cast<std::uint8_t>(tick.frame().reason);
  t.mode = static_cast<std::uint8_t>(output.mode);
  t.flags = static_cast<std::uint8_t>(
      (measurement.enabled ? kEnabled : 0) | (output.saturated ? kSaturated : 0) | (reset ? kReset : 0) |
      (tick.drill() != nullptr && tick.drill()->spins() ? kSpins : 0) | (measurement.failed ? kFailed : 0));
  t.gripper = measurement.gripper.value_or(std::numeric_limits<double>::quiet_NaN());
  t.heat = measurement.heat;
  t.buttons = measurement.buttons;
  t.conditions = measurement.conditions;
  t.age = static_cast<std::uint8_t>(std::clamp(measurement.age, 0, 255));
  std::memcpy(chunkAt(now) + sizeof(ChunkHead) + padded(header_.stateSize) + ticks_ * sizeof(t), &t, sizeof(t));
  if (++ticks_ < kChunkTicks) return;
  const std::uint32_t ticks = kChunkTicks;
  std::memcpy(chunkAt(now) + offsetof(ChunkHead, ticks), &ticks, sizeof(ticks));
  ticks_ = 0;
  filled_.store(now + 1, std::memory_order_release);
}

void Recorder::makeRoom() const {
  while (filled_.load(std::memory_order_relaxed) - written_.load(std::memory_order_acquire) + 1 >= room_ &&
         !failing_.load(std::memory_order_relaxed))
    std::this_thread::sleep_for(kLook);
}

// Functions of the writing thread.

// Continue an incomplete write.
bool Recorder::writeOut(const char* bytes, std::size_t size) noexcept {
  while (done_ < size) {
    errno = 0;
    const std::size_t more = write_(bytes + done_, size - done_);
    if (more == 0 && errno == EINTR) continue;
    if (more == 0) {
      error_ = errno;
      return false;
    }
    done_ += more;
    bytes_ += more;
  }
  return true;
}

void Recorder::run() noexcept {
  system::nameThread("recorder");
  system::makeWriteErrorsOrdinary();
  std::uint64_t now = 0;
  while (true) {
    const bool stopping = stop_.load(std::memory_order_acquire);  // read before filled_: nothing follows
    if (now == filled_.load(std::memory_order_acquire)) {
      if (stopping) return;
      std::this_thread::sleep_for(kLook);
      continue;
    }
    char* chunk = chunkAt(now);
    ChunkHead head;
    std::memcpy(&head, chunk, sizeof(head));
    const std::size_t size = sizeof(head) + padded(header_.stateSize) + head.ticks * sizeof(TickBytes);
    head.crc = crc32({chunk + kChunkCrcBegin, size - kChunkCrcBegin});
    std::memcpy(chunk, &head, sizeof(head));
    if (!writeOut(chunk, size)) {
      if (stopping) return;
      failing_.store(true, std::memory_order_relaxed);
      std::this_thread::sleep_for(kAgain);
      continue;
    }
    failing_.store(false, std::memory_order_relaxed);
    done_ = 0;
    ticksWritten_ += head.ticks;
    written_.store(++now, std::memory_order_release);
  }
}

RecordingResult Recorder::close() {
  if (!open_) return result_;
  open_ = false;
  // The unfinished chunk becomes the last one. Without one, write an empty chunk.
  const std::uint64_t now = filled_.load(std::memory_order_relaxed);
  ChunkHead head;
  if (ticks_ == 0) {
    head.sequence = sequence_;
    head.lost = lostNow_;
    std::fill_n(chunkAt(now), chunkSize_, '\0');
  } else {
    std::memcpy(&head, chunkAt(now), sizeof(head));
  }
  head.ticks = static_cast<std::uint32_t>(ticks_);
  head.flags |= kLast;
  std::memcpy(chunkAt(now), &head, sizeof(head));
  filled_.store(now + 1, std::memory_order_release);
  stop_.store(true, std::memory_order_release);
  thread_.join();

  std::uint64_t added = 0;
  for (std::uint64_t i = written_.load(); i < now + 1; ++i) {
    std::memcpy(&head, chunkAt(i), sizeof(head));
    added += head.ticks;
  }
  result_.ticks = ticksWritten_;
  result_.lost = lost() + added;
  if (written_.load() <= now) result_.problem = path_ + ": cannot write the recording: " + std::strerror(error_);
  if (file_ < 0) return result_;
  if (!result_.problem.empty()) (void)system::setSize(file_, bytes_ - done_);
  if (!system::close(file_) && result_.problem.empty())
    result_.problem = path_ + ": cannot write the recording: " + std::strerror(errno);
  return result_;
}

}  // namespace enamel
