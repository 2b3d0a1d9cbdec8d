#include "enamel/device/device_file.hpp"

#include "core/toml.hpp"
#include "device/read.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/cartesian/mechanism.hpp"
#include "enamel/device/delta/mechanism.hpp"
#include "enamel/device/tau/mechanism.hpp"

namespace enamel {
namespace {

struct Make {
  std::shared_ptr<const Mechanism> operator()(const TauParameters& p) { return std::make_shared<TauMechanism>(p); }
  std::shared_ptr<const Mechanism> operator()(const DeltaParameters& p) { return std::make_shared<DeltaMechanism>(p); }
  std::shared_ptr<const Mechanism> operator()(const CartesianParameters& p) {
    return std::make_shared<CartesianMechanism>(p);
  }
};

struct AddDamping {
  const Vec6& damping;
  void operator()(TauParameters& p) const { p.platform.damping += damping; }
  void operator()(DeltaParameters& p) const { p.platform.damping += damping.head<3>(); }
  void operator()(CartesianParameters& p) const { p.damping.head(p.axes) += damping.head(p.axes); }
};

struct AddFriction {
  double friction;
  void operator()(TauParameters& p) const { p.motor.viscousFriction += friction; }
  void operator()(DeltaParameters& p) const { p.motor.viscousFriction += friction; }
  void operator()(CartesianParameters& p) const { p.damping.head(p.axes).array() += friction; }
};

struct AddMass {
  double mass;
  void operator()(TauParameters& p) const { p.platform.mass += mass; }
  void operator()(DeltaParameters& p) const { p.platform.mass += mass; }
  void operator()(CartesianParameters& p) const {
    p.mass += mass;
    for (double& each : p.massTable.mass) each += mass;
  }
};

struct AddHandpiece {
  const Handpiece& h;

  void operator()(TauParameters& p) const {  // both about their common centre of mass
    const double mass = p.platform.mass + h.mass, share = h.mass / mass;
    const Vec3 between = h.com - p.platform.com;
    p.platform.inertia += h.inertia + p.platform.mass * share *
                                          (between.squaredNorm() * Mat3::Identity() - between * between.transpose());
    p.platform.com += share * between;
    p.platform.mass = mass;
  }
  void operator()(DeltaParameters& p) const { p.platform.mass += h.mass; }
  void operator()(CartesianParameters& p) const {
    if (p.axes == 6 && (h.com != Vec3::Zero() || h.inertia != Mat3::Zero()))
      throw Error("a handpiece on a Cartesian device that turns must have its mass at the TCP, without inertia");
    if (h.gravity != p.gravity) {
      if (!p.massTable.mass.empty())
        throw Error("a handpiece on a Cartesian device with a mass table must have the gravity of the device, " +
                    formatVector(p.gravity) + " m/s^2");
      p.gravity = (p.mass * p.gravity + h.mass * h.gravity) / (p.mass + h.mass);
    }
    AddMass{h.mass}(p);
  }
};

struct ScaleMasses {
  double factor;
  bool isRigid;  // the rotors move with the links

