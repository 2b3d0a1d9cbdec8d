#include "enamel/render/friction.hpp"

#include <algorithm>
#include <limits>

namespace enamel {
namespace {

constexpr double kLoadFollows = 0.1;  // filter gain per tick: the load is a mean over about ten ticks

Vec3 vector(const std::array<double, 3>& a) noexcept { return {a[0], a[1], a[2]}; }

// Shorten `v` to `length` if it is longer.
Vec3 shortened(const Vec3& v, double length) noexcept {
  const double size = v.norm();
  return size > length ? Vec3(v * (length / size)) : v;
}

}  // namespace

void FrictionMemory::begin() noexcept {
  now_ = {};
  count_ = 0.0;
}

Vec3 FrictionMemory::force(const Contact& contact, const SurfaceMotion& slide, const TangentialGains& gains,
                           double normalForce) noexcept {
  const Material& material = contact.material;
  const int slot = static_cast<int>(count_);
  if (!(material.friction > 0.0 && gains.stiffness > 0.0) || slot >= kMaxFrictionPoints) return Vec3::Zero();

  // Find the last tick's contact with the same obstacle, part and key, nearest in position. Each is used only once.
  FrictionPoint* before = nullptr;
  double nearest = std::numeric_limits<double>::infinity();
  for (FrictionPoint& point : last_) {
    if (point.obstacle != contact.obstacle || point.part != contact.part || point.key != contact.key) continue;
    const double distance = (vector(point.point) - contact.point).squaredNorm();
    if (distance < nearest) {
      nearest = distance;
      before = &point;
    }
  }
  if (before == nullptr && !(normalForce > 0.0)) return Vec3::Zero();
  // The walls of a hole hold the tool in every direction. Along the normal, the ground does if it carries a force.
  const bool floats = isHeldByWalls(contact, normalForce);
  const auto along = [&](const Vec3& v) { return floats ? v : Vec3(v - contact.normal.dot(v) * contact.normal); };
  Vec3 stretch = Vec3::Zero();
  double load = normalForce, budget = normalForce;
  bool slides = false;
  if (before != nullptr) {
    stretch = along(vector(before->stretch) + slide.displacement);
    load = before->load + kLoadFollows * (normalForce - before->load);
    budget += std::min(before->budget, load / kLoadFollows);
    slides = before->slides != 0.0;
    before->obstacle = -1.0;
  }

  constexpr double kSteps = 4.0;
  const double limit = material.friction * std::max(load, normalForce);
  const double soft = gains.step > 0.0 ? std::min(1.0, limit / (kSteps * gains.step * gains.stiffness)) : 1.0;
  const double stiffness = soft * gains.stiffness, damping = soft * gains.damping;

  const Vec3 lead = along(slide.predicted), velocity = along(slide.velocity);
  // Strong ticks save budget for weak ones, so that a hopping tool keeps its grip until it lands.
  const double holds = normalForce > 0.0 ? std::min(std::max(load, normalForce), budget) : budget;
  // The spring decides whether the contact slides. The damper must not: it reacts to every encoder count.
  const double sliding = material.slidingRatio(velocity.norm());
  slides = stiffness * (stretch + lead).norm() > (slides ? sliding : material.friction) * holds;
  const double most = (slides ? sliding : material.friction) * holds;
  if (slides) stretch = shortened(stretch + lead, most / std::max(stiffness, 1e-12)) - lead;
  const Vec3 force = shortened(-stiffness * (stretch + lead) - damping * velocity, most);

  FrictionPoint& point = now_[slot];
  point = {static_cast<double>(contact.obstacle),
           static_cast<double>(contact.part),
           static_cast<double>(contact.key),
           {contact.point.x(), contact.point.y(), contact.point.z()},
           {stretch.x(), stretch.y(), stretch.z()},
           load,
           normalForce > 0.0 ? std::max(0.0, budget - force.norm() / material.friction) : budget,
           slides ? 1.0 : 0.0};
  count_ += 1.0;
  if (!(normalForce > 0.0)) return Vec3::Zero();
  return slides ? Vec3(force - material.viscosity * velocity) : force;
}

}  // namespace enamel
