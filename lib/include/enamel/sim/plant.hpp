// What moves between two ticks: a device in motion, behind the same interface whatever computes it.
#pragma once

#include <memory>
#include <type_traits>

#include "enamel/sim/integrator.hpp"

namespace enamel {

/// The wrench load(time, pose, twist) of the surroundings on the platform at the TCP, N, N m. Refers to a callable,
/// which must outlive it. Called several times a step of integration.
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

/// Faster than this a plant means nothing (rigid links, motors without speed limit, steps of a tick), m/s and rad/s.
inline constexpr double kMaxPlantSpeed = 20.0, kMaxPlantTurnRate = 1000.0;

/// A device in motion. Refers to its mechanism.
class Plant {
 public:
  /// The mechanism that it is: geometry, limits of its motors and encoders.
  explicit Plant(const Mechanism& mechanism) : mechanism_(mechanism) {}
  virtual ~Plant() = default;
  Plant& operator=(const Plant&) = delete;

  /// Copy the plant with its state. The copy moves on bit for bit as the original does, and shares only immutable data
  /// with it. Throws Error: a plant that cannot be copied. Realtime: no.
  [[nodiscard]] virtual std::unique_ptr<Plant> clone() const = 0;

  const Mechanism& mechanism() const noexcept { return mechanism_; }

  /// At rest at a pose, under the torque that balances gravity there. Statuses: those of Mechanism::reach(); others
  /// where it cannot be assembled. Realtime: no.
  [[nodiscard]] virtual Status start(const Pose& pose) = 0;

  /// Moves on from `time` by `duration` (s) under constant motor torques (N m or N) and a load. Returns ok, or the
  /// status of the configuration that it could not leave, outOfRange where it would become faster than kMaxPlantSpeed
  /// or kMaxPlantTurnRate: it then stays where it is. Realtime: as each plant says.
  [[nodiscard]] virtual Status advance(double time, double duration, const JointVector& torque,
                                       const ExternalWrench& load) noexcept = 0;

  /// What the encoders see where the platform is at `truth`, state() with its kinematics: joint coordinates and rates.
  /// Realtime: yes.
  virtual void read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept {
    q = truth.q;
    rates = truth.rates;
  }

  /// The truth. Realtime: yes.
  const DeviceState& state() const noexcept { return state_; }

 protected:
  Plant(const Plant&) = default;

  /// state() at rest at a pose, and the mechanism there. Statuses of Mechanism::reach(); nothing is then changed.
  [[nodiscard]] Status rest(const Pose& pose, Kinematics& kinematics) noexcept;

  DeviceState state_;

 private:
  const Mechanism& mechanism_;
};

/// Whether a state is within kMaxPlantSpeed and kMaxPlantTurnRate. Realtime: yes.
bool isWithinSpeedLimits(const DeviceState& state) noexcept;

/// The mechanism's own dynamics (Mechanism::accelerate()), integrated in pose and twist. Realtime: yes, if the load is.
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
