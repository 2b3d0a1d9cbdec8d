// The linear closed loop of position control against simulated loops, and random loops on devices that differ from
// their files by errors at which the linear loop is stable.
#include "enamel/study/stability.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "enamel/control/margins.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/runtime/haptic_loop.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/imperfect_plant.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/wall_trials.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"

namespace enamel::test_stability {

namespace {

constexpr double kPeriod = 1e-3;

// A device whose mass is wrong by a factor; gravity and friction are right.
class Heavier final : public Mechanism {
 public:
  Heavier(std::shared_ptr<const Mechanism> mechanism, const double& factor)
      : Mechanism(mechanism->name(), mechanism->limits()), mechanism_(std::move(mechanism)), factor_(factor) {
    setHome();
  }
  Status track(const JointVector& q, const JointVector& rates, bool inertia, Kinematics& k) const noexcept override {
    return mechanism_->track(q, rates, inertia, k);
  }
  Status reach(const Pose& pose, const Vec6& twist, bool inertia, Kinematics& k) const noexcept override {
    return mechanism_->reach(pose, twist, inertia, k);
  }
  Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                    Vec6& acceleration) const noexcept override {
    const Status status = mechanism_->accelerate(pose, twist, torque, wrench, acceleration);
    acceleration /= factor_;
    return status;
  }
  std::vector<Bar> bars(const Pose& pose) const override { return mechanism_->bars(pose); }

 private:
  std::shared_ptr<const Mechanism> mechanism_;
  const double& factor_;
};

// A plant whose commands act a part of a tick late.
class Late final : public Plant {
 public:
  Late(std::unique_ptr<Plant> plant, const double& part)
      : Plant(plant->mechanism()), plant_(std::move(plant)), part_(part) {}
  std::unique_ptr<Plant> clone() const override { throw Error("not needed"); }
  Status start(const Pose& pose) override {
    const Status status = plant_->start(pose);
    state_ = plant_->state();
    return status;
  }
  Status advance(double time, double duration, const JointVector& torque,
                 const ExternalWrench& load) noexcept override {
    const double late = part_ * duration;
    Status status = Status::ok;
    if (late > 0.0 && last_.size() > 0) status = plant_->advance(time, late, last_, load);
    if (status == Status::ok) status = plant_->advance(time + late, duration - late, torque, load);
    last_ = torque;
    state_ = plant_->state();
    return status;
  }
  void read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept override {
    plant_->read(truth, q, rates);
  }

 private:
  std::unique_ptr<Plant> plant_;
  const double& part_;
  JointVector last_;
};

// A device that does not report the torque that acts.
class Driver final : public HapticDevice {
 public:
  explicit Driver(VirtualDevice& device) : device_(device) {}
  Status measure(Measurement& m) noexcept override {
    const Status status = device_.measure(m);
    m.applied.reset();
    return status;
  }
  Status actuate(const Command& command) noexcept override { return device_.actuate(command); }

 private:
  VirtualDevice& device_;
};

template <typename Change>
void changeImperfections(DeviceParameters& device, const Change& change) {
  std::visit(
      [&](auto& d) {
        if constexpr (!std::is_same_v<std::decay_t<decltype(d)>, CartesianParameters>) change(d.imperfections);
      },
      device);
}

struct Setup {
  DeviceParameters device;
  int delay = 0;  // assumed, ticks
  Vec3 normal = Vec3::UnitZ();
  DeviceErrors errors;
  bool isExact = false;  // encoders
  std::uint64_t seed = 1;
  std::uint32_t run = 0;
};

// Position control at a wall through home.
class Loop {
 public:
  explicit Loop(const Setup& s)
      : errors_(s.errors),
        model_(makeMechanism(modelFor(plantOf(s.device), s.device))),
        normal_(s.normal),
        scene_(flatWall(Vec3::Zero(), s.normal)) {
    const int whole = static_cast<int>(std::floor(s.delay + s.errors.delay));
    part_ = s.delay + s.errors.delay - whole;
    VirtualDeviceSetup setup;
    setup.delay = {whole, whole};
    setup.encoders = {!s.isExact, s.isExact ? RateSource::exact : RateSource::difference};
    setup.seed = s.seed;
    setup.run = s.run;
    device_.emplace(makePlant(s, setup), setup);
    driver_.emplace(*device_);
    renderer_.emplace(positionControlFor(*model_, kPeriod, s.delay, s.delay));
    GuardOptions options = guardFor(*model_, kPeriod);
    setDrive(*model_, options);
    options.delay = s.delay;
    tick_.emplace(*model_, scene_, Tool{}, *renderer_, options, Pose{});
    body_.emplace(*driver_, *tick_, HapticLoopOptions{});
  }

  // Run one tick under a push against the wall. Return whether the loop is not lost.
  bool step(double push) {
    body_->step();
    const auto hand = [&](double, const Pose& pose, const Vec6& twist) {
      Vec6 wrench = guidingWrench(pose, twist, Pose{}, normal_);
      wrench.head<3>() -= push * normal_;
      return wrench;
    };
    constexpr double kLost = 0.02;  // m, as in a wall design
    return device_->advance(hand) == Status::ok && !isFault(body_->tick().reason) && std::abs(gap()) < kLost;
  }
  double gap() const { return normal_.dot(device_->state().position); }
  GuardReason reason() const { return body_->tick().reason; }
  const LoopTick& tick() const { return body_->tick(); }
  double mass() const { return renderer_->state().mass; }
  const Mechanism& model() const { return *model_; }
  // Change the device between two ticks; the delay by less than a tick.
  void change(double mass, double delay) {
    errors_.mass = mass;
    part_ += delay;
  }

