// Contacts for the tests.
#pragma once

#include <algorithm>

#include "enamel/collision/contacts.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"

namespace enamel::test {

Tool sphereTool(double radius, const Vec3& centre = Vec3::Zero());

Pose at(const Vec3& position);

ContactSnapshot contactsOf(const Scene& scene, const Tool& tool, const Pose& pose, double margin,
                           ToolCache* cache = nullptr);

/// Return the distance of x (W) from the feature that a contact with a mesh or a box names, m.
double distanceFromFeature(const Scene& scene, const Contact& contact, const Vec3& x);

/// Return how far the contact's point is from its tool part's surface, and the obstacle's point from the feature, m.
double identityError(const Scene& scene, const Tool& tool, const Pose& pose, const Contact& contact);

/// Compare bit for bit.
bool areEqual(const Contact& a, const Contact& b);

bool areEqual(const ContactSnapshot& a, const ContactSnapshot& b);

}  // namespace enamel::test
