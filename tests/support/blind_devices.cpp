#include "support/blind_devices.hpp"

#include <algorithm>
#include <cmath>

#include "enamel/core/error.hpp"
#include "enamel/sim/random.hpp"
#include "support/mechanisms.hpp"

namespace enamel::test {
namespace {

// Draws numbers by name, so that a new one does not change the others.
class Draw {
 public:
  explicit Draw(std::uint64_t seed) : seed_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * next(); }
  double factor(double low, double high) { return low * std::pow(high / low, next()); }
  int integer(int low, int high) { return low + static_cast<int>(next() * (high - low + 1)); }
  std::uint64_t seed() const noexcept { return seed_; }

 private:
  double next() { return RandomStream(seed_, 77).uniform(RandomStream::Purpose::test, count_++); }

  std::uint64_t seed_, count_ = 0;
};

// Torque constants with a mean of 1 in each group of joints.
JointVector drawRatios(Draw& draw, Eigen::Index n, Eigen::Index group) {
  JointVector ratio(n);
  for (double& r : ratio) r = draw.uniform(0.95, 1.05);
  for (Eigen::Index first = 0; first < n; first += group)
    ratio.segment(first, group) /= ratio.segment(first, group).mean();
  return ratio;
}

JointVector drawAround(Draw& draw, Eigen::Index n, double middle) {
  JointVector values(n);
  for (double& v : values) v = middle * draw.uniform(0.7, 1.3);
  return values;
}

void drawLoop(Draw& draw, BlindDevice& device, Imperfections& e) {
  device.delay.low = device.delay.high = draw.integer(0, 4);
  device.jitter = draw.uniform(0.0, 0.05);
  device.lost = draw.uniform(0.0, 0.01);
  e.currentBandwidth = draw.factor(250.0, 1500.0);
  device.value["motor lag"] = 1.0 / (2.0 * M_PI * e.currentBandwidth);
}

void name(BlindDevice& device) {
  const Eigen::Index n = device.built.offset.size();
  const bool isCartesian = std::holds_alternative<CartesianParameters>(device.file);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::string joint = !isCartesian ? "joint " + std::to_string(i + 1)
                                           : std::string(i < 3 ? "axis " : "rotation about ") + "xyz"[i % 3];
    device.value["Coulomb friction of " + joint] = device.built.coulombFriction[i];
    device.value["torque ratio of " + joint] = device.built.torqueConstant[i];
    device.value["cogging of " + joint] = device.built.cogging[i];
  }
  device.value["imperfections.torque_ripple"] = device.built.imperfections.torqueRipple;
  device.value["imperfections.periods"] = device.built.imperfections.periods;
}

BlindDevice makeCartesian3(Draw& draw) {
  CartesianParameters file = loadCartesian(deviceFile("cartesian-3.toml")), truth = file;
  truth.mass = draw.factor(0.03, 0.15);
  file.mass = truth.mass * draw.factor(0.5, 2.0);
  for (int i = 0; i < 3; ++i) {
    truth.damping[i] = draw.uniform(0.02, 0.4);
    truth.gravity[i] = draw.uniform(-0.3, 0.3);
  }
  truth.halfWidths *= 2.0;  // a device has no walls; the file has the range that its owner uses
  BlindDevice device;
  Imperfections e;
  drawLoop(draw, device, e);
  e.torqueStep = 0.002;
  e.torqueRipple = draw.uniform(0.0, 0.01);
  e.periods = 2.0 * M_PI / draw.factor(0.004, 0.03);
  device.built.imperfections = e;
  device.built.mechanism = makeMechanism(truth);
  device.built.offset = JointVector::Zero(3);
  device.built.torqueConstant = drawRatios(draw, 3, 3);
  device.built.coulombFriction = drawAround(draw, 3, draw.factor(0.03, 0.15));
  device.built.cogging = drawAround(draw, 3, draw.factor(0.005, 0.04));
  device.built.coggingPhase = JointVector::Zero(3);
  for (double& phase : device.built.coggingPhase) phase = draw.uniform(0.0, 2.0 * M_PI);
  device.value["platform.mass"] = truth.mass;
  for (int i = 0; i < 3; ++i) {
    device.value["platform.damping[" + std::to_string(i) + "]"] = truth.damping[i];
    device.value["gravity[" + std::to_string(i) + "]"] = truth.gravity[i];
  }
  device.file = file;
  device.truth = truth;
  return device;
}

