#include "enamel/render/scene_motion.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

namespace enamel {
namespace {

constexpr double kLongestFrame = 0.1;                    // s: a newer pose belongs to a motion
constexpr double kStretch = 1.2;                         // of a frame: how late the next one may be
constexpr double kTwistError = 0.5;                      // share of the stated twist, or of the motion
constexpr double kLeastSpeed = 1e-3, kLeastTurn = 0.02;  // m/s, rad/s: smaller differences do not count

bool isSame(const Pose& a, const Pose& b) noexcept { return a.position == b.position && a.rotation == b.rotation; }

// Twist [v; w] in W between two poses that are `time` s apart.
Vec6 twistBetween(const Pose& from, const Pose& to, double time) noexcept {
  Vec6 twist;
  twist << (to.position - from.position) / time, rotationVector(to.rotation * from.rotation.transpose()) / time;
  return twist;
}

bool agrees(const Vec3& stated, const Vec3& real, double least) noexcept {
  return (stated - real).norm() <= std::max(least, kTwistError * std::max(stated.norm(), real.norm()));
}

bool agrees(const Vec6& stated, const Vec6& real) noexcept {
  return agrees(stated.head<3>(), real.head<3>(), kLeastSpeed) && agrees(stated.tail<3>(), real.tail<3>(), kLeastTurn);
}

}  // namespace

SceneMotion::SceneMotion(const Scene& scene) : scene_(scene), glides_(scene.obstacles().size()) {
  for (std::size_t i = 0; i < glides_.size(); ++i)
    if (scene.obstacles()[i].suspension) bodies_.push_back({static_cast<int>(i), {}, Vec6::Zero(), {}});
  reset(scene);
}

void SceneMotion::reset(const Scene& stated) noexcept {
  goToStated(stated);
  for (Body& body : bodies_) body.state = {};
}

void SceneMotion::goToStated(const Scene& stated) noexcept {
  for (std::size_t i = 0; i < glides_.size() && i < stated.obstacles().size(); ++i) {
    glides_[i] = {stated.obstacles()[i].pose, 0.0, 0.0, Vec6::Zero()};
    (void)scene_.move(static_cast<int>(i), glides_[i].goal, Vec6::Zero());
    (void)scene_.activate(static_cast<int>(i), stated.obstacles()[i].active);
  }
  for (Body& body : bodies_) body.rest = scene_.obstacles()[static_cast<std::size_t>(body.obstacle)].pose;
  started_ = false;
}

void SceneMotion::takeOver(const SceneMotion& old) noexcept {
  if (!old.started_) return;
  started_ = true;
  time_ = old.time_;
  ignored_ = old.ignored_;
  ignoredObstacle_ = old.ignoredObstacle_;
  for (std::size_t i = 0; i < glides_.size(); ++i) {
    glides_[i].set = time_ - kLongestFrame;
    if (!isSameObstacle(old.scene_, scene_, i)) continue;
    const Obstacle& moved = old.scene_.obstacles()[i];
    const Body* const body = old.find(static_cast<int>(i));
    glides_[i] = old.glides_[i];
    (void)scene_.move(static_cast<int>(i), body ? body->rest : moved.pose, body ? body->restTwist : moved.twist);
  }
  for (Body& body : bodies_) {
    const Body* const before = old.find(body.obstacle);
    if (before && isSameObstacle(old.scene_, scene_, static_cast<std::size_t>(body.obstacle))) body = *before;
    (void)place(body);
  }
}

const Scene& SceneMotion::follow(const Scene& stated, double time, double elapsed) noexcept {
  for (const Body& body : bodies_) (void)scene_.move(body.obstacle, body.rest, body.restTwist);
  if (!started_) {
    goToStated(stated);
    for (Glide& glide : glides_) glide.set = time - kLongestFrame;
    started_ = true;
  }
  const double before = std::exchange(time_, time);
  for (std::size_t i = 0; i < glides_.size() && i < stated.obstacles().size(); ++i)
    followOne(stated.obstacles()[i], static_cast<int>(i), before);
  for (Body& body : bodies_) {
    const Obstacle& obstacle = scene_.obstacles()[static_cast<std::size_t>(body.obstacle)];
    body.rest = obstacle.pose;
    body.restTwist = obstacle.twist;
    if (!obstacle.active) body.state = {};
    const Vec6 last = body.state.offset;
    advance(of(body), elapsed, body.state);
    if (place(body)) continue;
    body.state = {};
    body.state.offset = last;  // it is farther or faster than a scene allows
    (void)place(body);
  }
  return scene_;
}

void SceneMotion::followOne(const Obstacle& stated, int number, double before) noexcept {
  Glide& glide = glides_[static_cast<std::size_t>(number)];
  if (stated.active != scene_.obstacles()[static_cast<std::size_t>(number)].active) {
    (void)scene_.activate(number, stated.active);
    (void)scene_.move(number, stated.pose, Vec6::Zero());  // it appears at its stated pose, at rest
    glide = {stated.pose, time_ - kLongestFrame, 0.0, Vec6::Zero()};
    return;
  }
  const Pose& pose = scene_.obstacles()[static_cast<std::size_t>(number)].pose;
  const bool isNew = !isSame(stated.pose, glide.goal);
  if (!isNew && glide.left == 0.0 && glide.twist.isZero(0.0) && stated.twist.isZero(0.0)) return;  // most obstacles
  const double elapsed = time_ - before, since = std::min(time_ - glide.set, kLongestFrame);
  if (!isNew && glide.left == 0.0) glide.twist.setZero();
  Vec6 measured = glide.twist;  // from the poses
  if (isNew) {
    measured = twistBetween(glide.goal, stated.pose, since);
    if (glide.set == before) {  // a new pose in every tick
      glide.left = elapsed;
      glide.twist = agrees(stated.twist, measured) ? stated.twist : measured;
    } else {
      glide.left = std::max(elapsed, kStretch * since);
      glide.twist = twistBetween(pose, stated.pose, glide.left);
    }
    glide.goal = stated.pose;
    glide.set = time_;
  }
  const bool begins = isNew && since == kLongestFrame;  // the first pose of a motion says nothing about the velocity
  if (!begins && !stated.twist.isZero(0.0) && !agrees(stated.twist, measured)) {
    ++ignored_;
    ignoredObstacle_ = number;
  }
  if (glide.left > elapsed * (1.0 + 1e-9)) {
    Pose next;
    next.position = pose.position + elapsed * glide.twist.head<3>();
    next.rotation = rotationFromVector(elapsed * glide.twist.tail<3>()) * pose.rotation;
    glide.left -= elapsed;
    if (scene_.move(number, next, glide.twist) == Status::ok) return;  // otherwise rounding has spoilt the rotation
  }
  glide.left = 0.0;
  (void)scene_.move(number, glide.goal, glide.twist);
}

// Move an obstacle to where its suspension lets it be.
bool SceneMotion::place(const Body& body) noexcept {
  const Vec3& centre = of(body).centre;
  const Mat3& axes = body.rest.rotation;
  const SuspendedState& s = body.state;
  Pose pose;
  pose.rotation = axes * rotationFromVector(s.offset.tail<3>());
  pose.position = body.rest.position + axes * (centre + s.offset.head<3>()) - pose.rotation * centre;
  const Vec3 turn = axes * s.velocity.tail<3>();
  Vec6 twist = body.restTwist;
  twist.head<3>() += axes * s.velocity.head<3>() - turn.cross(pose.rotation * centre) +
                     body.restTwist.tail<3>().cross(pose.position - body.rest.position);
  twist.tail<3>() += turn;
  return scene_.move(body.obstacle, pose, twist) == Status::ok;
}

const Suspension& SceneMotion::of(const Body& body) const noexcept {
  return *scene_.obstacles()[static_cast<std::size_t>(body.obstacle)].suspension;
}

const SceneMotion::Body* SceneMotion::find(int obstacle) const noexcept {
  const auto body = std::find_if(bodies_.begin(), bodies_.end(), [&](const Body& b) { return b.obstacle == obstacle; });
  return body == bodies_.end() ? nullptr : &*body;
}

const SuspendedState* SceneMotion::suspended(int obstacle) const noexcept {
  const Body* const body = find(obstacle);
  return body ? &body->state : nullptr;
}

void SceneMotion::yieldAt(const ContactSnapshot& contacts, double period, double scale,
                          ContactYield& yield) const noexcept {
  yield.isAny = false;
  if (bodies_.empty()) return;
  std::array<const Body*, kMaxContacts> body;
  std::array<Eigen::Matrix<double, 3, 6>, kMaxContacts>
      point;  // velocity of the contact's point, W, by that of the body
  const auto count = static_cast<std::size_t>(contacts.count);
  for (std::size_t i = 0; i < count; ++i) {
    const Contact& contact = contacts.contacts[i];
    body[i] = find(contact.obstacle);
    yield.velocity[i] = yield.after[i] = Vec3::Zero();
    if (!body[i]) continue;
    yield.isAny = true;
    for (int axis = 0; axis < 3; ++axis)
      point[i].row(axis) = wrenchAt(*body[i], contact.point, Vec3::Unit(axis)).transpose();
    yield.velocity[i] = point[i] * body[i]->state.velocity;
    yield.after[i] = point[i] * freeVelocity(of(*body[i]), body[i]->state, period);
  }
  for (std::size_t i = 0; yield.isAny && i < count; ++i) {
    const Vec3& normal = contacts.contacts[i].normal;
    const Vec6 inverse = body[i] ? Vec6(scale * inverseInertia(of(*body[i]), period)) : Vec6(Vec6::Zero());
    double all = 0.0;
    for (std::size_t j = 0; j < count; ++j) {
      yield.response[i][j] = Vec3::Zero();
      if (body[i] && body[j] == body[i])
        yield.response[i][j] = point[i] * inverse.cwiseProduct(point[j].transpose() * contacts.contacts[j].normal);
      yield.inverse[i][j] = normal.dot(yield.response[i][j]);
    }
    if (body[i]) all = (point[i] * inverse.asDiagonal() * point[i].transpose()).trace();
    yield.across[i] = std::max(0.0, all - yield.inverse[i][i]);
  }
}

// Wrench at the centre, in the axes at rest, of a force (W) at a point (W).
Vec6 SceneMotion::wrenchAt(const Body& body, const Vec3& point, const Vec3& force) const noexcept {
  const Mat3 axes = body.rest.rotation.transpose();
  const Vec3 arm = axes * (point - body.rest.position) - of(body).centre - body.state.offset.head<3>();
  Vec6 wrench;
  wrench << axes * force, arm.cross(axes * force);
  return wrench;
}

void SceneMotion::push(int obstacle, const Vec3& point, const Vec3& force) noexcept {
  for (Body& body : bodies_)
    if (body.obstacle == obstacle) body.state.wrench += wrenchAt(body, point, force);
}

void SceneMotion::push(int obstacle, const Vec6& impulse) noexcept {
  for (Body& body : bodies_)
    if (body.obstacle == obstacle) body.state.impulse += impulse;
}

void SceneMotion::hold(int obstacle, const Vec3& point, const Vec3& normal, double stiffness, double period) noexcept {
  const Mat3 frame = frameAlong(normal);
  for (Body& body : bodies_) {
    if (body.obstacle != obstacle) continue;
    const Vec6 inverse = inverseInertia(of(body), period);
    for (int axis = 0; axis < 2; ++axis) {
      const Vec6 row = wrenchAt(body, point, frame.col(axis)),
                 next = freeVelocity(of(body), body.state, period) + period * inverse.cwiseProduct(body.state.wrench);
      const double give = period * period * row.dot(inverse.cwiseProduct(row));
      body.state.wrench -= stiffness * period * row.dot(next) / (1.0 + stiffness * give) * row;
    }
  }
}

void SceneMotion::scaleForces(double factor) noexcept {
  for (Body& body : bodies_) body.state.wrench *= factor;
}

std::size_t SceneMotion::stateSize() const noexcept { return 24 * bodies_.size(); }

void SceneMotion::saveState(double* state) const noexcept {
  for (const Body& body : bodies_)
    for (const Vec6* part : {&body.state.offset, &body.state.velocity, &body.state.wrench, &body.state.impulse})
      state = std::copy_n(part->data(), 6, state);
}

void SceneMotion::loadState(const double* state) noexcept {
  for (Body& body : bodies_) {
    bool isFinite = true;
    for (Vec6* part : {&body.state.offset, &body.state.velocity, &body.state.wrench, &body.state.impulse}) {
      std::copy_n(state, 6, part->data());
      isFinite = isFinite && part->allFinite();
      state += 6;
    }
    if (!isFinite || !place(body)) body.state = {};
  }
}

}  // namespace enamel
