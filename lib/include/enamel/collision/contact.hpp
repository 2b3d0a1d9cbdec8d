// The result of a contact query: a snapshot of fixed size that renderers only read.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "enamel/collision/feature.hpp"
#include "enamel/collision/material.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// One place where the tool is near or inside an obstacle, in W.
struct Contact {
  Vec3 point = Vec3::Zero();             ///< tool point nearest to, or deepest in, the obstacle, m
  Vec3 normal = Vec3::UnitZ();           ///< outward unit normal of the obstacle at the contact
  double gap = 0.0;                      ///< signed distance, m; negative inside the obstacle
  Vec3 obstacleVelocity = Vec3::Zero();  ///< velocity of the obstacle's material at the point, m/s
  int obstacle = 0;                      ///< number of the obstacle in its scene
  Material material;                     ///< material of the obstacle, or of the layer of a solid
  double compression = -1.0;             ///< of a compliant layer at the last tick, m; below 0: no layer
  bool isPunctured = false;              ///< the layer is broken: gap and material are those of the ground below
  double sunk = 0.0;                     ///< so deep is a bur that has not yet cut what it had compressed, m
  double grip = 0.0;                     ///< of the hole in a broken layer: normal force of its walls on the tool, N
  int part = -1;                         ///< number of the tool's part; -1: no contact
  int triangle = -1;                     ///< triangle of the obstacle's mesh; -1: no mesh
  Feature feature = Feature::face;       ///< feature of the triangle or shape at the obstacle's nearest point
  int featureIndex = -1;                 ///< see Feature
  std::uint32_t key = 0;                 ///< constant from tick to tick in followContacts(); 0: no key
};

/// Largest number of contacts that one query reports.
inline constexpr int kMaxContacts = 8;

/// All contacts of one tick, the deepest first. Plain data of fixed size.
struct ContactSnapshot {
  std::array<Contact, kMaxContacts> contacts{};
  int count = 0;
  int omitted = 0;  ///< shallower contacts within the margin for which there was no room
};

/// Put the contacts in order again after their gaps changed. Equal ones keep their order. Realtime: yes.
inline void sortByDepth(ContactSnapshot& contacts) noexcept {
  const auto first = contacts.contacts.begin();
  const auto isDeeper = [](const Contact& a, const Contact& b) { return a.gap < b.gap; };
  for (int i = 1; i < contacts.count; ++i)  // std::stable_sort allocates
    std::rotate(std::upper_bound(first, first + i, first[i], isDeeper), first + i, first + i + 1);
}

}  // namespace enamel
