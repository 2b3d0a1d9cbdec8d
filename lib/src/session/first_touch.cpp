#include "enamel/session/first_touch.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <thread>
#include <vector>

#include "core/message.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/core/error.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/runtime/recorder.hpp"

namespace enamel {
namespace {

constexpr double kRest = 1.0, kPush = 0.06, kAfter = 0.3, kWall = 4.0;  // s, of the steps
constexpr double kMostLost = 0.1;                                       // share of the ticks
constexpr double kClockError = 0.05;                                    // of the time stamps
constexpr double kShortestMove = 0.01, kLongestMove = 0.2;              // m, of a motion "by about 5 cm"
constexpr double kStill = 1e-4;                                         // m
constexpr double kSmallPush = 0.1, kMediumPush = 0.5;                   // N
constexpr double kMassFactor = 4.0;                                     // between the file and the measurement
constexpr int kDelayError = 2, kMostDelay = 12;                         // ticks
constexpr double kSoftWall = 300.0;                                     // N/m
const char* const kDirections[] = {"to the right", "up", "towards you"};

struct Surprise {
  std::string what;
};

std::string text(const char* format, double a, double b = 0.0, double c = 0.0) {
  std::array<char, 160> line{};
  std::snprintf(line.data(), line.size(), format, a, b, c);
  return line.data();
}

struct Sample {
  double time = 0.0;  // s, of the measurement
  Vec3 position = Vec3::Zero(), force = Vec3::Zero();
  bool isNew = false;
  std::uint32_t buttons = 0;
};

// Keeps every tick, and passes it on to a recorder. Pushes along an axis for kPush, after a pause at rest.
class Log final : public TickSink {
 public:
  Log(std::size_t ticks, HapticTick& haptics, const Vec3& push) : haptics_(haptics), push_(push) {
    samples.reserve(ticks + 1000);
  }
  void before(Measurement& measurement) noexcept override {
    if (first_ < 0.0) first_ = measurement.time;
    const double time = measurement.time - first_;
    Vec6 wrench = Vec6::Zero();
    if (time >= kAfter && time < kAfter + kPush) wrench.head<3>() = push_;
    haptics_.setEffect(wrench);
  }
  void tick(const LoopTick& tick, const HapticTick& haptics) noexcept override {
    if (recorder != nullptr) recorder->tick(tick, haptics);
    if (samples.size() == samples.capacity()) return;
    const Kinematics& k = haptics.frame().kinematics;
    JointVector added = tick.command.effort;
    if (added.size() == k.gravity.size()) added -= k.gravity;
    samples.push_back({tick.measurement.time, tick.pose.position,
                       k.q.size() == added.size() ? Vec3(wrenchOf(k, added).head<3>()) : Vec3(Vec3::Zero()),
                       tick.measurement.age == 0, tick.measurement.buttons});
    if (fault == GuardReason::none) fault = haptics.guard().fault();
    if (tick.mode == RenderMode::contact) ++contact;
  }

  std::vector<Sample> samples;
  Recorder* recorder = nullptr;
  GuardReason fault = GuardReason::none;
  int contact = 0;

 private:
  HapticTick& haptics_;
  Vec3 push_;            // N
  double first_ = -1.0;  // s, of the first tick; negative: none yet
};

// The steps of one trial.
class Trial {
 public:
  Trial(OpenedDevice& opened, const FirstTouchOptions& options, const std::function<bool(const std::string&)>& ask)
      : opened_(opened), options_(options), ask_(ask) {
    require(options.largestForce >= kMediumPush && options.largestForce <= 10.0,
            "first touch: the largest force is " + formatNumber(options.largestForce) + " N, must be in 0.5 to 10 N");
  }

