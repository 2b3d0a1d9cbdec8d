#include "enamel/identify/excitation.hpp"

#include <algorithm>
#include <cmath>

#include "core/message.hpp"
#include "core/toml.hpp"
#include "enamel/core/file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/sim/random.hpp"
#include "identify/device_model.hpp"

namespace enamel {
namespace {

using identify::kComSpread;
using identify::kGravitySpread;

constexpr int kSlowLines = 8, kFastLines = 40;
constexpr double kSlowest = 0.15, kSlowEnd = 3.0, kFastBegin = 4.0;  // Hz
constexpr double kFastEnd = 0.4;                                     // of the tick rate
constexpr double kHold = 2.0;                                        // Hz, least of the spring that follows the path
constexpr double kCalm = 4.0;                                        // of the hold's frequency: damping acts below
constexpr double kRamp = 1.0;                                        // s, at the beginning and the end
constexpr double kRelease = 0.1;                                     // s, in which the hold fades at the end
constexpr double kTurn = 0.15;                                       // rad, of the slow part
constexpr double kFreeTurn = 0.5;                                    // of kTurn, outside the path
constexpr double kFollow = 0.3;                                      // of the largest force, for the slow part

// A sum of sines and its first two derivatives.
Vec3 motionOf(const std::vector<Sine>& sines, double time) noexcept {
  Vec3 sum = Vec3::Zero();
  for (const Sine& s : sines) {
    const double rate = 2.0 * M_PI * s.frequency, angle = rate * time + s.phase, sine = std::sin(angle);
    sum += s.amplitude * Vec3(sine, rate * std::cos(angle), -rate * rate * sine);
  }
  return sum;
}

double sumOf(const std::vector<Sine>& sines, double time) noexcept { return motionOf(sines, time)[0]; }

// Largest value of a derivative of a sum of sines during a run.
double peakOf(const std::vector<Sine>& sines, double duration, int derivative) {
  double peak = 0.0;
  for (double time = 0.0; time < duration; time += 0.05)
    peak = std::max(peak, std::abs(motionOf(sines, time)[derivative]));
  return 1.1 * peak + 1e-12;
}

void scale(std::vector<Sine>& sines, double factor) {
  for (Sine& s : sines) s.amplitude *= factor;
}

bool reaches(const Mechanism& mechanism, const Vec3& corner, double turn) {
  Kinematics there;
  for (int signs = 0; signs < 8; ++signs) {
    const Vec3 sign(signs & 1 ? -1.0 : 1.0, signs & 2 ? -1.0 : 1.0, signs & 4 ? -1.0 : 1.0);
    const Pose pose{corner.cwiseProduct(sign), rotationFromVector(turn / std::sqrt(3.0) * sign)};
    if (mechanism.reach(pose, Vec6::Zero(), true, there) != Status::ok) return false;
  }
  return true;
}

// Half widths of a box that the device reaches, with turns.
Vec3 boxOf(const Mechanism& mechanism, double turn) {
  Vec3 box;
  for (int axis = 0; axis < 3; ++axis) {
    double length = 0.3;
    while (length > 1e-3 && !reaches(mechanism, length * Vec3::Unit(axis), 0.0)) length *= 0.95;
    box[axis] = length;
  }
  while (box.maxCoeff() > 1e-3 && !reaches(mechanism, box, turn)) box *= 0.95;
  require(box.minCoeff() > 1e-3, "\"" + mechanism.name() + "\" reaches no box of 1 mm around home");
  return box;
}

// Sines with frequencies between those of the other axes.
std::vector<Sine> sines(int count, double begin, double end, double shift, const RandomStream& random, int axis) {
  std::vector<Sine> all;
  for (int k = 0; k < count; ++k) {
    const double share = (k + shift) / count;
    const auto number = static_cast<std::uint64_t>(1000 * axis + k + (begin > 1.0 ? 500 : 0));
    all.push_back(
        {begin * std::pow(end / begin, share), 1.0, 2.0 * M_PI * random.uniform(RandomStream::Purpose::build, number)});
  }
  return all;
}

// Inertia of the platform along each direction, as a push feels it.
Eigen::VectorXd inertiasOf(const Kinematics& home) {
  const Eigen::MatrixXd J = home.jacobian, M = home.inertia;
  const Eigen::MatrixXd compliance = J * M.inverse() * J.transpose();
  return compliance.diagonal().head(std::min<Eigen::Index>(6, home.q.size())).cwiseInverse();
}

// Scale the fast parts to a share of the motors' torque at home.
void limitTorque(Excitation& excitation, const Mechanism& mechanism, double share) {
  double most = 0.0;
  const JointVector& limit = mechanism.limits().effort;
  for (double time = 0.0; time < excitation.duration; time += 0.00317) {
    Vec6 wrench = Vec6::Zero();
    for (std::size_t axis = 0; axis < excitation.axes.size(); ++axis)
      wrench[static_cast<Eigen::Index>(axis)] = sumOf(excitation.axes[axis].force, time);
    const JointVector torque = torqueOf(mechanism.home().jacobian, wrench);
    for (Eigen::Index i = 0; i < torque.size(); ++i)
      if (limit[i] > 0.0) most = std::max(most, std::abs(torque[i]) / limit[i]);
  }
  for (ExcitationAxis& axis : excitation.axes) scale(axis.force, share / most);
}

// Stiffness of the spring that follows the path. A file may miss `load`, which falls into the spring when the motion
// begins: at most twice as far as it stretches the spring at rest. That must not be more than `free`.
double holdOf(double inertia, double load, double free) {
  return std::max(inertia * std::pow(2.0 * M_PI * kHold, 2), 2.0 * load / free);
}

ExcitationAxis axisOf(const ExcitationOptions& options, double inertia, double stiffness, double width, double speed,
                      double force, int axis, int axes) {
  const RandomStream random(options.seed, 0);
  const double shift = (axis + 0.5) / axes;
  ExcitationAxis result{inertia, stiffness, std::sqrt(stiffness * inertia), {}, {}};
  result.motion = sines(kSlowLines, kSlowest, kSlowEnd, shift, random, axis);
  for (Sine& s : result.motion) s.amplitude = std::pow(s.frequency, -0.7);
  scale(result.motion, std::min({width / peakOf(result.motion, options.duration, 0),
                                 speed / peakOf(result.motion, options.duration, 1),
                                 kFollow * force / inertia / peakOf(result.motion, options.duration, 2)}));
  result.force = sines(kFastLines, kFastBegin, kFastEnd / options.period, shift, random, axis);
  for (Sine& s : result.force) s.amplitude = force * std::sqrt(std::max(1.0, s.frequency / 50.0));
  return result;
}

void requireIn(double value, double low, double high, const char* what) {
  require(value >= low && value <= high, std::string("the excitation's ") + what + " is " + formatNumber(value) +
                                             ", must be in " + formatNumber(low) + " to " + formatNumber(high));
}

}  // namespace

Excitation designExcitation(const Mechanism& mechanism, const ExcitationOptions& options) {
  requireIn(options.duration, 5.0, 600.0, "duration, s,");
  requireIn(options.share, 0.05, 0.8, "share of the torque");
  requireIn(options.width, 0.05, 0.9, "share of the workspace");
  requireIn(options.speed, 0.01, 1.0, "speed, m/s,");
  requirePeriod(options.period, "the excitation: ");
  const Kinematics& home = mechanism.home();
  const bool turns = mechanism.joints() >= 6;
  const Vec3 box = boxOf(mechanism, turns ? (1.0 + kFreeTurn) * kTurn : 0.0);
  const Eigen::VectorXd inertia = inertiasOf(home);
  const auto axes = static_cast<int>(inertia.size());
  const double weight = wrenchOf(home, home.gravity).head<3>().norm();  // masses may be wrong by a factor of 2
  Excitation excitation;
  excitation.duration = options.duration;
  excitation.period = options.period;
  excitation.workspace = box;
  for (int axis = 0; axis < axes; ++axis) {
    const Vec6 push = Vec6::Unit(axis);
    const JointVector torque = torqueOf(home.jacobian, push);
    double force = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < torque.size(); ++i)
      if (std::abs(torque[i]) > 1e-9)
        force = std::min(force, (mechanism.limits().effort[i] - std::abs(home.gravity[i])) / std::abs(torque[i]));
    require(force > 0.0, "the motors of \"" + mechanism.name() + "\" cannot push along every direction at home");
    (axis < 3 ? excitation.force : excitation.moment) =
        std::max(axis < 3 ? excitation.force : excitation.moment, force);
    const bool isTurn = axis >= 3;
    const double stiffness =
        isTurn ? holdOf(inertia[axis], weight * kComSpread, kFreeTurn * kTurn)
               : holdOf(inertia[axis], weight + inertia[axis] * kGravitySpread, (1.0 - options.width) * box[axis]);
    excitation.axes.push_back(axisOf(options, inertia[axis], stiffness, isTurn ? kTurn : options.width * box[axis],
                                     isTurn ? 1.5 : options.speed, force, axis, axes));
  }
  limitTorque(excitation, mechanism, options.share);
  return excitation;
}

