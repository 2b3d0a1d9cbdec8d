// A stand-in of the Haply Inverse service: a WebSocket with the messages that docs.haply.co describes, and a simulated
// Inverse3 that a hand holds. Faults are switched while it runs.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "enamel/device/haptic_device.hpp"

namespace enamel::test {

class HaplyService {
 public:
  /// The hand moves the device along W's z: from `high` to `low` and back within 1 s (m). hold() ends that.
  HaplyService(const std::string& deviceFile, double high, double low);
  ~HaplyService();
  HaplyService(const HaplyService&) = delete;
  HaplyService& operator=(const HaplyService&) = delete;

  /// Hold the device at a place, W, m, with a stiffness and a damping, N/m, N s/m.
  void hold(const Vec3& place, double stiffness, double damping);

  /// Report this sample instead of the simulated ones. It has the coordinates of the device file.
  void show(const Measurement& sample);

  /// Return the newest force of the client, W, N.
  Vec3 newestForce() const;

  /// Return "127.0.0.1:PORT".
  std::string address() const;

  // Faults.
  std::atomic<int> late_ms{0};              ///< before each answer
  std::atomic<int> lateOnce_ms{0};          ///< before the next answer
  std::atomic<bool> isShuffled{false};      ///< members in another order, and members that nobody knows
  std::atomic<bool> isSlow{false};          ///< each answer in two halves, 0.3 ms apart
  std::atomic<bool> isUnplugged{false};     ///< answers without the device
  std::atomic<bool> isGarbage{false};       ///< answers that are not JSON
  std::atomic<bool> isClosing{false};       ///< closes the connection at the next message
  std::atomic<bool> isUncalibrated{false};  ///< in the status
  std::atomic<bool> hasNoPower{false};      ///< in the status
  std::atomic<bool> isPermuted{false};      ///< in the first message
  std::atomic<bool> isTurned{false};        ///< the mount, in the first message

  std::atomic<std::uint64_t> messages{0};             ///< answered
  std::atomic<double> force{0.0}, largestForce{0.0};  ///< size of the newest and of the largest force, N
  std::atomic<bool> hasProfile{false};                ///< the session named itself

 private:
  struct Server;
  std::unique_ptr<Server> server_;
};

}  // namespace enamel::test
