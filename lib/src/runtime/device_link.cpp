#include "enamel/runtime/device_link.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/message.hpp"
#include "enamel/core/file.hpp"

namespace enamel {
namespace {

constexpr std::uint32_t kLinkMagic = 0x4c4d4e45;  // "ENML"
constexpr unsigned kLinkVersion = 1;
constexpr unsigned kMeasurement = 1, kCommand = 2, kCall = 3;
constexpr unsigned kIsEnabled = 1, kHasApplied = 2, kWatchdog = 4;  // flags
constexpr std::size_t kHead = 56, kTail = 12;                       // bytes; the tail has tag and checksum
constexpr double kNanoseconds = 1e9;                                // per second

std::uint32_t checksum(const unsigned char* bytes, std::size_t size) noexcept {
  return crc32({reinterpret_cast<const char*>(bytes), size});
}

// The bytes of a number, lowest first.
template <typename Number>
void put(unsigned char* at, Number value) noexcept {
  for (std::size_t i = 0; i < sizeof value; ++i) at[i] = static_cast<unsigned char>(value >> (8 * i));
}

std::uint64_t get(const unsigned char* at, int bytes) noexcept {
  std::uint64_t value = 0;
  for (int i = 0; i < bytes; ++i) value |= static_cast<std::uint64_t>(at[i]) << (8 * i);
  return value;
}

void putNumber(unsigned char* at, double value) noexcept {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, 8);
  put(at, bits);
}

double getNumber(const unsigned char* at) noexcept {
  const std::uint64_t bits = get(at, 8);
  double value = 0.0;
  std::memcpy(&value, &bits, 8);
  return value;
}

void putNumbers(unsigned char* at, const JointVector& v) noexcept {
  for (int i = 0; i < kMaxJoints; ++i) putNumber(at + 8 * i, i < v.size() ? v[i] : 0.0);
}

// Returns false if a number is not finite.
bool getNumbers(const unsigned char* at, int joints, JointVector& v) noexcept {
  v.resize(joints);
  for (int i = 0; i < joints; ++i) v[i] = getNumber(at + 8 * i);
  return v.allFinite();
}

// The start of every datagram.
struct Head {
  unsigned kind = 0, joints = 0, flags = 0;
  std::uint64_t client = 0, server = 0, sequence = 0;
  std::int64_t stamp = 0;  // of the sender's clock
  std::uint64_t echo = 0;  // sequence of the newest datagram from the other end
  std::int64_t echoStamp = 0;
};

void putHead(const Head& h, Datagram& d) noexcept {
  put(&d[0], kLinkMagic);
  d[4] = kLinkVersion;
  d[5] = static_cast<unsigned char>(h.kind);
  d[6] = static_cast<unsigned char>(h.joints);
  d[7] = static_cast<unsigned char>(h.flags);
  put(&d[8], h.client);
  put(&d[16], h.server);
  put(&d[24], h.sequence);
  put(&d[32], h.stamp);
  put(&d[40], h.echo);
  put(&d[48], h.echoStamp);
}

// Append tag and checksum.
std::size_t seal(const LinkOptions& options, std::size_t size, Datagram& d) noexcept {
  const std::string_view body(reinterpret_cast<const char*>(d.data()), size - kTail);
  put(&d[size - kTail], options.key ? sipHash(*options.key, body) : 0);
  put(&d[size - 4], checksum(d.data(), size - 4));
  return size;
}

// Check everything that needs no session. Returns kDropReasons if the datagram is valid.
int examine(const LinkOptions& options, const unsigned char* d, std::size_t size, bool command, Head& h) noexcept {
  const auto drop = [](DropReason reason) { return static_cast<int>(reason); };
  if (size != (command ? kCommandBytes : kMeasurementBytes)) return drop(DropReason::length);
  if (get(d, 4) != kLinkMagic) return drop(DropReason::magic);
  if (get(d + 4, 1) != kLinkVersion) return drop(DropReason::version);
  if (get(d + size - 4, 4) != checksum(d, size - 4)) return drop(DropReason::checksum);
  const std::string_view body(reinterpret_cast<const char*>(d), size - kTail);
  if (get(d + size - kTail, 8) != (options.key ? sipHash(*options.key, body) : 0)) return drop(DropReason::tag);
  h.kind = static_cast<unsigned>(d[5]);
  h.joints = static_cast<unsigned>(d[6]);
  h.flags = static_cast<unsigned>(d[7]);
  h.client = get(d + 8, 8);
  h.server = get(d + 16, 8);
  h.sequence = get(d + 24, 8);
  h.stamp = static_cast<std::int64_t>(get(d + 32, 8));
  h.echo = get(d + 40, 8);
  h.echoStamp = static_cast<std::int64_t>(get(d + 48, 8));
  const bool known = command ? h.kind == kCommand || h.kind == kCall : h.kind == kMeasurement;
  if (!known || h.joints != static_cast<unsigned>(options.joints)) return drop(DropReason::kind);
  return kDropReasons;
}

bool count(LinkCounts& counts, DropReason reason) noexcept {
  counts.dropped[static_cast<std::size_t>(reason)].fetch_add(1, std::memory_order_relaxed);
  return false;
}

// Time since `stamp` of our own clock, s. A forged stamp may be any number.
double since(std::int64_t stamp, std::int64_t now) noexcept {
  return (static_cast<double>(now) - static_cast<double>(stamp)) / kNanoseconds;
}

bool isWithin(std::int64_t stamp, std::int64_t now, double most) noexcept {
  return stamp <= now && since(stamp, now) <= most;
}

const LinkOptions& checked(const LinkOptions& options) {
  require(options.joints >= 1 && options.joints <= kMaxJoints,
          "link: the number of joints is " + std::to_string(options.joints) + ", must be in 1 to 7");
  for (const double time : {options.timeout, options.rampIn, options.rampOut})
    require(time > 0.0 && time <= 10.0,
            "link: the timeout or a ramp is " + formatNumber(time) + " s, must be above 0 and at most 10 s");
  return options;
}

JointVector bounded(const JointVector& torque, const Mechanism& mechanism) noexcept {
  return torque.cwiseMax(-mechanism.limits().effort).cwiseMin(mechanism.limits().effort);
}

std::uint64_t rotate(std::uint64_t x, int by) noexcept { return (x << by) | (x >> (64 - by)); }

}  // namespace

