// A stand-in of libHD of OpenHaptics: the documented functions that the driver uses, a scheduler with its own thread,
// and a simulated Touch. The functions hdStandIn...() are not the vendor's: they select the device and its faults.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <deque>
#include <iterator>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include "runtime/system_thread.hpp"
#include "support/held_device.hpp"

using namespace enamel;

namespace {

using Clock = std::chrono::steady_clock;
struct Error {
  unsigned code;
  int internal;
  unsigned handle;
};
using Callback = unsigned (*)(void*);

constexpr unsigned kHandle = 3;
const Vec3 kMiddle(0.0, 40.0, -10.0);  // of the workspace in the axes of the HD API, mm

struct StandIn {
  std::recursive_mutex mutex;
  std::map<std::string, double> faults;  // by the names of hdStandIn()
  bool isOpen = false, forces = false, isInFrame = false;
  std::deque<Error> errors;
  double force[3] = {};
  std::unique_ptr<test::HeldDevice> device;
  unsigned rate = 1000;  // of the scheduler, Hz
  std::map<unsigned long, std::pair<Callback, void*>> tasks;
  unsigned long lastTask = 0;
  std::thread scheduler;
  std::atomic<bool> isRunning{false};

  bool has(const char* fault) const {
    const auto found = faults.find(fault);
    return found != faults.end() && found->second != 0.0;
  }
  double valueOf(const char* fault) const { return has(fault) ? faults.at(fault) : 0.0; }
};
StandIn s;
using Lock = std::lock_guard<std::recursive_mutex>;

void fail(unsigned code) { s.errors.push_front({code, -7, kHandle}); }

void makeDevice() {
  s.device = std::make_unique<test::HeldDevice>(s.has("touch-x") ? "touch-x.toml" : "touch.toml", 1.0 / s.rate);
  s.device->advance(Vec3::Zero(), Vec3::Zero());
}

// One period of the scheduler: all tasks, then the device moves. hdUnschedule() waits for its end, as the vendor's.
void period() {
  const Lock lock(s.mutex);
  if (!s.has("stalled")) {
    const auto tasks = s.tasks;
    for (const auto& [task, call] : tasks) (void)call.first(call.second);  // the driver's task always continues
  }
  if (!s.isOpen) return;
  s.device->turn = {s.valueOf("turn-x"), s.valueOf("turn-y"), s.valueOf("turn-z")};
  s.device->place = {s.valueOf("place-x"), s.valueOf("place-y"), s.valueOf("place-z")};
  if (s.has("stiffness")) s.device->stiffness = s.valueOf("stiffness");
  if (s.has("damping")) s.device->damping = s.valueOf("damping");
  s.device->advance(s.forces && !s.has("unplugged") ? Vec3(Vec3::Map(s.force)) : Vec3(Vec3::Zero()), Vec3::Zero());
}

}  // namespace

