// Contacts for the tests.
#pragma once

#include "enamel/collision/scene.hpp"
#include "support/catch.hpp"

namespace enamel::test {

inline Tool sphereTool(double radius, const Vec3& centre = Vec3::Zero()) {
  Tool tool;
  tool.parts[0] = {centre, centre, radius};
  tool.count = 1;
  return tool;
}

inline Pose at(const Vec3& position) { return {position, Mat3::Identity()}; }

inline ContactSnapshot contactsOf(const Scene& scene, const Tool& tool, const Pose& pose, double margin,
                                  ToolCache* cache = nullptr) {
  ContactSnapshot contacts;
  REQUIRE(findContacts(scene, tool, pose, margin, cache, contacts) == Status::ok);
  return contacts;
}

/// To the bit.
inline bool areEqual(const ContactSnapshot& a, const ContactSnapshot& b) {
  if (a.count != b.count) return false;
  for (int i = 0; i < a.count; ++i)
    if (a.contacts[i].gap != b.contacts[i].gap || a.contacts[i].point != b.contacts[i].point ||
        a.contacts[i].normal != b.contacts[i].normal || a.contacts[i].obstacle != b.contacts[i].obstacle)
      return false;
  return true;
}

}  // namespace enamel::test