BlindDevice makeCartesian6(Draw& draw) {
  CartesianParameters file = loadCartesian(deviceFile("cartesian-6.toml")), truth = file;
  truth.mass = draw.factor(0.15, 0.5);
  file.mass = truth.mass * draw.factor(0.5, 2.0);
  BlindDevice device;
  for (int i = 0; i < 3; ++i) {
    truth.inertia(i, i) *= draw.factor(0.7, 1.4);
    truth.damping[i] = draw.uniform(0.1, 1.0);
    truth.damping[i + 3] = draw.uniform(1e-4, 1e-3);
    truth.gravity[i] = draw.uniform(-0.3, 0.3);
    device.value["platform.inertia[" + std::to_string(i) + "]"] = truth.inertia(i, i);
    device.value["gravity[" + std::to_string(i) + "]"] = truth.gravity[i];
  }
  for (int i = 0; i < 6; ++i) device.value["platform.damping[" + std::to_string(i) + "]"] = truth.damping[i];
  device.value["platform.mass"] = truth.mass;
  truth.halfWidths *= 2.0;
  Imperfections e;
  drawLoop(draw, device, e);
  e.torqueRipple = draw.uniform(0.0, 0.01);
  e.periods = 2.0 * M_PI / draw.factor(0.008, 0.03);
  device.built.imperfections = e;
  device.built.mechanism = makeMechanism(truth);
  device.built.offset = JointVector::Zero(6);
  device.built.torqueConstant = drawRatios(draw, 6, 3);
  device.built.coulombFriction = drawAround(draw, 6, draw.factor(0.1, 0.5));
  device.built.cogging = drawAround(draw, 6, draw.factor(0.02, 0.1));
  device.built.coulombFriction.tail(3) *= 0.01;  // N to N m
  device.built.cogging.tail(3) *= 0.01;
  device.built.coggingPhase = JointVector::Zero(6);
  for (double& phase : device.built.coggingPhase) phase = draw.uniform(0.0, 2.0 * M_PI);
  device.file = file;
  device.truth = truth;
  return device;
}

