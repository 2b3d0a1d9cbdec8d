#include "enamel/render/drill.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "enamel/render/roughness.hpp"

namespace enamel {
namespace {

constexpr double kMostTurns = 1e4;
constexpr double kLeastRotor = 1e-12, kMostRotor = 1e-3, kMostDrag = 10.0, kMostRunOut = 1e-4;
constexpr int kMostBlades = 100;
constexpr double kFollow = 0.05;    // filter gain per tick for force, hardness and feed
constexpr double kMostFeed = 0.02;  // m/s
constexpr double kMostOwed = 4.0;
constexpr double kPartly = 4.0;                             // area of a bur over the least area that cuts
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
  const auto require = [](bool isValid, const char* what, double value, const char* limits) {
    if (!isValid) throw Error("the " + std::string(what) + " of the bur is " + formatNumber(value) + limits);
  };
  require(bur.torque > 0.0, "torque", bur.torque, " N m, must be above 0");
  require(bur.inertia >= kLeastRotor && bur.inertia <= kMostRotor, "inertia", bur.inertia,
          " kg m^2, must be in 1e-12 to 1e-3");
  require(bur.drag >= 0.0 && bur.drag <= kMostDrag, "drag", bur.drag, ", must be in 0 to 10");
  require(bur.runOut >= 0.0 && bur.runOut <= kMostRunOut, "run-out", bur.runOut, " m, must be in 0 to 1e-4");
  require(bur.blades >= 0 && bur.blades <= kMostBlades, "number of blades", bur.blades, ", must be in 0 to 100");
  free_ = bur.turns;
  torque_ = bur.torque;
  follow_ = std::isinf(torque_) || free_ == 0.0 ? 0.0 : torque_ / (2.0 * M_PI * bur.inertia * free_);
  drag_ = bur.drag;
  runOut_ = bur.runOut;
  blades_ = bur.blades;
  removal_ = bur.wear * 2.0 * M_PI * part_.radius * bur.turns;
  area_ = (M_PI * part_.radius + 2.0 * (part_.b - part_.a).norm()) * part_.radius;
}

void Drill::spin(bool on) noexcept {
  isOn_ = on;
  if (follow_ == 0.0) speed_ = on ? 1.0 : 0.0;
}

// The speed under a constant load is known exactly: it approaches its equilibrium exponentially.
void Drill::turn(double elapsed) noexcept {
  if (follow_ > 0.0) {
    const double goal = (isOn_ ? 1.0 : 0.0) - load_ / torque_;
    speed_ = std::max(0.0, goal + (speed_ - goal) * std::exp(-follow_ * elapsed));
  }
  phase_ = std::fmod(phase_ + speed_ * free_ * elapsed, 1.0);
}

void Drill::vibrate(const Pose& pose, double period, ContactSnapshot& contacts) noexcept {
  head_.setZero();
  const double turns = speed_ * free_;
  if (!(turns > 0.0) || (runOut_ == 0.0 && blades_ == 0)) return;
  const Vec3 along = part_.b - part_.a;
  const Vec3 axis = pose.rotation * (along.squaredNorm() > 0.0 ? Vec3(along.normalized()) : Vec3(Vec3::UnitZ()));
  const Mat3 frame = frameAlong(axis);
  const auto rendered = [&](double rate, double amplitude) { return amplitude * sampledShare(1.0 / (rate * period)); };
  const double runOut = rendered(turns, runOut_), angle = 2.0 * M_PI * phase_, rate = 2.0 * M_PI * turns;
  head_ = runOut * (std::cos(angle) * frame.col(0) + std::sin(angle) * frame.col(1));
  Vec3 velocity = runOut * rate * (std::cos(angle) * frame.col(1) - std::sin(angle) * frame.col(0));
  if (blades_ > 0 && obstacle_ >= 0) {  // a blade bites half of its feed more and less than the mean
    const double bite = 0.5 * std::clamp(feed_, 0.0, kMostFeed) / (turns * blades_);
    const double amplitude = rendered(blades_ * turns, bite);
    head_ -= amplitude * std::cos(blades_ * angle) * way_;
    velocity += amplitude * blades_ * rate * std::sin(blades_ * angle) * way_;
  }
  for (int i = 0; i < contacts.count; ++i) {
    Contact& c = contacts.contacts[static_cast<std::size_t>(i)];
    if (c.part != number_) continue;
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
  load_ = 0.0;
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
  load_ = drag_ * pressed * part_.radius;
  way_ = pressed > 0.0 ? Vec3(force_ / pressed) : deepest->normal;
  rough_ = solid.cell() * solid.cell() / (4.0 * part_.radius);
  const double rate = removal_ * speed_ * pressed / hardness_, asked = rate * elapsed + owed_;
  advance_ = std::clamp(asked / area_, 0.0, kMostFeed * elapsed + rough_);

  // Retract the bur until no contact is deeper than this tick's advance.
  double back = -rough_;
  for (const Contact* c = deepest; c != end; ++c) {
    const double gap = gaps_[static_cast<std::size_t>(c - first)];
    if (c->obstacle != number || c->part != number_ || gap >= 0.0 || way_.dot(c->normal) < kAhead) continue;
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
  // While the bur cuts, the tool moves with the surface. A tool that moves faster than the bur can cut is in the air.
  const Vec3 moved = obstacle.pose.rotation * (axis.a - last_.a);
  if (obstacle_ == number)
    feed_ = std::min(feed_ + kFollow * (-way_.dot(moved) / elapsed - feed_), kPartly * rate / area_);
  obstacle_ = number;
  last_ = axis;
  if (reached > 0.0 && reached < 1.0)  // the next tick cuts the rest
    last_ = {from.a + reached * (axis.a - from.a), from.b + reached * (axis.b - from.b)};
  if (reached > 0.0) lastCut_ = {number, from, last_, part_.radius};
}

}  // namespace enamel
