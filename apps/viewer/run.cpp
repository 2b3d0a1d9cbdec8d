// The two loops that drive a viewer: a person's in a window, a script's without a display.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>
#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "clip.hpp"
#include "enamel/core/file.hpp"
#include "input.hpp"
#include "offscreen/png.hpp"
#include "viewer.hpp"

namespace enamel::viewer {
namespace {

constexpr double kFrame = 1.0 / 60.0;  // s

// ---- pictures and the report -------------------------------------------------------------------------------------

std::string picturePath(const Options& options, const std::string& name) {
  const std::filesystem::path folder = options.record.empty() ? "." : options.record;
  if (!name.empty()) return (folder / (name + ".png")).string();
  for (int i = 1;; ++i) {
    char free[32];
    std::snprintf(free, sizeof(free), "enamel-%03d.png", i);
    if (!std::filesystem::exists(folder / free)) return (folder / free).string();
  }
}

void takePictures(const Options& options, Viewer& viewer, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const std::string path = picturePath(options, name);
    const Picture picture = viewer.stage().read();
    offscreen::writePng(picture.size.x, picture.size.y, picture.rgb.data(), path);
    std::printf("%s\n", path.c_str());
    std::fflush(stdout);
  }
}

// The clip that a viewer wants, and the film of the last one.
class ClipMaker {
 public:
  explicit ClipMaker(const Options& options) : folder_(options.record.empty() ? "." : options.record) {}

  /// Before a picture: whether the clip needs it.
  bool begin(Viewer& viewer, double now) {
    if (film_.valid() && film_.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
      tell(viewer, film_.get());
    if (viewer.wantsClip() && !clip_) guarded(viewer, [&] { clip_.emplace(folder_, now); });
    if (!viewer.wantsClip() && clip_) end(viewer);
    viewer.showClip(clip_ ? clip_->seconds(now) : -1.0);
    return clip_ && clip_->wants(now);
  }

  /// After it was drawn.
  void add(Viewer& viewer, double now) {
    guarded(viewer, [&] { clip_->add(now, viewer.stage().read()); });
  }

  /// At the end of the program.
  void finish(Viewer& viewer) {
    if (clip_) end(viewer);
    if (film_.valid()) tell(viewer, film_.get());
  }

 private:
  template <typename Function>
  void guarded(Viewer& viewer, const Function& function) {
    try {
      function();
    } catch (const Error& error) {
      viewer.notify(error.what());
      viewer.endClip();
    }
  }
  void end(Viewer& viewer) {
    if (film_.valid()) tell(viewer, film_.get());
    film_ = filmOf(*clip_);
    clip_.reset();
  }
  static void tell(Viewer& viewer, const std::string& text) {
    viewer.notify(text);
    std::printf("%s\n", text.c_str());
    std::fflush(stdout);
  }

  std::string folder_;
  std::optional<Clip> clip_;
  std::future<std::string> film_;
};

// What is under way when the program ends.
void finish(Viewer& viewer, ClipMaker& clip) {
  clip.finish(viewer);
  if (const std::string recorded = viewer.endRecording(); !recorded.empty()) std::printf("%s\n", recorded.c_str());
}

long residentKilobytes() {
  std::ifstream file("/proc/self/statm");
  long total = 0, resident = 0;
  file >> total >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

TimingNumbers numbersOf(const PeriodicTiming& timing, double framesPerSecond) {
  TimingNumbers n;
  n.available = true;
  n.realtime = timing.realtime;
  n.wakeMedian = timing.wakeUp.quantile(0.5);
  n.wakeHigh = timing.wakeUp.quantile(0.999);
  n.computeMedian = timing.compute.quantile(0.5);
  n.computeHigh = timing.compute.quantile(0.999);
  n.computeLargest = timing.compute.largest();
  n.periods = timing.periods;
  n.missed = timing.missed;
  n.framesPerSecond = framesPerSecond;
  for (const auto& [shares, histogram] : {std::pair(&n.interval, &timing.interval), {&n.compute, &timing.compute}}) {
    const double all = std::max(1.0, static_cast<double>(histogram->count()));
    double low = TimingNumbers::kShortest;
    for (float& share : *shares) {
      const double high = low * std::exp2(0.25);
      share = static_cast<float>(static_cast<double>(histogram->count(low, high)) / all);
      low = high;
    }
  }
  return n;
}

// While it lives, SIGINT and SIGTERM only ask the loop to end, and SIGUSR1 asks it for a report.
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

  /// The signal that ends the loop, or 0.
  int caught() const { return caught_; }

  /// Whether a report was asked for since the last call.
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

// What test pushes measured, with the names of study/metrics.hpp.
nlohmann::ordered_json testPushes(const Viewer& viewer) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < viewer.rendererNames().size(); ++i) {
    const TestPush& test = viewer.frame().tests[i];
    if (!test.made) continue;
    const bool judged = test.status == Status::ok || test.status == Status::stopped;
    nlohmann::ordered_json json = {{"renderer", viewer.rendererNames()[i]},
                                   {"status", toString(test.status)},
                                   {"first impact", judged ? nlohmann::ordered_json(toString(test.verdict)) : nullptr},
                                   {"shown", shownText(test)}};
    const bool measured = test.verdict == FirstImpactVerdict::measured;
    json["D_z1 [m]"] = measured ? nlohmann::ordered_json(test.depth) : nullptr;
    json["K_z1 [N/m]"] = measured ? nlohmann::ordered_json(test.stiffness) : nullptr;
    list.push_back(std::move(json));
  }
  return list;
}

// What a run was like, for tests and for people who tune.
class Report {
 public:
  explicit Report(double started) : started_(started) {}

