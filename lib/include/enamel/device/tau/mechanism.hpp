// The TAU as a Mechanism.
#pragma once

#include "enamel/device/mechanism.hpp"
#include "enamel/device/tau/model.hpp"

namespace enamel {

/// Mechanism of a TAU: six joints, six degrees of freedom. Joint vectors and poses are those of kinematics.hpp.
class TauMechanism final : public Mechanism {
 public:
  /// Throws ConfigurationError: as makeModel(). Realtime: no.
  explicit TauMechanism(const TauParameters& parameters);

  const TauModel& model() const noexcept { return model_; }

  [[nodiscard]] Status track(const JointVector& q, const JointVector& rates, bool withInertia,
                             Kinematics& kinematics) const noexcept override;
  [[nodiscard]] Status reach(const Pose& pose, const Vec6& twist, bool withInertia,
                             Kinematics& kinematics) const noexcept override;
  [[nodiscard]] Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                                  Vec6& acceleration) const noexcept override;
  std::vector<Bar> bars(const Pose& pose) const override;

 private:
  TauModel model_;
};

}  // namespace enamel
