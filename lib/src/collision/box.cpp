#include "enamel/collision/box.hpp"

namespace enamel {

Contact contactWith(const Box& box, const Vec3& toolPoint) noexcept {
  const Vec3 local = box.pose.rotation.transpose().lazyProduct(toolPoint - box.pose.position);
  const Vec3 beyond = local.cwiseAbs() - box.halfSize;  // of each pair of faces; negative between them
  const Vec3 outside = beyond.cwiseMax(0.0);
  const double distance = outside.stableNorm();
  Contact contact;
  contact.point = toolPoint;
  Vec3 normal = Vec3::Zero();
  if (distance > 0.0) {
    contact.gap = distance;
    for (int i = 0; i < 3; ++i) normal[i] = (local[i] < 0.0 ? -outside[i] : outside[i]) / distance;
  } else {
    int axis = 0;
    contact.gap = beyond.maxCoeff(&axis);
    normal[axis] = local[axis] < 0.0 ? -1.0 : 1.0;
  }
  contact.normal = box.pose.rotation.lazyProduct(normal);
  return contact;
}

}  // namespace enamel
