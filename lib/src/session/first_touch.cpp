#include "enamel/session/first_touch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>
#include <vector>

#include "core/message.hpp"
#include "device/inertia.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/core/error.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/runtime/recorder.hpp"
#include "session/first_touch_judge.hpp"

namespace enamel {
namespace {

using namespace trial;

constexpr double kRest = 1.0, kPush = 0.06, kAfter = 0.3, kWall = 4.0;  // s, of the steps
constexpr double kLongestWait = 4.0;                                    // s, until the handle is still
constexpr double kTremor = 1e-3, kTremorTurn = 0.02;                    // m, rad, of a handle that is held still
constexpr double kMostLost = 0.1;                                       // share of the ticks
constexpr double kClockError = 0.05;                                    // of the time stamps
constexpr double kShortestMove = 0.01, kLongestMove = 0.2;              // m, of a motion "by about 5 cm"
constexpr double kShortestTurn = 0.15, kLongestTurn = 1.5;              // rad, of a turn "by about 30 degrees"
constexpr double kStill = 1e-4;                                         // m
constexpr double kSmallPush = 0.1, kMediumPush = 0.5;                   // N
constexpr double kLever = 0.025;                                        // m: moments are the forces times this
constexpr double kGripperMove = 0.05;                                   // rad, of a gripper that is opened
constexpr double kUnfelt = 2e-4, kUnfeltTurn = 5e-3;                    // m, rad: less is friction or a firm hand
constexpr double kPlay = 5e-3, kPlayTurn = 0.1;                         // m, rad, by which the hand may move alone
constexpr double kMassFactor = 4.0;                                     // between the file and the measurement
constexpr int kDelayError = 2;                                          // ticks
constexpr double kSoftWall = 300.0;                                     // N/m

// Force on the handle and on the gripper.
struct Push {
  bool isOn = false;
  Vec6 wrench = Vec6::Zero();  // N, N m
  double gripper = 0.0;        // N
};

// Keeps every tick, and passes it on to a recorder. Pushes for kPush, after the handle was still for kAfter.
class Log final : public TickSink {
 public:
  /// `done` becomes true after the push.
  Log(std::size_t ticks, HapticTick& haptics, const Push& push, std::atomic<bool>& done)
      : haptics_(haptics), push_(push), done_(&done) {
    samples.reserve(ticks + 1000);
  }
  void before(Measurement& measurement) noexcept override {
    const double time = measurement.time;
    if (moved_ < 0.0) moved_ = time;
    if (begin_ < 0.0) first = samples.size();
    if (begin_ < 0.0 && time - moved_ >= kAfter) begin_ = time;
    const bool isOn = begin_ >= 0.0 && time < begin_ + kPush;
    isDone = push_.isOn && begin_ >= 0.0 && time >= begin_ + kPush + kAfter;
    if (isDone) *done_ = true;
    haptics_.setEffect(isOn ? push_.wrench : Vec6(Vec6::Zero()));
    haptics_.setGripper(isOn ? push_.gripper : 0.0);
  }
  void tick(const LoopTick& tick, const HapticTick& haptics) noexcept override {
    if (recorder != nullptr) recorder->tick(tick, haptics);
    if (samples.size() == samples.capacity()) return;
    const Measurement& m = tick.measurement;
    if (samples.empty() && m.age > 0) return;  // no sample yet
    const Kinematics& k = haptics.frame().kinematics;
    if (samples.empty()) home_ = tick.pose;
    Sample s;
    s.time = m.time;
    const Eigen::AngleAxisd turn(Mat3(tick.pose.rotation * home_.rotation.transpose()));
    s.place << tick.pose.position - home_.position, turn.angle() * turn.axis();
    s.rates = tick.twist;
    JointVector added = tick.command.effort;
    if (added.size() == k.gravity.size()) added -= k.gravity;
    if (k.q.size() == added.size()) s.wrench = wrenchOf(k, added);
    s.isNew = m.age == 0;
    s.isEnabled = m.enabled;
    s.buttons = m.buttons;
    s.conditions = m.conditions;
    s.gripper = m.gripper.value_or(0.0);
    s.hasGripper = m.gripper.has_value();
    s.depth = -tick.pose.position.z();
    samples.push_back(s);
    const Vec6 way = s.place - still_;
    if (way.head<3>().norm() > kTremor || way.tail<3>().norm() > kTremorTurn) {
      still_ = s.place;
      moved_ = s.time;
    }
    if (fault == GuardReason::none) fault = haptics.guard().fault();
    if (tick.mode == RenderMode::contact) ++contact;
  }

