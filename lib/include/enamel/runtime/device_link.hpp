// A link to a device over a wire that may lose, duplicate, reorder, delay or forge datagrams. This header has the
// datagrams of measurements and commands, and the two ends without sockets (udp_device.hpp has the sockets). Format,
// states and watchdogs for authors of drivers: lib/docs/device.md.
//
// Each time `now` is in ns of the end's own clock, which never goes back. The clocks of the two ends need not agree.
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

/// Sizes of a measurement and of a command on the wire, bytes.
inline constexpr std::size_t kMeasurementBytes = 244, kCommandBytes = 124;
using Datagram = std::array<unsigned char, kMeasurementBytes>;

/// Secret key of both ends. Required if the link leaves the machine.
using LinkKey = std::array<unsigned char, 16>;

/// Read a key, 32 hexadecimal digits. Throws ConfigurationError if the file does not contain one. Realtime: no.
LinkKey readKey(const std::string& path);

/// Return the SipHash-2-4 of bytes (Aumasson and Bernstein 2012). Realtime: yes.
std::uint64_t sipHash(const LinkKey& key, std::string_view bytes) noexcept;

/// Why a datagram was dropped, in the order of the checks.
enum class DropReason : std::uint8_t {
  length,
  magic,
  version,
  checksum,
  tag,        ///< not made with our key
  kind,       ///< not for this end, or a device with another number of joints
  session,    ///< of another client, or of an earlier session
  duplicate,  ///< a copy of the newest one
  old,        ///< a newer one arrived before
  notFinite,
  limits,  ///< a command exceeds the motors' limits
  /// A command for, or a measurement after, a datagram that is too old.
  stale,
};
inline constexpr int kDropReasons = 12;

/// Return the name of a reason in plain words. Realtime: yes.
const char* toString(DropReason reason) noexcept;

/// Counters of one end. Its thread writes them; any thread may read them.
struct LinkCounts {
  std::atomic<std::uint64_t> sent{0}, accepted{0};
  std::array<std::atomic<std::uint64_t>, kDropReasons> dropped{};
  DurationHistogram roundTrip;  ///< from sending to the first answer, s; includes the other end's period
};

/// Options of a link. Both ends must have the same `joints` and `key`.
struct LinkOptions {
  int joints = 0;
  std::optional<LinkKey> key;
  double timeout = 0.01;  ///< largest age of a valid command or measurement, s
  double rampIn = 0.1;    ///< ramps of the server's watchdog, s
  double rampOut = 0.02;
};

/// A client that sends no commands calls every 5 ms. A session ends after 100 ms without a datagram from the other end.
inline constexpr std::int64_t kCallInterval = 5'000'000, kSessionTimeout = 100'000'000;  // ns

/// The loop's end of a link. It has no thread, clock or socket.
class LinkClient {
 public:
  /// `nonce` is a random number, a new one for each client. Throws Error if the number of joints is outside 1 to 7 or a
  /// time is not positive.
  LinkClient(const LinkOptions& options, std::uint64_t nonce);

  /// Receive a datagram. Realtime: yes.
  void receive(const unsigned char* bytes, std::size_t size, std::int64_t now) noexcept;

  /// Return the newest measurement. Status stale: nothing new arrived since the last call, or the server answers
  /// commands older than `timeout`. While the server's watchdog acts, `enabled` is false. Realtime: yes.
  [[nodiscard]] Status measure(Measurement& measurement, std::int64_t now) noexcept;

  /// Write a call if one is due. Return its size, or 0. Realtime: yes.
  std::size_t call(std::int64_t now, Datagram& datagram) noexcept;

  /// Write a command if there is a session. Return its size, or 0. Realtime: yes.
  std::size_t command(const JointVector& torque, std::int64_t now, Datagram& datagram) noexcept;

  const LinkCounts& counts() const noexcept { return counts_; }

 private:
  LinkOptions options_;
  LinkCounts counts_;
  std::uint64_t client_, server_ = 0, sent_ = 0, newest_ = 0, answered_ = 0;
  std::int64_t stamp_ = 0;               // of the newest measurement, server's clock
  std::int64_t heard_ = 0, called_ = 0;  // own clock
  std::int64_t echo_ = 0;                // of the newest measurement, own clock
  bool session_ = false, everCalled_ = false, commanding_ = false, fresh_ = false;
  Measurement measurement_;
};

/// The device's end of a link, with a watchdog. A command acts while the measurement that it answers is younger than
/// `timeout`. After that, the torque ramps within `rampOut` to the torque that balances gravity, or to zero. When
/// commands come again, their part ramps in.
class LinkServer {
 public:
  /// `mechanism` has the motors' limits and gravity. It must outlive this object. Throws Error as LinkClient, and if
  /// the number of joints differs from the mechanism's.
  LinkServer(const LinkOptions& options, const Mechanism& mechanism, std::uint64_t nonce);

  /// Receive a datagram. Return whether it is from the session's client. Realtime: yes.
  bool receive(const unsigned char* bytes, std::size_t size, std::int64_t now) noexcept;

  /// Return the torque of the motors for the next `period` s. Call this once per tick. The torque is always within the
  /// limits, whatever was received. Realtime: yes.
  JointVector torque(const JointVector& q, double period, std::int64_t now) noexcept;

  /// Write a measurement if there is a session. Return its size, or 0. Realtime: yes.
  std::size_t measurement(const Measurement& measurement, std::int64_t now, Datagram& datagram) noexcept;

  /// Return whether the session of a client is active. Realtime: yes.
  bool hasSession(std::int64_t now) const noexcept { return session_ && now - heard_ <= kSessionTimeout; }

  /// Return whether the watchdog reduces the client's command. rests() returns whether it has reduced the command to
  /// nothing. Realtime: yes.
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
  std::int64_t of_ = 0;     // time of sending the measurement that torque_ answers, own clock
  bool session_ = false, commanded_ = false;
  JointVector torque_;
  double weight_ = 0.0;  // of torque_
};

}  // namespace enamel
