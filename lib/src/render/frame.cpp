#include "enamel/render/frame.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "device/inertia.hpp"
#include "enamel/collision/scene.hpp"

namespace enamel {
namespace {

constexpr double kLeastInertia = 1e-12, kMostInertia = 1e6;  // limits of a joint's inertia, kg m^2 or kg

// torque = J^T [force; arm x force]. response = M^-1 D torque, where D removes the joints without a motor.
void fillRow(const TickFrame& frame, const Vec3& arm, const Vec3& force, JointRow& torque,
             JointRow& response) noexcept {
  Vec6 wrench;
  wrench << force, arm.cross(force);
  for (int i = 0; i < frame.kinematics.jacobian.cols(); ++i) {
    torque[i] = frame.kinematics.jacobian.col(i).dot(wrench);
    response[i] = frame.maxTorque[i] > 0.0 ? torque[i] : 0.0;
  }
  frame.rows.inertia.solve(response.data());
}

}  // namespace

const char* toString(RenderMode mode) noexcept {
  switch (mode) {
    case RenderMode::free: return "free";
    case RenderMode::contact: return "contact";
    case RenderMode::fault: return "fault";
  }
  return "unknown mode";
}

Vec3 ContactYield::afterUnder(const std::array<double, kMaxContacts>& forces, int contact, int contacts,
                              double period) const noexcept {
  Vec3 then = after[static_cast<std::size_t>(contact)];
  for (int j = 0; j < contacts; ++j) then -= period * forces[static_cast<std::size_t>(j)] * response[contact][j];
  return then;
}

Status fillContactRows(TickFrame& frame) noexcept {
  const Kinematics& k = frame.kinematics;
  const Eigen::Index n = k.q.size();
  frame.rows.count = -1;
  if (n < 1 || k.inertia.rows() != n || k.inertia.cols() != n || k.jacobian.cols() != n ||
      frame.maxTorque.size() != n || frame.contacts.count < 0 || frame.contacts.count > kMaxContacts ||
      !factorInertia(k.inertia, frame.rows.inertia))
    return Status::outOfRange;
  for (Eigen::Index i = 0; i < n; ++i)
    if (!(k.inertia(i, i) >= kLeastInertia && k.inertia(i, i) <= kMostInertia)) return Status::outOfRange;
  for (int c = 0; c < frame.contacts.count; ++c) {
    const Contact& contact = frame.contacts.contacts[c];
    ContactRow& row = frame.rows.row[c];
    const Vec3 arm = contact.point - k.pose.position;
    fillRow(frame, arm, contact.normal, row.normal, row.response);
    double inverseMass = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) inverseMass += row.normal[i] * row.response[i];
    row.mass = 1.0 / inverseMass;
    if (!(contact.material.friction > 0.0)) continue;
    row.axes = frameAlong(contact.normal);
    for (int t = 0; t < 2; ++t) fillRow(frame, arm, row.axes.col(t), row.tangent[t], row.tangentResponse[t]);
  }
  frame.rows.count = frame.contacts.count;
  return Status::ok;
}

}  // namespace enamel
