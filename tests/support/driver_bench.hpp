// Shared by tests of drivers: the stand-in of a vendor's library, and a device that ticks in real time.
#pragma once

#include <dlfcn.h>

#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "enamel/plugin/driver_conformance.hpp"
#include "enamel/session/open_device.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/eventually.hpp"

namespace enamel::test {

/// The stand-in in this process; the driver opens the same library. `vendor` begins the names of its functions.
class StandIn {
 public:
  StandIn(const std::string& library, const std::string& vendor)
      : handle_(dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    REQUIRE(handle_ != nullptr);
    set_ = find<void(const char*, double)>(vendor + "StandIn");
    force_ = find<double(int)>(vendor + "StandInForce");
  }
  ~StandIn() { dlclose(handle_); }
  StandIn(const StandIn&) = delete;
  StandIn& operator=(const StandIn&) = delete;

  void set(const char* what, double value) const { set_(what, value); }
  /// Hold the device with the hand: place, W, m; N/m, N s/m.
  void hold(const Vec3& place, double stiffness, double damping) const {
    set("place-x", place.x());
    set("place-y", place.y());
    set("place-z", place.z());
    set("stiffness", stiffness);
    set("damping", damping);
  }
  double force(int axis) const { return force_(axis); }  ///< in the axes of the vendor
  Vec3 force() const { return {force(0), force(1), force(2)}; }

  template <typename Function>
  Function* find(const std::string& name) const {
    return reinterpret_cast<Function*>(dlsym(handle_, name.c_str()));
  }

 private:
  void* handle_;
  void (*set_)(const char*, double);
  double (*force_)(int);
};

/// Open a device with the drivers in ENAMEL_PLUGINS.
inline OpenedDevice openAt(const std::string& url) {
  OpenDeviceOptions options;
  options.pluginFolder = ENAMEL_PLUGINS;
  return openDevice(url, options);
}

/// A device that runs until the end of the scope. Each tick sends the command.
struct DriverBench {
  OpenedDevice opened;
  Measurement sample;
  Command command{JointVector::Zero(opened.mechanism->joints())};

  explicit DriverBench(const std::string& url) : opened(openAt(url)) { opened.device->open(); }
  ~DriverBench() { opened.device->close(); }
  DriverBench(const DriverBench&) = delete;
  DriverBench& operator=(const DriverBench&) = delete;

  Status tick() {
    (void)opened.device->actuate(command);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return opened.device->measure(sample);
  }
  bool soon(const std::function<bool()>& isTrue) {
    return eventually([&] { return tick() == Status::ok && isTrue(); });
  }
};

/// The driver keeps its contract with this library, in this process.
inline void checkContract(const std::string& driver, const std::string& library) {
  DriverConformanceOptions options;
  options.options = {{"library", library}};
  options.duration = 0.1;
  std::string failed;
  CHECK(checkDriver(findDriver(driver, ENAMEL_PLUGINS), options, [&](const ConformanceResult& result) {
    if (result.verdict == ConformanceResult::Verdict::failed) failed += result.what + ": " + result.detail + "\n";
  }));
  CHECK(failed.empty());
}

/// The same by the command, which also counts allocations.
inline void checkByCommand(const std::string& driver, const std::string& address) {
  const CommandResult check = run("check-driver " + driver + " '" + address + "'");
  INFO(check.output);
  CHECK(check.status == 0);
#ifndef ENAMEL_SANITIZED
  CHECK_THAT(check.output, ContainsSubstring("passed       allocates nothing in measure and actuate"));
#endif
}

/// `enamel device` prints what a stand-in reports. `state`: as ENAMEL_STAND_IN.
inline void checkReported(const std::string& state, const std::string& url, const std::vector<std::string>& lines) {
  const CommandResult result = runCommand("ENAMEL_STAND_IN='" + state + "' '" ENAMEL_TOOL "' device --connect '" + url +
                                          "' --duration 0.5 < /dev/null");
  INFO(result.output);
  for (const std::string& line : lines) CHECK_THAT(result.output, ContainsSubstring(line));
}

}  // namespace enamel::test