  std::vector<Sample> samples;
  Recorder* recorder = nullptr;
  GuardReason fault = GuardReason::none;
  int contact = 0;
  std::size_t first = 0;  // index of the first sample of the push
  bool isDone = false;    // the push, and kAfter

 private:
  HapticTick& haptics_;
  Push push_;
  std::atomic<bool>* done_;
  Pose home_;                           // at the first tick
  Vec6 still_ = Vec6::Zero();           // place of the last motion
  double moved_ = -1.0, begin_ = -1.0;  // s, of the last motion and of the push; negative: none yet
};

// The steps of one trial.
class Trial {
 public:
  Trial(OpenedDevice& opened, const FirstTouchOptions& options, const std::function<bool(const std::string&)>& ask)
      : opened_(opened),
        options_(options),
        ask_(ask),
        turns_(opened.mechanism && opened.mechanism->joints() == 6),
        hasMoments_(turns_ && opened.mechanism->limits().effort.minCoeff() > 0.0) {
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
    if (ticks < 2.0 || fresh < 2.0) {
      requireNoFault(log.fault, log.samples, false);
      throw Surprise{"the driver gives no samples"};
    }
    const double elapsed = log.samples.back().time - log.samples.front().time, wanted = (ticks - 1.0) / options_.rate;
    double noise = 0.0;
    for (const Sample& s : log.samples) noise = std::max(noise, s.place.head<3>().norm());
    hasGripper_ = log.samples.back().hasGripper;
    note(text("rest: %.1f %% of the samples lost, ", 100.0 * lost) +
         text("time stamps %.3f s in %.3f s, ", elapsed, wanted) + text("position within %.3f mm", 1e3 * noise));
    if (lost > kMostLost) throw Surprise{text("%.0f %% of the samples are missing", 100.0 * lost)};
    if (std::abs(elapsed - wanted) > kClockError * wanted)
      throw Surprise{text("the time stamps advance by %.3f s in %.3f s: is their unit s?", elapsed, wanted)};
    requireNoFault(log.fault, log.samples, false);
    return true;
  }

  bool buttons() {
    if (!confirm("Confirm, then press each button of the handle within " + formatNumber(options_.moveTime) +
                 " s. No force acts. Without buttons, wait."))
      return false;
    const Log log = runFree(options_.moveTime);
    std::uint32_t pressed = 0;
    for (const Sample& s : log.samples) pressed |= s.buttons;
    std::string line = "buttons pressed:";
    for (int i = 0; i < 32; ++i)
      if ((pressed >> static_cast<unsigned>(i) & 1U) != 0) line += " " + std::to_string(i);
    note(line + (pressed == 0 ? " none" : ""));
    requireNoFault(log.fault, log.samples, false);
    return true;
  }

  bool moves() {
    for (int direction = 0; direction < (turns_ ? 6 : 3); ++direction)
      if (!moved(direction)) return false;
    return true;
  }

  bool gripper() {
    if (!hasGripper_) return true;
    if (!confirm("Close the gripper. Confirm, then open it within " + formatNumber(options_.moveTime) +
                 " s. No force acts."))
      return false;
    const Log opens = runFree(options_.moveTime);
    const double way = opens.samples.back().gripper - opens.samples.front().gripper;
    note("opened the gripper: " + lengthText(way, true));
    requireNoFault(opens.fault, opens.samples, false);
    if (std::abs(way) < kGripperMove)
      throw Surprise{"the angle of the gripper changed by " + lengthText(way, true) + ": is its unit rad?"};
    if (way < 0.0)
      throw Surprise{"the angle of the gripper fell by " + lengthText(-way, true) + " while it opened: wrong sign"};
    if (!confirm("Hold the gripper loosely, half open. A force of " + formatNumber(kMediumPush) +
                 " N opens it for 60 ms."))
      return false;
    const Log pushed = push({true, Vec6::Zero(), kMediumPush});
    const double opened = pushed.samples[pushed.first + pushTicks()].gripper - pushed.samples[pushed.first].gripper;
    note("pushed the gripper open: " + lengthText(opened, true));
    if (opened < -kUnfeltTurn)
      throw Surprise{"the force closed the gripper by " + lengthText(-opened, true) + ": wrong sign of its force"};
    return true;
  }

