// Contacts of a moving tool: its side of a surface, the identity of contacts from tick to tick, and its saved state.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>

#include "part_contacts.hpp"

namespace enamel {

using namespace kernel;

namespace {

constexpr double kSameContact = 0.7071067811865476;  // cos 45 deg
constexpr double kPressed = 1e-4;                    // m

// Return how far a contact has moved, m: its point, its gap, and the place at which it holds a tool that a hand pushes
// by kPressed into the surface.
double changeOf(const Contact& known, const Vec3& point, const Vec3& normal, double gap) {
  return (point - known.point).norm() + std::abs(gap - known.gap) + kPressed * (normal - known.normal).norm();
}

// A contact keeps its key if obstacle and part match: those that have changed least first. `last` holds contacts in the
// frames of their obstacles.
void nameContacts(const Scene& scene, ContactSnapshot& last, std::uint32_t& lastKey, ContactSnapshot& contacts) {
  constexpr double kOther = std::numeric_limits<double>::infinity();
  std::array<Vec3, kMaxContacts> points, normals;  // in the frames of the obstacles
  double change[kMaxContacts][kMaxContacts];       // kOther: another contact
  for (int k = 0; k < contacts.count; ++k) {
    Contact& contact = contacts.contacts[k];
    const Pose& pose = scene.obstacles()[static_cast<std::size_t>(contact.obstacle)].pose;
    normals[k] = pose.rotation.transpose() * contact.normal;
    points[k] = pose.rotation.transpose() * (contact.point - pose.position);
    contact.key = 0;
    for (int i = 0; i < last.count; ++i) {
      const Contact& known = last.contacts[i];
      const bool isSame = known.key != 0 && known.obstacle == contact.obstacle && known.part == contact.part &&
                          (known.point - points[k]).norm() <= kLargestMove &&
                          known.normal.dot(normals[k]) > kSameContact;
      change[k][i] = isSame ? changeOf(known, points[k], normals[k], contact.gap) : kOther;
    }
  }
  for (;;) {
    int which = -1, best = -1;
    double least = kOther;
    for (int k = 0; k < contacts.count; ++k)
      for (int i = 0; contacts.contacts[k].key == 0 && i < last.count; ++i)
        if (change[k][i] < least && last.contacts[i].key != 0) {
          least = change[k][i];
          which = k;
          best = i;
        }
    if (best < 0) break;
    contacts.contacts[which].key = std::exchange(last.contacts[best].key, 0u);
  }
  for (int k = 0; k < contacts.count; ++k) {
    if (contacts.contacts[k].key != 0) continue;
    if (++lastKey == 0) lastKey = 1;
    contacts.contacts[k].key = lastKey;
  }
  last.count = contacts.count;
  for (int k = 0; k < contacts.count; ++k) {
    last.contacts[k] = contacts.contacts[k];
    last.contacts[k].normal = normals[k];
    last.contacts[k].point = points[k];
  }
}

}  // namespace

ToolTrack::ToolTrack() = default;
ToolTrack::ToolTrack(const ToolTrack& other) = default;
ToolTrack::ToolTrack(ToolTrack&& other) noexcept = default;
ToolTrack& ToolTrack::operator=(const ToolTrack& other) = default;
ToolTrack& ToolTrack::operator=(ToolTrack&& other) noexcept = default;
ToolTrack::~ToolTrack() = default;

ToolTrack makeToolTrack(const Scene& scene, const Tool& tool) {
  ToolTrack track;
  track.cache_ = makeToolCache(scene, tool);
  track.parts_.resize(scene.obstacles().size() * static_cast<std::size_t>(tool.count));
  return track;
}

namespace {

constexpr std::size_t kPartState = 8;      // axis, clearance, whether it is known
constexpr std::size_t kContactState = 10;  // point, normal, obstacle, part, key, gap
constexpr double kLargestPlace = 1e3;      // m

std::uint64_t revisionOf(const Obstacle& obstacle) noexcept {
  if (const auto* solid = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape)) return (*solid)->restorations();
  const auto* mesh = std::get_if<std::shared_ptr<const MeshModel>>(&obstacle.shape);
  return mesh == nullptr ? 1 : Inside::of(**mesh).view.revision;
}

bool isWhole(double value, double most) noexcept { return value >= 0.0 && value <= most && value == std::floor(value); }

}  // namespace

std::size_t ToolTrack::stateSize() const noexcept {
  return kPartState * parts_.size() + kContactState * kMaxContacts + 2;
}

void ToolTrack::saveState(const Scene& scene, double* state) const noexcept {
  const std::size_t obstacles = scene.obstacles().size();
  for (std::size_t i = 0; i < parts_.size(); ++i, state += kPartState) {
    const kernel::PartTrack& part = parts_[i];
    // After a change of the mesh, the part starts again.
    const bool isKnown = part.isKnown && part.revision == revisionOf(scene.obstacles()[i * obstacles / parts_.size()]);
    std::copy_n(part.axis.a.data(), 3, state);
    std::copy_n(part.axis.b.data(), 3, state + 3);
    state[6] = part.clear;
    state[7] = isKnown ? 1.0 : 0.0;
  }
  for (const Contact& c : last_.contacts) {
    const bool isKnown = &c < last_.contacts.data() + last_.count;
    const Vec3 point = isKnown ? c.point : Vec3(Vec3::Zero()), normal = isKnown ? c.normal : Vec3(Vec3::Zero());
    std::copy_n(point.data(), 3, state);
    std::copy_n(normal.data(), 3, state + 3);
    state[6] = isKnown ? c.obstacle : 0;
    state[7] = isKnown ? c.part : 0;
    state[8] = isKnown ? c.key : 0;
    state[9] = isKnown ? c.gap : 0.0;
    state += kContactState;
  }
  state[0] = last_.count;
  state[1] = lastKey_;
}