LinkKey readKey(const std::string& path) {
  std::string text = readFile(path, 4096);
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  const auto digit = [](char c) { return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1; };
  LinkKey key{};
  bool good = text.size() == 2 * key.size();
  for (std::size_t i = 0; good && i < text.size(); ++i) {
    good = digit(text[i]) >= 0;
    if (good) key[i / 2] = static_cast<unsigned char>(16 * key[i / 2] + digit(text[i]));
  }
  if (!good)
    throw ConfigurationError(path, 0, "", "the key must be 32 hexadecimal digits (0 to 9, a to f) on one line");
  return key;
}

std::uint64_t sipHash(const LinkKey& key, std::string_view text) noexcept {
  const auto* bytes = reinterpret_cast<const unsigned char*>(text.data());
  const std::uint64_t k0 = get(key.data(), 8), k1 = get(key.data() + 8, 8);
  std::uint64_t v0 = k0 ^ 0x736f6d6570736575u, v1 = k1 ^ 0x646f72616e646f6du, v2 = k0 ^ 0x6c7967656e657261u,
                v3 = k1 ^ 0x7465646279746573u;
  const auto rounds = [&](int n) {
    for (; n > 0; --n) {
      v0 += v1;
      v1 = rotate(v1, 13) ^ v0;
      v0 = rotate(v0, 32);
      v2 += v3;
      v3 = rotate(v3, 16) ^ v2;
      v0 += v3;
      v3 = rotate(v3, 21) ^ v0;
      v2 += v1;
      v1 = rotate(v1, 17) ^ v2;
      v2 = rotate(v2, 32);
    }
  };
  const auto absorb = [&](std::uint64_t word) {
    v3 ^= word;
    rounds(2);
    v0 ^= word;
  };
  std::size_t at = 0;
  for (; at + 8 <= text.size(); at += 8) absorb(get(bytes + at, 8));
  absorb(get(bytes + at, static_cast<int>(text.size() - at)) | static_cast<std::uint64_t>(text.size() & 0xff) << 56);
  v2 ^= 0xff;
  rounds(4);
  return v0 ^ v1 ^ v2 ^ v3;
}

