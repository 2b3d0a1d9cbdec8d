#include "enamel/sim/push.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/message.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

constexpr double kHandStiffness = 40.0, kHandDamping = 3.6;     // N/m, N s/m
constexpr double kGuideStiffness = 100.0, kGuideDamping = 3.6;  // N/m, N s/m
constexpr double kGuideTurn = 0.5, kGuideTurnDamping = 0.014;   // N m/rad, N m s/rad
constexpr double kOnset = 1.0, kHandStill = 2.0;                // s
constexpr double kLongestRun = 3600.0;                          // s

std::uint64_t tickAt(double time, double period) noexcept {
  return static_cast<std::uint64_t>(std::llround(time / period));
}

// Rotation vector of a rotation matrix, rad; exact for the angles that a hand allows (below 2 rad).
Vec3 rotationVector(const Mat3& r) noexcept {
  const Vec3 axis(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
  const double sine = 0.5 * axis.norm();
  if (sine < 1e-9) return 0.5 * axis;
  return axis * (0.5 * std::atan2(sine, 0.5 * (r.trace() - 1.0)) / sine);
}

// The wrench of the person on the platform at the TCP.
class PersonLoad {
 public:
  PersonLoad(const Person& person, const Pose& start) noexcept : person_(person), start_(start) {}

  /// Sets the parts that are held over a tick.
  void hold(double stepForce, double noise) noexcept { held_ = stepForce + noise; }

  /// Force against the normal.
  double force(double time, const Pose& pose, const Vec6& twist) const noexcept {
    if (person_.scenario == 1) return held_;
    const HandMotion hand = handMotion(person_.force, time);
    const Vec3& n = person_.normal;
    const double spring = kHandStiffness * (hand.position - n.dot(pose.position - start_.position));
    return held_ - spring - kHandDamping * (hand.velocity - n.dot(twist.head<3>()));
  }

  Vec6 operator()(double time, const Pose& pose, const Vec6& twist) const noexcept {
    Vec6 wrench = Vec6::Zero();
    const Vec3& n = person_.normal;
    wrench.head<3>() = -force(time, pose, twist) * n;
    if (person_.guide) {
      const Vec3 pull = kGuideStiffness * (pose.position - start_.position) + kGuideDamping * Vec3(twist.head<3>());
      wrench.head<3>() -= pull - n.dot(pull) * n;
      const Mat3 turned = pose.rotation.lazyProduct(start_.rotation.transpose());
      wrench.tail<3>() -= kGuideTurn * rotationVector(turned) + kGuideTurnDamping * twist.tail<3>();
    }
    return wrench;
  }

 private:
  Person person_;
  Pose start_;
  double held_ = 0.0;  // N
};

void require(bool condition, const std::string& message) {
  if (!condition) throw Error(message);
}

}  // namespace

HandMotion handMotion(double force, double time) noexcept {
  // Three phases whose displacements add up to -F_c / 40 at 2 s: a (0.45^2 + 0.45 * 0.1) = a * 0.2475.
  const double a = -force / 9.9;  // m/s^2
  const double t1 = std::clamp(time - 1.0, 0.0, 0.45), t2 = std::clamp(time - 1.45, 0.0, 0.10),
               t3 = std::clamp(time - 1.55, 0.0, 0.45);
  const double fastest = a * 0.45;
  HandMotion motion{0.5 * a * t1 * t1, a * t1};
  motion.position += fastest * t2 + fastest * t3 - 0.5 * a * t3 * t3;
  motion.velocity -= a * t3;
  if (time >= 2.0) motion.velocity = 0.0;
  return motion;
}

void checkPush(const PushSetup& setup) {
  checkLoop(setup);
  const Person& p = setup.person;
  require(p.scenario == 1 || p.scenario == 2, "scenario is " + std::to_string(p.scenario) + ", must be 1 or 2");
  require(std::abs(p.normal.norm() - 1.0) <= 1e-6,
          "the normal of the push has the length " + formatNumber(p.normal.norm()) + ", must be 1");
  require(p.force >= 0.0 && p.force <= 1e3, "force is " + formatNumber(p.force) + ", must be in 0 to 1000 N");
  require(p.noise >= 0.0 && p.noise <= 1e3, "noise is " + formatNumber(p.noise) + ", must be in 0 to 1000 N");
  require(setup.duration >= 0.0 && setup.duration <= kLongestRun,
          "duration is " + formatNumber(setup.duration) + ", must be in 0 to 3600 s");
}

PushResult runPush(const TauModel& model, Renderer& renderer, const PushSetup& setup,
                   const std::function<void(const TickRecord&)>& record) {
  checkPush(setup);
  VirtualLoop loop(model, renderer, setup);
  PersonLoad person(setup.person, setup.start);
  const RandomStream random(setup.seed, setup.run);
  const std::uint64_t onset = tickAt(kOnset, setup.period);
  const std::uint64_t noisy = setup.person.scenario == 1 ? onset : tickAt(kHandStill, setup.period);
  const std::uint64_t ticks = tickAt(setup.duration, setup.period);
  PushResult result{Status::ok, 0};
  TickRecord tick;
  for (std::uint64_t i = 0; i < ticks; ++i) {
    person.hold(setup.person.scenario == 1 && i >= onset ? setup.person.force : 0.0,
                i >= noisy ? setup.person.noise * random.normal(RandomStream::Purpose::noise, i) : 0.0);
    result.status = loop.tick(person, tick);
    if (result.status != Status::ok) break;
    ++result.ticks;
    record(tick);
  }
  renderer.deactivate();
  return result;
}

}  // namespace enamel
