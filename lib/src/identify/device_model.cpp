#include "identify/device_model.hpp"

#include <cmath>
#include <limits>

namespace enamel::identify {
namespace {

constexpr double kMassSpread = 0.7;       // of the logarithm: a factor of 2
constexpr double kRatioSpread = 0.15;     // of a motor's torque
constexpr double kScaleSpread = 0.3;      // of the logarithm: of the torque of all motors
constexpr double kLagSpread = 5e-4;       // s
constexpr double kDelaySpread = 3.0;      // ticks
constexpr double kFrictionSpread = 0.03;  // of the largest effort
constexpr double kCableSpread = 1.0;      // of the logarithm

using Value = std::function<double&(DeviceModel&)>;

TauParameters& tau(DeviceModel& m) { return std::get<TauParameters>(m.device); }
DeltaParameters& delta(DeviceModel& m) { return std::get<DeltaParameters>(m.device); }
CartesianParameters& cartesian(DeviceModel& m) { return std::get<CartesianParameters>(m.device); }

// Collects unknowns.
class List {
 public:
  explicit List(const DeviceModel& model) : model_(model) {}

  bool isOfDrives = false, isInFile = true;  // of the next unknowns

  // A positive number that may be wrong by a factor.
  void factor(const std::string& key, const std::string& unit, Value value, double spread = kMassSpread) {
    const double reference = value(model_);
    if (reference > 0.0) add({key, unit, std::move(value), spread, 0.0, reference});
  }
  // A number that may be wrong by `spread` in its unit.
  Unknown& term(const std::string& key, const std::string& unit, Value value, double spread) {
    const double reference = value(model_);
    return add({key, unit, std::move(value), 1.0, spread, reference});
  }
  std::vector<Unknown> take() { return std::move(unknowns_); }

 private:
  Unknown& add(Unknown unknown) {
    unknowns_.push_back(std::move(unknown));
    unknowns_.back().isOfDrives = isOfDrives;
    unknowns_.back().isInFile = isInFile;
    return unknowns_.back();
  }

