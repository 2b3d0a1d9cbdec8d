// The steps of PushObserver in which the time goes, compiled for more than one SIMD level.
#pragma once

#include "render/push_observer.hpp"

namespace enamel {

template <int kMech>
struct ObserverSteps {
  using Observer = PushObserver<kMech>;
  using Pairs = double[Observer::kPairs][kLanes];

  void (*predict)(const typename Observer::Model& model, const double* command, const double* matters, double scale, const Pairs& noise,
                  typename Observer::Hypothesis& h) noexcept;
  void (*correct)(const double* innovation, const double* variance, int read, bool teaches,
                  typename Observer::Hypothesis& h) noexcept;
  void (*gather)(const typename Observer::Hypothesis& h, const typename Observer::States& mean, double weight,
                 Pairs& P) noexcept;
};

extern const ObserverSteps<2> kRigidSteps, kRigidStepsAvx2;
extern const ObserverSteps<4> kCableSteps, kCableStepsAvx2;

}  // namespace enamel
