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

constexpr double kFollow = 0.05;   // filter gain per tick for force, hardness and feed
constexpr double kMostOwed = 4.0;  // times the area and the height to which the surface is known
constexpr double kSeed = 1e-3;     // amplitude at which chatter begins, over the largest one
constexpr double kFacing = 0.1, kAhead = 0.7, kSide = 0.9;  // cosines
// Contacts beside the direction of the force are soft. A servo that is as stiff sideways as ahead holds a spinning bur
// in three directions, and encoder noise makes it chatter in each.
constexpr double kSideStiffness = 2e4;  // N/m

}  // namespace

Drill::Drill(const Tool& tool, std::vector<std::shared_ptr<Solid>> solids, const Bur& bur)
    : bur_(bur), parts_{bur.part, tool.head}, solids_(std::move(solids)) {
  if (bur.part < 0 || tool.head < 1 || bur.part + tool.head > tool.count)
    throw Error("the bur is part " + std::to_string(bur.part) + " of the tool" +
                (tool.head > 1 ? " and the next " + std::to_string(tool.head - 1) : "") +
                ", must be below its number of parts, " + std::to_string(tool.count));
  std::copy_n(tool.parts.begin() + bur.part, tool.head, head_.begin());
  radius_ = thinnest_ = head_[0].radius;
  Vec3 along = head_[0].b - head_[0].a;
  for (int i = 0; i < parts_.count; ++i) {
    const ToolPart& part = head_[static_cast<std::size_t>(i)];
    const std::string name = "the bur, part " + std::to_string(bur.part + i) + " of the tool,";
    if (!(part.radius > 0.0)) throw Error(name + " must have a radius greater than 0 mm");
    if (!(part.radius <= Solid::kLargestBur))
      throw Error(name + " has a radius of " + formatNumber(1e3 * part.radius) + " mm, must be at most " +
                  formatNumber(1e3 * Solid::kLargestBur) + " mm; are its lengths in metres?");
    radius_ = std::max(radius_, part.radius);
    thinnest_ = std::min(thinnest_, part.radius);
    if (const Vec3 other = part.b - part.a; other.norm() > along.norm()) along = other;
  }
  const auto refuse = [](const std::string& name, double value, const std::string& unit, const std::string& limits) {
    throw Error("the " + name + " of the bur is " + formatNumber(value) + unit + ", must be " + limits);
  };
  for (const BurNumber& number : kBurNumbers)
    if (const double value = bur.*number.value; !(value >= number.low && value <= number.high))
      refuse(number.key, value, number.unit, "in " + formatNumber(number.low) + " to " + formatNumber(number.high));
  if (!(bur.torque > 0.0)) refuse("torque", bur.torque, " N m", "above 0");
  if (bur.blades < 0 || bur.blades > kMostBlades)
    refuse("number of blades", bur.blades, "", "in 0 to " + std::to_string(kMostBlades));
  axes_ = frameAlong(along.squaredNorm() > 0.0 ? Vec3(along.normalized()) : Vec3(Vec3::UnitZ()));
  double length = 0.0;
  for (int i = 0; i < parts_.count; ++i) {
    const ToolPart& part = head_[static_cast<std::size_t>(i)];
    for (const Vec3& end : {part.a, part.b})
      length = std::max(length, std::abs(axes_.col(2).dot(end - head_[0].a)) + part.radius - radius_);
  }
  follow_ = std::isinf(bur.torque) || bur.turns == 0.0 ? 0.0 : bur.torque / (2.0 * M_PI * bur.inertia * bur.turns);
  chatterFrequency_ = bur.shaftFrequency * std::sqrt(1.0 + 2.0 * bur.shaftDamping);
  removal_ = bur.wear * 2.0 * M_PI * radius_ * bur.turns;
  area_ = (M_PI * radius_ + 2.0 * length) * radius_;
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
  wave_ = std::fmod(wave_ + chatterFrequency_ * elapsed, 1.0);
}