Vec6 wrenchAt(const Excitation& excitation, double time, const Pose& pose, const Vec6& twist) noexcept {
  Vec6 wrench = Vec6::Zero();
  if (!(time > 0.0 && time < excitation.duration)) return wrench;
  const double near = std::min({1.0, time / kRamp, (excitation.duration - time) / kRamp});
  const double ramp = 0.5 - 0.5 * std::cos(M_PI * near);
  Vec6 place;
  place << pose.position, rotationVector(pose.rotation);
  for (std::size_t i = 0; i < excitation.axes.size(); ++i) {
    const ExcitationAxis& axis = excitation.axes[i];
    const auto k = static_cast<Eigen::Index>(i);
    const Vec3 motion = ramp * motionOf(axis.motion, time);
    wrench[k] = axis.inertia * motion[2] + axis.stiffness * (motion[0] - place[k]) +
                axis.damping * (motion[1] - twist[k]) + ramp * sumOf(axis.force, time);
    wrench[k] *= std::min(1.0, (excitation.duration - time) / kRelease);
  }
  return wrench;
}

void smoothTwist(const Excitation& excitation, const Vec6& twist, Vec6& smoothed) noexcept {
  for (std::size_t i = 0; i < excitation.axes.size(); ++i) {
    const ExcitationAxis& axis = excitation.axes[i];
    const auto k = static_cast<Eigen::Index>(i);
    const double rate = kCalm * std::sqrt(axis.stiffness / axis.inertia);
    smoothed[k] -= std::expm1(-rate * excitation.period) * (twist[k] - smoothed[k]);
  }
}

