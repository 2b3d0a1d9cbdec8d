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
  using States = typename Observer::States;
  using Pairs = typename Observer::Pairs;

  void (*carry)(const Model& model, const double* command, const double* matters, double scale, States& x) noexcept;
  void (*predict)(const Model& model, const double* command, const double* matters, double scale, const Pairs& noise,
                  States& x, Pairs& P) noexcept;
  void (*weigh)(const double* innovation, const double* expected, const double* variance, const double* largest,
                Evidence& seen) noexcept;
  void (*correct)(const double* variance, int read, Pairs& P, States& column, States& gain) noexcept;
  void (*gather)(const States& x, const States& g, const Lane& v, const States& mean, double share, Pairs& P) noexcept;
};

extern const ObserverSteps<2> kRigidSteps, kRigidStepsAvx2;
extern const ObserverSteps<4> kCableSteps, kCableStepsAvx2;

}  // namespace enamel