BlindDevice makeTau(Draw& draw) {
  TauParameters file = loadTau(deviceFile("tau-detailed.toml"));
  file.imperfections.lengthError = 0.0;  // its 24 lengths are not estimated
  TauParameters truth = file;
  BlindDevice device;
  truth.platform.mass *= draw.factor(0.7, 1.4);
  for (int i = 0; i < 3; ++i) {
    truth.platform.com[i] += draw.uniform(-0.004, 0.004);
    truth.platform.inertia(i, i) *= draw.factor(0.9, 1.1);
    device.value["platform.com[" + std::to_string(i) + "]"] = truth.platform.com[i];
    device.value["platform.inertia[" + std::to_string(i) + "]"] = truth.platform.inertia(i, i);
  }
  device.value["platform.mass"] = truth.platform.mass;
  for (std::size_t i = 0; i < 6; ++i) {
    LinkParameters& link = i % 2 == 0 ? truth.chain[i / 2].link1 : truth.chain[i / 2].link2;
    const double factor = draw.factor(0.6, 1.6);
    link.mass *= factor;
    link.inertia *= factor;
    device.value["mass factor of link " + std::to_string(i % 2 + 1) + " of chain " + std::to_string(i / 2 + 1)] =
        factor;
  }
  truth.motor.rotorInertia *= draw.factor(0.6, 1.6);
  truth.motor.viscousFriction = draw.uniform(0.0, 2e-3);
  Imperfections& e = truth.imperfections;
  drawLoop(draw, device, e);
  e.torqueRipple = draw.uniform(0.0, 0.01);
  e.periods = draw.factor(40.0, 150.0);
  e.cableStiffness = draw.factor(500.0, 2000.0);
  e.cableDamping = e.cableStiffness * draw.factor(2e-5, 8e-5);
  const double offset = e.encoderOffset;
  e.massError = e.encoderOffset = 0.0;
  device.built = makeImperfectDevice(truth, draw.seed());
  device.built.torqueConstant = drawRatios(draw, 6, 6);
  device.built.coulombFriction = drawAround(draw, 6, draw.factor(0.003, 0.012));
  device.built.cogging = drawAround(draw, 6, draw.factor(1e-3, 4e-3));
  device.built.coggingPhase = JointVector::Zero(6);
  for (double& phase : device.built.coggingPhase) phase = draw.uniform(0.0, 2.0 * M_PI);
  for (int i = 0; i < 6; ++i) {
    const double error = draw.uniform(-offset, offset);
    device.built.offset[i] += error;
    device.value["encoder offset of joint " + std::to_string(i + 1)] = error;
  }
  device.value["motor.rotor_inertia"] = device.built.rotorInertia;
  device.value["motor.viscous_friction"] = truth.motor.viscousFriction;
  device.value["imperfections.cable_stiffness"] = e.cableStiffness;
  device.value["imperfections.cable_damping"] = e.cableDamping;
  device.file = file;
  device.truth = truth;
  return device;
}

BlindDevice makeDelta(Draw& draw) {
  DeltaParameters file = loadDelta(deviceFile("delta.toml")), truth = file;
  for (double* mass : {&truth.platform.mass, &truth.bar.mass, &truth.upperLink.inertia, &truth.motor.rotorInertia})
    *mass *= draw.factor(0.6, 1.6);
  truth.upperLink.com *= draw.uniform(0.6, 1.4);
  truth.motor.viscousFriction *= draw.uniform(0.0, 2.0);
  Imperfections& e = truth.imperfections;
  BlindDevice device;
  drawLoop(draw, device, e);
  e.torqueRipple = draw.uniform(0.0, 0.01);
  e.periods = draw.factor(40.0, 150.0);
  e.cableStiffness = draw.factor(50.0, 400.0);
  e.cableDamping = e.cableStiffness * draw.factor(5e-5, 2e-4);
  const double length = file.imperfections.lengthError, offset = file.imperfections.encoderOffset;
  DeltaGeometry& g = truth.geometry;
  for (double* const l : {&g.a, &g.b, &g.c, &g.d, &g.e, &g.f, &g.r, &g.s}) *l *= 1.0 + draw.uniform(-length, length);
  e.massError = e.lengthError = e.encoderOffset = 0.0;
  device.built = makeImperfectDevice(truth, draw.seed());
  const JointVector expected = makeMechanism(file)->home().q - makeMechanism(truth)->home().q;  // set at home
  device.built.offset += expected;
  for (int i = 0; i < 3; ++i) {
    const double error = draw.uniform(-offset, offset);
    device.built.offset[i] += error;
    device.value["encoder offset of joint " + std::to_string(i + 1)] = error;
  }
  device.built.torqueConstant = drawRatios(draw, 3, 3);
  device.built.coulombFriction = drawAround(draw, 3, draw.factor(0.002, 0.008));
  device.built.cogging = drawAround(draw, 3, draw.factor(5e-4, 2e-3));
  device.built.coggingPhase = JointVector::Zero(3);
  for (double& phase : device.built.coggingPhase) phase = draw.uniform(0.0, 2.0 * M_PI);
  device.value["platform.mass"] = truth.platform.mass;
  device.value["bar.mass"] = truth.bar.mass;
  device.value["upper_link.inertia"] = truth.upperLink.inertia;
  device.value["upper_link.com"] = truth.upperLink.com;
  device.value["motor.rotor_inertia"] = device.built.rotorInertia;
  device.value["motor.viscous_friction"] = truth.motor.viscousFriction;
  device.value["imperfections.cable_stiffness"] = e.cableStiffness;
  device.value["imperfections.cable_damping"] = e.cableDamping;
  device.file = file;
  device.truth = truth;
  return device;
}

}  // namespace

