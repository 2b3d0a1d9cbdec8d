#include "enamel/render/friction.hpp"

#include <algorithm>
#include <limits>

namespace enamel {
namespace {

Vec3 vector(const std::array<double, 3>& a) noexcept { return {a[0], a[1], a[2]}; }

Vec3 along(const Vec3& normal, const Vec3& v) noexcept { return v - normal.dot(v) * normal; }

// `v`, shortened to `length`.
Vec3 shortened(const Vec3& v, double length) noexcept {
  const double size = v.norm();
  return size > length ? Vec3(v * (length / size)) : v;
}

}  // namespace

void FrictionMemory::begin() noexcept {
  now_ = {};
  count_ = 0.0;
}

Vec3 FrictionMemory::force(const Contact& contact, const Slide& slide, const Grasp& grasp,
                           double normalForce) noexcept {
  const Material& material = contact.material;
  const int slot = static_cast<int>(count_);
  if (!(material.friction > 0.0 && normalForce > 0.0 && grasp.stiffness > 0.0) || slot >= kMaxFrictionPoints)
    return Vec3::Zero();

  // The same contact at the last tick; without a key the nearest of its obstacle and part. It is taken over once only.
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
  const Vec3& n = contact.normal;
  Vec3 stretch = Vec3::Zero();
  bool slides = false;
  if (before != nullptr) {
    stretch = along(n, vector(before->stretch) + slide.way);
    slides = before->slides != 0.0;
    before->obstacle = -1.0;
  }

  const Vec3 velocity = along(n, slide.velocity);
  const Vec3 damping = grasp.damping * velocity;
  const auto pull = [&](const Vec3& e) { return Vec3(-grasp.stiffness * (e + along(n, slide.ahead)) - damping); };
  Vec3 force = pull(stretch);
  const double holds = material.friction * normalForce, drags = material.sliding * normalForce;
  slides = force.norm() > (slides ? drags : holds);
  if (slides) {
    force = shortened(force, drags);
    // What the spring would carry at this force, and no more than it can.
    stretch = shortened(-(force + damping) / grasp.stiffness - along(n, slide.ahead), drags / grasp.stiffness);
  }

  FrictionPoint& point = now_[slot];
  point = {static_cast<double>(contact.obstacle),   static_cast<double>(contact.part),
           static_cast<double>(contact.key),        {contact.point.x(), contact.point.y(), contact.point.z()},
           {stretch.x(), stretch.y(), stretch.z()}, slides ? 1.0 : 0.0};
  count_ += 1.0;
  return slides ? Vec3(force - material.viscosity * velocity) : force;
}

}  // namespace enamel
