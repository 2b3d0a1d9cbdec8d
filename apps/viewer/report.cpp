#include "report.hpp"

#include <malloc.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "enamel/core/file.hpp"
#include "overlay_parts.hpp"
#include "run.hpp"

namespace enamel::viewer {
namespace {

long residentKilobytes() {
  std::ifstream file("/proc/self/statm");
  long total = 0, resident = 0;
  file >> total >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

// Return the results of test pushes with the names of study/metrics.hpp.
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
    json["K_d [N/m]"] = test.depthStiffness > 0.0 ? nlohmann::ordered_json(test.depthStiffness) : nullptr;
    list.push_back(std::move(json));
  }
  return list;
}

// Return what a connected device reports.
nlohmann::ordered_json deviceOf(const LiveDevice& live) {
  const Snapshot now = live.snapshot();
  const Measurement& m = now.tick.measurement;
  return {{"url", live.url()},
          {"lost", isLostIn(m, live.period())},
          {"fault", toString(now.fault)},
          {"enabled", now.enabled},
          {"forces cut", (m.conditions & kForcesCut) != 0},
          {"calibrated", (m.conditions & kUncalibrated) == 0},
          {"buttons", m.buttons},
          {"gripper [rad]", m.gripper ? nlohmann::ordered_json(*m.gripper) : nullptr},
          {"heat", m.heat}};
}

}  // namespace

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

void Report::frame(double time) {
  if (frames_++ == 0) firstFrame_ = steadySeconds() - started_;
  if (time - lastMemory_ >= 1.0 - 1e-9) measureMemory(time);
}

void Report::measureMemory(double time) {
  lastMemory_ = time;
  memoryAt_.push_back(time);
  memory_.push_back(residentKilobytes());
  const struct mallinfo2 heap = mallinfo2();
  heap_.push_back(static_cast<long>((heap.uordblks + heap.hblkhd) / 1024));
}

void Report::write(const std::string& path, double seconds, Viewer& viewer, const TimingNumbers& timing) const {
  if (path.empty()) return;
  nlohmann::ordered_json json;
  json["seconds"] = seconds;
  json["frames"] = frames_;
  json["size"] = {viewer.layout().size.x, viewer.layout().size.y};
  json["frames_per_second"] = seconds > 0.0 ? static_cast<double>(frames_) / seconds : 0.0;
  json["first_frame_s"] = firstFrame_;
  json["touring"] = viewer.isTouring();
  json["contact"] = viewer.isInContact();
  const RemovedVolume& removed = viewer.frame().drilled.removed;
  json["removed [m^3]"] = std::accumulate(removed.begin(), removed.end(), 0.0);
  json["paused"] = viewer.frame().paused;
  if (viewer.live() != nullptr) json["device"] = deviceOf(*viewer.live());
  json["open"] = nlohmann::ordered_json::array();
  const OverlayState& overlay = viewer.overlay();
  for (const auto& [open, name] : {std::pair(overlay.help, "help"), {overlay.list, "list"}, {overlay.timing, "timing"}})
    if (open) json["open"].push_back(name);
  const Camera& camera = viewer.camera();
  json["camera"] = {{"focus", {camera.focus.x, camera.focus.y, camera.focus.z}},
                    {"azimuth", camera.azimuth},
                    {"elevation", camera.elevation},
                    {"distance", camera.distance}};
  const Rect& scene = viewer.layout().scene;
  const glm::dvec3 tool = project(camera, {scene.width, scene.height}, viewer.tool());
  json["tool"] = {scene.x + tool.x, scene.y + tool.y};  // pixels
  const Vec3& hand = viewer.frame().hand.target;
  json["hand"] = {hand.x(), hand.y(), hand.z()};
  json["typing"] = ImGui::GetIO().WantTextInput ? overlay.typing.name : "";  // name of the slider
  const DisplayHistory& shown = viewer.history();
  json["shown"] = {{"scenes", shown.scenes},
                   {"choice of scenes", viewer.sceneNames()},
                   {"renderers", shown.renderers},
                   {"notices", shown.notices},
                   {"badges", shown.badges},
                   {"tips", shown.tips},
                   {"ratios", shown.ratios},
                   {"deepest [m]", shown.deepest},
                   {"stiffnesses", shown.stiffnesses},
                   {"stiffness [N/m]", overlay.settings.spring.stiffness},
                   {"delay [ticks]", overlay.settings.delay.high}};
  json["readouts"] = overlay.readouts;
  for (const auto& [name, at] : overlay.controls) json["controls"][name] = {at.x, at.y};
  json["opengl_errors"] = viewer.canvas().errors();
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

}  // namespace enamel::viewer