// Near the limit the amplitude grows at the rate 2 pi f (F / (2 k (1 + z) h) - z). The motor pays for what the shaft
// loses, and cannot give more than the cut takes.
void Drill::swing(double pressed, double elapsed) noexcept {
  const double passes = turns() * bur_.blades, bite = passes > 0.0 ? std::max(0.0, feed_) / passes : 0.0;
  const double give = bur_.shaftCompliance, damping = bur_.shaftDamping, rate = 2.0 * M_PI * bur_.shaftFrequency;
  if (!(give > 0.0 && bite > 0.0)) {
    chatter_ = 0.0;
    return;
  }
  const double turning = 2.0 * M_PI * turns(), loss = damping * rate / give;  // loss: power over amplitude^2
  const double most = std::min(bite / std::sqrt(2.0), std::sqrt(load_ * turning / loss));
  const double growth = rate * (0.5 * give * pressed / ((1.0 + damping) * bite) - damping);
  const double from = growth > 0.0 ? std::max(chatter_, kSeed * most) : chatter_;
  chatter_ = std::min(most, from * std::exp(growth * elapsed));
  load_ += loss * chatter_ * chatter_ / turning;
}

void Drill::vibrate(const Pose& pose, double period, ContactSnapshot& contacts) noexcept {
  shake_.setZero();
  const double turns = this->turns();
  if (!(turns > 0.0) || (bur_.runOut == 0.0 && bur_.blades == 0)) return;
  const Mat3 frame = pose.rotation * axes_;
  const auto rendered = [&](double rate, double amplitude) { return amplitude * sampledShare(1.0 / (rate * period)); };
  const double runOut = rendered(turns, bur_.runOut), angle = 2.0 * M_PI * phase_, rate = 2.0 * M_PI * turns;
  shake_ = runOut * (std::cos(angle) * frame.col(0) + std::sin(angle) * frame.col(1));
  Vec3 velocity = runOut * rate * (std::cos(angle) * frame.col(1) - std::sin(angle) * frame.col(0));
  if (bur_.blades > 0 && obstacle_ >= 0) {  // a blade bites half of its feed more and less than the mean
    const double bite = 0.5 * std::max(0.0, feed_) / (turns * bur_.blades);
    const double amplitude = rendered(bur_.blades * turns, bite);
    shake_ -= amplitude * std::cos(bur_.blades * angle) * way_;
    velocity += amplitude * bur_.blades * rate * std::sin(bur_.blades * angle) * way_;
    const double swing = rendered(chatterFrequency_, chatter_), wave = 2.0 * M_PI * wave_;
    shake_ -= swing * std::cos(wave) * way_;
    velocity += 2.0 * M_PI * chatterFrequency_ * swing * std::sin(wave) * way_;
  }
  for (int i = 0; i < contacts.count; ++i) {
    Contact& c = contacts.contacts[static_cast<std::size_t>(i)];
    if (!parts_.has(c.part)) continue;
    c.gap += shake_.dot(c.normal);
    c.obstacleVelocity -= velocity.dot(c.normal) * c.normal;
  }
}

void Drill::correct(ContactSnapshot& contacts) noexcept {
  const double feed = std::max(0.0, feed_);
  for (int i = 0; i < contacts.count; ++i) {
    Contact& c = contacts.contacts[static_cast<std::size_t>(i)];
    gaps_[static_cast<std::size_t>(i)] = c.gap;
    const double along = obstacle_ < 0 ? 1.0 : way_.dot(c.normal);
    c.gap += c.sunk * std::max(0.0, along);
    if (obstacle_ < 0 || c.obstacle != obstacle_ || !parts_.has(c.part)) continue;
    double back = rough_;
    if (along < kSide) c.material.stiffness = std::min(c.material.stiffness, kSideStiffness);
    if (along > kFacing) {
      back = std::max(back, advance_ * along);  // material that this tick will remove
      if (c.sunk == 0.0) c.obstacleVelocity -= feed * along * c.normal;
    }
    c.gap = std::max(c.gap, std::min(c.gap + back, 0.0));
  }
}

void Drill::lift() noexcept {
  removed_ = RemovedVolume{};
  lastCuts_ = {};
  obstacle_ = -1;
  rests_ = false;
  load_ = 0.0;
  force_.setZero();
  feed_ = recession_ = chatter_ = 0.0;
}

