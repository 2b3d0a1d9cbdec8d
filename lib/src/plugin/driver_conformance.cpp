#include "enamel/plugin/driver_conformance.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <thread>

#include "core/message.hpp"
#include "enamel/device/device_file.hpp"
#include "plugin/checks.hpp"
#include "plugin/own_device.hpp"

namespace enamel {
namespace driver_conformance {
namespace {

using conformance::Check;
using conformance::demand;
using conformance::nameOf;

using Clock = std::chrono::steady_clock;

constexpr double kFirstSample = 1.0;    // s, longest wait after open()
constexpr double kLargestSpeed = 20.0;  // m/s or rad/s: more is a wrong unit
constexpr double kClockError = 0.05;    // of the time stamps, share of the duration

double since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

// A device of the driver; its end closes and disconnects it.
class Link {
 public:
  Link(const DriverLibrary& library, const std::string& address, const std::map<std::string, std::string>& options)
      : table_(library.table()) {
    std::vector<EnamelParameter> parameters;
    for (const auto& [key, value] : options) parameters.push_back({key.c_str(), value.c_str(), nullptr});
    connected.size = sizeof connected;
    result = table_.connect(address.c_str(), parameters.data(), parameters.size(), &connected,
                            {reason.data(), reason.size()});
    reason.back() = 0;
  }
  ~Link() {
    if (result != ENAMEL_OK) return;
    if (isOpen) close();
    table_.disconnect(&connected);
  }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  void open() {
    demand(result == ENAMEL_OK, "connect() returned " + nameOf(result) + ": " + reason.data());
    std::array<char, 1024> text{};
    const std::int32_t opened = device().open ? device().open(device().user, {text.data(), text.size()}) : 0;
    text.back() = 0;
    demand(opened == ENAMEL_OK, "open() returned " + nameOf(opened) + ": " + text.data());
    isOpen = true;
  }
  void close() {
    if (device().close) device().close(device().user);
    isOpen = false;
  }
  std::int32_t measure() {
    std::memset(&sample, 0xff, sizeof sample);  // NaN: what the driver does not write is not finite
    sample.size = sizeof sample;
    sample.age = sample.applied_known = sample.has_gripper = sample.failed = 0;
    return device().measure(device().user, &sample);
  }
  std::int32_t actuate(double effort) {
    std::array<double, ENAMEL_MAX_JOINTS> efforts{};
    efforts[0] = effort;
    return device().actuate(device().user, efforts.data(), connected.joints);
  }
  // Measure and command zero once a period until there is a sample.
  void await(double period) {
    for (const auto begin = Clock::now(); since(begin) < kFirstSample;) {
      const std::int32_t measured = measure();
      if (measured == ENAMEL_OK) return;
      demand(measured == ENAMEL_STALE, "measure() after open() returned " + nameOf(measured));
      (void)actuate(0.0);
      std::this_thread::sleep_for(std::chrono::duration<double>(period));
    }
    demand(false, "no sample within " + formatNumber(kFirstSample) + " s after open()");
  }
  const EnamelDevice& device() const { return connected.device; }

  EnamelConnected connected{};
  EnamelMeasurement sample{};
  std::int32_t result = ENAMEL_OK;
  std::array<char, 1024> reason{};
  bool isOpen = false;

 private:
  const EnamelDriver& table_;
};

// The checks of a driver. Each returns a detail to report, or throws Failure.
class DriverChecks {
 public:
  DriverChecks(const std::shared_ptr<const DriverLibrary>& library, const DriverConformanceOptions& options)
      : library_(*library), options_(options) {}

  std::string describesItself() {
    demand(library_.table().describe() == library_.table().describe(), "describe() returned different addresses");
    return std::string(library_.description().name) + " " + library_.description().version;
  }

  std::string listsDevices() {
    try {
      return std::to_string(listDriver(library_).size()) + " connected";
    } catch (const PluginError& none) {
      return none.what();
    }
  }

  std::string refusesUnknownAddress() {
    const Link link(library_, "no such device/ ?", {});
    demand(link.result != ENAMEL_OK, "connect() with the address \"no such device/ ?\" was accepted");
    demand(link.reason[0] != 0, "connect() gave no reason");
    return link.reason.data();
  }

