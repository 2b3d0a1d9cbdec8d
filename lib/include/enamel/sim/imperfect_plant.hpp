// A device that is not ideal. The [imperfections] of its file act between command and motion, and between motion and
// measurement.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include "enamel/device/device_file.hpp"
#include "enamel/sim/plant.hpp"

namespace enamel {

/// One device within the tolerances of a file. Immutable; may be shared between threads.
struct ImperfectDevice {
  Imperfections imperfections;
  std::shared_ptr<const Mechanism> mechanism;  ///< as built; without rotors if cables hold them
  double rotorInertia = 0.0;                   ///< as built, kg m^2
  JointVector offset;                          ///< of the encoders, rad
  JointVector torqueConstant;                  ///< of each motor, torque per commanded torque; empty: 1
  JointVector coulombFriction, cogging;        ///< of each joint, N m; empty: all as in `imperfections`
  JointVector coggingPhase;                    ///< of each joint, of cogging and ripple, rad; empty: 0
};

/// Draw one device from a seed and a number: lengths, masses, and the offset of each encoder. The encoders are set at
/// home: there they report the coordinates that `parameters` expect, plus their offset. Throws ConfigurationError as
/// makeMechanism() of the drawn device. Throws Error for a Cartesian device, because nothing is known about its drives.
/// Realtime: no.
ImperfectDevice makeImperfectDevice(const DeviceParameters& parameters, std::uint64_t seed, std::uint32_t number = 0);

/// A plant with a rotor behind each joint. c is the command and m the motor's torque. The rotor has the angle th, the
/// speed w and the inertia J. q is the joint and T the torque on it.
///
///   m' = 2 pi f (g round(c) - m)                         amplifier, torque constant g and current loop.
///   J w' = m (1 + r sin(N th + p)) + a sin(N th + p) - F - T       ripple and cogging with the phase p.
///   F = F_c z / z_c,  z' = w - |w| z / z_c               Coulomb friction.
///   T = k (th - q -+ b/2) + d (w - q')                   cable; T is 0 within the backlash b.
///
/// The friction is that of P. Dahl, "A solid friction model", 1968. A rigid transmission has th = q, and its rotors are
/// part of the mechanism. The encoders are on the rotors.
class ImperfectPlant final : public Plant {
 public:
  /// Integrate in steps of at most `step` s (Strang 1968). Each step has three parts: half a step of current and
  /// friction, exact at constant speed; the motion by RK4; the other half of current and friction.
  explicit ImperfectPlant(ImperfectDevice device, double step = 5e-5) noexcept;

  [[nodiscard]] std::unique_ptr<Plant> clone() const override { return std::make_unique<ImperfectPlant>(*this); }
  [[nodiscard]] Status start(const Pose& pose) override;
  /// Realtime: yes, if the load is.
  [[nodiscard]] Status advance(double time, double duration, const JointVector& torque,
                               const ExternalWrench& load) noexcept override;
  void read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept override;

 private:
  struct Rotors {
    JointVector angle, speed;         // th, w
    JointVector current, presliding;  // m, z
  };
  struct State {
    DeviceState link;
    Rotors rotors;
  };
  struct Slope {
    DeviceSlope link;
    JointVector speed, acceleration;  // of the rotors
  };
  friend State moved(const State& state, const Slope& slope, double h) noexcept;
  friend Slope weighted(const Slope& k1, const Slope& k2, const Slope& k3, const Slope& k4) noexcept;

  bool isRigid() const noexcept { return device_.imperfections.cableStiffness == 0.0; }
  Status step(double time, double h, const JointVector& command, const ExternalWrench& load,
              State& state) const noexcept;
  void relax(double h, const JointVector& command, Rotors& rotors) const noexcept;
  Status moveRigidly(double time, double h, const ExternalWrench& load, State& state) const noexcept;
  Status move(double time, double h, const ExternalWrench& load, State& state) const noexcept;
  Status slopeAt(double time, const State& state, const ExternalWrench& load, Slope& slope) const noexcept;
  JointVector torqueOf(const Rotors& rotors) const noexcept;

  ImperfectDevice device_;
  double step_;
  Rotors rotors_;
};

}  // namespace enamel
