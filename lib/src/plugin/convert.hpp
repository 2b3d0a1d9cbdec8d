// Conversion between the plain structs of the C interface and the C++ contract. Every number is copied unchanged.
#pragma once

#include <algorithm>
#include <vector>

#include "enamel/plugin/abi.h"
#include "enamel/plugin/host.hpp"
#include "enamel/render/compliance.hpp"

namespace enamel {

static_assert(ENAMEL_MAX_CONTACTS == kMaxContacts && ENAMEL_MAX_JOINTS == kMaxJoints);
static_assert(ENAMEL_NOT_FINITE == static_cast<int>(Status::notFinite) &&
              ENAMEL_INACTIVE == static_cast<int>(Status::inactive));
static_assert(ENAMEL_CONTACT == static_cast<int>(RenderMode::contact) &&
              ENAMEL_FAULT == static_cast<int>(RenderMode::fault));
static_assert(ENAMEL_EDGE == static_cast<int>(Feature::edge) && ENAMEL_VERTEX == static_cast<int>(Feature::vertex));

inline int storedContacts(int count) noexcept { return std::clamp(count, 0, kMaxContacts); }
inline int storedJoints(int count) noexcept { return std::clamp(count, 0, kMaxJoints); }

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

inline void toPlain(const Pose& pose, double* position, double* rotation) noexcept {
  Eigen::Map<Vec3>(position, 3) = pose.position;
  Eigen::Map<RowMajor>(rotation, 3, 3) = pose.rotation;
}
inline void toPlain(const JointVector& in, double* out) noexcept { std::copy_n(in.data(), in.size(), out); }
inline void fromPlain(const double* in, int count, JointVector& out) noexcept {
  out.resize(count);
  std::copy_n(in, count, out.data());
}

inline void toPlain(const Contact& from, EnamelContact& to) noexcept {
  Eigen::Map<Vec3>(to.point) = from.point;
  Eigen::Map<Vec3>(to.normal) = from.normal;
  to.gap = from.gap;
  Eigen::Map<Vec3>(to.obstacle_velocity) = from.obstacleVelocity;
  to.obstacle = from.obstacle;
  to.stiffness = from.compression < 0.0 ? from.material.stiffness : 1.0 / softness(from, from.compression, 0.0, 1.0);
  to.friction = from.material.friction;
  to.sliding_friction = from.material.slidingFriction;
  to.viscosity = from.material.viscosity;
  to.part = from.part;
  to.triangle = from.triangle;
  to.feature = static_cast<int32_t>(from.feature);
  to.feature_index = from.featureIndex;
  to.key = from.key;
}

/// Kinematics within a plain struct. An inertia without columns is not copied.
template <typename Plain>
void toPlain(const Kinematics& in, Plain& out) noexcept {
  toPlain(in.q, out.q);
  toPlain(in.rates, out.rates);
  toPlain(in.pose, out.position, out.rotation);
  Eigen::Map<Vec6>(out.twist) = in.twist;
  std::copy_n(in.jacobian.data(), in.jacobian.size(), out.jacobian[0]);
  std::copy_n(in.inverseTransposed.data(), in.inverseTransposed.size(), out.inverse[0]);
  toPlain(in.gravity, out.gravity);
  for (Eigen::Index i = 0; i < in.inertia.cols(); ++i)
    std::copy_n(in.inertia.col(i).data(), in.inertia.rows(), out.inertia[i]);
}

/// `withInertia`: the inertia is defined.
template <typename Plain>
void fromPlain(const Plain& in, int joints, bool withInertia, Kinematics& out) noexcept {
  fromPlain(in.q, joints, out.q);
  fromPlain(in.rates, joints, out.rates);
  out.pose = {Eigen::Map<const Vec3>(in.position), Eigen::Map<const RowMajor>(in.rotation)};
  out.twist = Eigen::Map<const Vec6>(in.twist);
  out.jacobian.resize(6, joints);
  std::copy_n(in.jacobian[0], 6 * joints, out.jacobian.data());
  out.inverseTransposed.resize(6, joints);
  std::copy_n(in.inverse[0], 6 * joints, out.inverseTransposed.data());
  fromPlain(in.gravity, joints, out.gravity);
  const int inertias = withInertia ? joints : 0;
  out.inertia.resize(inertias, inertias);
  for (int i = 0; i < inertias; ++i) std::copy_n(in.inertia[i], joints, out.inertia.col(i).data());
}

inline void toPlain(const TickFrame& in, EnamelTickInput& out) noexcept {
  out.time = in.time;
  out.age = in.age;
  toPlain(in.kinematics, out);
  toPlain(in.maxTorque, out.max_torque);
  const bool isSent = in.command.size() == in.kinematics.q.size();
  out.applied_known = in.applied ? ENAMEL_APPLIED_REPORTED : isSent ? ENAMEL_APPLIED_SENT : ENAMEL_APPLIED_UNKNOWN;
  if (out.applied_known != ENAMEL_APPLIED_UNKNOWN) toPlain(in.applied ? *in.applied : in.command, out.applied);
  out.joint_count = static_cast<int32_t>(in.kinematics.q.size());
  out.contact_count = in.contacts.count;
  for (int i = 0; i < storedContacts(in.contacts.count); ++i) toPlain(in.contacts.contacts[i], out.contacts[i]);
}

inline void fromPlain(const EnamelTickInput& in, bool withInertia, TickFrame& out) noexcept {
  const int n = storedJoints(in.joint_count);
  out.time = in.time;
  out.age = in.age;
  fromPlain(in, n, withInertia, out.kinematics);
  fromPlain(in.max_torque, n, out.maxTorque);
  out.applied.reset();
  out.command.resize(0);
  if (in.applied_known == ENAMEL_APPLIED_REPORTED) fromPlain(in.applied, n, out.applied.emplace());
  if (in.applied_known == ENAMEL_APPLIED_SENT) fromPlain(in.applied, n, out.command);
  out.contacts.count = in.contact_count;
  for (int i = 0; i < storedContacts(in.contact_count); ++i) {
    const EnamelContact& from = in.contacts[i];
    Contact& to = out.contacts.contacts[i];
    to.point = Eigen::Map<const Vec3>(from.point);
    to.normal = Eigen::Map<const Vec3>(from.normal);
    to.gap = from.gap;
    to.obstacleVelocity = Eigen::Map<const Vec3>(from.obstacle_velocity);
    to.obstacle = from.obstacle;
    to.material = {from.stiffness, from.friction, from.sliding_friction, from.viscosity};
    to.part = from.part;
    to.triangle = from.triangle;
    to.feature = static_cast<Feature>(std::clamp(from.feature, int32_t{ENAMEL_FACE}, int32_t{ENAMEL_VERTEX}));
    to.featureIndex = from.feature_index;
    to.key = from.key;
  }
}

inline void toPlain(const TickOutput& in, EnamelTickOutput& out) noexcept {
  out = EnamelTickOutput{};
  toPlain(in.torque, out.torque);
  out.normal_force = in.normalForce;
  out.answer = ENAMEL_TORQUE;
  out.mode = static_cast<int32_t>(in.mode);
  out.saturated = in.saturated ? 1 : 0;
}

/// A setup in the form that a plugin receives. `setup` must outlive it.
class PlainSetup {
 public:
  explicit PlainSetup(const PluginSetup& setup) {
    const auto given = [](const std::string& text) { return text.empty() ? nullptr : text.c_str(); };
    for (const auto& [key, value] : setup.parameters) parameters_.push_back({key.c_str(), value.c_str(), nullptr});
    plain_ = {given(setup.devicePath), given(setup.deviceText), given(setup.scenePath),
              given(setup.sceneText),  parameters_.data(),      parameters_.size()};
  }
  PlainSetup(const PlainSetup&) = delete;
  PlainSetup& operator=(const PlainSetup&) = delete;
  const EnamelConfiguration* get() const noexcept { return &plain_; }

 private:
  std::vector<EnamelParameter> parameters_;
  EnamelConfiguration plain_{};
};

}  // namespace enamel