void ToolTrack::loadState(const Scene& scene, const double* state) noexcept {
  const std::size_t obstacles = scene.obstacles().size();
  bool isSound = true;
  for (std::size_t i = 0; i < stateSize(); ++i) isSound = isSound && std::isfinite(state[i]);
  for (kernel::PartTrack& part : parts_) {
    const std::size_t i = static_cast<std::size_t>(&part - parts_.data());
    const auto ends = Eigen::Map<const Vec6>(state);
    part.isKnown = isSound && state[7] == 1.0 && ends.cwiseAbs().maxCoeff() <= kLargestPlace;
    if (isSound) {
      part.axis = {ends.head<3>(), ends.tail<3>()};
      part.clear = part.isKnown ? state[6] : -1.0;
    }
    part.revision = revisionOf(scene.obstacles()[i * obstacles / parts_.size()]);
    state += kPartState;
  }
  const double* counts = state + kContactState * kMaxContacts;
  isSound = isSound && isWhole(counts[0], kMaxContacts) && isWhole(counts[1], UINT32_MAX);
  last_.count = isSound ? static_cast<int>(counts[0]) : 0;
  lastKey_ = isSound ? static_cast<std::uint32_t>(counts[1]) : 0;
  for (int k = 0; k < last_.count; ++k, state += kContactState) {
    Contact& c = last_.contacts[k];
    c.point = Eigen::Map<const Vec3>(state);
    c.normal = Eigen::Map<const Vec3>(state + 3);
    const bool isContact = isWhole(state[6], static_cast<double>(obstacles)) && isWhole(state[7], kMaxToolParts) &&
                           isWhole(state[8], UINT32_MAX);
    c.obstacle = isContact ? static_cast<int>(state[6]) : 0;
    c.part = isContact ? static_cast<int>(state[7]) : 0;
    c.key = isContact ? static_cast<std::uint32_t>(state[8]) : 0;  // 0: no contact continues it
    c.gap = state[9];
  }
}

void ToolTrack::reset(const Scene& scene) noexcept {
  const std::size_t obstacles = scene.obstacles().size();
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    parts_[i].isKnown = false;
    parts_[i].revision = revisionOf(scene.obstacles()[i * obstacles / parts_.size()]);
  }
  last_.count = 0;
  lastKey_ = 0;
}

void ToolTrack::letIn(const Tool& tool, int obstacle, int part) noexcept {
  const auto i =
      static_cast<std::size_t>(obstacle) * static_cast<std::size_t>(tool.count) + static_cast<std::size_t>(part);
  if (obstacle >= 0 && part >= 0 && part < tool.count && i < parts_.size()) parts_[i].isKnown = false;
}

void ToolTrack::takeOver(ToolTrack& old, const Scene& before, const Scene& now) noexcept {
  const std::size_t obstacles = now.obstacles().size(), others = before.obstacles().size();
  const std::size_t parts = obstacles == 0 ? 0 : parts_.size() / obstacles;
  for (std::size_t i = 0; i < std::min(obstacles, others); ++i) {
    if (!isSameObstacle(before, now, i)) continue;
    std::swap(cache_.parts_[i], old.cache_.parts_[i]);
    for (std::size_t k = 0; k < parts; ++k) parts_[i * parts + k] = old.parts_[i * parts + k];
  }
  last_ = old.last_;
  lastKey_ = old.lastKey_;
  for (int k = 0; k < last_.count; ++k)
    if (!isSameObstacle(before, now, static_cast<std::size_t>(last_.contacts[k].obstacle))) last_.contacts[k].key = 0;
}

Status followContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolTrack& track,
                      ContactSnapshot& contacts) noexcept {
  const auto visit = [&](const Obstacle& obstacle, const Segment& axis, double radius, PartCache* known,
                         Collector& out) {
    const int pair = out.pair.number * tool.count + out.pair.part;
    const auto i = static_cast<std::size_t>(pair);
    if (i >= track.parts_.size()) {
      addPart(obstacle, axis, radius, known, out);
      return;
    }
    PartTrack& part = track.parts_[i];
    const PartTrack::State state = part.follow(obstacle, axis, known);
    out.isOutside = out.pad > 0.0 || state != PartTrack::State::unknown;
    const bool isHeld = state == PartTrack::State::held;
    out.from = isHeld ? &part.axis : nullptr;
    out.actual = isHeld ? &axis : nullptr;
    out.near = &part.near;
    addPart(obstacle, isHeld ? part.axis : axis, radius, known, out);
  };
  const auto parts = static_cast<std::size_t>(tool.count);
  for (std::size_t i = 0; (i + 1) * parts <= track.parts_.size(); ++i)  // a path ends while its obstacle is not active
    for (std::size_t k = 0; k < parts && !scene.obstacles()[i].active; ++k) track.parts_[i * parts + k].isKnown = false;
  const Status status = forEachPart(scene, tool, pose, margin, &track.cache_, contacts, visit);
  if (status == Status::ok) nameContacts(scene, track.last_, track.lastKey_, contacts);
  return status;
}

}  // namespace enamel
