// The steps of PushObserver in which the time goes, compiled for more than one SIMD level.
#pragma once

#include "render/push_observer.hpp"

namespace enamel {

/// What a rounded reading says, as one with Gaussian noise that leaves the same mean and variance. Its likelihood is
/// exp(-square / 2) / volume, over that of a Gaussian reading of the same variance that was expected exactly.
struct Evidence {
  Lane innovation, variance, square, volume;
};

template <int kMech>
struct ObserverSteps {
  using Observer = PushObserver<kMech>;
  using Model = typename Observer::Model;
  using State = typename Observer::State;
  using States = typename Observer::States;

  void (*carry)(const Model& model, const double* command, const double* matters, double scale, States& x) noexcept;
  void (*predict)(const ModeData& data, const Model& model, const Lane& command, State& s) noexcept;
  void (*weigh)(const double* innovation, const double* expected, const double* variance, const double* precision,
                const double* largest, Evidence& seen) noexcept;
  void (*correct)(int read, const Lane& reading, State& s) noexcept;
  void (*merge)(State& s) noexcept;
  typename Observer::Moments (*moments)(const State& s, const States& row) noexcept;
};

extern const ObserverSteps<2> kRigidSteps, kRigidStepsAvx2, kRigidStepsAvx512;
extern const ObserverSteps<4> kCableSteps, kCableStepsAvx2, kCableStepsAvx512;

}  // namespace enamel