  std::uint64_t frames() const { return frames_; }

  /// After a picture; `time` is the run's, s.
  void frame(double time) {
    if (frames_++ == 0) firstFrame_ = steadySeconds() - started_;
    if (time - lastMemory_ >= 1.0 - 1e-9) measureMemory(time);
  }

  void measureMemory(double time) {
    lastMemory_ = time;
    memoryAt_.push_back(time);
    memory_.push_back(residentKilobytes());
    const struct mallinfo2 heap = mallinfo2();
    heap_.push_back(static_cast<long>((heap.uordblks + heap.hblkhd) / 1024));
  }

  void write(const std::string& path, double seconds, Viewer& viewer, const TimingNumbers& timing) const {
    if (path.empty()) return;
    nlohmann::ordered_json json;
    json["seconds"] = seconds;
    json["frames"] = frames_;
    json["size"] = {viewer.layout().size.x, viewer.layout().size.y};
    json["frames_per_second"] = seconds > 0.0 ? static_cast<double>(frames_) / seconds : 0.0;
    json["first_frame_s"] = firstFrame_;
    json["touring"] = viewer.isTouring();
    json["contact"] = viewer.isInContact();
    json["paused"] = viewer.frame().paused;
    json["typing"] = ImGui::GetIO().WantTextInput ? viewer.overlay().typedInto : "";  // the slider's name
    const Seen& seen = viewer.seen();
    json["shown"] = {{"scenes", seen.scenes},
                     {"choice of scenes", viewer.sceneNames()},
                     {"renderers", seen.renderers},
                     {"notices", seen.notices},
                     {"badges", seen.badges},
                     {"tips", seen.tips},
                     {"deepest [m]", seen.deepest},
                     {"stiffnesses", seen.stiffnesses},
                     {"stiffness [N/m]", viewer.overlay().settings.spring.stiffness},
                     {"delay [ticks]", viewer.overlay().settings.delay.high}};
    for (const auto& [name, at] : viewer.overlay().controls) json["controls"][name] = {at.x, at.y};
    json["opengl_errors"] = viewer.stage().errors();
    json["dropped_samples"] = viewer.frame().droppedSamples;
    json["test_pushes"] = testPushes(viewer);
    json["memory_at_s"] = memoryAt_;
    json["resident_kB"] = memory_;
    json["heap_in_use_kB"] = heap_;
    if (timing.available)
      json["haptics"] = {{"realtime_class", timing.realtime},
                         {"periods", timing.periods},
                         {"missed", timing.missed},
                         {"wake_up_us", {{"p50", 1e6 * timing.wakeMedian}, {"p99.9", 1e6 * timing.wakeHigh}}},
                         {"compute_us",
                          {{"p50", 1e6 * timing.computeMedian},
                           {"p99.9", 1e6 * timing.computeHigh},
                           {"max", 1e6 * timing.computeLargest}}}};
    writeFile(path, json.dump(1) + '\n');
  }

