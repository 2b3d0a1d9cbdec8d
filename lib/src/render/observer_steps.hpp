// Hot loops of PushObserver, compiled for several SIMD levels.
#pragma once

#include "render/push_observer.hpp"

namespace enamel {

/// Gaussian equivalent of a rounded reading: it leaves the same mean and variance. The likelihood is exp(-square / 2) /
/// volume, relative to a Gaussian reading of the same variance without innovation.
struct Evidence {
  Lane innovation, variance, square, volume;
};

template <int kMech>
struct ObserverSteps {
  using Observer = PushObserver<kMech>;
  using Model = typename Observer::Model;
  using State = typename Observer::State;
  using States = typename Observer::States;

  void (*carry)(const Model& model, const Lane& command, const Lane& matters, double scale, States& x) noexcept;
  void (*advanceSensitivity)(const Model& model, const Lane& command, const States& x, States& d) noexcept;
  void (*pullBack)(const Model& model, States& row) noexcept;
  void (*predict)(const ModeData& data, const Model& model, const Lane& command, const Lane& variance,
                  State& s) noexcept;
  void (*shift)(const Drive& drive, double stiffness, double seconds, State& s) noexcept;
  void (*weigh)(const Lane& innovation, const Lane& expected, const Lane& variance, const Lane& precision,
                const Lane& largest, Evidence& seen) noexcept;  // a part of correct(), for its test
  void (*innovation)(int read, const Lane& reading, const State& s, Lane& difference, Lane& variance) noexcept;
  void (*correct)(const ModeData& data, const Model& model, int read, const Lane& reading, State& s) noexcept;
  void (*merge)(State& s) noexcept;
  typename Observer::Moments (*moments)(const State& s, const States& row) noexcept;
};

extern const ObserverSteps<2> kRigidSteps, kRigidStepsAvx2;
extern const ObserverSteps<4> kCableSteps, kCableStepsAvx2;

}  // namespace enamel
