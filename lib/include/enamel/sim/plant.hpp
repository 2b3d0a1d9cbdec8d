// The interface of a plant: the device in motion between two ticks, with any model of its dynamics.
#pragma once

#include <memory>
#include <type_traits>

#include "enamel/sim/integrator.hpp"

namespace enamel {

/// The wrench load(time, pose, twist) of the surroundings on the platform at the TCP, N, N m. It refers to a callable,
/// which must outlive it. An integration step calls it several times.
class ExternalWrench {
 public:
  template <typename F, typename = std::enable_if_t<!std::is_same_v<std::decay_t<F>, ExternalWrench>>>
  ExternalWrench(const F& load) noexcept
      : load_(&load), call_([](const void* f, double time, const Pose& pose, const Vec6& twist) noexcept -> Vec6 {
          return (*static_cast<const F*>(f))(time, pose, twist);
        }) {}

  Vec6 operator()(double time, const Pose& pose, const Vec6& twist) const noexcept {
    return call_(load_, time, pose, twist);
  }

 private:
  const void* load_;
  Vec6 (*call_)(const void*, double, const Pose&, const Vec6&) noexcept;
};

/// Largest speeds of a plant, m/s and rad/s. Above them its model is invalid: rigid links, motors without speed limit,
/// steps of one tick.
inline constexpr double kMaxPlantSpeed = 20.0, kMaxPlantTurnRate = 1000.0;

/// A device in motion. It refers to its mechanism.
class Plant {
 public:
  /// `mechanism` is the simulated device: its geometry, and the limits of its motors and encoders.
  explicit Plant(const Mechanism& mechanism) : mechanism_(mechanism) {}
  virtual ~Plant() = default;
  Plant& operator=(const Plant&) = delete;

  /// Copy the plant with its state. The copy moves on bit for bit as the original does. The two share only immutable
  /// data. Throws Error if the plant cannot be copied. Realtime: no.
  [[nodiscard]] virtual std::unique_ptr<Plant> clone() const = 0;

  const Mechanism& mechanism() const noexcept { return mechanism_; }

  /// Put the plant at rest at a pose, under the torque that balances gravity there. Returns a status of
  /// Mechanism::reach(), or another status if the plant cannot be assembled. Realtime: no.
  [[nodiscard]] virtual Status start(const Pose& pose) = 0;

  /// Move on from `time` by `duration` (s) under constant motor torques (N m or N) and a load. On any status but ok the
  /// plant does not move.
  ///
  /// - ok: the plant has moved.
  /// - outOfRange: it would exceed kMaxPlantSpeed or kMaxPlantTurnRate.
  /// - Other statuses: the status of the configuration that it cannot leave.
  ///
  /// Realtime: as each plant states.
  [[nodiscard]] virtual Status advance(double time, double duration, const JointVector& torque,
                                       const ExternalWrench& load) noexcept = 0;

  /// Return the joint coordinates and rates at the encoders. `truth` has the kinematics of state(). Realtime: yes.
  virtual void read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept {
    q = truth.q;
    rates = truth.rates;
  }

  /// Return the true state. Realtime: yes.
  const DeviceState& state() const noexcept { return state_; }

 protected:
  Plant(const Plant&) = default;

  /// Set state() to rest at a pose, and compute the kinematics there. Returns a status of Mechanism::reach(); on an
  /// error nothing changes.
  [[nodiscard]] Status rest(const Pose& pose, Kinematics& kinematics) noexcept;

  DeviceState state_;

 private:
  const Mechanism& mechanism_;
};

/// Return whether a state is within kMaxPlantSpeed and kMaxPlantTurnRate. Realtime: yes.
bool isWithinSpeedLimits(const DeviceState& state) noexcept;

/// A plant with the mechanism's own dynamics (Mechanism::accelerate()), integrated in pose and twist. Realtime: yes, if
/// the load is.
class ClosedFormPlant final : public Plant {
 public:
  explicit ClosedFormPlant(const Mechanism& mechanism, Integrator integrator = Integrator::rungeKutta4,
                           int substeps = 1) noexcept
      : Plant(mechanism), integrator_(integrator), substeps_(substeps) {}

  [[nodiscard]] std::unique_ptr<Plant> clone() const override { return std::make_unique<ClosedFormPlant>(*this); }
  /// Realtime: yes.
  [[nodiscard]] Status start(const Pose& pose) noexcept override;
  [[nodiscard]] Status advance(double time, double duration, const JointVector& torque,
                               const ExternalWrench& load) noexcept override;

 private:
  Integrator integrator_;
  int substeps_;
};

}  // namespace enamel