 private:
  double started_, firstFrame_ = 0.0, lastMemory_ = -1.0;
  std::uint64_t frames_ = 0;
  std::vector<double> memoryAt_;     // s of the run
  std::vector<long> memory_, heap_;  // once a second, and with each report
};

// Steps of a script that are due.
class ScriptPlayer {
 public:
  explicit ScriptPlayer(const Options& options) {
    if (!options.script.empty())
      steps_ = loadScript(options.script,
                          options.play.empty() ? rendererNames(options.plugin.get()) : std::vector<std::string>{});
  }

  template <typename Function>
  void play(double now, const Function& follow) {
    for (; next_ < steps_.size() && steps_[next_].time <= now + 1e-9; ++next_) follow(steps_[next_]);
  }

 private:
  std::vector<ScriptStep> steps_;
  std::size_t next_ = 0;
};

// ---- input -------------------------------------------------------------------------------------------------------

Input& inputOf(GLFWwindow* window) { return *static_cast<Input*>(glfwGetWindowUserPointer(window)); }

void onKey(GLFWwindow* window, int key, int, int action, int modifiers) {
  if (!ImGui::GetIO().WantTextInput) inputOf(window).key(key, action, modifiers);
}

void onButton(GLFWwindow* window, int button, int action, int modifiers) {
  if (action == GLFW_RELEASE || !ImGui::GetIO().WantCaptureMouse) inputOf(window).button(button, action, modifiers);
}

void onCursor(GLFWwindow* window, double x, double y) { inputOf(window).cursor({x, y}); }

void onDrop(GLFWwindow* window, int count, const char** paths) { inputOf(window).drop({paths, paths + count}); }

bool isDown(GLFWwindow* window, int key) { return glfwGetKey(window, key) == GLFW_PRESS; }

void onWheel(GLFWwindow* window, double, double notches) {
  if (!ImGui::GetIO().WantCaptureMouse)
    inputOf(window).wheel(notches, isDown(window, GLFW_KEY_LEFT_CONTROL) || isDown(window, GLFW_KEY_RIGHT_CONTROL));
}

void makeFolder(const std::string& path) {
  if (path.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (!std::filesystem::is_directory(path)) throw Error(path + ": cannot make the folder for pictures");
}

// Dear ImGui's part of a window; ends before the stage does. ImGui 1.86 looks at the keys once a picture: what was
// pressed and released since the last one is released one picture later, or an Enter would be lost now and then.
class WindowInput {
 public:
  explicit WindowInput(GLFWwindow* window) : window_(window) {
    ImGui_ImplGlfw_InitForOpenGL(window, true);
    behind_ = glfwSetKeyCallback(window, onAnyKey);
  }
  ~WindowInput() { ImGui_ImplGlfw_Shutdown(); }
  WindowInput(const WindowInput&) = delete;
  WindowInput& operator=(const WindowInput&) = delete;

  /// Before the events of a picture.
  void begin() {
    pressed_.clear();
    for (const Key& key : std::exchange(released_, {}))
      behind_(window_, key.key, key.scancode, GLFW_RELEASE, key.modifiers);
  }

 private:
  struct Key {
    int key, scancode, modifiers;
  };
  static void onAnyKey(GLFWwindow* window, int key, int scancode, int action, int modifiers) {
    if (action == GLFW_PRESS) pressed_.push_back(key);
    if (action == GLFW_RELEASE && std::find(pressed_.begin(), pressed_.end(), key) != pressed_.end())
      released_.push_back({key, scancode, modifiers});
    else
      behind_(window, key, scancode, action, modifiers);
  }

  GLFWwindow* window_;
  static inline GLFWkeyfun behind_ = nullptr;  // ImGui's, and then ours
  static inline std::vector<int> pressed_;     // since begin()
  static inline std::vector<Key> released_;    // to be told at the next one
};

}  // namespace

int runInWindow(const Options& options, double started) {
  Signals signals;
  ScriptPlayer script(options);
  makeFolder(options.record);
  const auto surface = openWindow("Enamel", options.size);
  Viewer viewer(options, *surface);
  GLFWwindow* window = surface->window();
  Input input(viewer);
  glfwSetWindowUserPointer(window, &input);
  glfwSetKeyCallback(window, onKey);
  glfwSetMouseButtonCallback(window, onButton);
  glfwSetCursorPosCallback(window, onCursor);
  glfwSetScrollCallback(window, onWheel);
  glfwSetDropCallback(window, onDrop);
  WindowInput imgui(window);

  Report report(started);
  ClipMaker clip(options);
  const double begin = steadySeconds();
  double last = begin, rate = 0.0;
  if (options.script.empty() && viewer.canTour() && isFirstStart()) viewer.act(Action::tour);
  {
    std::optional<PeriodicThread> haptics;
    if (Runner* const runner = viewer.runner()) haptics.emplace(kPeriod, [runner] { runner->period(); });
    const auto timing = [&] { return haptics ? numbersOf(haptics->timing(), rate) : TimingNumbers{}; };
    bool scripted = false;
    while (glfwWindowShouldClose(window) == GLFW_FALSE && !viewer.wantsToEnd() && signals.caught() == 0) {
      const bool reports = signals.takeReportWanted();  // before the events: the report is of a picture that knows them
      imgui.begin();
      glfwPollEvents();
      const double now = steadySeconds(), passed = now - last;
      last = now;
      if (passed > 0.0) rate += 0.1 * (1.0 / passed - rate);
      const double time = options.fixedStep ? static_cast<double>(report.frames()) / options.frameRate : now - begin;
      script.play(time, [&](const ScriptStep& step) {
        viewer.follow(step, time);
        surface->setFullScreen(viewer.fullScreen());  // before a step that sets the size
        scripted = scripted || step.kind == ScriptStep::Kind::end;
      });
      if (!ImGui::GetIO().WantTextInput)
        input.hold([window](int key) { return isDown(window, key); }, std::min(passed, 0.1));
      surface->setFullScreen(viewer.fullScreen());
      viewer.update(time, timing());
      ImGui_ImplGlfw_NewFrame();
      const std::vector<std::string> names = viewer.takePictures();
      const bool clipped = clip.begin(viewer, time);
      viewer.draw(!names.empty());
      takePictures(options, viewer, names);
      if (clipped) clip.add(viewer, time);
      surface->present();
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
  if (signals.caught() != 0) return signals.caught();
  if (viewer.runner() == nullptr) return 0;
  if (viewer.isTouring()) return 0;  // nobody's hand
  if (viewer.isInContact())
    throw Error("the window was closed while the tool was in contact: the wall was gone at once");
  return 0;
}

int runHeadless(const Options& options, double started) {
  if (options.script.empty()) throw Error("--headless needs --script FILE: there is nobody to drive");
  Signals signals;
  ScriptPlayer script(options);
  makeFolder(options.record);
  const auto surface = openHeadless(options.size, options.scale);
  Viewer viewer(options, *surface);
  ImGui::GetIO().DeltaTime = static_cast<float>(kFrame);
  Report report(started);
  ClipMaker clip(options);
  const double begin = steadySeconds();
  const auto ticksAt = [](std::uint64_t frame) { return frame * 1000 / 60; };  // of kPeriod in frames of kFrame
  int recorded = 0, recordEvery = 0;
  for (std::uint64_t frame = 0; !viewer.wantsToEnd() && signals.caught() == 0; ++frame) {
    const double now = static_cast<double>(frame) * kFrame;
    script.play(now, [&](const ScriptStep& step) {
      if (step.kind == ScriptStep::Kind::frames)
        recordEvery = step.number == 0 ? 0 : std::max(1, 60 / step.number);
      else
        viewer.follow(step, now);
    });
    viewer.update(now, TimingNumbers{});
    std::vector<std::string> names = viewer.takePictures();
    if (recordEvery > 0 && frame % static_cast<std::uint64_t>(recordEvery) == 0) {
      char name[32];
      std::snprintf(name, sizeof(name), "frame-%05d", recorded++);
      names.emplace_back(name);
    }
    const bool clipped = clip.begin(viewer, now);
    if (!names.empty() || clipped) {
      viewer.draw(true);
      takePictures(options, viewer, names);
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
