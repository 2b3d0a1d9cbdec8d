#include "player.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "enamel/core/error.hpp"
#include "recorded.hpp"

namespace enamel::viewer {
namespace {

constexpr std::size_t kSeen = 64;                   // stretches whose samples are kept: more than charts show
constexpr std::uint64_t kMostLost = 1'000'000'000;  // ticks; no recorder has counted as many
constexpr double kLargest = 1e6;                    // of what is drawn
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

bool isPlain(double value) { return std::abs(value) < kLargest; }  // false for NaN

bool isFinite(const RecordedTick& t) {
  const Measurement& m = t.measurement;
  for (const JointVector* v : {&m.q, &m.rates, &m.applied, &t.requested, &t.command})
    if (!v->allFinite()) return false;
  return std::isfinite(m.time) && std::isfinite(t.normalForce);
}

Sample nothing(int joints) {
  Sample sample;
  sample.position.setConstant(kNothing);
  sample.gap = sample.normalForce = kNothing;
  sample.torque = JointVector::Constant(joints, kNothing);
  return sample;
}

std::shared_ptr<const Mechanism> deviceOf(const DeviceParameters& parameters, const RecordingHeader& header,
                                          const std::string& path) {
  auto device = makeMechanism(parameters);
  if (device->joints() != header.joints)
    throw Error(path + ": the device has " + std::to_string(device->joints()) + " joints, its ticks have " +
                std::to_string(header.joints));
  return device;
}

GuardOptions unguarded(GuardOptions guard) {
  guard.on = false;
  return guard;
}

// As VirtualLoop has it, NaN where that is no number.
double wallForce(const RecordedTick& t, const Kinematics& k, const Vec3& normal) {
  const double force =
      t.reason == GuardReason::none ? t.normalForce : normal.dot(wrenchOf(k, t.command - k.gravity).head<3>());
  return isPlain(force) ? force : kNothing;
}

// That really acted; where the device cannot tell, the command.
const JointVector& torqueOf(const RecordedTick& t) {
  return t.measurement.applied.size() == t.command.size() ? t.measurement.applied : t.command;
}

std::string counted(std::uint64_t count, const char* what) {
  return std::to_string(count) + ' ' + what + (count == 1 ? "" : "s");
}

}  // namespace

Player::Player(const std::string& path)
    : path_(path),
      reader_(path),
      parameters_(parseDevice(reader_.header().deviceText, reader_.header().deviceFile)),
      device_(deviceOf(parameters_, reader_.header(), path)),
      scene_(app::recordedScene(reader_.header())),
      tick_(*device_, scene_.scene, scene_.tool, watcher_, unguarded(reader_.header().guard), reader_.header().start),
      cache_(makeToolCache(scene_.scene, scene_.tool)),
      // Of the guard and the kinematics, whatever the renderer's is.
      restores_(reader_.header().stateSize - std::min(reader_.header().stateSize, reader_.header().rendererState) ==
                    tick_.stateSize() - watcher_.stateSize() &&
                reader_.header().rendererState >= watcher_.stateSize()) {
  if (scene_.name.empty()) scene_.name = "Flat wall";  // the recording names no scene file
  makeIndex();
}

void Player::makeIndex() {
  std::uint64_t missing = 0, lost = 0, damaged = 0, unfit = 0;
  std::string damage, end;
  bool closed = false;
  for (std::uint64_t i = 0; i < reader_.chunks(); ++i) {
    if (const std::string problem = reader_.read(i, chunk_); !problem.empty()) {
      if (i + 1 == reader_.chunks()) {
        end = ": " + problem;
        break;
      }
      if (damaged++ == 0) damage = problem;
      missing += kChunkTicks;
      continue;
    }
    if (chunk_.lost > kMostLost)
      throw Error(path_ + ": chunk " + std::to_string(i) + " says that " + std::to_string(chunk_.lost) +
                  " ticks are lost before it, at most " + std::to_string(kMostLost) + " can be");
    lost += chunk_.lost;
    missing += chunk_.lost;
    closed = chunk_.last;
    if (chunk_.ticks.empty()) continue;
    Stretch stretch;
    stretch.lost = missing;
    stretch.begin = size_ + missing;
    stretch.chunk = i;
    stretch.ticks = static_cast<std::uint32_t>(chunk_.ticks.size());
    for (const RecordedTick& t : chunk_.ticks) {
      stretch.contact = stretch.contact || t.mode == RenderMode::contact;
      if (stretch.reason == GuardReason::none || (isFault(t.reason) && !isFault(stretch.reason)))
        stretch.reason = t.reason;
      if (!isFinite(t)) ++unfit;
    }
    size_ = stretch.begin + stretch.ticks;
    ticks_ += stretch.ticks;
    missing = 0;
    stretches_.push_back(stretch);
  }
  if (stretches_.empty()) throw Error(path_ + ": has no tick that can be read");
  loaded_ = SIZE_MAX;
  if (!closed) notes_.push_back("not closed, ends with its last whole chunk" + end);
  if (lost > 0) notes_.push_back(counted(lost, "tick") + " lost when it was recorded");
  if (damaged > 0) notes_.push_back(counted(damaged, "chunk") + " cannot be read: " + damage);
  if (unfit > 0) notes_.push_back(counted(unfit, "tick") + " with values that are not finite");
  try {
    if (app::filesHaveChanged(header(), scene_.scene)) notes_.push_back("a mesh or the servo's file has changed since");
  } catch (const Error& error) {
    notes_.push_back(error.what());  // of the servo: nothing that is drawn needs it
  }
}

std::size_t Player::stretchAt(std::uint64_t position) const noexcept {
  const auto after = std::upper_bound(stretches_.begin(), stretches_.end(), position,
                                      [](std::uint64_t p, const Stretch& s) { return p < s.begin; });
  return after == stretches_.begin() ? 0 : static_cast<std::size_t>(after - stretches_.begin()) - 1;
}

std::uint64_t Player::gap() const noexcept {
  if (position() < stretches_.front().begin) return stretches_.front().lost;
  const std::size_t at = stretchAt(position());
  return position() < stretches_[at].begin + stretches_[at].ticks ? 0 : stretches_[at + 1].lost;
}

void Player::setPlaying(bool playing) noexcept {
  if (playing && position() + 1 >= size_) place_ = 0.0;
  playing_ = playing;
}

void Player::setSpeed(double speed) noexcept { speed_ = std::clamp(speed, kSlowest, kFastest); }

void Player::seek(double position) noexcept {
  place_ = std::floor(std::clamp(position, 0.0, static_cast<double>(size_ - 1)));
}

void Player::advance(double seconds) noexcept {
  if (!playing_ || !(seconds > 0.0)) return;
  const double last = static_cast<double>(size_ - 1);
  place_ = std::min(last, place_ + seconds * speed_ / header().guard.period);
  if (place_ >= last) playing_ = false;
}

void Player::step(std::int64_t ticks) noexcept {
  playing_ = false;
  // Counted in ticks that are there: from a gap, on is the one behind it and back the one before it.
  std::size_t at = stretchAt(position());
  auto offset = static_cast<std::int64_t>(position()) - static_cast<std::int64_t>(stretches_[at].begin);
  const auto count = [&] { return static_cast<std::int64_t>(stretches_[at].ticks); };
  if (offset >= count()) {
    offset = count() - 1;
    if (ticks < 0) ++ticks;
  }
  offset = std::max<std::int64_t>(offset, -1);
  for (offset += ticks; offset >= count(); offset -= count(), ++at)
    if (at + 1 == stretches_.size()) return seek(static_cast<double>(size_));
  for (; offset < 0; offset += count()) {
    if (at == 0) return seek(static_cast<double>(stretches_.front().begin));
    --at;
  }
  place_ = static_cast<double>(stretches_[at].begin) + static_cast<double>(offset);
}

const RecordedChunk& Player::chunkOf(std::size_t stretch) {
  if (loaded_ != stretch) {
    loaded_ = SIZE_MAX;
    // It could be read before: another program may have changed it since.
    if (const std::string problem = reader_.read(stretches_[stretch].chunk, chunk_); !problem.empty())
      throw Error(path_ + ": changed while it was played: " + problem);
    if (chunk_.ticks.size() != stretches_[stretch].ticks) throw Error(path_ + ": changed while it was played");
    loaded_ = stretch;
  }
  return chunk_;
}

// Runs the ticks of a stretch before `end`; each(number, tick, isSeen): whether HapticTick's kinematics is that of this
// tick.
template <typename Function>
void Player::watch(std::size_t stretch, std::size_t end, const Function& each) {
  const RecordedChunk& chunk = chunkOf(stretch);
  Command command;
  if (restores_)
    tick_.loadState(chunk.state.data());
  else
    tick_.reset();
  for (std::size_t i = 0; i < end; ++i) {
    const RecordedTick& t = chunk.ticks[i];
    (void)tick_(t.measurement, command);
    const JointVector& q = tick_.input().kinematics.q;
    each(i, t, q.size() == t.measurement.q.size() && q == t.measurement.q);
    if (i == 0 && restores_) tick_.loadState(chunk.state.data());  // that is the state behind the first tick
  }
}

const Frame& Player::frame() {
  frame_.paused = !playing_;
  if (framed_ == position()) return frame_;
  framed_ = position();
  const std::size_t at = stretchAt(position());
  const Stretch& stretch = stretches_[at];
  const std::uint64_t offset = position() - std::min(position(), stretch.begin);
  const std::size_t end = std::min<std::uint64_t>(offset, stretch.ticks - 1) + 1;
  watch(at, end, [&](std::size_t i, const RecordedTick& t, bool) {
    if (i + 1 < end) return;
    const Kinematics& k = tick_.input().kinematics;
    TickRecord& r = frame_.record;
    r.tick = t.number;
    r.time = t.measurement.time;
    r.pose = k.pose;
    r.twist = k.twist;
    r.q = t.measurement.q;
    r.requested = t.requested;
    r.command = t.command;
    r.torque = torqueOf(t);
    for (double& value : r.torque) value = isPlain(value) ? value : 0.0;
    r.rendered = wrenchOf(k, r.torque - k.gravity);
    r.nearest = nearestContact(scene_.scene, scene_.tool, k.pose, &cache_);
    r.gapRate = r.nearest.normal.dot(contactVelocity(k, r.nearest));
    const double force = wallForce(t, k, r.nearest.normal);
    r.normalForce = isPlain(force) ? force : 0.0;
    r.mode = t.mode;
    r.saturated = t.saturated;
    r.status = t.status;
    r.guard = t.reason;
    frame_.contacts = tick_.input().contacts;
    frame_.hand.target = frame_.hand.position = k.pose.position;
  });
  return frame_;
}

const std::vector<Sample>& Player::seen(std::size_t stretch) {
  for (const Seen& one : seen_)
    if (one.stretch == stretch) return one.samples;
  Seen* to = nullptr;
  if (seen_.size() < kSeen) {
    to = &seen_.emplace_back();
  } else {
    to = &seen_[oldest_];
    oldest_ = (oldest_ + 1) % kSeen;
  }
  to->stretch = SIZE_MAX;  // until it is whole
  to->samples.clear();
  watch(stretch, stretches_[stretch].ticks, [&](std::size_t, const RecordedTick& t, bool isSeen) {
    Sample sample = nothing(header().joints);
    const Kinematics& k = tick_.input().kinematics;
    const Contact nearest = nearestContact(scene_.scene, scene_.tool, k.pose, &cache_);
    if (isSeen) {
      sample.position = k.pose.position;
      sample.gap = nearest.gap;
    }
    sample.normalForce = wallForce(t, k, nearest.normal);
    const JointVector& torque = torqueOf(t);
    for (int i = 0; i < torque.size(); ++i) sample.torque[i] = isPlain(torque[i]) ? torque[i] : kNothing;
    to->samples.push_back(sample);
  });
  to->stretch = stretch;
  return to->samples;
}

const std::vector<Sample>& Player::samples(std::int64_t from, std::size_t count) {
  samples_.assign(count, nothing(header().joints));
  const std::int64_t end = from + static_cast<std::int64_t>(count);
  if (end <= 0) return samples_;
  for (std::size_t at = stretchAt(static_cast<std::uint64_t>(std::max<std::int64_t>(0, from))); at < stretches_.size();
       ++at) {
    const auto begin = static_cast<std::int64_t>(stretches_[at].begin);
    if (begin >= end) break;
    const std::int64_t first = std::max(begin, from), last = std::min(begin + stretches_[at].ticks, end);
    if (first >= last) continue;
    const std::vector<Sample>& of = seen(at);
    std::copy(of.begin() + (first - begin), of.begin() + (last - begin), samples_.begin() + (first - from));
  }
  return samples_;
}

}  // namespace enamel::viewer