  std::string connects() {
    Link link(library_, options_.address, options_.options);
    demand(link.result == ENAMEL_OK, "connect() returned " + nameOf(link.result) + ": " + link.reason.data());
    demand(link.measure() == ENAMEL_INACTIVE, "measure() before open() did not return inactive");
    demand(link.actuate(0.0) == ENAMEL_INACTIVE, "actuate() before open() did not return inactive");
    return "";
  }

  std::string hasDeviceFile() {
    const Link link(library_, options_.address, options_.options);
    demand(link.result == ENAMEL_OK && link.connected.device_file != nullptr, "connect() gave no device file");
    mechanism_ = makeMechanism(parseDevice(link.connected.device_file, "device file"));
    demand(mechanism_->joints() == link.connected.joints,
           "the device file has " + std::to_string(mechanism_->joints()) + " joints, connect() gave " +
               std::to_string(link.connected.joints));
    return mechanism_->name();
  }

  std::string measuresAtRest() {
    Link link(library_, options_.address, options_.options);
    link.open();
    link.await(options_.period);
    const auto begin = Clock::now();
    const double start = link.sample.time;
    double last = start;
    double arrived = 0.0, largestGap = 0.0;  // s, on this clock; the machine may pause
    int samples = 0, ticks = 0;
    for (; since(begin) < options_.duration; ++ticks) {
      const std::int32_t sent = link.actuate(0.0);
      demand(sent == ENAMEL_OK || sent == ENAMEL_STALE, "actuate() of zero returned " + nameOf(sent));
      std::this_thread::sleep_for(std::chrono::duration<double>(options_.period));
      const std::int32_t measured = link.measure();
      demand(measured == ENAMEL_OK || measured == ENAMEL_STALE, "measure() returned " + nameOf(measured));
      if (measured != ENAMEL_OK) continue;
      requireValid(link.sample, last, samples++);
      largestGap = std::max(largestGap, since(begin) - arrived);
      arrived = since(begin);
    }
    demand(samples > 0, "no sample in " + formatNumber(options_.duration) + " s");
    demand(std::abs(last - start - arrived) < kClockError * arrived + largestGap + 2e-2,
           "the time stamps advanced by " + formatNumber(last - start) + " s in " + formatNumber(arrived) + " s");
    return std::to_string(samples) + " samples in " + std::to_string(ticks) + " ticks";
  }

  std::string refusesBadEfforts() {
    Link link(library_, options_.address, options_.options);
    link.open();
    link.await(options_.period);
    for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()})
      demand(link.actuate(bad) == ENAMEL_NOT_FINITE, "actuate() of " + formatNumber(bad) + " was accepted");
    const std::array<double, ENAMEL_MAX_JOINTS> zero{};
    for (const int joints : {0, -1, link.connected.joints + 1})
      demand(link.device().actuate(link.device().user, zero.data(), joints) == ENAMEL_OUT_OF_RANGE,
             "actuate() of " + std::to_string(joints) + " joints was accepted");
    link.await(options_.period);
    return "";
  }

  std::string opensAgain() {
    Link link(library_, options_.address, options_.options);
    link.open();
    link.await(options_.period);
    const double before = link.sample.time;
    link.close();
    demand(link.measure() == ENAMEL_INACTIVE, "measure() after close() did not return inactive");
    demand(link.actuate(0.0) == ENAMEL_INACTIVE, "actuate() after close() did not return inactive");
    link.open();
    link.await(options_.period);
    demand(link.sample.time > before, "the time went back from " + formatNumber(before) + " s to " +
                                          formatNumber(link.sample.time) + " s when the device was opened again");
    return "";
  }

  std::string allocatesNothing() {
    Link link(library_, options_.address, options_.options);
    link.open();
    link.await(options_.period);
    for (int i = 0; i < 20; ++i) tick(link);  // buffers that grow once
    long count = 0;
    for (const auto begin = Clock::now(); since(begin) < options_.duration;) {
      const long before = options_.allocationCount();
      (void)link.measure();
      (void)link.actuate(0.0);
      count += options_.allocationCount() - before;
      std::this_thread::sleep_for(std::chrono::duration<double>(options_.period));
    }
    demand(count == 0, std::to_string(count) + " allocations or releases");
    return "";
  }

