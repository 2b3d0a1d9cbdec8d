// A device at the other end of a wire that loses, doubles, reorders, delays and forges: the datagrams of a measurement
// and of a command, and the two ends without sockets (udp_device.hpp has those). Bytes, states and watchdogs as a
// driver's author needs them: lib/docs/device.md.
//
// Times `now` are ns of a clock of the end's own that never goes back; the two ends' clocks need not agree.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "enamel/device/haptic_device.hpp"
#include "enamel/device/mechanism.hpp"
#include "enamel/runtime/duration_histogram.hpp"

namespace enamel {

/// Bytes of a measurement and of a command on the wire.
inline constexpr std::size_t kMeasurementBytes = 244, kCommandBytes = 124;
using Datagram = std::array<unsigned char, kMeasurementBytes>;

/// What both ends must know where a wire leaves the machine.
using LinkKey = std::array<unsigned char, 16>;

/// Reads a key, 32 hexadecimal digits. Throws ConfigurationError. Realtime: no.
LinkKey readKey(const std::string& path);

/// SipHash-2-4 (Aumasson and Bernstein 2012). Realtime: yes.
std::uint64_t sipHash(const LinkKey& key, std::string_view bytes) noexcept;

/// Why a datagram was dropped, in the order of the checks.
enum class DropReason : std::uint8_t {
  length,
  magic,
  version,
  checksum,
  tag,        ///< not made with our key
  kind,       ///< not for this end, or of a device with another number of joints
  session,    ///< of another client, or from before
  duplicate,  ///< the newest once more
  old,        ///< something newer was here already
  notFinite,
  limits,  ///< a command beyond the motors'
  stale,   ///< a command for, or a measurement after, something too long ago
};
inline constexpr int kDropReasons = 12;

/// Name of a reason in plain words. Realtime: yes.
const char* toString(DropReason reason) noexcept;

/// What an end has seen. Written by its thread, read by any.
struct LinkCounts {
  std::atomic<std::uint64_t> sent{0}, accepted{0};
  std::array<std::atomic<std::uint64_t>, kDropReasons> dropped{};
  DurationHistogram roundTrip;  ///< from sending to the first answer to it, s: the other end's period is in it
};

/// Both ends must agree on `joints` and `key`.
struct LinkOptions {
  int joints = 0;
  std::optional<LinkKey> key;
  double timeout = 0.01;  ///< older is no command and no measurement, s
  double rampIn = 0.1;    ///< of the server's watchdog, s
  double rampOut = 0.02;
};

/// A client that does not command calls every 5 ms; a session ends after 100 ms without a datagram of the other end.
inline constexpr std::int64_t kCallInterval = 5'000'000, kSessionTimeout = 100'000'000;  // ns

/// The end of the loop. No thread, no clock, no socket.
class LinkClient {
 public:
  /// `nonce`: a random number of its own. Throws Error: joints outside 1 to 7; times not positive.
  LinkClient(const LinkOptions& options, std::uint64_t nonce);

  /// Takes a datagram as it came. Realtime: yes.
  void receive(const unsigned char* bytes, std::size_t size, std::int64_t now) noexcept;

  /// The newest measurement; stale: none since the last call, or the server answers to commands from before `timeout`.
  /// Not enabled while the server's watchdog acts. Realtime: yes.
  [[nodiscard]] Status measure(Measurement& measurement, std::int64_t now) noexcept;

  /// Writes a call where one is due, or nothing; returns the size. Realtime: yes.
  std::size_t call(std::int64_t now, Datagram& datagram) noexcept;

  /// Writes a command, or nothing without a session; returns the size. Realtime: yes.
  std::size_t command(const JointVector& torque, std::int64_t now, Datagram& datagram) noexcept;

  const LinkCounts& counts() const noexcept { return counts_; }

 private:
  LinkOptions options_;
  LinkCounts counts_;
  std::uint64_t client_, server_ = 0, sent_ = 0, newest_ = 0, answered_ = 0;
  std::int64_t stamp_ = 0;               // of the newest measurement, the server's clock
  std::int64_t heard_ = 0, called_ = 0;  // own clock
  std::int64_t echo_ = 0;                // of the newest measurement, own clock
  bool session_ = false, everCalled_ = false, commanding_ = false, fresh_ = false;
  Measurement measurement_;
};

/// The end of the device, with the watchdog: a command acts while the measurement that it answers is younger than
/// `timeout`; from then on the torque goes within `rampOut` to what balances gravity, or to zero. Once commands come
/// again their part ramps in.
class LinkServer {
 public:
  /// `mechanism`: the motors' limits and gravity; must outlive it. Throws Error: as LinkClient; another number of
  /// joints.
  LinkServer(const LinkOptions& options, const Mechanism& mechanism, std::uint64_t nonce);

  /// Takes a datagram as it came; true: it is from the client of the session. Realtime: yes.
  bool receive(const unsigned char* bytes, std::size_t size, std::int64_t now) noexcept;

  /// What the motors get for the next `period` s, once a tick; within the limits whatever came in. Realtime: yes.
  JointVector torque(const JointVector& q, double period, std::int64_t now) noexcept;

  /// Writes a measurement, or nothing without a session; returns the size. Realtime: yes.
  std::size_t measurement(const Measurement& measurement, std::int64_t now, Datagram& datagram) noexcept;

  /// Return whether a client's session lasts. Realtime: yes.
  bool hasSession(std::int64_t now) const noexcept { return session_ && now - heard_ <= kSessionTimeout; }

  /// Whether the torque is less than the client's command; whether nothing of that is left. Realtime: yes.
  bool watchdog() const noexcept { return weight_ < 1.0; }
  bool rests() const noexcept { return weight_ == 0.0; }

  const LinkCounts& counts() const noexcept { return counts_; }

 private:
  LinkOptions options_;
  const Mechanism& mechanism_;
  Kinematics kinematics_;
  LinkCounts counts_;
  std::uint64_t client_ = 0, server_, sent_ = 0, newest_ = 0, answered_ = 0;
  std::int64_t stamp_ = 0;  // of the newest command, the client's clock
  std::int64_t heard_ = 0;  // own clock
  std::int64_t of_ = 0;     // when the measurement that torque_ answers was sent, own clock
  bool session_ = false, commanded_ = false;
  JointVector torque_;
  double weight_ = 0.0;  // of torque_
};

}  // namespace enamel