GuardOptions guardFor(const Mechanism& mechanism, const Excitation& excitation) {
  GuardOptions guard = guardFor(mechanism, excitation.period);
  guard.force = excitation.force;
  if (excitation.moment > 0.0) guard.moment = excitation.moment;
  guard.workspace = excitation.workspace;
  guard.speed = excitation.speed;
  guard.stopSpeed = 3.0 * excitation.speed;
  guard.turn = excitation.turn;
  guard.stopTurn = 3.0 * excitation.turn;
  guard.energy = excitation.force * excitation.workspace.norm();
  guard.power = excitation.force * excitation.speed;
  guard.mostMissed = 30;  // 30 % of lost samples: their share is a result
  return guard;
}

void ExcitationPlayer::before(Measurement& measurement) noexcept {
  if (begin_ < 0.0) begin_ = measurement.time;
  const double time = measurement.time - begin_;
  if (!measurement.enabled || time > excitation_.duration || haptics_.guard().fault() != GuardReason::none)
    isOver_.store(true);
  const Kinematics& last = haptics_.frame().kinematics;
  smoothTwist(excitation_, last.twist, twist_);
  haptics_.setEffect(isOver_.load() ? Vec6(Vec6::Zero()) : wrenchAt(excitation_, time, last.pose, twist_));
  if (next_ != nullptr) next_->before(measurement);
}

void ExcitationPlayer::tick(const LoopTick& tick, const HapticTick& haptics) noexcept {
  if (next_ != nullptr) next_->tick(tick, haptics);
}