  bool rest() {
    if (!confirm("Lay the handle down or hold it still. No force acts.")) return false;
    const Log log = runFree(kRest);
    const auto fresh = static_cast<double>(
        std::count_if(log.samples.begin(), log.samples.end(), [](const Sample& s) { return s.isNew; }));
    const auto ticks = static_cast<double>(log.samples.size());
    const double lost = ticks > 0.0 ? 1.0 - fresh / ticks : 1.0;
    const double elapsed = log.samples.back().time - log.samples.front().time, wanted = (ticks - 1.0) / options_.rate;
    Vec3 low = log.samples[0].position, high = low;
    for (const Sample& s : log.samples) low = low.cwiseMin(s.position), high = high.cwiseMax(s.position);
    note(text("rest: %.1f %% of the samples lost, ", 100.0 * lost) +
         text("time stamps %.3f s in %.3f s, ", elapsed, wanted) +
         text("position within %.3f mm", 1e3 * (high - low).maxCoeff()));
    if (lost > kMostLost) throw Surprise{text("%.0f %% of the samples are missing", 100.0 * lost)};
    if (std::abs(elapsed - wanted) > kClockError * wanted)
      throw Surprise{text("the time stamps advance by %.3f s in %.3f s: is their unit s?", elapsed, wanted)};
    requireNoFault(log);
    return true;
  }

  bool moves() {
    for (int axis = 0; axis < 3; ++axis) {
      if (!confirm(std::string("Confirm, then move the handle ") + kDirections[axis] + " by about 5 cm within " +
                   formatNumber(options_.moveTime) + " s, and hold it there. No force acts."))
        return false;
      const Log log = runFree(options_.moveTime);
      const Vec3 way = log.samples.back().position - log.samples.front().position;
      std::uint32_t buttons = 0;
      for (const Sample& s : log.samples) buttons |= s.buttons;
      note(std::string("moved ") + kDirections[axis] + ": " +
           text("%.1f, %.1f, %.1f mm", 1e3 * way.x(), 1e3 * way.y(), 1e3 * way.z()) + ", buttons " +
           std::to_string(buttons));
      requireNoFault(log);
      if (way.norm() < kStill)
        throw Surprise{
            "the position did not change: did you move the handle, and does the vendor's own program show "
            "its position?"};
      requireAlong(way, axis, "position", kDirections[axis]);
      if (way.norm() < kShortestMove || way.norm() > kLongestMove)
        throw Surprise{text("the position changed by %.4g m instead of about 0.05 m: is its unit m?", way.norm())};
    }
    return true;
  }

  bool pushes() {
    for (const double force : {kSmallPush, kMediumPush, options_.largestForce})
      for (int axis = 0; axis < 3; ++axis) {
        if (!confirm("Hold the handle loosely in the middle. A force of " + formatNumber(force) + " N acts " +
                     kDirections[axis] + " for 60 ms."))
          return false;
        judgePush(runFree(2.0 * kAfter + kPush, force * Vec3::Unit(axis)), force, axis);
      }
    return true;
  }

  bool walls() {
    const double period = 1.0 / options_.rate;
    ImpedanceRenderer soft({kSoftWall, 0.0});
    if (!wall(soft, kImpedance, {{"stiffness", formatNumber(kSoftWall)}}, "a soft wall of 300 N/m", "")) return false;
    const auto [lowest, highest] = std::minmax_element(delays_.begin(), delays_.end());
    const int low = *lowest, high = *highest;
    note("position control assumes the measured delay; add the option delay=" + toText({low, high}) + " to the URL");
    PositionControlRenderer hard(positionControlFor(*opened_.mechanism, period, low, high));
    return wall(hard, kPositionControl, {{"delay", std::to_string(low)}, {"delay-high", std::to_string(high)}},
                "a hard wall", options_.recording);
  }

  std::string report;

 private:
  void note(const std::string& line) { report += line + "\n"; }
  bool confirm(const std::string& request) {
    if (ask_(request)) return true;
    note("ended by the person before: " + request);
    return false;
  }

  // Run the loop without a wall.
  Log runFree(double duration, const Vec3& push = Vec3::Zero()) {
    ImpedanceRenderer balance({kSoftWall, 0.0});  // touches nothing: balances gravity
    return run(balance, Scene(), duration, push, nullptr);
  }

