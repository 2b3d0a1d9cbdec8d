// Between the plain structs of the boundary and the C++ contract: every number is copied as it is.
#pragma once

#include <algorithm>
#include <vector>

#include "enamel/plugin/abi.h"
#include "enamel/plugin/host.hpp"

namespace enamel {

static_assert(ENAMEL_MAX_CONTACTS == kMaxContacts);
static_assert(ENAMEL_NOT_FINITE == static_cast<int>(Status::notFinite) &&
              ENAMEL_INACTIVE == static_cast<int>(Status::inactive));
static_assert(ENAMEL_CONTACT == static_cast<int>(RenderMode::contact) &&
              ENAMEL_FAULT == static_cast<int>(RenderMode::fault));

inline int storedContacts(int count) noexcept { return std::clamp(count, 0, kMaxContacts); }

inline void toPlain(const TickInput& in, EnamelTickInput& out) noexcept {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  out.time = in.time;
  Eigen::Map<Vec6>(out.q) = in.q;
  Eigen::Map<Vec6>(out.rates) = in.rates;
  Eigen::Map<Vec3>(out.position) = in.pose.position;
  Eigen::Map<RowMajor>(out.rotation) = in.pose.rotation;
  Eigen::Map<Vec6>(out.twist) = in.twist;
  out.max_torque = in.maxTorque;
  out.contact_count = in.contacts.count;
  out.reserved = 0;
  for (int i = 0; i < storedContacts(in.contacts.count); ++i) {
    const Contact& from = in.contacts.contacts[i];
    EnamelContact& to = out.contacts[i];
    Eigen::Map<Vec3>(to.point) = from.point;
    Eigen::Map<Vec3>(to.normal) = from.normal;
    to.gap = from.gap;
    Eigen::Map<Vec3>(to.obstacle_velocity) = from.obstacleVelocity;
    to.obstacle = from.obstacle;
    to.material = from.material;
  }
}

inline void fromPlain(const EnamelTickInput& in, TickInput& out) noexcept {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  out.time = in.time;
  out.q = Eigen::Map<const Vec6>(in.q);
  out.rates = Eigen::Map<const Vec6>(in.rates);
  out.pose.position = Eigen::Map<const Vec3>(in.position);
  out.pose.rotation = Eigen::Map<const RowMajor>(in.rotation);
  out.twist = Eigen::Map<const Vec6>(in.twist);
  out.maxTorque = in.max_torque;
  out.contacts.count = in.contact_count;
  for (int i = 0; i < storedContacts(in.contact_count); ++i) {
    const EnamelContact& from = in.contacts[i];
    Contact& to = out.contacts.contacts[i];
    to.point = Eigen::Map<const Vec3>(from.point);
    to.normal = Eigen::Map<const Vec3>(from.normal);
    to.gap = from.gap;
    to.obstacleVelocity = Eigen::Map<const Vec3>(from.obstacle_velocity);
    to.obstacle = from.obstacle;
    to.material = from.material;
  }
}

inline void toPlain(const TickOutput& in, EnamelTickOutput& out) noexcept {
  Eigen::Map<Vec6>(out.torque) = in.torque;
  out.normal_force = in.normalForce;
  out.mode = static_cast<int32_t>(in.mode);
  out.saturated = in.saturated ? 1 : 0;
}

/// A setup as a plugin is given it; `setup` must outlive it.
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