BlindDevice makeBlindDevice(BlindKind kind, std::uint64_t seed) {
  Draw draw(seed);
  BlindDevice device = kind == BlindKind::cartesian3   ? makeCartesian3(draw)
                       : kind == BlindKind::cartesian6 ? makeCartesian6(draw)
                       : kind == BlindKind::delta      ? makeDelta(draw)
                                                       : makeTau(draw);
  name(device);
  return device;
}

namespace {

// An imperfect plant whose first motor may give less than its commands.
class Saturating final : public Plant {
 public:
  Saturating(const ImperfectDevice& device, double most)
      : Plant(*device.mechanism), plant_(device, kStep), most_(most) {}

  std::unique_ptr<Plant> clone() const override { return std::make_unique<Saturating>(*this); }
  Status start(const Pose& pose) override {
    const Status status = plant_.start(pose);
    state_ = plant_.state();
    return status;
  }
  Status advance(double time, double duration, const JointVector& torque,
                 const ExternalWrench& load) noexcept override {
    JointVector command = torque;
    command[0] = std::clamp(command[0], -most_, most_);
    const Status status = plant_.advance(time, duration, command, load);
    state_ = plant_.state();
    return status;
  }
  void read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept override {
    plant_.read(truth, q, rates);
  }

 private:
  // s. Errors are of second order. Twice as much biases rotors and cables of a TAU by a deviation, in 30 s of data.
  static constexpr double kStep = 6.25e-6;

  ImperfectPlant plant_;
  double most_;
};

std::vector<RecordedTick> record(const BlindDevice& device, const Mechanism& mechanism, const Excitation& excitation,
                                 std::uint64_t seed, const ExternalWrench& load) {
  VirtualDeviceSetup setup;
  setup.encoders = {device.isRounded, RateSource::difference, 100.0};
  setup.delay = device.delay;
  setup.jitter = device.jitter;
  setup.lostSamples = device.lost;
  setup.seed = seed;
  VirtualDevice plant(std::make_unique<Saturating>(device.built, device.saturation), setup);
  std::vector<RecordedTick> ticks;
  const auto each = [&](std::uint64_t number, const Measurement& measurement, const HapticTick& haptics,
                        const Command& command, Status status) {
    RecordedTick tick;
    tick.number = number;
    tick.measurement = measurement;
    tick.measurement.applied.reset();  // a device that does not report the torque
    tick.command = command.effort;
    tick.status = status;
    tick.reason = haptics.frame().reason;
    ticks.push_back(tick);
  };
  const GuardReason reason = runExcitation(excitation, mechanism, plant, load, each);
  if (reason != GuardReason::none) throw Error(toString(reason));
  return ticks;
}

}  // namespace

std::vector<RecordedTick> recordBlind(const BlindDevice& device, double duration, std::uint64_t seed,
                                      const ExternalWrench* load) {
  const std::shared_ptr<const Mechanism> mechanism = makeMechanism(device.file);
  const auto nothing = [](double, const Pose&, const Vec6&) { return Vec6(Vec6::Zero()); };
  const ExternalWrench free(nothing);
  ExcitationOptions options;
  options.duration = duration;
  options.seed = seed;
  for (;; options.share *= 0.6, options.speed *= 0.6) {  // as the page says
    try {
      return record(device, *mechanism, designExcitation(*mechanism, options), seed, load != nullptr ? *load : free);
    } catch (const Error&) {
      if (options.share < 0.1) throw;
    }
  }
}

}  // namespace enamel::test
