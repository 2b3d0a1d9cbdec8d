#include "support/contacts.hpp"

#include <algorithm>

#include "support/catch.hpp"
#include "support/meshes.hpp"

namespace enamel::test {

Tool sphereTool(double radius, const Vec3& centre) {
  Tool tool;
  tool.parts[0] = {centre, centre, radius};
  tool.count = 1;
  return tool;
}

Pose at(const Vec3& position) { return {position, Mat3::Identity()}; }

ContactSnapshot contactsOf(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache) {
  ContactSnapshot contacts;
  REQUIRE(findContacts(scene, tool, pose, margin, cache, contacts) == Status::ok);
  return contacts;
}

double distanceFromFeature(const Scene& scene, const Contact& contact, const Vec3& x) {
  const Obstacle& obstacle = scene.obstacles().at(static_cast<std::size_t>(contact.obstacle));
  const Vec3 p = obstacle.pose.rotation.transpose() * (x - obstacle.pose.position);
  if (const auto* box = std::get_if<Box>(&obstacle.shape)) {
    REQUIRE(contact.triangle == -1);
    Vec3 nearest;
    int sides = 0, rest = contact.featureIndex;
    for (int k = 0; k < 3; ++k, rest /= 3) {
      const int side = rest % 3 - 1;
      sides += side * side;
      nearest[k] = side == 0 ? std::clamp(p[k], -box->half[k], box->half[k]) : side * box->half[k];
    }
    REQUIRE(sides == static_cast<int>(contact.feature) + 1);
    return (p - nearest).norm();
  }
  const TriangleMesh& mesh = std::get<std::shared_ptr<const MeshModel>>(obstacle.shape)->mesh();
  const std::array<int, 3>& t = mesh.triangles.at(static_cast<std::size_t>(contact.triangle));
  const auto corner = [&](int i) {
    return mesh.vertices[static_cast<std::size_t>(t[static_cast<std::size_t>(i % 3)])];
  };
  const int i = contact.featureIndex;
  REQUIRE((contact.feature == Feature::face ? i == -1 : i >= 0 && i < 3));
  if (contact.feature == Feature::face) return referenceDistance(p, corner(0), corner(1), corner(2));
  if (contact.feature == Feature::edge) return referenceDistance(p, corner(i), corner(i + 1), corner(i + 1));
  return (p - corner(i)).norm();
}

double identityError(const Scene& scene, const Tool& tool, const Pose& pose, const Contact& contact) {
  const ToolPart& part = tool.parts.at(static_cast<std::size_t>(contact.part));
  const Vec3 centre = contact.point + part.radius * contact.normal;
  const Vec3 a = pose.rotation * part.a + pose.position, b = pose.rotation * part.b + pose.position;
  return std::max(referenceDistance(centre, a, b, b),
                  distanceFromFeature(scene, contact, contact.point - contact.gap * contact.normal));
}

bool areEqual(const Contact& a, const Contact& b) {
  return a.gap == b.gap && a.point == b.point && a.normal == b.normal && a.obstacleVelocity == b.obstacleVelocity &&
         a.obstacle == b.obstacle && a.material.stiffness == b.material.stiffness &&
         a.material.friction == b.material.friction && a.part == b.part && a.triangle == b.triangle &&
         a.feature == b.feature && a.featureIndex == b.featureIndex;
}

bool areEqual(const ContactSnapshot& a, const ContactSnapshot& b) {
  return std::equal(a.contacts.begin(), a.contacts.begin() + a.count, b.contacts.begin(), b.contacts.begin() + b.count,
                    [](const Contact& x, const Contact& y) { return areEqual(x, y); });
}

}  // namespace enamel::test
