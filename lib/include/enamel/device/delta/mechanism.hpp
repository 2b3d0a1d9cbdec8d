// The delta as a Mechanism.
#pragma once

#include "enamel/device/delta/model.hpp"
#include "enamel/device/mechanism.hpp"

namespace enamel {

/// Three joints, three freedoms: the platform keeps the axes of W. A pose turned by more than 1e-9 and a twist that
/// turns faster than 1e-9 rad/s are unreachable; moments on the platform are borne by the legs and do nothing.
class DeltaMechanism final : public Mechanism {
 public:
  /// Throws ConfigurationError: as makeModel(), and as setHome(). Realtime: no.
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
