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
  double rotorInertia = 0.0;                   ///< as built, kg m^2; kg on Cartesian devices
  JointVector offset;                          ///< of the encoders, rad; m on Cartesian devices
  JointVector torqueConstant;                  ///< of each motor, torque per commanded torque; empty: 1
  JointVector coulombFriction, cogging;        ///< of each joint, N m or N; empty: all as in `imperfections`
  JointVector coggingPhase;                    ///< of each joint, of cogging and ripple, rad; empty: 0
};

/// Draw one device from a seed and a number: lengths, masses, and the offset of each encoder. The encoders are set at
/// home: there they report the coordinates that `parameters` expect, plus their offset. Throws ConfigurationError as
/// makeMechanism() of the drawn device. Realtime: no.
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
  /// Integrate in parts of at most `step` s. In a part the mechanism is linear: it has the inertia and the free
  /// acceleration of its middle. Rotors, cables, friction and the load move in shorter steps, 25 or more in a period of
  /// the cable's resonance. All errors are of second order in `step`.
  explicit ImperfectPlant(ImperfectDevice device, double step = 2.5e-4) noexcept;

  [[nodiscard]] std::unique_ptr<Plant> clone() const override { return std::make_unique<ImperfectPlant>(*this); }
  [[nodiscard]] Status start(const Pose& pose) override;
  /// Realtime: yes, if the load is.
  [[nodiscard]] Status advance(double time, double duration, const JointVector& torque,
                               const ExternalWrench& load) noexcept override;
  void read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept override;

 private:
  // Numbers of all joints in a size that the compiler unrolls; those of joints that do not exist are 0.
  using Padded = Eigen::Matrix<double, kMaxJoints + 1, 1>;
  // Joints and rotors in motion, or their slopes.
  struct Drives {
    Padded q, rates;      // of the joints
    Padded angle, speed;  // of the rotors: th, w; as the joints if the transmission is rigid

    friend Drives moved(const Drives& s, const Drives& slope, double h) noexcept {
      return {s.q + h * slope.q, s.rates + h * slope.rates, s.angle + h * slope.angle, s.speed + h * slope.speed};
    }
    friend Drives weighted(const Drives& k1, const Drives& k2, const Drives& k3, const Drives& k4) noexcept {
      return {k1.q + 2.0 * (k2.q + k3.q) + k4.q, k1.rates + 2.0 * (k2.rates + k3.rates) + k4.rates,
              k1.angle + 2.0 * (k2.angle + k3.angle) + k4.angle, k1.speed + 2.0 * (k2.speed + k3.speed) + k4.speed};
    }
  };
  // The mechanism near one state: q'' = free + mobility (T + J^T F).
  struct Linear {
    Eigen::Matrix<double, 6, kMaxJoints + 1> jacobian;
    Padded free;
    Eigen::Matrix<double, kMaxJoints + 1, kMaxJoints + 1> mobility;
  };
  struct Motion {
    Drives drives;
    Padded current, presliding;  // m, z
    Linear linear;               // at the middle of the last part
  };
  bool isRigid() const noexcept { return device_.imperfections.cableStiffness == 0.0; }
  Status linearize(const DeviceState& state, Kinematics& kinematics, Linear& linear) const noexcept;
  Status movePart(double time, double duration, const Padded& asked, const ExternalWrench& load, DeviceState& platform,
                  Motion& motion) const noexcept;
  Padded meanCurrent(double h, const Padded& asked, Padded& current) const noexcept;
  void slide(double h, Motion& motion) const noexcept;
  Padded torqueAt(const Padded& angle, const Padded& current, const Padded& presliding) const noexcept;
  Drives slopeOf(const Drives& drives, const Padded& torque, const Padded& pushed, const Linear& linear) const noexcept;

  ImperfectDevice device_;
  double step_;       // s
  double resonance_;  // the highest of rotors, cables and friction, or more, rad/s
  Motion motion_;     // at state()
};

}  // namespace enamel