  // Run the loop for `duration`, then let it ramp out.
  Log run(Renderer& renderer, const Scene& scene, double duration, const Vec3& push, const RecordingHeader* header) {
    const double period = 1.0 / options_.rate;
    GuardOptions guard = guardFor(*opened_.mechanism, period);
    guard.force = std::min(guard.force, options_.largestForce);
    // A push gives energy on purpose: at most its force over 0.2 m.
    if (scene.obstacles().empty()) guard.energy = std::max(guard.energy, options_.largestForce * kLongestMove);
    HapticTick haptics(*opened_.mechanism, scene, Tool(), renderer, guard);
    std::unique_ptr<Recorder> recorder;
    if (header != nullptr) recorder = std::make_unique<Recorder>(options_.recording, *header, haptics);
    Log log(static_cast<std::size_t>(duration * options_.rate), haptics, push);
    log.recorder = recorder.get();
    HapticLoopOptions how;
    how.sink = &log;
    if (options_.isSimulated) {
      LoopBody body(*opened_.device, haptics, how);
      for (int i = 0; i < static_cast<int>(duration * options_.rate); ++i) (void)body.step();
      body.stop();
      while (body.step()) {
      }
    } else {
      how.period = opened_.poll;
      const HapticLoop loop(*opened_.device, haptics, how);
      std::this_thread::sleep_for(std::chrono::duration<double>(duration));
    }
    if (recorder) {
      const RecordingResult result = recorder->close();
      note("recording: " + options_.recording + ", " + std::to_string(result.ticks) + " ticks" +
           (result.problem.empty() ? "" : ", " + result.problem));
    }
    return log;
  }

  static void requireNoFault(const Log& log) {
    if (log.fault != GuardReason::none)
      throw Surprise{std::string("the guard stopped the loop: ") + toString(log.fault)};
  }

  // Throw Surprise unless a motion is mainly along an axis, forwards.
  static void requireAlong(const Vec3& way, int axis, const std::string& what, const char* direction) {
    int main = 0;
    const double size = way.cwiseAbs().maxCoeff(&main);
    constexpr char kNames[] = {'x', 'y', 'z'};
    if (main != axis)
      throw Surprise{"the " + what + " moved along " + kNames[main] + " by " + text("%.2f mm", 1e3 * way[main]) +
                     ", expected " + kNames[axis] + " (" + direction + "): wrong axis"};
    if (way[axis] < 0.0)
      throw Surprise{"the " + what + " moved along " + kNames[axis] + " by " + text("%.2f mm", -1e3 * size) +
                     ", expected forwards (" + direction + "): wrong sign"};
  }

  // Compare the motion with the push: axis, sign, apparent mass and delay.
  void judgePush(const Log& log, double force, int axis) {
    requireNoFault(log);
    const std::vector<Sample>& s = log.samples;
    const auto isPushed = [](const Sample& sample) { return sample.force.norm() > 0.03; };
    const auto first = static_cast<std::size_t>(std::find_if(s.begin(), s.end(), isPushed) - s.begin());
    const auto length = static_cast<std::size_t>(kPush * options_.rate);
    if (first == s.size() || first + length + length / 2 >= s.size())
      throw Surprise{"the push of the loop did not act"};
    // A hand that drifts is subtracted: its velocity before the push.
    const std::size_t before = first - std::min(first, length);
    const Vec3 drift = first > before
                           ? Vec3((s[first].position - s[before].position) / static_cast<double>(first - before))
                           : Vec3(Vec3::Zero());
    const auto motion = [&](std::size_t i) {
      return Vec3(s[first + i].position - s[first].position - static_cast<double>(i) * drift);
    };
    const Vec3 end = motion(length);
    const std::string name = text("push of %.1f N ", force) + kDirections[axis];
    note(name + ": " + text("%.2f, %.2f, %.2f mm", 1e3 * end.x(), 1e3 * end.y(), 1e3 * end.z()));
    const double step = opened_.mechanism->limits().encoderStep[axis];
    if (end.cwiseAbs().maxCoeff() < std::max(10.0 * step, 2e-4)) {
      if (force > kMediumPush) throw Surprise{name + " moved the handle by less than 0.2 mm: unit of the forces?"};
      return;  // friction or a firm hand
    }
    requireAlong(end, axis, "handle", kDirections[axis]);
    if (force <= kMediumPush) return;

    const auto [mass, delay] = fit(s, first, length + length / 2, axis, step, motion);
    const Kinematics& home = opened_.mechanism->home();
    const double wanted = effectiveMass(home, home.pose.position, Vec3::Unit(axis));
    note("  " + text("apparent mass %.3f kg (file %.3f kg), ", mass, wanted) + "delay " + std::to_string(delay) +
         " ticks (stated " + std::to_string(opened_.delay.low) + " to " + std::to_string(opened_.delay.high) + ")");
    delays_.push_back(delay);
    if (!(mass > wanted / kMassFactor && mass < wanted * kMassFactor))
      throw Surprise{name + text(": the apparent mass is %.3f kg, the device file has %.3f kg: unit of the forces, or "
                                 "the file?",
                                 mass, wanted)};
    if (delay < opened_.delay.low - kDelayError || delay > opened_.delay.high + kDelayError)
      throw Surprise{name + ": the delay is " + std::to_string(delay) + " ticks, stated are " +
                     std::to_string(opened_.delay.low) + " to " + std::to_string(opened_.delay.high)};
  }