  std::string takesTime() {
    Link link(library_, options_.address, options_.options);
    link.open();
    link.await(options_.period);
    std::vector<double> times_us;
    for (const auto begin = Clock::now(); since(begin) < options_.duration;) {
      times_us.push_back(tick(link));
      std::this_thread::sleep_for(std::chrono::duration<double>(options_.period));
    }
    std::sort(times_us.begin(), times_us.end());
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), "median %.1f us, p99 %.1f us, longest %.1f us",
                  times_us[times_us.size() / 2], times_us[times_us.size() * 99 / 100], times_us.back());
    return text.data();
  }

 private:
  // Return the time of a measurement and a command, us.
  static double tick(Link& link) {
    const auto start = Clock::now();
    (void)link.measure();
    (void)link.actuate(0.0);
    return 1e6 * since(start);
  }

  void requireValid(const EnamelMeasurement& m, double& last, int number) const {
    const std::string name = "sample " + std::to_string(number);
    demand(std::isfinite(m.time) && m.time > last,
           name + ": its time is " + formatNumber(m.time) + " s, the one before has " + formatNumber(last) + " s");
    last = m.time;
    const Measurement sample = measurementOf(m, mechanism_->joints());
    demand(sample.q.allFinite() && sample.rates.allFinite(), name + " is not finite");
    demand(!sample.applied || sample.applied->allFinite(), name + ": the applied effort is not finite");
    demand(!sample.gripper || std::isfinite(*sample.gripper), name + ": the gripper is not finite");
    demand(sample.heat >= 0.0 && sample.heat < 10.0,
           name + ": the heat is " + formatNumber(sample.heat) + ", must be a share of the limit of the motors");
    demand(sample.rates.cwiseAbs().maxCoeff() < kLargestSpeed,
           name + ": a rate is " + formatNumber(sample.rates.cwiseAbs().maxCoeff()) + "; are the units SI?");
    Kinematics kinematics = mechanism_->home();
    const Status status = mechanism_->track(sample.q, sample.rates, false, kinematics);
    demand(status == Status::ok, name + " is " + toString(status) + " on the device of the file; units and origin?");
  }

  const DriverLibrary& library_;
  const DriverConformanceOptions& options_;
  std::shared_ptr<const Mechanism> mechanism_;
};

constexpr Check<DriverChecks> kFirst[] = {
    {"describes itself the same way every time", &DriverChecks::describesItself},
    {"lists its devices, or gives the reason why it finds no device", &DriverChecks::listsDevices},
    {"refuses an unknown address, with a reason", &DriverChecks::refusesUnknownAddress},
    {"connects, and is inactive before open", &DriverChecks::connects},
    {"has a valid device file", &DriverChecks::hasDeviceFile},
};
constexpr Check<DriverChecks> kOpen[] = {
    {"measures finite samples in reach, with times that advance like the clock", &DriverChecks::measuresAtRest},
    {"refuses efforts that are not finite or for other joints", &DriverChecks::refusesBadEfforts},
    {"is inactive after close, and opens again", &DriverChecks::opensAgain},
};
constexpr Check<DriverChecks> kNoAllocation = {"allocates nothing in measure and actuate",
                                               &DriverChecks::allocatesNothing};
constexpr Check<DriverChecks> kDuration = {"time of measure and actuate (reported only)", &DriverChecks::takesTime};

}  // namespace
}  // namespace driver_conformance

bool checkDriver(const std::shared_ptr<const DriverLibrary>& library, const DriverConformanceOptions& options,
                 const std::function<void(const ConformanceResult&)>& report) {
  using namespace driver_conformance;
  DriverChecks checks(library, options);
  conformance::Suite<DriverChecks> suite(checks, report);
  if (!suite.run(kFirst)) return false;
  suite.run(kOpen);
  suite.runCounted(kNoAllocation, static_cast<bool>(options.allocationCount));
  return suite.run(kDuration);
}

}  // namespace enamel