// Cut a solid with each part, on the way from the last tick to its place now.
RemovedVolume Drill::cutTo(Solid& solid, int number, const std::array<Segment, kMaxToolParts>& axes) noexcept {
  RemovedVolume sum{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(parts_.count); ++i) {
    const Segment &to = axes[i], from = obstacle_ == number ? last_[i] : to;
    double reached = 0.0;
    const RemovedVolume removed = solid.cut(from, to, head_[i].radius, &reached);
    for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += removed[k];
    last_[i] = to;
    if (reached > 0.0 && reached < 1.0)  // the next tick cuts the rest
      last_[i] = {from.a + reached * (to.a - from.a), from.b + reached * (to.b - from.b)};
    if (reached > 0.0) lastCuts_[i] = {number, from, last_[i], head_[i].radius};
  }
  return sum;
}

// Update the feed. While the bur rests on the surface, to within the height to which that is known, it moves with it.
// Otherwise the surface is at rest. `back`: the way back to the surface.
void Drill::follow(const Vec3& moved, double back, double elapsed) noexcept {
  const bool rests = back > -rough_;
  feed_ += kFollow * ((rests && rests_ ? -way_.dot(moved) / elapsed : 0.0) - feed_);
  rests_ = rests;
}

void Drill::cut(const Scene& scene, const Pose& pose, const Vec3& force, double elapsed,
                const ContactSnapshot& contacts) noexcept {
  const Contact* const first = contacts.contacts.data();
  const Contact* const end = first + contacts.count;
  const Contact* const deepest = std::find_if(first, end, [this](const Contact& c) {
    const auto obstacle = static_cast<std::size_t>(c.obstacle);
    return parts_.has(c.part) && obstacle < solids_.size() && solids_[obstacle] != nullptr;
  });
  turn(elapsed);
  if (deepest == end || deepest->isPunctured || !isOn_ || !force.allFinite()) return lift();
  lastCuts_ = {};
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
    rests_ = false;
  }
  force_ += kFollow * (force - force_);
  const double pressed = force_.norm();
  load_ = bur_.drag * pressed * radius_;
  way_ = pressed > 0.0 ? Vec3(force_ / pressed) : deepest->normal;
  rough_ = solid.cell() * solid.cell() / (4.0 * thinnest_);
  recession_ = removal_ * speed_ * pressed / (hardness_ * area_);
  const double asked = recession_ * area_ * elapsed + owed_;
  advance_ = std::max(0.0, asked / area_);

  // The bur cuts where it is, or where it rests on the surface if it is deeper, and as far ahead as the law wants.
  double depth = -rough_;
  for (const Contact* c = deepest; c != end; ++c)
    if (c->obstacle == number && parts_.has(c->part) && way_.dot(c->normal) >= kAhead)
      depth = std::max(depth, -gaps_[static_cast<std::size_t>(c - first)] / way_.dot(c->normal));
  const double back = std::max(0.0, depth) - advance_;
  std::array<Segment, kMaxToolParts> axes;
  for (std::size_t i = 0; i < static_cast<std::size_t>(parts_.count); ++i)
    axes[i] = {inSolid(pose.position + pose.rotation * head_[i].a + back * way_ + shake_),
               inSolid(pose.position + pose.rotation * head_[i].b + back * way_ + shake_)};
  const Vec3 moved = obstacle.pose.rotation * (axes[0].a - last_[0].a);
  removed_ = cutTo(solid, number, axes);
  const double volume = std::accumulate(removed_.begin(), removed_.end(), 0.0);
  if (volume > 0.0) {
    double weighted = 0.0;
    for (std::size_t k = 0; k < solid.layers().size(); ++k) weighted += removed_[k] * solid.layers()[k].hardness;
    hardness_ += kFollow * (weighted / volume - hardness_);
  }
  owed_ = std::clamp(asked - volume, -kMostOwed * area_ * rough_, kMostOwed * area_ * rough_);
  if (obstacle_ == number) follow(moved, depth, elapsed);
  swing(pressed, elapsed);
  obstacle_ = number;
}

}  // namespace enamel