  DeviceModel model_;
  std::vector<Unknown> unknowns_;
};

// A length of the device within the tolerance of its file: uniform errors of the lengths that act together.
void addLength(List& list, const std::string& key, Value value, double length, const Imperfections& e) {
  if (e.lengthError > 0.0 && length > 0.0)
    list.term(key, "m", std::move(value), length * e.lengthError / std::sqrt(3.0));
}

void addMechanism(List& list, const DeltaParameters& p) {
  list.factor("platform.mass", "kg", [](DeviceModel& m) -> double& { return delta(m).platform.mass; });
  list.factor("bar.mass", "kg", [](DeviceModel& m) -> double& { return delta(m).bar.mass; });
  list.term(
      "upper_link.com", "m", [](DeviceModel& m) -> double& { return delta(m).upperLink.com; }, 0.25 * p.geometry.a);
  list.factor("upper_link.inertia", "kg m^2", [](DeviceModel& m) -> double& { return delta(m).upperLink.inertia; });
  const DeltaGeometry& g = p.geometry;
  const Imperfections& e = p.imperfections;
  const auto length = [](double DeltaGeometry::*which) {
    return [which](DeviceModel& m) -> double& { return delta(m).geometry.*which; };
  };
  addLength(list, "geometry.a", length(&DeltaGeometry::a), g.a, e);
  addLength(list, "geometry.b", length(&DeltaGeometry::b), g.b, e);
  addLength(list, "geometry.d", length(&DeltaGeometry::d), g.d, e);
  addLength(list, "geometry.e", length(&DeltaGeometry::e), g.e, e);
  addLength(list, "geometry.r", length(&DeltaGeometry::r), std::hypot(g.c, g.r), e);
  addLength(list, "geometry.s", length(&DeltaGeometry::s), std::hypot(g.f, g.s), e);
}

void addMechanism(List& list, const TauParameters&) {
  list.factor("platform.mass", "kg", [](DeviceModel& m) -> double& { return tau(m).platform.mass; });
  for (int i = 0; i < 3; ++i) {
    const std::string index = "[" + std::to_string(i) + "]";
    list.term(
        "platform.com" + index, "m", [i](DeviceModel& m) -> double& { return tau(m).platform.com[i]; }, kComSpread);
    list.factor("platform.inertia" + index, "kg m^2",
                [i](DeviceModel& m) -> double& { return tau(m).platform.inertia(i, i); });
  }
  list.isInFile = false;
  for (std::size_t i = 0; i < 6; ++i)
    list.factor("mass factor of link " + std::to_string(i % 2 + 1) + " of chain " + std::to_string(i / 2 + 1), "",
                [i](DeviceModel& m) -> double& { return m.links[i]; });
  list.isInFile = true;
}

void addMechanism(List& list, const CartesianParameters& p) {
  if (p.massTable.isEmpty())
    list.factor("platform.mass", "kg", [](DeviceModel& m) -> double& { return cartesian(m).mass; });
  for (int i = 0; i < 3; ++i)
    list.term(
        "gravity[" + std::to_string(i) + "]", "m/s^2",
        [i](DeviceModel& m) -> double& { return cartesian(m).gravity[i]; }, kGravitySpread);
  for (int i = 3; i < p.axes; ++i)
    list.factor("platform.inertia[" + std::to_string(i - 3) + "]", "kg m^2",
                [i](DeviceModel& m) -> double& { return cartesian(m).inertia(i - 3, i - 3); });
}

struct AddMechanism {
  List& list;
  template <typename Parameters>
  void operator()(const Parameters& p) const {
    addMechanism(list, p);
  }
};

double& viscousOf(DeviceModel& m, int i) {
  if (std::holds_alternative<CartesianParameters>(m.device)) return cartesian(m).damping[i];
  return std::holds_alternative<TauParameters>(m.device) ? tau(m).motor.viscousFriction
                                                         : delta(m).motor.viscousFriction;
}

bool isCartesian(const DeviceParameters& device) { return std::holds_alternative<CartesianParameters>(device); }

void addViscous(List& list, const DeviceModel& model, const JointVector& effort, const std::string& unit) {
  // A damping that takes the largest effort at 2 rad/s or 1 m/s is the largest that a file may miss.
  const int count = isCartesian(model.device) ? static_cast<int>(effort.size()) : 1;
  for (int i = 0; i < count; ++i)
    list.term(
            count > 1 ? "platform.damping[" + std::to_string(i) + "]" : "motor.viscous_friction", unit,
            [i](DeviceModel& m) -> double& { return viscousOf(m, i); }, 0.3 * effort[i])
        .isNonNegative = true;
}

void addJoint(List& list, const DeviceModel& model, int i, double effort) {
  const std::string name = jointName(model.device, i);
  const bool turns = !isCartesian(model.device) || i >= 3;
  const std::string unit = turns ? "N m" : "N";
  const auto inWords = [](Unknown& unknown) -> Unknown& {
    unknown.isInFile = false;
    return unknown;
  };
  inWords(list.term(
              "Coulomb friction of " + name, unit, [i](DeviceModel& m) -> double& { return m.coulomb[i]; },
              kFrictionSpread* effort))
      .isNonNegative = true;
  if (i > 0 && !(isCartesian(model.device) && i == 3))
    inWords(list.term(
        "torque ratio of " + name, "", [i](DeviceModel& m) -> double& { return m.ratio[i]; }, kRatioSpread));
  const double offset = imperfectionsOf(model.device).encoderOffset / std::sqrt(3.0);
  if (offset > 0.0)
    inWords(list.term(
        "encoder offset of " + name, turns ? "rad" : "m", [i](DeviceModel& m) -> double& { return m.offset[i]; },
        offset));
}

void addDrive(List& list, const DeviceModel& model) {
  Unknown& lag = list.term(
      "motor lag", "s", [](DeviceModel& m) -> double& { return m.lag; }, kLagSpread);
  lag.isNonNegative = true;
  lag.isInFile = false;
  Unknown& delay = list.term(
      "loop delay", "ticks", [](DeviceModel& m) -> double& { return m.delay; }, kDelaySpread);
  delay.isNonNegative = true;
  delay.isInFile = false;
  const bool turns = !isCartesian(model.device);
  list.isOfDrives = model.hasCables();
  list.factor(turns ? "motor.rotor_inertia" : "rotor_mass", turns ? "kg m^2" : "kg",
              [](DeviceModel& m) -> double& { return rotorInertiaOf(m.device); });
  list.isOfDrives = true;
  if (!model.hasCables()) return;
  list.factor(
      "imperfections.cable_stiffness", turns ? "N m/rad" : "N/m",
      [](DeviceModel& m) -> double& { return m.drive.cableStiffness; }, kCableSpread);
  list.factor(
      "imperfections.cable_damping", turns ? "N m s/rad" : "N s/m",
      [](DeviceModel& m) -> double& { return m.drive.cableDamping; }, kCableSpread);
}

struct TakeImperfections {
  template <typename Device>
  void operator()(Device& p) const {
    p.imperfections = {};
    p.motor.viscousFriction = 0.0;
  }
  void operator()(CartesianParameters& p) const {
    p.imperfections = {};
    p.damping.setZero();
  }
};

// The moving parts of a model, without its drives.
DeviceParameters bodiesOf(const DeviceModel& model) {
  DeviceParameters bodies = model.device;
  std::visit(TakeImperfections{}, bodies);
  if (auto* tau = std::get_if<TauParameters>(&bodies)) scaleLinks(model.links, *tau);
  if (model.hasCables()) removeRotors(bodies);
  return bodies;
}

}  // namespace

void scaleLinks(const std::array<double, 6>& factors, TauParameters& device) {
  for (std::size_t i = 0; i < 6; ++i) {
    LinkParameters& link = i % 2 == 0 ? device.chain[i / 2].link1 : device.chain[i / 2].link2;
    link.mass *= factors[i];
    link.inertia *= factors[i];
  }
}

std::string jointName(const DeviceParameters& device, int i) {
  if (!isCartesian(device)) return "joint " + std::to_string(i + 1);
  return std::string(i < 3 ? "axis " : "rotation about ") + "xyz"[i % 3];
}

double Unknown::at(double x) const noexcept { return scale == 0.0 ? reference * std::exp(x) : reference + scale * x; }

double Unknown::slope(double x) const noexcept { return scale == 0.0 ? reference * std::exp(x) : scale; }

double Unknown::least() const noexcept {
  return isNonNegative ? -reference / scale : -std::numeric_limits<double>::infinity();
}

DeviceModel modelOf(const DeviceParameters& device) {
  const Kinematics home = makeMechanism(device)->home();
  const Eigen::Index n = home.q.size();
  DeviceModel model;
  model.device = device;
  model.drive = imperfectionsOf(device);
  model.drive.torqueRipple = 0.0;  // unknown until cogging is found
  if (model.drive.currentBandwidth > 0.0) model.lag = 1.0 / (2.0 * M_PI * model.drive.currentBandwidth);
  model.ratio = JointVector::Ones(n);
  model.coulomb = JointVector::Constant(n, model.drive.coulombFriction);
  model.offset = model.sine = model.cosine = JointVector::Zero(n);
  model.home = home.q;
  return model;
}

JointVector torqueRatios(const DeviceModel& model) {
  JointVector ratio = model.ratio;
  const Eigen::Index n = ratio.size(), first = isCartesian(model.device) ? std::min<Eigen::Index>(n, 3) : n;
  ratio.head(first) /= ratio.head(first).mean();
  if (n > first) ratio.tail(n - first) /= ratio.tail(n - first).mean();
  return ratio;
}

JointVector viscousFriction(const DeviceModel& model) {
  DeviceModel copy = model;
  JointVector friction(model.home.size());
  for (Eigen::Index i = 0; i < friction.size(); ++i) friction[i] = viscousOf(copy, static_cast<int>(i));
  return friction;
}

std::shared_ptr<const Mechanism> weightedMechanism(const DeviceModel& model) {
  DeviceParameters bodies = bodiesOf(model);
  Handpiece weight;
  weight.mass = model.weight;
  weight.gravity.setZero();
  if (const auto* device = std::get_if<CartesianParameters>(&bodies)) weight.gravity = device->gravity;
  addHandpiece(bodies, weight);
  return makeMechanism(bodies);
}

ImperfectDevice deviceOf(const DeviceModel& model) {
  DeviceModel copy = model;
  ImperfectDevice device;
  device.rotorInertia = rotorInertiaOf(copy.device);
  device.mechanism = makeMechanism(bodiesOf(model));
  device.imperfections = model.drive;
  device.imperfections.currentBandwidth = device.imperfections.torqueStep = 0.0;
  device.coulombFriction = model.coulomb;
  device.cogging = (model.sine.array().square() + model.cosine.array().square()).sqrt();
  const Kinematics& home = device.mechanism->home();
  device.offset = model.home - home.q + model.offset;
  if (model.hasCables()) device.offset -= home.gravity / model.drive.cableStiffness;
  device.coggingPhase = model.drive.periods * device.offset;  // from the reading to the angle
  for (Eigen::Index i = 0; i < model.sine.size(); ++i)
    device.coggingPhase[i] += std::atan2(model.cosine[i], model.sine[i]);
  return device;
}

std::vector<Unknown> unknownsOf(const DeviceModel& model) {
  List list(model);
  std::visit(AddMechanism{list}, model.device);
  list.factor(
      kWeight, "kg", [](DeviceModel& m) -> double& { return m.weight; }, kScaleSpread);
  list.isOfDrives = true;
  const JointVector effort = makeMechanism(model.device)->limits().effort;
  addViscous(list, model, effort, isCartesian(model.device) ? "N s/m or N m s/rad" : "N m s/rad");
  addDrive(list, model);
  for (int i = 0; i < effort.size(); ++i) addJoint(list, model, i, effort[i]);
  return list.take();
}

DeviceModel modelAt(const DeviceModel& reference, const std::vector<Unknown>& unknowns, const Eigen::VectorXd& x) {
  DeviceModel model = reference;
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    unknowns[i].value(model) = unknowns[i].at(x[static_cast<Eigen::Index>(i)]);
  return model;
}

}  // namespace enamel::identify
