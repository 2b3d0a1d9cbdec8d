#include "enamel/render/drill.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "collision/bur_limits.hpp"
#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "enamel/render/roughness.hpp"

namespace enamel {
namespace {

constexpr double kFollow = 0.05;    // filter gain per tick for force, hardness and feed
constexpr double kMostFeed = 0.02;  // m/s
constexpr double kMostOwed = 4.0;
constexpr double kFacing = 0.1, kAhead = 0.7, kSide = 0.9;  // cosines
// Contacts beside the direction of the force are soft. A servo that is as stiff sideways as ahead holds a spinning bur
// in three directions, and encoder noise makes it chatter in each.
constexpr double kSideStiffness = 2e4;  // N/m

}  // namespace

Drill::Drill(const Tool& tool, std::vector<std::shared_ptr<Solid>> solids, const Bur& bur)
    : bur_(bur), solids_(std::move(solids)) {
  if (bur.part < 0 || bur.part >= tool.count)
    throw Error("the bur is part " + std::to_string(bur.part) + " of the tool, must be below its number of parts, " +
                std::to_string(tool.count));
  part_ = tool.parts[static_cast<std::size_t>(bur.part)];
  if (!(part_.radius > 0.0))
    throw Error("the bur, part " + std::to_string(bur.part) + " of the tool, must have a radius greater than 0 mm");
  if (!(part_.radius <= Solid::kLargestBur))
    throw Error("the bur, part " + std::to_string(bur.part) + " of the tool, has a radius of " +
                formatNumber(1e3 * part_.radius) + " mm, must be at most " + formatNumber(1e3 * Solid::kLargestBur) +
                " mm; are its lengths in metres?");
  const auto refuse = [](const std::string& name, double value, const std::string& unit, const std::string& limits) {
    throw Error("the " + name + " of the bur is " + formatNumber(value) + unit + ", must be " + limits);
  };
  for (const BurNumber& number : kBurNumbers)
    if (const double value = bur.*number.value; !(value >= number.low && value <= number.high))
      refuse(number.key, value, number.unit, "in " + formatNumber(number.low) + " to " + formatNumber(number.high));
  if (!(bur.torque > 0.0)) refuse("torque", bur.torque, " N m", "above 0");
  if (bur.blades < 0 || bur.blades > kMostBlades)
    refuse("number of blades", bur.blades, "", "in 0 to " + std::to_string(kMostBlades));
  const Vec3 along = part_.b - part_.a;
  axes_ = frameAlong(along.squaredNorm() > 0.0 ? Vec3(along.normalized()) : Vec3(Vec3::UnitZ()));
  follow_ = std::isinf(bur.torque) || bur.turns == 0.0 ? 0.0 : bur.torque / (2.0 * M_PI * bur.inertia * bur.turns);
  removal_ = bur.wear * 2.0 * M_PI * part_.radius * bur.turns;
  area_ = (M_PI * part_.radius + 2.0 * along.norm()) * part_.radius;
}

void Drill::spin(bool on) noexcept {
  isOn_ = on;
  if (follow_ == 0.0) speed_ = on ? 1.0 : 0.0;
}

// The speed under a constant load is known exactly: it approaches its equilibrium exponentially.
void Drill::turn(double elapsed) noexcept {
  if (follow_ > 0.0) {
    const double goal = (isOn_ ? 1.0 : 0.0) - load_ / bur_.torque;
    speed_ = std::max(0.0, goal + (speed_ - goal) * std::exp(-follow_ * elapsed));
  }
  phase_ = std::fmod(phase_ + turns() * elapsed, 1.0);
}

void Drill::vibrate(const Pose& pose, double period, ContactSnapshot& contacts) noexcept {
  head_.setZero();
  const double turns = this->turns();
  if (!(turns > 0.0) || (bur_.runOut == 0.0 && bur_.blades == 0)) return;
  const Mat3 frame = pose.rotation * axes_;
  const auto rendered = [&](double rate, double amplitude) { return amplitude * sampledShare(1.0 / (rate * period)); };
  const double runOut = rendered(turns, bur_.runOut), angle = 2.0 * M_PI * phase_, rate = 2.0 * M_PI * turns;
  head_ = runOut * (std::cos(angle) * frame.col(0) + std::sin(angle) * frame.col(1));
  Vec3 velocity = runOut * rate * (std::cos(angle) * frame.col(1) - std::sin(angle) * frame.col(0));
  if (bur_.blades > 0 && obstacle_ >= 0) {  // a blade bites half of its feed more and less than the mean
    const double bite = 0.5 * std::clamp(feed_, 0.0, kMostFeed) / (turns * bur_.blades);
    const double amplitude = rendered(bur_.blades * turns, bite);
    head_ -= amplitude * std::cos(bur_.blades * angle) * way_;
    velocity += amplitude * bur_.blades * rate * std::sin(bur_.blades * angle) * way_;
  }
  for (int i = 0; i < contacts.count; ++i) {
    Contact& c = contacts.contacts[static_cast<std::size_t>(i)];
    if (c.part != bur_.part) continue;
    c.gap += head_.dot(c.normal);
    c.obstacleVelocity -= velocity.dot(c.normal) * c.normal;
  }
}

void Drill::correct(ContactSnapshot& contacts) noexcept {
  for (int i = 0; i < contacts.count; ++i) gaps_[static_cast<std::size_t>(i)] = contacts.contacts[i].gap;
  if (obstacle_ < 0) return;
  const double feed = std::clamp(feed_, 0.0, kMostFeed);
  for (int i = 0; i < contacts.count; ++i) {
    Contact& c = contacts.contacts[i];
    if (c.obstacle != obstacle_ || c.part != bur_.part) continue;
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
  load_ = 0.0;
  force_.setZero();
  feed_ = recession_ = 0.0;
}

void Drill::cut(const Scene& scene, const Pose& pose, const Vec3& force, double elapsed,
                const ContactSnapshot& contacts) noexcept {
  const Contact* const first = contacts.contacts.data();
  const Contact* const end = first + contacts.count;
  const Contact* const deepest = std::find_if(first, end, [this](const Contact& c) {
    const auto obstacle = static_cast<std::size_t>(c.obstacle);
    return c.part == bur_.part && obstacle < solids_.size() && solids_[obstacle] != nullptr;
  });
  turn(elapsed);
  if (deepest == end || deepest->isPunctured || !isOn_ || !force.allFinite()) return lift();
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
  load_ = bur_.drag * pressed * part_.radius;
  way_ = pressed > 0.0 ? Vec3(force_ / pressed) : deepest->normal;
  rough_ = solid.cell() * solid.cell() / (4.0 * part_.radius);
  recession_ = removal_ * speed_ * pressed / (hardness_ * area_);
  const double asked = recession_ * area_ * elapsed + owed_;
  advance_ = std::clamp(asked / area_, 0.0, kMostFeed * elapsed + rough_);

  // Retract the bur until no contact is deeper than this tick's advance.
  double back = -rough_;
  for (const Contact* c = deepest; c != end; ++c) {
    const double gap = gaps_[static_cast<std::size_t>(c - first)];
    if (c->obstacle != number || c->part != bur_.part || gap >= 0.0 || way_.dot(c->normal) < kAhead) continue;
    back = std::max(back, -gap / way_.dot(c->normal) - advance_);
  }
  const Segment axis{inSolid(pose.position + pose.rotation * part_.a + back * way_ + head_),
                     inSolid(pose.position + pose.rotation * part_.b + back * way_ + head_)};
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
