#define GLFW_INCLUDE_NONE
#include "run.hpp"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <thread>

#include "capture.hpp"
#include "enamel/core/error.hpp"
#include "program/outputs.hpp"
#include "report.hpp"
#include "window_input.hpp"

namespace enamel::viewer {
namespace {

constexpr double kFrame = 1.0 / 60.0;  // s

// While it exists, SIGINT and SIGTERM end the loop instead of the program, and SIGUSR1 requests a report.
class Signals {
 public:
  Signals() {
    caught_ = reportWanted_ = 0;
    struct sigaction action {};
    action.sa_handler = [](int number) { (number == SIGUSR1 ? reportWanted_ : caught_) = number; };
    action.sa_flags = SA_RESTART;
    for (std::size_t i = 0; i < std::size(kSignals); ++i) sigaction(kSignals[i], &action, &before_[i]);
  }
  ~Signals() {
    for (std::size_t i = 0; i < std::size(kSignals); ++i) sigaction(kSignals[i], &before_[i], nullptr);
  }
  Signals(const Signals&) = delete;
  Signals& operator=(const Signals&) = delete;

  /// Return the signal that ends the loop, or 0.
  int caught() const { return caught_; }

  /// Return whether a report was requested since the last call.
  bool takeReportWanted() {
    if (reportWanted_ == 0) return false;
    reportWanted_ = 0;
    return true;
  }

 private:
  static constexpr int kSignals[] = {SIGINT, SIGTERM, SIGUSR1};
  static volatile std::sig_atomic_t caught_, reportWanted_;
  struct sigaction before_[std::size(kSignals)]{};
};
volatile std::sig_atomic_t Signals::caught_ = 0, Signals::reportWanted_ = 0;

// Complete recordings and clips at the end of the program.
void finish(Viewer& viewer, ClipMaker& clip) {
  clip.finish(viewer);
  if (const std::string recorded = viewer.endRecording(); !recorded.empty()) std::printf("%s\n", recorded.c_str());
}

void requireFree(const Options& options, const std::string& picture) {
  app::requireFree((std::filesystem::path(options.folder()) / (picture + ".png")).string(), options.overwrite);
}

std::string frameName(int number) {
  char name[32];
  std::snprintf(name, sizeof(name), "frame-%05d", number);
  return name;
}

// Runs due steps of a script. In a window, a step that takes a picture ends the turn. Otherwise the concurrent haptic
// loop would already perform the steps after it before the picture is drawn.
class ScriptPlayer {
 public:
  explicit ScriptPlayer(const Options& options) : isHeadless_(options.headless) {
    if (!options.script.empty())
      steps_ = loadScript(options.script,
                          options.play.empty() ? rendererNames(options.plugin.get()) : std::vector<std::string>{});
    for (const ScriptStep& step : steps_) {
      if (step.kind == ScriptStep::Kind::picture) requireFree(options, step.name);
      if (step.kind == ScriptStep::Kind::frames) requireFree(options, frameName(0));  // from an earlier run
    }
  }

  template <typename Function>
  void play(double now, const Function& follow) {
    for (bool pictured = false; !pictured && next_ < steps_.size() && steps_[next_].time <= now + 1e-9; ++next_) {
      follow(steps_[next_]);
      pictured = !isHeadless_ && steps_[next_].kind == ScriptStep::Kind::picture;
    }
  }

 private:
  bool isHeadless_;
  std::vector<ScriptStep> steps_;
  std::size_t next_ = 0;
};

// Synchronises a script of fixed steps with the haptic loop: each step waits until the loop has run for the same time,
// even on a slow machine.
class HapticPace {
 public:
  explicit HapticPace(double step) : ticks_(static_cast<std::uint64_t>(step / kPeriod)) {}

  void wait(const PeriodicThread& haptics, const Signals& signals) {
    while (haptics.timing().periods < due_ && signals.caught() == 0)
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    due_ = haptics.timing().periods + ticks_;
  }