#pragma GCC visibility push(default)
extern "C" {

// Faults of 1 or 0: "button", "unplugged", "fault", "warm", "stalled". "absent" is the error of hdInitDevice().
// "uncalibrated": 1 if an update helps, 2 if only the user can. "touch-x": another model. "max-force": N.
// "heat": of the hottest motor. "manual": periods by hdStandInPeriods() instead of a thread. Of the hand, in the axes
// of W: "stiffness", "damping", "place-x" to "place-z", "turn-x" to "turn-z".
void hdStandIn(const char* what, double value) {
  const Lock lock(s.mutex);
  s.faults[what] = value;
  if (s.has("unplugged")) s.forces = false;  // nothing drives the motors any more
}
double hdStandInForce(int axis) {
  const Lock lock(s.mutex);
  return s.forces ? s.force[axis] : 0.0;
}
void hdStandInShow(const Measurement* sample) {
  const Lock lock(s.mutex);
  s.device->show(*sample);
}
void hdStandInPeriods(int count) {
  for (int i = 0; i < count; ++i) period();
}

unsigned hdInitDevice(const char* name) {
  const Lock lock(s.mutex);
  if (s.isOpen) return fail(0x0301), 0xFFFFFFFF;
  if (s.has("absent")) return fail(static_cast<unsigned>(s.valueOf("absent"))), 0xFFFFFFFF;
  if (s.has("unplugged")) return fail(0x0302), 0xFFFFFFFF;
  if (name != nullptr && std::strcmp(name, "Default Device") != 0) return fail(0x0300), 0xFFFFFFFF;
  s.isOpen = true;
  std::fill(std::begin(s.force), std::end(s.force), 0.0);
  makeDevice();
  return kHandle;
}
void hdDisableDevice(unsigned handle) {
  const Lock lock(s.mutex);
  if (handle != kHandle || !s.isOpen) return fail(0x0104);
  s.isOpen = s.forces = false;
}
void hdMakeCurrentDevice(unsigned handle) {
  const Lock lock(s.mutex);
  if (handle != kHandle || !s.isOpen) fail(0x0104);
}
const char* hdGetString(unsigned what) {
  const Lock lock(s.mutex);
  if (what == 0x2501) return s.has("touch-x") ? "Touch X" : "Touch";
  return what == 0x2504 ? "S-1" : what == 0x2500 ? "3.50" : what == 0x2502 ? "2023.1" : nullptr;
}
void hdGetIntegerv(unsigned what, int* values) {
  const Lock lock(s.mutex);
  if (what == 0x2555)
    *values = 4;  // by the inkwell
  else if (what != 0x2000)
    fail(0x0100);
  else if (!s.isInFrame)
    fail(0x0402);
  else
    *values = s.has("button") ? 2 : 0;
}
void hdGetDoublev(unsigned what, double* values) {
  const Lock lock(s.mutex);
  if (what == 0x2551) {
    Eigen::Map<Vec6> corners(values);
    corners << kMiddle - Vec3(80, 60, 35), kMiddle + Vec3(80, 60, 35);
  } else if (what == 0x2603) {
    *values = s.has("max-force") ? s.valueOf("max-force") : s.has("touch-x") ? 7.9 : 3.3;
  } else if (what == 0x2604) {
    *values = 0.88;
  } else if (what == 0x2602) {
    *values = 0.5;  // N/mm
  } else if (what == 0x2609) {
    *values = 0.002;  // N s/mm
  } else if (what == 0x2505) {
    *values = 1.5;
  } else if (what == 0x2605) {
    for (int i = 0; i < 3; ++i) values[i] = i == 1 ? s.valueOf("heat") : 0.0;
  } else if (what != 0x2050 && what != 0x2052) {
    fail(0x0100);
  } else if (!s.isInFrame) {
    fail(0x0402);
  } else {
    const Pose pose = s.device->pose();
    const Vec3 mm = 1e3 * pose.position + kMiddle;
    if (what == 0x2050) {
      Vec3::Map(values) = mm;
    } else {
      Eigen::Map<Eigen::Matrix4d> frame(values);
      frame.setIdentity();
      frame.topLeftCorner<3, 3>() = pose.rotation;
      frame.topRightCorner<3, 1>() = mm;
    }
  }
}
void hdSetDoublev(unsigned what, const double* values) {
  const Lock lock(s.mutex);
  if (what != 0x2700) return fail(0x0100);
  if (!s.isInFrame) return fail(0x0402);
  const double largest = s.has("touch-x") ? 7.9 : 3.3;
  const bool isRefused = s.has("warm") || Vec3::Map(values).norm() > largest + 1e-9;
  if (isRefused) fail(s.has("warm") ? 0x0200 : 0x0201);
  for (int i = 0; i < 3; ++i) s.force[i] = isRefused ? 0.0 : values[i];
}
Error hdGetError() {
  const Lock lock(s.mutex);
  if (s.errors.empty()) return {0, 0, 0};
  const Error error = s.errors.front();
  s.errors.pop_front();
  return error;
}
unsigned hdCheckCalibration() {
  const Lock lock(s.mutex);
  return s.has("uncalibrated") ? 0x5000 + static_cast<unsigned>(s.valueOf("uncalibrated")) : 0x5000;
}
void hdUpdateCalibration(unsigned style) {
  const Lock lock(s.mutex);
  if (style == 4 && s.valueOf("uncalibrated") == 1.0) s.faults["uncalibrated"] = 0.0;
}
void hdEnable(unsigned what) {
  const Lock lock(s.mutex);
  if (what == 0x4000) s.forces = true;
}
void hdDisable(unsigned what) {
  const Lock lock(s.mutex);
  if (what == 0x4000) s.forces = false;
}
void hdSetSchedulerRate(unsigned rate) {
  const Lock lock(s.mutex);
  if (rate < 500 || rate > 4000) return fail(0x0101);
  if (rate == s.rate) return;
  s.rate = rate;
  makeDevice();
}
unsigned long hdScheduleAsynchronous(Callback call, void* user, unsigned short) {
  const Lock lock(s.mutex);
  s.tasks[++s.lastTask] = {call, user};
  return s.lastTask;
}
void hdUnschedule(unsigned long task) {
  const Lock lock(s.mutex);
  s.tasks.erase(task);
}
void hdStartScheduler() {
  const Lock lock(s.mutex);
  if (!s.isOpen || s.has("fault")) return fail(0x0304);
  if (s.isRunning || s.has("manual")) return;
  s.isRunning = true;
  s.scheduler = std::thread([] {
    (void)system::requestRealtime(85);  // other programs on this machine are not part of the test
    for (auto next = Clock::now(); s.isRunning; std::this_thread::sleep_until(next)) {
      period();
      next =
          std::max(next + std::chrono::microseconds(1000000 / s.rate), Clock::now() - std::chrono::milliseconds(100));
    }
  });
}
void hdStopScheduler() {
  s.isRunning = false;
  if (s.scheduler.joinable()) s.scheduler.join();
}
void hdBeginFrame(unsigned handle) {
  const Lock lock(s.mutex);
  if (handle != kHandle || !s.isOpen) return fail(0x0104);
  if (s.isInFrame) return fail(0x0400);
  if (s.has("unplugged")) fail(0x0302);
  s.isInFrame = true;
}
void hdEndFrame(unsigned) {
  const Lock lock(s.mutex);
  if (!s.isInFrame) return fail(0x0401);
  s.isInFrame = false;
}

}  // extern "C"

namespace {
[[maybe_unused]] const bool isSet = test::setFromEnvironment(hdStandIn);
}  // namespace
#pragma GCC visibility pop