GuardReason runExcitation(const Excitation& excitation, const Mechanism& mechanism, VirtualDevice& device,
                          const ExternalWrench& load, const ExcitationTick& each) {
  ImpedanceRenderer renderer({100.0, 0.0});  // touches nothing: balances gravity
  const Scene scene;
  const Tool tool;
  HapticTick haptics(mechanism, scene, tool, renderer, guardFor(mechanism, excitation));
  Measurement measurement;
  Command command;
  Vec6 twist = Vec6::Zero();
  const auto ticks = static_cast<std::uint64_t>(excitation.duration / excitation.period);
  for (std::uint64_t number = 0; number < ticks; ++number) {
    const Status measured = device.measure(measurement);
    require(measured == Status::ok || measured == Status::stale,
            "the virtual device left its workspace at " + formatNumber(device.time()) + " s");
    measurement.age = measured == Status::ok ? 0 : measurement.age + 1;
    measurement.time = device.time();
    const Kinematics& last = haptics.frame().kinematics;
    smoothTwist(excitation, last.twist, twist);
    haptics.setEffect(wrenchAt(excitation, static_cast<double>(number) * excitation.period, last.pose, twist));
    const Status status = haptics(measurement, command);
    each(number, measurement, haptics, command, status);
    if (haptics.guard().fault() != GuardReason::none) return haptics.guard().fault();
    (void)device.actuate(command);
    require(device.advance(load) == Status::ok,
            "the virtual device left its workspace at " + formatNumber(device.time()) + " s");
  }
  return GuardReason::none;
}

namespace {

std::vector<Sine> readSines(TomlTable& axis, const std::string& key) {
  const std::vector<double> numbers = axis.numbers(key);
  if (numbers.size() % 3 != 0) axis.fail(key, "must have three numbers for each sine: Hz, amplitude, phase");
  std::vector<Sine> all;
  for (std::size_t i = 0; i < numbers.size(); i += 3) all.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  return all;
}

std::string textOf(const std::vector<Sine>& sines) {
  std::string text = "[";
  for (const Sine& s : sines)
    text += "\n  " + formatNumber(s.frequency) + ", " + formatNumber(s.amplitude) + ", " + formatNumber(s.phase) + ",";
  return text + "\n]\n";
}

double positive(TomlTable& table, const char* key, double most) {
  const double value = table.number(key);
  if (!(value > 0.0 && value <= most))
    table.fail(key, "is " + formatNumber(value) + ", must be above 0 and at most " + formatNumber(most));
  return value;
}

}  // namespace

Excitation parseExcitation(std::string_view text, const std::string& file) {
  TomlTable root = parseToml(text, file);
  Excitation excitation;
  excitation.duration = positive(root, "duration", 600.0);
  excitation.period = positive(root, "period", 0.1);
  excitation.force = positive(root, "force", kLargestTorque);
  excitation.workspace = root.vector3("workspace");
  excitation.speed = positive(root, "speed", 3.0);
  excitation.turn = positive(root, "turn", 60.0);
  if (root.has("moment")) excitation.moment = positive(root, "moment", kLargestTorque);
  for (TomlTable& table : root.tables("axis")) {
    ExcitationAxis axis;
    axis.inertia = table.number("inertia");
    axis.stiffness = table.number("stiffness");
    axis.damping = table.number("damping");
    axis.motion = readSines(table, "motion");
    axis.force = readSines(table, "force");
    table.finish();
    excitation.axes.push_back(std::move(axis));
  }
  if (excitation.axes.size() > 6) root.fail("axis", "has more than 6 axes");
  root.finish();
  return excitation;
}

Excitation loadExcitation(const std::string& path) { return parseExcitation(readFile(path), path); }

std::string textOf(const Excitation& excitation) {
  const auto line = [](const std::string& key, double value, const std::string& comment) {
    return key + " = " + formatNumber(value) + "  # " + comment + "\n";
  };
  std::string text =
      "# Excitation for enamel identify. Each sine has Hz, amplitude (m, rad, N or N m) and phase (rad).\n" +
      line("duration", excitation.duration, "s") + line("period", excitation.period, "s, of a tick") +
      line("force", excitation.force, "N, limit of the guard") +
      line("speed", excitation.speed, "m/s, limit of the guard") +
      line("turn", excitation.turn, "rad/s, limit of the guard");
  if (excitation.moment > 0.0) text += line("moment", excitation.moment, "N m, limit of the guard");
  text += "workspace = [" + formatNumber(excitation.workspace.x()) + ", " + formatNumber(excitation.workspace.y()) +
          ", " + formatNumber(excitation.workspace.z()) + "]  # m, half widths, limit of the guard\n";
  for (const ExcitationAxis& axis : excitation.axes)
    text += "\n[[axis]]\n" + line("inertia", axis.inertia, "kg or kg m^2") +
            line("stiffness", axis.stiffness, "N/m or N m/rad") + line("damping", axis.damping, "N s/m or N m s/rad") +
            "motion = " + textOf(axis.motion) + "force = " + textOf(axis.force);
  return text;
}

}  // namespace enamel
