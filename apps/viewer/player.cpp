#include "player.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "enamel/core/error.hpp"
#include "program/recorded.hpp"

namespace enamel::viewer {
namespace {

constexpr std::size_t kKept = 64;                   // stretches with cached samples; the charts show fewer
constexpr std::uint64_t kMostLost = 1'000'000'000;  // ticks; more cannot have been counted by a recorder
constexpr std::uint64_t kQuiet = 50;                // ticks without it before its return is a new event
constexpr double kLargest = 1e6;                    // largest value that is drawn
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

// Return whether a tick can be drawn: it is finite and has one number for each joint.
bool isPlain(const RecordedTick& t, int joints) {
  const Measurement& m = t.measurement;
  const auto plain = [joints](const JointVector& v) {
    return v.size() == joints && (v.array().abs() < kLargest).all();  // false for NaN
  };
  return plain(m.q) && plain(m.rates) && plain(t.requested) && plain(t.command) && (!m.applied || plain(*m.applied)) &&
         std::isfinite(m.time) && std::abs(t.normalForce) < kLargest;
}

Sample nothing(int joints) {
  return {Vec3::Constant(kNothing), kNothing, kNothing, JointVector::Constant(joints, kNothing)};
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
      cache_(makeToolCache(scene_.scene, scene_.tool)) {
  if (scene_.name.empty()) scene_.name = "Flat wall";  // the recording has no scene file
  // Compare the states without the renderer's part, which is at the end and at least as large as the watcher's.
  if (header().rendererState < watcher_.stateSize() ||
      header().stateSize - header().rendererState != tick_.stateSize() - watcher_.stateSize())
    throw Error(path + ": the size of its states does not match the scene");
  makeIndex();
}

void Player::makeIndex() {
  std::uint64_t at = 0, lost = 0, damaged = 0, unfit = 0;
  std::string damage, end;
  bool closed = false;
  // Earliest position of the next event of each reason; the first one is for contacts.
  std::array<std::uint64_t, kGuardReasons> quiet{};
  const auto happens = [&](GuardReason reason) {
    std::uint64_t& from = quiet[static_cast<std::size_t>(reason)];
    if (at >= from) events_.push_back({at, reason});
    from = at + kQuiet;
  };
  for (std::uint64_t i = 0; i < reader_.chunks(); ++i) {
    if (const std::string problem = reader_.read(i, chunk_); !problem.empty()) {
      if (i + 1 == reader_.chunks()) {
        end = ": " + problem;
        break;
      }
      if (damaged++ == 0) damage = problem;
      at += kChunkTicks;
      continue;
    }
    if (chunk_.lost > kMostLost)
      throw Error(path_ + ": chunk " + std::to_string(i) + " reports " + std::to_string(chunk_.lost) +
                  " lost ticks before it, must be at most " + std::to_string(kMostLost));
    lost += chunk_.lost;
    at += chunk_.lost;
    closed = chunk_.last;
    if (chunk_.ticks.empty()) continue;
    if (stretches_.empty()) at = 0;
    Stretch stretch{at, at + chunk_.ticks.size(), i};
    for (const RecordedTick& t : chunk_.ticks) {
      if (t.mode == RenderMode::contact) {
        stretch.contact = true;
        happens(GuardReason::none);
      }
      if (t.reason > GuardReason::engaging) happens(t.reason);  // smaller reasons occur in every start
      if (!isPlain(t, header().joints)) ++unfit;
      ++at;
    }
    stretches_.push_back(stretch);
  }
  if (stretches_.empty()) throw Error(path_ + ": has no tick that can be read");
  if (!closed) notes_.push_back("not closed: it ends with its last whole chunk" + end);
  if (lost > 0) notes_.push_back(counted(lost, "tick") + " lost during the recording");
  if (damaged > 0) notes_.push_back(counted(damaged, "chunk") + " cannot be read: " + damage);
  if (unfit > 0) notes_.push_back(counted(unfit, "tick") + " with values that are not finite");
  try {
    if (filesHaveChanged(header(), scene_.scene))
      notes_.push_back("a mesh or the servo file has changed since the recording");
  } catch (const Error& error) {
    notes_.push_back(error.what());  // about the servo, which is not needed for drawing
  }
}

std::size_t Player::stretchAt(std::uint64_t position) const noexcept {
  const auto after = std::upper_bound(stretches_.begin(), stretches_.end(), position,
                                      [](std::uint64_t p, const Stretch& s) { return p < s.begin; });
  return static_cast<std::size_t>(after - stretches_.begin()) - 1;  // the first stretch begins at 0
}

std::uint64_t Player::gap() const noexcept {
  const Stretch* const s = &stretches_[stretchAt(position())];
  return position() < s->end ? 0 : s[1].begin - s->end;
}

void Player::setPlaying(bool playing) noexcept {
  if (playing && position() + 1 >= size()) place_ = 0.0;
  playing_ = playing;
}

void Player::setSpeed(double speed) noexcept { speed_ = std::clamp(speed, kSlowest, kFastest); }

void Player::seek(double position) noexcept {
  place_ = std::floor(std::clamp(position, 0.0, static_cast<double>(size() - 1)));
}

void Player::advance(double seconds) noexcept {
  if (!playing_ || !(seconds > 0.0)) return;
  const double last = static_cast<double>(size() - 1);
  place_ = std::min(last, place_ + seconds * speed_ / header().guard.period);
  if (place_ >= last) playing_ = false;
}

void Player::step(std::int64_t ticks) noexcept {
  playing_ = false;
  seek(std::floor(place_) + static_cast<double>(ticks));
  if (gap() == 0) return;
  const Stretch* const s = &stretches_[stretchAt(position())];
  place_ = static_cast<double>(ticks > 0 ? s[1].begin : s->end - 1);
}

bool Player::jump(bool forward) noexcept {
  auto found = std::lower_bound(events_.begin(), events_.end(), position() + (forward ? 1 : 0),
                                [](const PlayerEvent& e, std::uint64_t p) { return e.position < p; });
  if (found == (forward ? events_.end() : events_.begin())) return false;
  if (!forward) --found;
  playing_ = false;
  place_ = static_cast<double>(found->position);
  return true;
}

// Run the ticks of a stretch before position `end`. each() is called when `frame` has been filled for a tick.
template <typename Function>
void Player::watch(std::size_t stretch, std::uint64_t end, Frame& frame, const Function& each) {
  const Stretch& s = stretches_[stretch];
  // It was readable before, but another program may have changed it since.
  if (!reader_.read(s.chunk, chunk_).empty() || chunk_.ticks.size() != s.end - s.begin)
    throw Error(path_ + ": the file changed while it was played");
  Command command;
  tick_.loadState(chunk_.state.data());
  tick_.reset();  // the saved state follows the first tick, which is repeated for its contacts
  for (std::size_t i = 0; i < std::min(end, s.end) - s.begin; ++i) {
    const RecordedTick& t = chunk_.ticks[i];
    (void)tick_(t.measurement, command);
    const bool plain = isPlain(t, header().joints);
    const Kinematics& k = tick_.frame().kinematics;  // the last valid one if the measurement is unusable
    TickRecord& r = frame.record;
    r.tick = t.number;
    r.time = t.measurement.time;
    r.pose = k.pose;
    r.twist = k.twist;
    r.q = t.measurement.q;
    r.requested = t.requested;
    r.command = t.command;
    r.torque = t.measurement.applied.value_or(t.command);
    if (!plain) r.torque = k.gravity;
    r.rendered = wrenchOf(k, r.torque - k.gravity);
    r.nearest = nearestContact(scene_.scene, scene_.tool, k.pose, &cache_);
    r.gapRate = r.nearest.normal.dot(contactVelocity(k, r.nearest));
    r.normalForce = t.normalForce;  // as in VirtualLoop
    if (t.reason != GuardReason::none)
      r.normalForce = r.nearest.normal.dot(wrenchOf(k, t.command - k.gravity).head<3>());
    if (!plain) r.normalForce = 0.0;
    r.mode = t.mode;
    r.saturated = t.saturated;
    r.status = t.status;
    r.guard = t.reason;
    frame.contacts = tick_.frame().contacts;
    frame.hand.target = frame.hand.position = k.pose.position;
    each(plain);
    if (i == 0) tick_.loadState(chunk_.state.data());  // the state that follows the first tick
  }
}

const Frame& Player::frame() {
  if (framed_ != position()) {
    ReadoutFilter readouts;
    const auto read = [&](bool) { frame_.readout = readouts.add(frame_.record); };
    const std::size_t at = stretchAt(position());
    if (at > 0) watch(at - 1, stretches_[at - 1].end, frame_, read);  // the filter needs more than a stretch
    watch(at, position() + 1, frame_, read);
    framed_ = position();
  }
  frame_.paused = !playing_;
  frame_.slowdown = static_cast<int>(std::ceil(1.0 / speed_));
  return frame_;
}

const std::vector<Sample>& Player::samplesOf(std::size_t stretch) {
  if (const auto found = samples_.find(stretch); found != samples_.end()) return found->second;
  // Discard the farthest stretch.
  if (samples_.size() == kKept)
    samples_.erase(samples_.begin()->first < stretch ? samples_.begin() : std::prev(samples_.end()));
  std::vector<Sample> samples;
  Frame frame;
  watch(stretch, stretches_[stretch].end, frame,
        [&](bool plain) { samples.push_back(plain ? sampleOf(frame.record) : nothing(header().joints)); });
  return samples_[stretch] = std::move(samples);
}

std::vector<Sample> Player::samples(std::int64_t from, std::size_t count) {
  std::vector<Sample> samples(count, nothing(header().joints));
  const std::int64_t end = from + static_cast<std::int64_t>(count);
  if (end <= 0) return samples;
  for (std::size_t at = stretchAt(static_cast<std::uint64_t>(std::max<std::int64_t>(0, from))); at < stretches_.size();
       ++at) {
    const auto begin = static_cast<std::int64_t>(stretches_[at].begin);
    const std::int64_t first = std::max(begin, from),
                       last = std::min(static_cast<std::int64_t>(stretches_[at].end), end);
    if (begin >= end) break;
    if (first >= last) continue;
    const auto of = samplesOf(at).begin();
    std::copy(of + (first - begin), of + (last - begin), samples.begin() + (first - from));
  }
  return samples;
}

}  // namespace enamel::viewer