  struct Fit {
    double mass = 0.0;  // kg
    int delay = 0;      // ticks
  };

  // Fit m x'' = F - b x' - k x - f: damping and stiffness of the hand, friction of the device, integrated twice. F is
  // delayed; f acts once the handle moves. Choose the delay with the smallest residual. The motion after the push
  // separates the force from the friction.
  template <typename Motion>
  Fit fit(const std::vector<Sample>& s, std::size_t first, std::size_t length, int axis, double step,
          const Motion& motion) const {
    Fit best;
    double smallest = std::numeric_limits<double>::infinity();
    const double period = 1.0 / options_.rate;
    for (int d = 0; d <= kMostDelay; ++d) {
      Eigen::Vector4d once = Eigen::Vector4d::Zero(), twice = once;  // integrals of F, -x', -x and -1
      Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
      Eigen::Vector4d right = Eigen::Vector4d::Zero();
      double own = 0.0;
      for (std::size_t i = 1; i <= length; ++i) {
        const std::size_t now = first + i - 1, source = now - std::min(now, static_cast<std::size_t>(d));
        const double x = motion(i)[axis], before = motion(i - 1)[axis];
        const Eigen::Vector4d rate(s[source].force[axis], 0.0, -0.5 * (x + before), std::abs(x) > step ? -1.0 : 0.0);
        twice += period * (once + 0.5 * period * rate);
        once += period * rate;
        twice[1] -= period * 0.5 * (x + before);
        normal += twice * twice.transpose();
        right += x * twice;
        own += x * x;
      }
      const Eigen::Vector4d solution = normal.ldlt().solve(right);
      const double residual = own - right.dot(solution);
      if (!(residual < smallest)) continue;
      smallest = residual;
      best = {1.0 / solution[0], d};
    }
    return best;
  }

  bool wall(Renderer& renderer, const char* name, const std::map<std::string, std::string>& parameters,
            const std::string& what, const std::string& recording) {
    if (!confirm("Hold the handle in front of the middle of the workspace. Confirm, then push slowly away from you, "
                 "against " +
                 what + ", for 4 s. At most " + formatNumber(options_.largestForce) + " N act."))
      return false;
    const Scene scene = flatWall();
    RecordingHeader header;
    header.deviceFile = opened_.file.empty() ? opened_.mechanism->name() : opened_.file;
    header.deviceText = opened_.text;
    nameRenderer(name, "", parameters, scene, header);
    const Log log = run(renderer, scene, kWall, Vec3::Zero(), recording.empty() ? nullptr : &header);
    requireNoFault(log);
    double deepest = 0.0, largest = 0.0;
    for (const Sample& s : log.samples) {
      deepest = std::max(deepest, -s.position.z());
      largest = std::max(largest, s.force.norm());
    }
    note(what +
         text(": %.0f ticks in contact, deepest %.2f mm, largest force %.2f N", log.contact, 1e3 * deepest, largest));
    return true;
  }

  OpenedDevice& opened_;
  const FirstTouchOptions& options_;
  const std::function<bool(const std::string&)>& ask_;
  std::vector<int> delays_;  // measured by the last pushes, ticks
};

}  // namespace

FirstTouchResult firstTouch(OpenedDevice& opened, const FirstTouchOptions& options,
                            const std::function<bool(const std::string& request)>& ask) {
  FirstTouchResult result;
  Trial trial(opened, options, ask);
  try {
    result.isComplete = trial.rest() && trial.moves() && trial.pushes() && trial.walls();
  } catch (const Surprise& surprise) {
    result.surprise = surprise.what;
    trial.report += "SURPRISE: " + surprise.what + "\n";
  }
  result.report = trial.report;
  return result;
}

}  // namespace enamel