const char* toString(DropReason reason) noexcept {
  switch (reason) {
    case DropReason::length: return "wrong length";
    case DropReason::magic: return "wrong protocol";
    case DropReason::version: return "another version";
    case DropReason::checksum: return "wrong checksum";
    case DropReason::tag: return "wrong key";
    case DropReason::kind: return "another kind or number of joints";
    case DropReason::session: return "another session";
    case DropReason::duplicate: return "duplicate";
    case DropReason::old: return "reordered";
    case DropReason::notFinite: return "not finite";
    case DropReason::limits: return "above the motors' limits";
    case DropReason::stale: return "too late";
  }
  return "unknown reason";
}

LinkClient::LinkClient(const LinkOptions& options, std::uint64_t nonce) : options_(checked(options)), client_(nonce) {}

void LinkClient::receive(const unsigned char* d, std::size_t size, std::int64_t now) noexcept {
  Head h;
  if (const int reason = examine(options_, d, size, false, h); reason != kDropReasons) {
    count(counts_, static_cast<DropReason>(reason));
    return;
  }
  if (h.client != client_ || !everCalled_ || (session_ && h.server != server_)) {
    count(counts_, DropReason::session);
    return;
  }
  if (session_ && h.sequence <= newest_) {
    count(counts_, h.sequence == newest_ ? DropReason::duplicate : DropReason::old);
    return;
  }
  Measurement m;
  m.time = getNumber(d + kHead);
  bool finite = std::isfinite(m.time);
  finite = getNumbers(d + kHead + 8, options_.joints, m.q) && finite;
  finite = getNumbers(d + kHead + 64, options_.joints, m.rates) && finite;
  if ((h.flags & kHasApplied) != 0)
    finite = getNumbers(d + kHead + 120, options_.joints, m.applied.emplace()) && finite;
  if (!finite) {
    count(counts_, DropReason::notFinite);
    return;
  }
  m.enabled = (h.flags & kIsEnabled) != 0 && (h.flags & kWatchdog) == 0;
  session_ = true;
  server_ = h.server;
  newest_ = h.sequence;
  stamp_ = h.stamp;
  heard_ = now;
  echo_ = h.echoStamp;
  if (h.echo > answered_ && h.echo <= sent_ && h.echoStamp <= now) {
    answered_ = h.echo;
    counts_.roundTrip.add(since(h.echoStamp, now));
  }
  counts_.accepted.fetch_add(1, std::memory_order_relaxed);
  measurement_ = m;
  fresh_ = true;
}

Status LinkClient::measure(Measurement& measurement, std::int64_t now) noexcept {
  if (session_ && now - heard_ > kSessionTimeout) {
    session_ = false;
    commanding_ = false;
    ++client_;  // packets in transit then belong to no session
    newest_ = answered_ = 0;
  }
  if (!session_ || !fresh_) return Status::stale;
  fresh_ = false;
  if (!isWithin(echo_, now, options_.timeout)) {
    count(counts_, DropReason::stale);
    return Status::stale;
  }
  measurement = measurement_;
  return Status::ok;
}

std::size_t LinkClient::call(std::int64_t now, Datagram& datagram) noexcept {
  if ((session_ && commanding_) || (everCalled_ && now - called_ < kCallInterval)) return 0;
  called_ = now;
  everCalled_ = true;
  Head h;
  h.kind = kCall;
  h.joints = static_cast<unsigned>(options_.joints);
  h.client = client_;
  h.sequence = ++sent_;
  h.stamp = now;
  putHead(h, datagram);
  putNumbers(&datagram[kHead], JointVector());
  counts_.sent.fetch_add(1, std::memory_order_relaxed);
  return seal(options_, kCommandBytes, datagram);
}

std::size_t LinkClient::command(const JointVector& torque, std::int64_t now, Datagram& datagram) noexcept {
  if (!session_) return 0;
  commanding_ = true;
  Head h;
  h.kind = kCommand;
  h.joints = static_cast<unsigned>(options_.joints);
  h.client = client_;
  h.server = server_;
  h.sequence = ++sent_;
  h.stamp = now;
  h.echo = newest_;
  h.echoStamp = stamp_;
  putHead(h, datagram);
  putNumbers(&datagram[kHead], torque);
  counts_.sent.fetch_add(1, std::memory_order_relaxed);
  return seal(options_, kCommandBytes, datagram);
}

