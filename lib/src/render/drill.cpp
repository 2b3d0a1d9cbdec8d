#include "enamel/render/drill.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/message.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

constexpr double kMostTurns = 1e4;
constexpr double kFollow = 0.05;    // filter gain per tick for force, hardness and feed
constexpr double kMostFeed = 0.02;  // m/s
constexpr double kMostOwed = 4.0;
constexpr double kFacing = 0.1, kAhead = 0.7, kSide = 0.9;  // cosines
// Contacts beside the direction of the force are soft. A servo that is as stiff sideways as ahead holds a spinning bur
// in three directions, and encoder noise makes it chatter in each.
constexpr double kSideStiffness = 2e4;  // N/m

}  // namespace

Drill::Drill(const Tool& tool, std::vector<std::shared_ptr<Solid>> solids, const Bur& bur)
    : number_(bur.part), solids_(std::move(solids)) {
  if (number_ < 0 || number_ >= tool.count)
    throw Error("the bur is part " + std::to_string(number_) + " of the tool, must be below its number of parts, " +
                std::to_string(tool.count));
  part_ = tool.parts[static_cast<std::size_t>(number_)];
  if (!(part_.radius > 0.0))
    throw Error("the bur, part " + std::to_string(number_) + " of the tool, must have a radius greater than 0 mm");
  if (!(part_.radius <= Solid::kLargestBur))
    throw Error("the bur, part " + std::to_string(number_) + " of the tool, has a radius of " +
                formatNumber(1e3 * part_.radius) + " mm, must be at most " + formatNumber(1e3 * Solid::kLargestBur) +
                " mm; are its lengths in metres?");
  if (!(bur.wear > 0.0 && std::isfinite(bur.wear)))
    throw Error("the wear of the bur is " + formatNumber(bur.wear) + ", must be positive and finite");
  if (!(bur.turns >= 0.0 && bur.turns <= kMostTurns))
    throw Error("the bur turns " + formatNumber(bur.turns) + " times a second, must be 0 to 10000");
  removal_ = bur.wear * 2.0 * M_PI * part_.radius * bur.turns;
  area_ = (M_PI * part_.radius + 2.0 * (part_.b - part_.a).norm()) * part_.radius;
}

void Drill::correct(ContactSnapshot& contacts) noexcept {
  for (int i = 0; i < contacts.count; ++i) gaps_[static_cast<std::size_t>(i)] = contacts.contacts[i].gap;
  if (obstacle_ < 0) return;
  const double feed = std::clamp(feed_, 0.0, kMostFeed);
  for (int i = 0; i < contacts.count; ++i) {
    Contact& c = contacts.contacts[i];
    if (c.obstacle != obstacle_ || c.part != number_) continue;
    const double along = way_.dot(c.normal);
    double back = rough_;
    if (along < kSide) c.material.stiffness = std::min(c.material.stiffness, kSideStiffness);
    if (along > kFacing) {
      back = std::max(back, advance_ * along);  // material that this tick will remove
      c.obstacleVelocity -= feed * along * c.normal;
    }
    c.gap = std::max(c.gap, std::min(c.gap + back, 0.0));
  }
}

void Drill::lift() noexcept {
  removed_ = RemovedVolume{};
  lastCut_.obstacle = obstacle_ = -1;
  force_.setZero();
  feed_ = 0.0;
}

void Drill::cut(const Scene& scene, const Pose& pose, const Vec3& force, double elapsed,
                const ContactSnapshot& contacts) noexcept {
  const Contact* const first = contacts.contacts.data();
  const Contact* const end = first + contacts.count;
  const Contact* const deepest = std::find_if(first, end, [this](const Contact& c) {
    const auto obstacle = static_cast<std::size_t>(c.obstacle);
    return c.part == number_ && obstacle < solids_.size() && solids_[obstacle] != nullptr;
  });
  if (deepest == end || !isOn_ || !force.allFinite()) return lift();
  lastCut_.obstacle = -1;
  const int number = deepest->obstacle;
  const Obstacle& obstacle = scene.obstacles()[static_cast<std::size_t>(number)];
  Solid& solid = *solids_[static_cast<std::size_t>(number)];
  const auto inSolid = [&](const Vec3& p) {
    return Vec3(obstacle.pose.rotation.transpose() * (p - obstacle.pose.position));
  };
  if (obstacle_ != number) {
    const int layer = solid.layerAt(inSolid(deepest->point - 0.5 * solid.cell() * deepest->normal));
    hardness_ = solid.layers()[static_cast<std::size_t>(layer)].hardness;
    feed_ = owed_ = 0.0;
  }
  force_ += kFollow * (force - force_);
  const double pressed = force_.norm();
  way_ = pressed > 0.0 ? Vec3(force_ / pressed) : deepest->normal;
  rough_ = solid.cell() * solid.cell() / (4.0 * part_.radius);
  const double asked = removal_ * pressed / hardness_ * elapsed + owed_;
  advance_ = std::clamp(asked / area_, 0.0, kMostFeed * elapsed + rough_);

  // Retract the bur until no contact is deeper than this tick's advance.
  double back = -rough_;
  for (const Contact* c = deepest; c != end; ++c) {
    const double gap = gaps_[static_cast<std::size_t>(c - first)];
    if (c->obstacle != number || c->part != number_ || gap >= 0.0 || way_.dot(c->normal) < kAhead) continue;
    back = std::max(back, -gap / way_.dot(c->normal) - advance_);
  }
  const Segment axis{inSolid(pose.position + pose.rotation * part_.a + back * way_),
                     inSolid(pose.position + pose.rotation * part_.b + back * way_)};
  const Segment from = obstacle_ == number ? last_ : axis;
  double reached = 0.0;
  removed_ = solid.cut(from, axis, part_.radius, &reached);
  const double volume = std::accumulate(removed_.begin(), removed_.end(), 0.0);
  if (volume > 0.0) {
    double weighted = 0.0;
    for (std::size_t k = 0; k < solid.layers().size(); ++k) weighted += removed_[k] * solid.layers()[k].hardness;
    hardness_ += kFollow * (weighted / volume - hardness_);
  }
  owed_ = std::clamp(asked - volume, -kMostOwed * area_ * rough_, kMostOwed * area_ * rough_);
  // While the bur cuts, the tool moves with the surface.
  const Vec3 moved = obstacle.pose.rotation * (axis.a - last_.a);
  if (obstacle_ == number) feed_ += kFollow * (-way_.dot(moved) / elapsed - feed_);
  obstacle_ = number;
  last_ = axis;
  if (reached > 0.0 && reached < 1.0)  // the next tick cuts the rest
    last_ = {from.a + reached * (axis.a - from.a), from.b + reached * (axis.b - from.b)};
  if (reached > 0.0) lastCut_ = {number, from, last_, part_.radius};
}

}  // namespace enamel
