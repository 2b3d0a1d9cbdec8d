// The delta as a Mechanism.
#pragma once

#include "enamel/device/delta/model.hpp"
#include "enamel/device/mechanism.hpp"

namespace enamel {

/// Mechanism of a delta: three joints, three degrees of freedom. The platform keeps the axes of W. A pose rotated by
/// more than 1e-9 rad is unreachable, and so is a twist that rotates faster than 1e-9 rad/s. The legs carry all
/// moments on the platform, so moments have no effect.
class DeltaMechanism final : public Mechanism {
 public:
  /// Throws ConfigurationError: as makeModel() and setHome(). Realtime: no.
  explicit DeltaMechanism(const DeltaParameters& parameters);

  const DeltaModel& model() const noexcept { return model_; }

  [[nodiscard]] Status track(const JointVector& q, const JointVector& rates, bool withInertia,
                             Kinematics& kinematics) const noexcept override;
  [[nodiscard]] Status reach(const Pose& pose, const Vec6& twist, bool withInertia,
                             Kinematics& kinematics) const noexcept override;
  [[nodiscard]] Status accelerate(const Pose& pose, const Vec6& twist, const JointVector& torque, const Vec6& wrench,
                                  Vec6& acceleration) const noexcept override;
  std::vector<Bar> bars(const Pose& pose) const override;

 private:
  DeltaModel model_;
  DeltaGeometry geometry_;
  double spacing_;
};

}  // namespace enamel
