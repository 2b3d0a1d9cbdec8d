// What a contact query answers: a fixed-size snapshot that renderers read and never change.
#pragma once

#include <array>
#include <cstdint>

#include "enamel/collision/feature.hpp"
#include "enamel/collision/material.hpp"
#include "enamel/core/types.hpp"

namespace enamel {

/// One place where the tool is near or in an obstacle. In W.
struct Contact {
  Vec3 point = Vec3::Zero();             ///< point of the tool nearest to, or deepest in, the obstacle, m
  Vec3 normal = Vec3::UnitZ();           ///< outward unit normal of the obstacle there
  double gap = 0.0;                      ///< signed distance, m; negative inside the obstacle
  Vec3 obstacleVelocity = Vec3::Zero();  ///< of the obstacle's material at the point, m/s
  int obstacle = 0;                      ///< number of the obstacle in its scene
  Material material;                     ///< of the obstacle
  int part = -1;                         ///< number of the tool's part; -1: no contact
  int triangle = -1;                     ///< of the obstacle's mesh; -1: it has none
  Feature feature = Feature::face;       ///< of the triangle or shape, that the obstacle's nearest point lies on
  int featureIndex = -1;                 ///< which one, as Feature tells
  std::uint32_t key = 0;                 ///< the same from tick to tick, from followContacts(); 0: none
};

/// Most contacts that one query reports.
inline constexpr int kMaxContacts = 8;

/// All contacts of one tick, the deepest first. Plain data of fixed size.
struct ContactSnapshot {
  std::array<Contact, kMaxContacts> contacts{};
  int count = 0;
};

}  // namespace enamel
