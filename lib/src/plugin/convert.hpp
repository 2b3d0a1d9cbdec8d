// Conversion between the plain structs of the C interface and the C++ contract. Every number is copied unchanged.
#pragma once

#include <algorithm>
#include <vector>

#include "enamel/plugin/abi.h"
#include "enamel/plugin/host.hpp"

namespace enamel {

static_assert(ENAMEL_MAX_CONTACTS == kMaxContacts && ENAMEL_MAX_JOINTS == kMaxJoints);
static_assert(ENAMEL_NOT_FINITE == static_cast<int>(Status::notFinite) &&
              ENAMEL_INACTIVE == static_cast<int>(Status::inactive));
static_assert(ENAMEL_CONTACT == static_cast<int>(RenderMode::contact) &&
              ENAMEL_FAULT == static_cast<int>(RenderMode::fault));
static_assert(ENAMEL_EDGE == static_cast<int>(Feature::edge) && ENAMEL_VERTEX == static_cast<int>(Feature::vertex));

inline int storedContacts(int count) noexcept { return std::clamp(count, 0, kMaxContacts); }
inline int storedJoints(int count) noexcept { return std::clamp(count, 0, kMaxJoints); }

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
  to.stiffness = from.material.stiffness;
  to.friction = from.material.friction;
  to.sliding_friction = from.material.slidingFriction;
  to.viscosity = from.material.viscosity;
  to.part = from.part;
  to.triangle = from.triangle;
  to.feature = static_cast<int32_t>(from.feature);
  to.feature_index = from.featureIndex;
  to.key = from.key;
}

inline void toPlain(const TickFrame& in, EnamelTickInput& out) noexcept {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Kinematics& k = in.kinematics;
  out.time = in.time;
  out.age = in.age;
  toPlain(k.q, out.q);
  toPlain(k.rates, out.rates);
  Eigen::Map<Vec3>(out.position) = k.pose.position;
  Eigen::Map<RowMajor>(out.rotation) = k.pose.rotation;
  Eigen::Map<Vec6>(out.twist) = k.twist;
  toPlain(k.gravity, out.gravity);
  toPlain(in.maxTorque, out.max_torque);
  if (in.applied) toPlain(*in.applied, out.applied);
  out.applied_known = in.applied ? 1 : 0;
  std::copy_n(k.jacobian.data(), k.jacobian.size(), out.jacobian[0]);
  std::copy_n(k.inverseTransposed.data(), k.inverseTransposed.size(), out.inverse[0]);
  for (Eigen::Index i = 0; i < k.inertia.cols(); ++i)
    std::copy_n(k.inertia.col(i).data(), k.inertia.rows(), out.inertia[i]);
  out.joint_count = static_cast<int32_t>(k.q.size());
  out.contact_count = in.contacts.count;
  for (int i = 0; i < storedContacts(in.contacts.count); ++i) toPlain(in.contacts.contacts[i], out.contacts[i]);
}

/// `withInertia`: the inertia is defined.
inline void fromPlain(const EnamelTickInput& in, bool withInertia, TickFrame& out) noexcept {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const int n = storedJoints(in.joint_count);
  Kinematics& k = out.kinematics;
  out.time = in.time;
  out.age = in.age;
  fromPlain(in.q, n, k.q);
  fromPlain(in.rates, n, k.rates);
  k.pose.position = Eigen::Map<const Vec3>(in.position);
  k.pose.rotation = Eigen::Map<const RowMajor>(in.rotation);
  k.twist = Eigen::Map<const Vec6>(in.twist);
  fromPlain(in.gravity, n, k.gravity);
  fromPlain(in.max_torque, n, out.maxTorque);
  out.applied.reset();
  if (in.applied_known != 0) fromPlain(in.applied, n, out.applied.emplace());
  k.jacobian.resize(6, n);
  std::copy_n(in.jacobian[0], 6 * n, k.jacobian.data());
  k.inverseTransposed.resize(6, n);
  std::copy_n(in.inverse[0], 6 * n, k.inverseTransposed.data());
  const int inertias = withInertia ? n : 0;
  k.inertia.resize(inertias, inertias);
  for (int i = 0; i < inertias; ++i) std::copy_n(in.inertia[i], n, k.inertia.col(i).data());
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
