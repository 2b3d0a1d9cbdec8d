// The stand-ins of all drivers in one form, for tests that run each driver.
#pragma once

#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "support/devices.hpp"
#include "support/driver_bench.hpp"
#ifdef ENAMEL_HAPLY_SERVICE
#include "support/haply_service.hpp"
#endif

namespace enamel::test {

// A stand-in as the test sees it.
struct Rig {
  std::string url, file;                                                    // file: of the device
  std::function<void()> period;                                             // one period of the stand-in has passed
  std::function<Vec3()> force;                                              // that the stand-in received, W, N
  std::function<void(const Vec3&, double stiffness, double damping)> hold;  // by the hand: place, W, m; N/m, N s/m
  std::function<void(const Measurement&)> show;                             // a sample instead of the simulated ones
  std::function<void(HapticDevice&, Measurement&, Status&)> await = {};     // an answer that comes in real time
  std::function<std::uint64_t()> messages = {};                             // answered, if that takes real time
  struct Fault {
    std::string name;
    std::function<void(bool)> set;
    bool isDeaf = false;  // commands do not arrive, and the vendor keeps the last force
  };
  std::vector<Fault> faults = {};
  std::function<void(const Vec3& turn, double gripper)> turn = {};  // of the hand, W, rad, if the device senses them
};

#ifdef ENAMEL_DHD_STAND_IN
struct DhdRig : StandIn {
  /// `model`: axes, 3, 6 or 7.
  explicit DhdRig(int model = 3) : StandIn(ENAMEL_DHD_STAND_IN, "dhd") {
    set("model", model);
    if (model == 3) return;
    rig.file = model == 6 ? "omega-6.toml" : "sigma-7.toml";
    rig.turn = [this](const Vec3& turn, double gripper) {
      set("turn-x", turn.z());  // the axes of the SDK: towards the user, right, up
      set("turn-y", turn.x());
      set("turn-z", turn.y());
      set("gripper", gripper);
    };
  }
  Rig rig{std::string("forcedimension://0?library=") + ENAMEL_DHD_STAND_IN,
          "omega-3.toml",
          [] {},
          [this] { return Vec3(force(1), force(2), force(0)); },
          [this](const Vec3& place, double stiffness, double damping) { hold(place, stiffness, damping); },
          find<void(const Measurement&)>("dhdStandInShow")};
};

#endif

#ifdef ENAMEL_HD_STAND_IN
struct HdRig : StandIn {
  /// `isManual`: rig.period() advances it, not a thread.
  explicit HdRig(bool isManual = true) : StandIn(ENAMEL_HD_STAND_IN, "hd") { set("manual", isManual ? 1.0 : 0.0); }
  ~HdRig() { set("manual", 0.0); }
  HdRig(const HdRig&) = delete;
  HdRig& operator=(const HdRig&) = delete;
  Rig rig{std::string("openhaptics://Default Device?library=") + ENAMEL_HD_STAND_IN,
          "touch.toml",
          [periods = find<void(int)>("hdStandInPeriods")] { periods(1); },
          [this] { return force(); },
          [this](const Vec3& place, double stiffness, double damping) { hold(place, stiffness, damping); },
          find<void(const Measurement&)>("hdStandInShow"),
          {},
          {},
          {},
          [this](const Vec3& turn, double) {
            set("turn-x", turn.x());
            set("turn-y", turn.y());
            set("turn-z", turn.z());
          }};
};

#endif

#ifdef ENAMEL_HAPLY_SERVICE
struct HaplyRig {
  HaplyService service{deviceFile("inverse3.toml"), 0.0, 0.0};
  bool isSilent = false;
  Rig rig{"haply://" + service.address(), "inverse3.toml", [] {}, [this] { return service.newestForce(); },
          [this](const Vec3& place, double stiffness, double damping) { service.hold(place, stiffness, damping); },
          [this](const Measurement& sample) { service.show(sample); },
          // The service answers over a socket in real time: wait for at most 0.2 s.
          [this](HapticDevice& device, Measurement& m, Status& status) {
            for (int i = 0; i < 10000 && !isSilent && status == Status::stale; ++i) {
              std::this_thread::sleep_for(std::chrono::microseconds(20));
              status = device.measure(m);
            }
          },
          [this] { return service.messages.load(); }};
};

#endif

}  // namespace enamel::test