  template <typename Body>
  void scale(Body& body) const {
    body.mass *= factor;
    body.inertia *= factor;
  }
  void scale(MotorParameters& motor) const { motor.rotorInertia *= isRigid ? factor : 1.0; }
  void operator()(TauParameters& p) const {
    for (ChainParameters& chain : p.chain) {
      scale(chain.link1);
      scale(chain.link2);
    }
    scale(p.platform);
    scale(p.motor);
  }
  void operator()(DeltaParameters& p) const {
    scale(p.upperLink);
    p.bar.mass *= factor;
    p.platform.mass *= factor;
    scale(p.motor);
  }
  void operator()(CartesianParameters& p) const {
    const double rotor = isRigid ? 0.0 : p.rotorMass;
    const auto scaled = [&](double mass) { return rotor + factor * (mass - rotor); };
    p.mass = scaled(p.mass);
    for (double& mass : p.massTable.mass) mass = scaled(mass);
    p.inertia *= factor;
    if (isRigid) p.rotorMass *= factor;
  }
};

struct Rotor {
  template <typename Device>
  double& operator()(Device& p) const {
    return p.motor.rotorInertia;
  }
  double& operator()(CartesianParameters& p) const { return p.rotorMass; }
};

struct RemoveRotors {
  template <typename Device>
  void operator()(Device& p) const {
    p.motor.rotorInertia = 0.0;
  }
  void operator()(CartesianParameters& p) const {
    p.mass -= p.rotorMass;
    for (double& mass : p.massTable.mass) mass -= p.rotorMass;
    p.rotorMass = 0.0;
  }
};

}  // namespace

DeviceParameters parseDevice(std::string_view text, const std::string& file) {
  TomlTable root = parseToml(text, file);
  if (root.has("obstacle")) root.fail("obstacle", "this is a scene file, a device file is needed");
  const std::string kind = kindOf(root);
  const Handpiece handpiece = readHandpiece(root);
  DeviceParameters parameters;
  if (kind == "tau")
    parameters = readTau(root);
  else if (kind == "delta")
    parameters = readDelta(root);
  else if (kind == "cartesian")
    parameters = readCartesian(root);
  else
    root.fail("kind", "is \"" + kind + "\", must be \"tau\", \"delta\" or \"cartesian\"");
  if (!root.has("handpiece")) return parameters;
  try {
    addHandpiece(parameters, handpiece);
  } catch (const Error& error) {
    root.fail("handpiece", error.what());
  }
  return parameters;
}

DeviceParameters loadDevice(const std::string& path) { return parseDevice(readFile(path), path); }

std::shared_ptr<const Mechanism> makeMechanism(const DeviceParameters& parameters) {
  return std::visit(Make{}, parameters);
}

const std::string& nameOf(const DeviceParameters& parameters) {
  return std::visit([](const auto& p) -> const std::string& { return p.name; }, parameters);
}

const Imperfections& imperfectionsOf(const DeviceParameters& parameters) noexcept {
  return std::visit([](const auto& p) -> const Imperfections& { return p.imperfections; }, parameters);
}

Imperfections& imperfectionsOf(DeviceParameters& parameters) noexcept {
  return std::visit([](auto& p) -> Imperfections& { return p.imperfections; }, parameters);
}

double& rotorInertiaOf(DeviceParameters& parameters) noexcept { return std::visit(Rotor{}, parameters); }

void removeRotors(DeviceParameters& parameters) noexcept { std::visit(RemoveRotors{}, parameters); }

DeviceParameters idealOf(DeviceParameters parameters) {
  imperfectionsOf(parameters) = {};
  return parameters;
}

void stiffenCables(DeviceParameters& parameters) noexcept {
  Imperfections& e = imperfectionsOf(parameters);
  e.cableStiffness = e.cableDamping = e.backlash = 0.0;
}

void addDamping(DeviceParameters& parameters, const Vec6& damping) { std::visit(AddDamping{damping}, parameters); }

void addFriction(DeviceParameters& parameters, double friction) { std::visit(AddFriction{friction}, parameters); }

void addMass(DeviceParameters& parameters, double mass) { std::visit(AddMass{mass}, parameters); }

void addHandpiece(DeviceParameters& parameters, const Handpiece& handpiece) {
  const Fail fail = [](const std::string& key, const std::string& problem) {
    throw Error("the handpiece: " + key + " " + problem);
  };
  requireNotNegative(handpiece.mass, "mass", "kg", fail);
  if (!handpiece.com.allFinite()) fail("com", "must be finite");
  if (!handpiece.gravity.allFinite()) fail("gravity", "must be finite");
  checkInertia(handpiece.inertia, "inertia", fail);
  std::visit(AddHandpiece{handpiece}, parameters);
}

void scaleMasses(DeviceParameters& parameters, double factor) {
  std::visit(ScaleMasses{factor, imperfectionsOf(parameters).cableStiffness == 0.0}, parameters);
}

}  // namespace enamel