 private:
  std::uint64_t ticks_, due_ = 0;
};

void makeFolder(const std::string& path) {
  if (path.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!std::filesystem::is_directory(path)) throw Error(path + ": cannot create the folder for pictures");
}

}  // namespace

double steadySeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

namespace {

// Show one scene or recording after another in a window, until a person, a script or a signal ends it. A dropped
// recording replaces the experiment, and a dropped scene or scan a recording: `next` becomes its path.
int showInWindow(const Options& options, WindowSurface& surface, Signals& signals, double started, std::string& next) {
  ScriptPlayer script(options);
  Viewer viewer(options, surface);
  Input target(viewer);
  WindowInput input(surface.window(), target);

  Report report(started);
  ClipMaker clip(options.folder());
  const double begin = steadySeconds();
  double last = begin, rate = 0.0;
  if (options.script.empty() && viewer.canTour() && isFirstStart()) viewer.act(Action::tour);
  {
    std::optional<PeriodicThread> haptics;
    if (Runner* const runner = viewer.runner()) haptics.emplace(kPeriod, [runner] { runner->period(); });
    const auto timing = [&] {
      if (viewer.live() != nullptr) return numbersOf(viewer.live()->timing(), rate);
      return haptics ? numbersOf(haptics->timing(), rate) : TimingNumbers{};
    };
    bool scripted = false;
    HapticPace pace(1.0 / options.frameRate);
    while (glfwWindowShouldClose(surface.window()) == GLFW_FALSE && !viewer.wantsToEnd() && signals.caught() == 0 &&
           viewer.wantsToOpen().empty()) {
      const bool reports = signals.takeReportWanted();  // before the events, so that the reported picture includes them
      input.poll();
      if (options.fixedStep && haptics) pace.wait(*haptics, signals);
      const double now = steadySeconds(), passed = now - last;
      last = now;
      if (passed > 0.0) rate += 0.1 * (1.0 / passed - rate);
      const double time = options.fixedStep ? static_cast<double>(report.frames()) / options.frameRate : now - begin;
      script.play(time, [&](const ScriptStep& step) {
        viewer.follow(step, time);
        surface.setFullScreen(viewer.fullScreen());  // before a step that sets the size
        scripted = scripted || step.kind == ScriptStep::Kind::end;
      });
      input.hold(std::min(passed, 0.1));
      surface.setFullScreen(viewer.fullScreen());
      viewer.update(time, timing());
      ImGui_ImplGlfw_NewFrame();
      const std::vector<std::string> names = viewer.takePictures();
      const bool clipped = clip.begin(viewer, time);
      viewer.draw(!names.empty());
      writePictures(options.folder(), viewer, names);
      if (clipped) clip.add(viewer, time);
      surface.present();
      report.frame(time);
      if (scripted) break;
      if (reports) {
        report.measureMemory(time);
        report.write(options.report, steadySeconds() - begin, viewer, timing());
      }
      const double spare = 1.0 / options.frameRate - (steadySeconds() - now);
      if (spare > 0.0) std::this_thread::sleep_for(std::chrono::duration<double>(spare));
    }
    report.write(options.report, steadySeconds() - begin, viewer, timing());
    haptics.reset();
    finish(viewer, clip);
    if (scripted) return 0;
  }
  next = viewer.wantsToOpen();
  return signals.caught();
}

}  // namespace

int runInWindow(const Options& options, double started) {
  Signals signals;
  makeFolder(options.record);
  Options shown = options;
  std::string next;
  if (!options.script.empty()) ScriptPlayer check(options);  // before a window opens
  const auto surface = openWindow("Enamel", options.size);
  for (int status = 0;;) {
    next.clear();
    status = showInWindow(shown, *surface, signals, started, next);
    if (status != 0 || next.empty()) return status;
    shown.script.clear();
    shown.play = isRecording(next) ? next : "";
    if (shown.play.empty()) shown.scene = next;
  }
}

int runHeadless(const Options& options, double started) {
  if (options.script.empty()) throw Error("--headless needs --script FILE, which moves the hand");
  Signals signals;
  ScriptPlayer script(options);
  makeFolder(options.record);
  const auto surface = openHeadless(options.size, options.scale);
  Viewer viewer(options, *surface);
  ImGui::GetIO().DeltaTime = static_cast<float>(kFrame);
  Report report(started);
  ClipMaker clip(options.folder());
  const double begin = steadySeconds();
  const auto ticksAt = [](std::uint64_t frame) { return frame * 1000 / 60; };  // ticks of kPeriod in frames of kFrame
  int recorded = 0, recordEvery = 0;
  for (std::uint64_t frame = 0; !viewer.wantsToEnd() && signals.caught() == 0; ++frame) {
    const double now = static_cast<double>(frame) * kFrame;
    if (viewer.live() != nullptr)  // a device runs in real time
      std::this_thread::sleep_for(std::chrono::duration<double>(begin + now - steadySeconds()));
    script.play(now, [&](const ScriptStep& step) {
      if (step.kind == ScriptStep::Kind::frames)
        recordEvery = step.number == 0 ? 0 : std::max(1, 60 / step.number);
      else
        viewer.follow(step, now);
    });
    viewer.update(now, TimingNumbers{});
    std::vector<std::string> names = viewer.takePictures();
    if (recordEvery > 0 && frame % static_cast<std::uint64_t>(recordEvery) == 0) names.push_back(frameName(recorded++));
    const bool clipped = clip.begin(viewer, now);
    if (!names.empty() || clipped) {
      viewer.draw(true);
      writePictures(options.folder(), viewer, names);
      if (clipped) clip.add(viewer, now);
      report.frame(now);
    }
    if (signals.takeReportWanted()) report.write(options.report, steadySeconds() - begin, viewer, TimingNumbers{});
    if (viewer.runner() == nullptr) continue;
    for (std::uint64_t tick = ticksAt(frame); tick < ticksAt(frame + 1); ++tick) viewer.runner()->period();
  }
  finish(viewer, clip);
  report.write(options.report, steadySeconds() - begin, viewer, TimingNumbers{});
  return signals.caught();
}

}  // namespace enamel::viewer
