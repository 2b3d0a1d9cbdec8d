#include <cmath>

#include "enamel/render/renderer.hpp"
#include "render/contact_walls.hpp"

namespace enamel {
namespace {

constexpr double kStick = 0.5;  // of the stiffness along the surface: encoder steps that are felt against creep

}  // namespace

JointRow frictionTorque(const TickFrame& frame, const PredictedModes& modes, const Wall* walls, JointRow& lastEstimate,
                        FrictionMemory& memory) noexcept {
  const Kinematics& k = frame.kinematics;
  JointRow torque{}, moved{};
  Lane coming{};
  for (int mode = 0; mode < modes.count; ++mode) coming[mode] = modes.place[mode] - modes.estimate[mode];
  const JointRow estimate = modes.toJoints(modes.estimate);
  for (int j = 0; j < modes.count; ++j) moved[j] = estimate[j] - lastEstimate[j];
  lastEstimate = estimate;
  const auto motionOf = [&](const JointRow& v) {
    Vec6 motion = Vec6::Zero();
    for (int j = 0; j < modes.count; ++j) motion += k.jacobian.col(j) * v[j];
    return motion;
  };
  const Vec6 way6 = motionOf(moved), ahead6 = motionOf(modes.toJoints(coming)),
             velocity6 = motionOf(modes.toJoints(modes.rate));
  std::array<double, kMaxContacts> normals{};
  for (int c = 0; c < frame.contacts.count; ++c) normals[static_cast<std::size_t>(c)] = walls[c].force;
  memory.begin();
  for (int c = 0; c < frame.contacts.count; ++c) {
    const Contact& contact = frame.contacts.contacts[c];
    if (!(contact.material.friction > 0.0)) continue;
    const double normal = normals[static_cast<std::size_t>(c)] + contact.grip;
    const bool floats = isHeldByWalls(contact, normal);
    const ContactRow& row = frame.rows.row[c];
    const Lane first = modes.toModes(row.tangent[0]), second = modes.toModes(row.tangent[1]);
    double aa = 0.0, ab = 0.0, bb = 0.0, lead = 0.0, rounding = 0.0;
    for (int mode = 0; mode < modes.count; ++mode) {
      const double soft = 1.0 / modes.law.stiffness[mode];
      aa += first[mode] * first[mode] * soft;
      ab += first[mode] * second[mode] * soft;
      bb += second[mode] * second[mode] * soft;
      lead += (first[mode] * first[mode] + second[mode] * second[mode]) * soft * modes.law.lead[mode];
      rounding += 0.5 * (first[mode] * first[mode] + second[mode] * second[mode]) * modes.readingVariance[mode];
    }
    double softest = 0.5 * (aa + bb) + std::hypot(0.5 * (aa - bb), ab);
    Vec3 base = contact.obstacleVelocity, after = base;  // during the delay, and when the torque acts
    if (floats) {
      const Lane across = modes.toModes(row.normal);
      for (int mode = 0; mode < modes.count; ++mode)
        softest += across[mode] * across[mode] / modes.law.stiffness[mode];  // at most, in any direction
    }
    if (frame.yield.isAny) {
      const auto at = static_cast<std::size_t>(c);
      softest +=
          modes.period * lead / (aa + bb) * (frame.yield.across[at] + (floats ? frame.yield.inverse[at][at] : 0.0));
      base -= frame.yield.velocity[at];
      after = base + frame.yield.afterUnder(normals, c, frame.contacts.count, modes.period);
    }
    const TangentialGains gains{kStick / softest, std::sqrt(kStick) * lead / (aa + bb) / softest,
                                std::sqrt(12.0 * rounding)};
    const Vec3 arm = contact.point - k.pose.position;
    const SurfaceMotion slide{translationAt(way6, arm) - modes.period * contact.obstacleVelocity,
                              translationAt(ahead6, arm) - modes.seconds * base, translationAt(velocity6, arm) - after};
    const Vec3 held = memory.force(contact, slide, gains, normal);
    for (int j = 0; j < modes.count; ++j) {
      torque[j] += row.axes.col(0).dot(held) * row.tangent[0][j] + row.axes.col(1).dot(held) * row.tangent[1][j];
      if (floats) torque[j] += contact.normal.dot(held) * row.normal[j];
    }
  }
  memory.end();
  return torque;
}

}  // namespace enamel