 private:
  std::unique_ptr<Plant> makePlant(const Setup& s, VirtualDeviceSetup& setup) {
    if (std::string(plantOf(s.device)) == kClosedForm) {
      plant_ = std::make_shared<Heavier>(model_, errors_.mass);
      return std::make_unique<Late>(std::make_unique<ClosedFormPlant>(*plant_), part_);
    }
    DeviceParameters device = s.device;
    changeImperfections(device, [&](Imperfections& i) {
      i.massError = 0.0;  // the errors contain it
      i.cableStiffness *= s.errors.cable;
      setup.jitter = i.jitter;
      setup.lostSamples = i.lostSamples;
    });
    ImperfectDevice built = makeImperfectDevice(device, s.seed, s.run);
    built.mechanism = std::make_shared<Heavier>(built.mechanism, errors_.mass);
    return std::make_unique<Late>(std::make_unique<ImperfectPlant>(std::move(built)), part_);
  }

  DeviceErrors errors_;
  double part_ = 0.0;
  std::shared_ptr<const Mechanism> model_, plant_;
  Vec3 normal_;
  Scene scene_;
  std::optional<VirtualDevice> device_;
  std::optional<Driver> driver_;
  std::optional<PositionControlRenderer> renderer_;
  std::optional<HapticTick> tick_;
  std::optional<LoopBody> body_;
};

const char* const kDevices[] = {"cartesian-3.toml", "cartesian-6.toml", "stylus.toml",
                                "delta.toml",       "tau-nominal.toml", "tau-detailed.toml"};
constexpr int kDelays = 4;
constexpr std::size_t kKinds = std::size(kDevices) * kDelays;  // of devices and assumed delays

// A device file and an assumed delay, with the ranges of single errors at which the loop is stable.
struct Kind {
  DeviceParameters device;
  LinearLoop loop;
  StableRange mass, cable{1.0, 1.0}, delay;
  Kind(std::size_t number, Scope scope)
      : device(loadDevice(test::deviceFile(kDevices[number / kDelays]))),
        loop(device, kPeriod, static_cast<int>(number % kDelays)),
        mass(stableRange(loop, &DeviceErrors::mass, scope)),
        delay(stableRange(loop, &DeviceErrors::delay, scope)) {
    if (loop.drive().stiffness > 0.0) cable = stableRange(loop, &DeviceErrors::cable, scope);
  }
};

// Draw errors evenly from the part of the stable set in a box. The box exceeds the ranges of single errors, because
// errors may compensate each other.
DeviceErrors drawErrors(const Kind& kind, Scope scope, test::Random& random) {
  constexpr double kWider = 1.3;
  const auto draw = [&](const StableRange& range, double nominal) {
    return nominal + kWider * (random.uniform(range.low, range.high) - nominal);
  };
  for (;;) {
    DeviceErrors errors;
    errors.mass = draw(kind.mass, 1.0);
    errors.cable = draw(kind.cable, 1.0);
    errors.delay = std::max<double>(-kind.loop.delay(), draw(kind.delay, 0.0));
    if (kind.loop.isStable(errors, scope)) return errors;
  }
}

struct Outcome {
  bool isLost = false;
  GuardReason reason = GuardReason::none;
  int lostAt = 0;                       // tick
  double deepest = 0.0, highest = 0.0;  // m, of the gap after the step
  DeviceErrors errors;
  int axis = 0;
  bool turned = false;
  double force = 0.0;
};

// A hand touches the wall, pushes and trembles, on a device whose errors are in the set.
Outcome outcomeOf(const Kind& kind, std::uint64_t number, Scope scope) {
  constexpr int kTicks = 500, kSettled = 150;
  test::Random random(number);
  Setup s;
  s.device = kind.device;
  s.delay = kind.loop.delay();
  s.errors = drawErrors(kind, scope, random);
  Outcome o;
  o.errors = s.errors;
  o.axis = std::min(2, static_cast<int>(random.uniform(0.0, 3.0)));
  o.turned = random.uniform(0.0, 1.0) < 0.5;
  s.normal = (o.turned ? -1.0 : 1.0) * Vec3::Unit(o.axis);
  s.seed = number;
  Loop loop(s);
  const Kinematics& home = loop.model().home();
  const double share =
      std::min(1.0, 0.3 * largestForce(home, loop.model().limits().effort, home.pose.position, s.normal) / 15.0);
  const int onset = kSettled + static_cast<int>(random.uniform(0.0, 30.0));
  o.force = share * random.uniform(2.0, 15.0);
  for (int i = 0; i < kTicks && !o.isLost; ++i) {
    const double noise = random.uniform(-1.0, 1.0) * std::sqrt(3.0) * 0.5 * share;
    o.isLost = !loop.step((i < onset ? share : o.force) + noise);
    o.lostAt = i;
    o.reason = loop.reason();
    if (i < kSettled) continue;
    o.deepest = std::max(o.deepest, -loop.gap());
    o.highest = std::max(o.highest, loop.gap());
  }
  return o;
}

}  // namespace

}  // namespace enamel::test_stability
