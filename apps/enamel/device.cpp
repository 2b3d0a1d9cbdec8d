#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <numeric>
#include <optional>
#include <thread>

#include "commands.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/identify/device_text.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/runtime/udp_device.hpp"
#include "enamel/session/first_touch.hpp"
#include "enamel/session/open_device.hpp"
#include "enamel/session/session.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/simulated_device.hpp"
#include "program/interrupt.hpp"
#include "program/outputs.hpp"
#include "program/plugin_folder.hpp"

namespace enamel::app {
namespace {

struct DeviceOptions {
  bool overwrite = false, spin = false;
  std::string serve, connect, firstTouch, output = "first-touch", scene, key, record, learnt,
                                          renderer = kPositionControl;
  ServeOptions server;
  double rate_Hz = 1000.0, duration = 0.0, force = kUnlimited;
};

// Wait for an interruption or for `duration` s; 0: until an interruption.
void wait(double duration, const std::function<void()>& step = {}) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  while (interruption() == 0 &&
         (duration == 0.0 || std::chrono::duration<double>(Clock::now() - begin).count() < duration)) {
    if (step) step();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

constexpr const char* kHow = " (lib/docs/device.md, \"Settings of the system\")";

void print(const char* name, const DurationHistogram& h) {
  fmt::print("{:<28} p50 {:>8.1f}  p99 {:>8.1f}  p99.9 {:>8.1f}  max {:>8.1f} us  ({})\n", name, 1e6 * h.quantile(0.5),
             1e6 * h.quantile(0.99), 1e6 * h.quantile(0.999), 1e6 * h.largest(), h.count());
}

void print(const PeriodicTiming& timing) {
  fmt::print(
      "periods {}, missed {}, scheduling {}\n", timing.periods.load(), timing.missed.load(),
      timing.realtime.load() ? "real-time" : "normal: the system refused the real-time class" + std::string(kHow));
  print("wake-up error", timing.wakeUp);
  print("compute time of a period", timing.compute);
}

std::string firstLineOf(const char* file) {
  std::string line;
  std::ifstream input(file);
  std::getline(input, line);
  return line;
}

// Print what the driver knows about this device.
void printFacts(const OpenedDevice& opened) {
  if (!opened.facts.empty()) fmt::print("device: {}\n", opened.facts);
}

// Print the settings of Linux that are missing, as the page names them.
void printMissingSettings() {
  constexpr const char* kIsolated = "/sys/devices/system/cpu/isolated";
  if (!std::ifstream(kIsolated)) return;
  std::string missing;
  const auto require = [&](bool isThere, const char* setting) {
    if (!isThere) missing += (missing.empty() ? "" : "; ") + std::string(setting);
  };
  const std::string governor = firstLineOf("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  require(!firstLineOf(kIsolated).empty(), "a core without other work");
  require(governor.empty() || governor == "performance", "full clock rate");
  require(firstLineOf("/sys/kernel/realtime") == "1", "bounded waits in the kernel");
  if (!missing.empty()) fmt::print("settings that are missing: {}{}\n", missing, kHow);
}

void print(const LinkCounts& counts, const char* trip) {
  fmt::print("datagrams sent {}, accepted {}", counts.sent.load(), counts.accepted.load());
  for (int i = 0; i < kDropReasons; ++i)
    if (const std::uint64_t n = counts.dropped[static_cast<std::size_t>(i)]; n > 0)
      fmt::print(", dropped ({}) {}", toString(static_cast<DropReason>(i)), n);
  fmt::print("\n");
  print(trip, counts.roundTrip);
}

// A hand that moves in and out along z with a period of 2 s, from 5 mm in front of home to 20 mm behind it. It is soft
// enough for a wall to stop it.
WrenchFunction scriptedHand() {
  return [](double time, const Pose& pose, const Vec6& twist) {
    constexpr Grip grip{400.0, 12.0};
    const double turn = M_PI * time;
    const double z = 0.005 - 0.0125 * (1.0 - std::cos(turn)), speed = -0.0125 * M_PI * std::sin(turn);
    Vec6 wrench = guidingWrench(pose, twist, Pose{}, Vec3::UnitZ());
    wrench[2] -= grip.stiffness * (pose.position.z() - z) + grip.damping * (twist[2] - speed);
    return wrench;
  };
}

// A hand that presses with 1 N and wanders over 8 x 8 mm, so that a bur always finds new material.
WrenchFunction drillingHand(const Pose& start) {
  return [start, press = pressingHand(start)](double time, const Pose& pose, const Vec6& twist) {
    constexpr double kAside = 4e-3, kTurn = 0.9, kOtherTurn = 0.57;  // m, rad/s
    Vec6 wrench = press(time, pose, twist);
    wrench[0] += kGuideGrip.stiffness * kAside * std::sin(kTurn * time);
    wrench[1] += kGuideGrip.stiffness * kAside * std::sin(kOtherTurn * time);
    return wrench;
  };
}

void serve(const DeviceOptions& options) {
  OpenDeviceOptions how;
  how.period = 1.0 / options.rate_Hz;
  how.start.emplace().position.z() = 0.005;
  how.hand = scriptedHand();
  how.pluginFolder = pluginFolder();
  const OpenedDevice opened = openDevice(options.serve, how);
  ServeOptions server = options.server;
  server.period = how.period;
  const InterruptGuard interruptions(InterruptGuard::Second::isIgnored);
  const DeviceServer serving(*opened.device, *opened.mechanism, server);
  fmt::print("{} at {}:{}, {} Hz, {}\n", opened.mechanism->name(), server.address, serving.port(), options.rate_Hz,
             server.link.key ? "with a key" : "without a key");
  std::fflush(stdout);
  wait(options.duration);
  print(serving.timing());
  print(serving.counts(), "measurement to command");
}

// Counts ticks by the guard's reason, and keeps what the device reported.
class Tally {
 public:
  void count(const Measurement& m) noexcept {
    if (m.age > 0) return;
    buttons_ |= m.buttons;
    heat_ = std::max(heat_, m.heat);
    if ((m.conditions & kForcesCut) != 0) ++cut_;
    if ((m.conditions & kUncalibrated) != 0) ++uncalibrated_;
    if (!m.gripper) return;
    narrow_ = std::min(narrow_, *m.gripper);
    wide_ = std::max(wide_, *m.gripper);
  }

  void count(const TickFrame& frame) noexcept {
    ++reasons_[static_cast<std::size_t>(frame.reason)];
    if (frame.reason == GuardReason::none) force_ = std::max(force_, frame.output.normalForce);
    if (frame.output.mode == RenderMode::contact) ++contact_;
  }

  void print() const {
    fmt::print("ticks in contact {}, largest force {:.2f} N; ticks by reason of the guard:", contact_, force_);
    for (std::size_t i = 0; i < reasons_.size(); ++i)
      if (reasons_[i] > 0) fmt::print(" {} {},", toString(static_cast<GuardReason>(i)), reasons_[i]);
    fmt::print("\nbuttons pressed:{}", buttons_ == 0 ? " none" : "");
    for (unsigned i = 0; i < 32; ++i)
      if ((buttons_ >> i & 1U) != 0) fmt::print(" {}", i);
    if (narrow_ <= wide_) fmt::print("; gripper {:.3f} to {:.3f} rad", narrow_, wide_);
    if (heat_ > 0.0) fmt::print("; hottest motor {:.0f} % of its limit", 100.0 * heat_);
    if (cut_ > 0) fmt::print("; forces cut by the device in {} ticks", cut_);
    if (uncalibrated_ > 0) fmt::print("; not calibrated in {} ticks", uncalibrated_);
    fmt::print("\n");
  }

 private:
  std::array<std::uint64_t, kGuardReasons> reasons_{};
  std::uint64_t contact_ = 0, cut_ = 0, uncalibrated_ = 0;
  double force_ = 0.0, heat_ = 0.0, narrow_ = HUGE_VAL, wide_ = -HUGE_VAL;
  std::uint32_t buttons_ = 0;
};

// Count the lines of the standard input. The thread ends with the input or the program.
std::shared_ptr<std::atomic<int>> countLines() {
  auto lines = std::make_shared<std::atomic<int>>(0);
  std::thread([lines] {
    for (std::string line; std::getline(std::cin, line);) ++*lines;
  }).detach();
  return lines;
}

// Watch a session until the end: print what happens to the device. Enter continues after a fault of the guard.
void watch(Session& session, const std::string& url, double duration) {
  const auto lines = countLines();
  std::uint32_t conditions = 0;
  int taken = 0;
  const auto begin = std::chrono::steady_clock::now();
  const auto say = [&](const std::string& what) {
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
    fmt::print("{:.2f} s: {}: {}\n", time.count(), url, what);
    std::fflush(stdout);
  };
  const auto step = [&] {
    const Snapshot now = session.snapshot();
    for (SessionEvent event; session.nextEvent(event);) {
      if (event.kind == EventKind::guardStop)
        say(std::string("stopped by the guard: ") + toString(event.reason) + "; Enter continues");
      if (event.kind == EventKind::deviceLost) say("lost; waiting for it");
      if (event.kind == EventKind::deviceBack) say("back; Enter continues");
    }
    for (const DeviceCondition each : {kForcesCut, kUncalibrated})
      if (((now.tick.measurement.conditions ^ conditions) & each) != 0)
        say(std::string(toString(each)) + ((conditions & each) != 0 ? ": no longer" : ""));
    conditions = now.tick.measurement.conditions;
    if (taken == lines->load()) return;
    taken = lines->load();
    session.reset();
  };
  wait(duration, step);
}

void connect(const DeviceOptions& options) {
  SessionDef def;
  def.device = parseDeviceUrl(options.connect).text;  // not a file
  def.scene = options.scene;
  def.renderer = options.renderer;
  def.pluginFolder = pluginFolder();
  def.rate = options.rate_Hz;
  def.maxForce = options.force;
  Tally tally;
  bool hasTicked = false;
  const PositionControlRenderer* control = nullptr;
  std::optional<PositionControlState> learnt;  // in the last contact; the end of the loop resets the renderer
  def.beforeTick = [&](TickAccess& access) {
    tally.count(access.measurement());
    if (hasTicked) tally.count(access.frame());
    if (hasTicked && control != nullptr && access.frame().output.mode == RenderMode::contact) learnt = control->state();
    hasTicked = true;
  };
  Session session(def);
  for (const std::string& note : session.notes()) fmt::print(stderr, "{}\n", note);
  if (options.scene.empty()) (void)session.add({flatWall().obstacles()[0]});
  if (!options.record.empty()) {
    removeOld(options.record, options.overwrite);
    session.record(options.record);
  }
  if (options.spin && session.haptics().drill() == nullptr) throw Error(options.scene + ": --spin needs a table [bur]");
  session.spin(options.spin);
  control = dynamic_cast<const PositionControlRenderer*>(&session.haptics().renderer());
  const InterruptGuard interruptions(InterruptGuard::Second::isIgnored);
  if (options.spin && parseDeviceUrl(options.connect).scheme == kVirtualScheme)
    session.start(makeVirtualDevice(session, drillingHand(session.start())));
  else
    session.startOpened();
  const HapticLoop& loop = *session.loop();
  const Delay delay = session.opened().delay;
  fmt::print("{} at {}: {}, delay {} ticks, memory {}\n", session.mechanism().name(), options.connect, options.renderer,
             toText(delay), loop.memoryLocked() ? "locked" : "not locked: the system refused" + std::string(kHow));
  printFacts(session.opened());
  printMissingSettings();
  std::fflush(stdout);
  watch(session, options.connect, options.duration == 0.0 ? 10.0 : options.duration);
  const GuardReason fault = session.snapshot().fault;
  print(loop.timing());
  print("age of the command", loop.age());
  fmt::print("periods without a new measurement {}, commands not sent {}\n", loop.held(), loop.unsent());
  session.stop();
  if (const auto* udp = dynamic_cast<const UdpDevice*>(session.opened().device.get()))
    print(udp->counts(), "command to measurement");
  if (!options.record.empty()) {
    const RecordingResult recorded = session.stopRecording();
    if (!recorded.problem.empty()) throw Error(fmt::format("{} ({} ticks are lost)", recorded.problem, recorded.lost));
    fmt::print("recording: {}, {} ticks, {} lost\n", options.record, recorded.ticks, recorded.lost);
  }
  tally.count(session.haptics().frame());
  tally.print();
  if (learnt) {
    fmt::print("position control learnt:\n{}", tableOf(*learnt));
    if (learnt->delayLow != delay.low || learnt->delayHigh != delay.high)
      fmt::print("the stated delay is {} ticks: measure it with --first-touch\n", toText(delay));
  }
  if (!options.learnt.empty()) {
    if (!learnt) throw Error("--learnt: nothing is learnt without a contact of position control");
    writeFile(options.learnt, learntText(session.opened().text, *learnt));
    fmt::print("device file: {}\n", options.learnt);
  }
  if (options.spin) {
    const RemovedVolume removed = session.snapshot().removed;
    fmt::print("removed {:.3f} mm^3\n", 1e9 * std::accumulate(removed.begin(), removed.end(), 0.0));
  }
  if (const Guard& seen = session.haptics().guard(); seen.ignoredReports() > 0)
    fmt::print("reports of the torque that acted: {} ignored; those of joint {} do not follow the commands\n",
               seen.ignoredReports(), seen.ignoredJoint());
  if (fault != GuardReason::none) throw Error(std::string("stopped by the guard: ") + toString(fault));
}

// Show a request. Enter continues; a text or the end of the input ends the trial.
bool confirmed(const std::string& request) {
  fmt::print("\n{}\n[Enter: continue, any text: end] ", request);
  std::fflush(stdout);
  std::string answer;
  return std::getline(std::cin, answer) && answer.empty();
}

void touchFirst(const DeviceOptions& options) {
  const std::string report = options.output + "/report.txt";
  FirstTouchOptions trial;
  trial.rate = options.rate_Hz;
  trial.largestForce = std::min(options.force, trial.largestForce);
  trial.recording = options.output + "/wall.rec";
  std::filesystem::create_directories(std::filesystem::u8path(options.output));
  for (const std::string& file : {report, trial.recording}) {
    requireFree(file, options.overwrite);
    removeOld(file, options.overwrite);
  }
  OpenDeviceOptions how;
  how.period = 1.0 / options.rate_Hz;
  how.pluginFolder = pluginFolder();
  OpenedDevice opened = openDevice(options.firstTouch, how);
  fmt::print("{} at {}. Keep the emergency stop within reach.\n", opened.mechanism->name(), options.firstTouch);
  printFacts(opened);
  const FirstTouchResult result = firstTouch(opened, trial, confirmed);
  const std::string text =
      fmt::format("{} at {}, enamel {}\n{}{}", opened.mechanism->name(), options.firstTouch, ENAMEL_VERSION,
                  opened.facts.empty() ? "" : "device: " + opened.facts + "\n", result.report);
  writeFile(report, text);
  fmt::print("\n{}report: {}\n", text, report);
  if (!result.surprise.empty()) throw Error("stopped at the first surprise: " + result.surprise);
  if (!result.isComplete) throw Error("the trial is not complete");
}

void run(DeviceOptions options) {
  const auto given = {!options.serve.empty(), !options.connect.empty(), !options.firstTouch.empty()};
  if (std::count(given.begin(), given.end(), true) != 1)
    throw Error("give one of --serve URL, --connect URL and --first-touch URL");
  if (!options.key.empty()) options.server.link.key = readKey(options.key);
  if (!options.firstTouch.empty()) return touchFirst(options);
  options.serve.empty() ? connect(options) : serve(options);
}

}  // namespace

void addDevice(CLI::App& app) {
  auto options = std::make_shared<DeviceOptions>();
  CLI::App* command = app.add_subcommand(
      "device",
      "Uses a device: --connect runs a haptic loop on it; --serve gives it to a loop in another process or machine, "
      "over\nUDP. Both print statistics at the end. enamel devices lists the URLs. The protocol: lib/docs/device.md.");
  CLI::Option* serve = command->add_option("--serve", options->serve,
                                           "URL of the device to serve until --duration or a signal; virtual: is the "
                                           "nominal TAU, moved by a simulated hand");
  CLI::Option* connect = command->add_option("--connect", options->connect, "URL of the device to run");
  CLI::Option* touch = command->add_option(
      "--first-touch", options->firstTouch,
      "URL of a device to try for the first time: small forces, each confirmed by you; stops at the first surprise");
  command->add_option("--output", options->output, "folder for the report and the recording of --first-touch")
      ->capture_default_str()
      ->needs(touch);
  command->add_option("--port", options->server.port, "port of the server; 0: any free port")
      ->capture_default_str()
      ->needs(serve);
  command->add_option("--bind", options->server.address, "address of the server; any other than 127.0.0.1 needs --key")
      ->capture_default_str()
      ->needs(serve);
  command
      ->add_option("--key", options->key,
                   "file with the key of the server and its clients, 32 hexadecimal digits; clients have it in the URL")
      ->needs(serve);
  command->add_option("--rate", options->rate_Hz, "rate of the device's ticks, Hz, the same on both sides")
      ->check(CLI::Range(500.0, 10000.0))
      ->capture_default_str();
  command->add_option("--duration", options->duration, "duration, s; 0: --serve runs without end, --connect 10 s")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  command->add_option("--renderer", options->renderer, "renderer, as in enamel push")
      ->capture_default_str()
      ->needs(connect);
  CLI::Option* scene =
      command->add_option("--scene", options->scene, "scene file (TOML); default: the wall z = 0")->needs(connect);
  command
      ->add_flag("--spin", options->spin,
                 "run the bur of the scene; a virtual device is then held by a hand that wanders and presses with 1 N")
      ->needs(scene);
  command->add_option("--record", options->record, "file for the recording, for enamel replay and enamel export")
      ->needs(connect);
  command
      ->add_option("--learnt", options->learnt,
                   "file for a proposal at the end: the device file with the masses and cables that position control "
                   "has learnt")
      ->needs(connect);
  command
      ->add_option("--max-force", options->force,
                   "largest force of the renderer on the tool, limited by the guard, N; with --first-touch 2 or less")
      ->default_str("no limit")
      ->excludes(serve);
  addOverwrite(*command, options->overwrite, {"--record", "--learnt"});
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