  bool pushes() {
    for (const double size : {kSmallPush, kMediumPush, options_.largestForce})
      for (int direction = 0; direction < (hasMoments_ ? 6 : 3); ++direction) {
        const double force = isTurn(direction) ? kLever * size : size;
        if (!confirm("Hold the handle loosely in the middle. A " +
                     std::string(isTurn(direction) ? "moment of " : "force of ") + forceText(force, isTurn(direction)) +
                     " acts " + wordsOf(direction) + " for 60 ms."))
          return false;
        judgePush(push({true, force * Vec6::Unit(direction), 0.0}), force, direction, size);
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
  Log runFree(double duration, const Push& push = {}) {
    ImpedanceRenderer balance({kSoftWall, 0.0});  // touches nothing: balances gravity
    return run(balance, Scene(), duration, push, nullptr);
  }

  // Run the loop for `duration`, then let it ramp out.
  Log run(Renderer& renderer, const Scene& scene, double duration, const Push& push, const RecordingHeader* header) {
    const double period = 1.0 / options_.rate;
    GuardOptions guard = guardFor(*opened_.mechanism, period);
    guard.force = std::min(guard.force, options_.largestForce);
    // A push gives energy on purpose: at most its force over 0.2 m.
    if (scene.obstacles().empty()) guard.energy = std::max(guard.energy, options_.largestForce * kLongestMove);
    HapticTick haptics(*opened_.mechanism, scene, Tool(), renderer, guard);
    std::unique_ptr<Recorder> recorder;
    if (header != nullptr) recorder = std::make_unique<Recorder>(options_.recording, *header, haptics);
    std::atomic<bool> done{false};
    Log log(static_cast<std::size_t>(duration * options_.rate), haptics, push, done);
    log.recorder = recorder.get();
    HapticLoopOptions how;
    how.sink = &log;
    if (options_.isSimulated) {
      LoopBody body(*opened_.device, haptics, how);
      for (int i = 0; i < static_cast<int>(duration * options_.rate) && !done; ++i) (void)body.step();
      body.stop();
      while (body.step()) {
      }
    } else {
      how.period = opened_.poll;
      const HapticLoop loop(*opened_.device, haptics, how);
      const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(duration);
      while (!done && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (recorder) {
      const RecordingResult result = recorder->close();
      note("recording: " + options_.recording + ", " + std::to_string(result.ticks) + " ticks" +
           (result.problem.empty() ? "" : ", " + result.problem));
    }
    return log;
  }

  std::size_t pushTicks() const { return static_cast<std::size_t>(kPush * options_.rate); }

  // Wait until the handle is still, then push.
  Log push(const Push& push) {
    Log log = runFree(kLongestWait, push);
    requireNoFault(log.fault, log.samples, true);
    if (!log.isDone) throw Surprise{"the handle moved for " + formatNumber(kLongestWait) + " s: hold it still"};
    return log;
  }

  // Let the person move the handle in a direction.
  bool moved(int direction) {
    const bool turns = isTurn(direction);
    if (!confirm(std::string("Confirm, then ") + (turns ? "turn" : "move") + " the handle " + wordsOf(direction) +
                 (turns ? ", by about 30 degrees" : " by about 5 cm") + " within " + formatNumber(options_.moveTime) +
                 " s, and hold it there. No force acts."))
      return false;
    const Log log = runFree(options_.moveTime);
    const Vec6& end = log.samples.back().place;
    const Vec3 way = turns ? end.tail<3>() : end.head<3>();
    const double unit = turns ? 180.0 / M_PI : 1e3;
    note(std::string(turns ? "turned " : "moved ") + wordsOf(direction) + ": " +
         text("%.1f, %.1f, %.1f ", unit * way.x(), unit * way.y(), unit * way.z()) + (turns ? "deg" : "mm"));
    requireNoFault(log.fault, log.samples, false);
    if (!turns && way.norm() < kStill)
      throw Surprise{
          text("the position changed by only %.3g m: did you move the handle, is its unit m, and does the vendor's own "
               "program show it?",
               way.norm())};
    const std::string what = turns ? "the handle" : "the position";
    requireAlong(way, direction, what);
    const double shortest = turns ? kShortestTurn : kShortestMove, longest = turns ? kLongestTurn : kLongestMove;
    if (way.norm() < shortest || way.norm() > longest)
      throw Surprise{
          turns ? text("the orientation changed by %.4g rad instead of about 0.5 rad: is its unit rad?", way.norm())
                : text("the position changed by %.4g m instead of about 0.05 m: is its unit m?", way.norm())};
    requireRates(log.samples, turns, 1.0 / options_.rate);
    return true;
  }

  // Compare the motion with the push: size, axis, sign, apparent mass and delay.
  void judgePush(const Log& log, double force, int direction, double size) {
    const std::vector<Sample>& s = log.samples;
    const bool turns = isTurn(direction);
    const std::size_t first = log.first, length = pushTicks();
    // A hand that drifts is subtracted: its velocity before the push.
    const std::size_t before = first - std::min(first, length);
    const Vec6 drift = first > before ? Vec6((s[first].place - s[before].place) / static_cast<double>(first - before))
                                      : Vec6(Vec6::Zero());
    const Vec6 motion = s[first + length].place - s[first].place - static_cast<double>(length) * drift;
    const Vec3 end = turns ? motion.tail<3>() : motion.head<3>();
    const std::string name = "push of " + forceText(force, turns) + " " + wordsOf(direction);
    const double unit = turns ? 180.0 / M_PI : 1e3;
    note(name + ": " + text("%.2f, %.2f, %.2f ", unit * end.x(), unit * end.y(), unit * end.z()) +
         (turns ? "deg" : "mm"));
    const double step = opened_.mechanism->limits().encoderStep[direction], wanted = massOf(direction);
    // Friction and the hand make the motion smaller than that of the mass alone.
    const double most = kMassFactor * 0.5 * force / wanted * kPush * kPush + (turns ? kPlayTurn : kPlay);
    if (end.norm() > most)
      throw Surprise{name + " moved the handle by " + lengthText(end.norm(), turns) + ", at most " +
                     lengthText(most, turns) + " are plausible: unit of the forces, or the file?"};
    if (end.cwiseAbs().maxCoeff() < std::max(10.0 * step, turns ? kUnfeltTurn : kUnfelt)) {
      if (size > kMediumPush)
        throw Surprise{name + " moved the handle by only " + lengthText(end.norm(), turns) + ": unit of the forces?"};
      return;  // friction or a firm hand
    }
    requireAlong(end, direction, "the handle");
    if (size <= kSmallPush) return;

    const auto [mass, delay] = fit(s, first, length + length / 2, direction, step, drift, 1.0 / options_.rate);
    note("  " +
         text(turns ? "apparent inertia %.2g kg m^2 (file %.2g kg m^2), " : "apparent mass %.3f kg (file %.3f kg), ",
              mass, wanted) +
         "delay " + std::to_string(delay) + " ticks (stated " + std::to_string(opened_.delay.low) + " to " +
         std::to_string(opened_.delay.high) + ")");
    if (turns) return;  // the inertia of the hand's fingers is unknown
    if (!(mass > wanted / kMassFactor && mass < wanted * kMassFactor))
      throw Surprise{name + text(": the apparent mass is %.3f kg, the device file has %.3f kg: unit of the forces, or "
                                 "the file?",
                                 mass, wanted)};
    if (size <= kMediumPush) return;
    delays_.push_back(delay);
    if (delay < opened_.delay.low - kDelayError || delay > opened_.delay.high + kDelayError)
      throw Surprise{name + ": the delay is " + std::to_string(delay) + " ticks, stated are " +
                     std::to_string(opened_.delay.low) + " to " + std::to_string(opened_.delay.high)};
  }

  // The mass or inertia of the device file along a direction.
  double massOf(int direction) const {
    const Kinematics& home = opened_.mechanism->home();
    if (!isTurn(direction)) return effectiveMass(home, home.pose.position, Vec3::Unit(direction));
    const Vec6 axis = Vec6::Unit(direction);
    return 1.0 / axis.dot(inverseInertiaOf(home) * axis);
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
    const Log log = run(renderer, scene, kWall, {}, recording.empty() ? nullptr : &header);
    requireNoFault(log.fault, log.samples, true);
    double deepest = 0.0, largest = 0.0;
    for (const Sample& s : log.samples) {
      deepest = std::max(deepest, s.depth);
      largest = std::max(largest, s.wrench.head<3>().norm());
    }
    note(what +
         text(": %.0f ticks in contact, deepest %.2f mm, largest force %.2f N", log.contact, 1e3 * deepest, largest));
    return true;
  }

  OpenedDevice& opened_;
  const FirstTouchOptions& options_;
  const std::function<bool(const std::string&)>& ask_;
  bool turns_, hasMoments_, hasGripper_ = false;  // the device senses turns, has motors for them
  std::vector<int> delays_;                       // measured by the last pushes, ticks
};

}  // namespace

FirstTouchResult firstTouch(OpenedDevice& opened, const FirstTouchOptions& options,
                            const std::function<bool(const std::string& request)>& ask) {
  FirstTouchResult result;
  Trial trial(opened, options, ask);
  try {
    result.isComplete =
        trial.rest() && trial.buttons() && trial.moves() && trial.gripper() && trial.pushes() && trial.walls();
  } catch (const Surprise& surprise) {
    result.surprise = surprise.what;
    trial.report += "SURPRISE: " + surprise.what + "\n";
  }
  result.report = trial.report;
  return result;
}

}  // namespace enamel