LinkServer::LinkServer(const LinkOptions& options, const Mechanism& mechanism, std::uint64_t nonce)
    : options_(checked(options)), mechanism_(mechanism), kinematics_(mechanism.home()), server_(nonce) {
  require(mechanism.joints() == options.joints, "link: the mechanism has " + std::to_string(mechanism.joints()) +
                                                    " joints, the link has " + std::to_string(options.joints));
  torque_ = JointVector::Zero(options.joints);
}

bool LinkServer::receive(const unsigned char* d, std::size_t size, std::int64_t now) noexcept {
  Head h;
  if (const int reason = examine(options_, d, size, true, h); reason != kDropReasons)
    return count(counts_, static_cast<DropReason>(reason));
  session_ = hasSession(now);
  if (h.kind == kCall) {
    if (session_ && h.client != client_) return count(counts_, DropReason::session);
    if (!session_) {
      if (h.client == client_) return count(counts_, DropReason::session);  // an ended session stays ended
      session_ = true;
      client_ = h.client;
      ++server_;
      newest_ = answered_ = 0;
      commanded_ = false;
    }
  } else if (!session_ || h.client != client_ || h.server != server_) {
    return count(counts_, DropReason::session);
  }
  if (h.sequence <= newest_) return count(counts_, h.sequence == newest_ ? DropReason::duplicate : DropReason::old);
  JointVector torque;
  if (h.kind == kCommand) {
    if (!getNumbers(d + kHead, options_.joints, torque)) return count(counts_, DropReason::notFinite);
    for (int i = 0; i < options_.joints; ++i)
      if (!(std::abs(torque[i]) <= mechanism_.limits().effort[i] * (1.0 + 1e-6)))
        return count(counts_, DropReason::limits);
  }
  newest_ = h.sequence;
  stamp_ = h.stamp;
  heard_ = now;
  if (h.kind == kCommand) {
    if (h.echo > answered_ && h.echo <= sent_ && h.echoStamp <= now) {
      answered_ = h.echo;
      counts_.roundTrip.add(since(h.echoStamp, now));
    }
    if (!isWithin(h.echoStamp, now, options_.timeout)) {
      count(counts_, DropReason::stale);
      return true;
    }
    torque_ = bounded(torque, mechanism_);
    of_ = h.echoStamp;
    commanded_ = true;
  }
  counts_.accepted.fetch_add(1, std::memory_order_relaxed);
  return true;
}

JointVector LinkServer::torque(const JointVector& q, double period, std::int64_t now) noexcept {
  const bool alive = commanded_ && isWithin(of_, now, options_.timeout);
  weight_ =
      alive ? std::min(1.0, weight_ + period / options_.rampIn) : std::max(0.0, weight_ - period / options_.rampOut);
  if (weight_ == 1.0) return torque_;
  JointVector rest = JointVector::Zero(options_.joints);
  if (mechanism_.track(q, rest, false, kinematics_) == Status::ok) rest = bounded(kinematics_.gravity, mechanism_);
  return rest + weight_ * (torque_ - rest);
}

std::size_t LinkServer::measurement(const Measurement& m, std::int64_t now, Datagram& datagram) noexcept {
  if (!hasSession(now) || m.q.size() != options_.joints || m.rates.size() != options_.joints) return 0;
  const bool applied = m.applied && m.applied->size() == options_.joints;
  Head h;
  h.kind = kMeasurement;
  h.joints = static_cast<unsigned>(options_.joints);
  h.flags = (m.enabled ? kIsEnabled : 0) | (applied ? kHasApplied : 0) | (watchdog() ? kWatchdog : 0);
  h.client = client_;
  h.server = server_;
  h.sequence = ++sent_;
  h.stamp = now;
  h.echo = newest_;
  h.echoStamp = stamp_;
  putHead(h, datagram);
  putNumber(&datagram[kHead], m.time);
  putNumbers(&datagram[kHead + 8], m.q);
  putNumbers(&datagram[kHead + 64], m.rates);
  putNumbers(&datagram[kHead + 120], applied ? *m.applied : JointVector());
  counts_.sent.fetch_add(1, std::memory_order_relaxed);
  return seal(options_, kMeasurementBytes, datagram);
}

}  // namespace enamel
