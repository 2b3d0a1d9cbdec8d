#include "enamel/render/compliance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/scene.hpp"
#include "enamel/collision/tool.hpp"
#include "render/scene_surfaces.hpp"

namespace enamel {
namespace {

constexpr double kUnit = 1e-3;     // m: Material::stiffness is that at this depth
constexpr int kMostHalvings = 80;  // of the search for a compression; about 6 are usual, halvings need 60 at most
constexpr int kMostCells = 100;    // of a layer of a solid: its thickness is sought no farther

// Return the normal force of the walls of a hole on a tool of a radius, m, at a depth, m. The tool has pressed the
// walls aside by its radius. Their pressure is that under a ball which is pressed in as deep, but at most that of a
// puncture.
double gripOf(Material m, double radius, double depth) noexcept {
  if (!(radius > 0.0)) return 0.0;
  const double area = std::min(depth, m.thickness) / radius;  // of the walls, over that of the ball, 2 pi radius^2
  m.thickness = std::numeric_limits<double>::infinity();
  return 2.0 * area * std::min(forceOf(m, radius, kNotCompressed, 1.0).force, m.puncture);
}

// Return how thick the layer of a solid is below the surface at a contact, m; infinite: its end was not found.
double thicknessAt(const Obstacle& obstacle, const Solid& solid, const Contact& contact) noexcept {
  const Mat3 axes = obstacle.pose.rotation.transpose();
  const Vec3 down = -(axes * contact.normal),
             surface = axes * (contact.point - contact.gap * contact.normal - obstacle.pose.position);
  const auto layerAt = [&](double cells) { return solid.layerAt(surface + cells * solid.cell() * down); };
  const int layer = layerAt(0.5);
  for (int i = 1; i < kMostCells; ++i)
    if (layerAt(0.5 + i) != layer) return i * solid.cell();
  return std::numeric_limits<double>::infinity();
}

// A ball that touches a rough surface has several contacts, and so have parts at one place. Return how many of the
// contacts, as deep as this one and in its direction, press on the same place of the layer. There the balls of their
// radii overlap, seen along the normal.
double contactsAt(const Contact& c, const Tool& tool, const ContactSnapshot& contacts) noexcept {
  constexpr double kSlack = 1e-9;  // m, of rounding
  double sum = 1.0;
  for (int i = 0; i < contacts.count; ++i) {
    const Contact& other = contacts.contacts[static_cast<std::size_t>(i)];
    if (&other == &c || other.obstacle != c.obstacle || !other.material.isLayer()) continue;
    const double reach = tool.parts[static_cast<std::size_t>(c.part)].radius +
                         tool.parts[static_cast<std::size_t>(other.part)].radius + kSlack;
    const Vec3 way = other.point - c.point, across = way - c.normal.dot(way) * c.normal;
    if (!(c.gap < 0.0 && other.gap < 0.0 && across.norm() <= reach)) continue;
    sum += std::max(0.0, c.normal.dot(other.normal)) * std::min(1.0, other.gap / c.gap);
  }
  return sum;
}

// Return whether the walls of the hole already hold the tool at another contact: the deepest one.
bool isHeld(const Contact& c, const ContactSnapshot& contacts) noexcept {
  return std::any_of(contacts.contacts.begin(), contacts.contacts.begin() + contacts.count,
                     [&c](const Contact& other) { return other.obstacle == c.obstacle && other.grip > 0.0; });
}

// Return how deep a bur is in the obstacle of a contact, m.
double depthOf(const Contact& c, const PartRange& bur, const ContactSnapshot& contacts) noexcept {
  double depth = 0.0;
  for (int i = 0; i < contacts.count; ++i) {
    const Contact& other = contacts.contacts[static_cast<std::size_t>(i)];
    if (other.obstacle == c.obstacle && bur.has(other.part) && !other.isPunctured) depth = std::max(depth, -other.gap);
  }
  return depth;
}

}  // namespace

MaterialForce forceOf(const Material& m, double x, double before, double period) noexcept {
  if (!(x > 0.0)) return {0.0, m.exponent == 1.0 ? m.stiffness : 0.0};
  const double open = 1.0 - x / m.thickness;
  const double elastic = m.stiffness * x * (m.exponent == 1.0 ? 1.0 : std::pow(x / kUnit, m.exponent - 1.0)) / open;
  const double slope = elastic * (m.exponent / x + 1.0 / (m.thickness * open));
  const double damping = before < kNotCompressed ? m.hysteresis / period : 0.0, factor = 1.0 + damping * (x - before);
  if (!(factor > 0.0)) return {0.0, 0.0};
  return {elastic * factor, slope * factor + elastic * damping};
}

double compressionInSeries(const Material& m, double depth, double soft, double before, double period) noexcept {
  if (!(depth > 0.0) || std::isinf(soft)) return 0.0;
  if (soft == 0.0) return std::min(depth, m.thickness);
  // The search of the root of a convex, rising function. Without thickness the compression would be `open`.
  const double open = kUnit * std::pow(depth / soft / (m.stiffness * kUnit), 1.0 / m.exponent);
  double low = 0.0, high = std::min({depth, m.thickness, std::max(before, open)});
  double x = high < m.thickness && high < open ? high : 1.0 / (1.0 / open + 1.0 / m.thickness);
  for (int step = 0; step < kMostHalvings; ++step) {
    x = x > low && x < high ? x : 0.5 * (low + high);
    const auto [force, slope] = forceOf(m, x, before, period);
    const double error = x + soft * force - depth;
    (error > 0.0 ? high : low) = x;
    const double next = x - error / (1.0 + soft * slope);
    const bool isFound = std::abs(next - x) <= 1e-13 * x;
    x = next;
    if (isFound) break;
  }
  return std::clamp(x, low, high);
}

double softness(const Contact& contact, double depth, double soft, double period) noexcept {
  const Material& m = contact.material;
  if (contact.compression < 0.0) return 1.0 / m.stiffness;
  const double x = compressionInSeries(m, depth, soft, contact.compression, period);
  return x > 0.0 ? std::min(kSoftest, x / forceOf(m, x, contact.compression, period).force) : 1.0 / m.stiffness;
}

double compressionUnder(const Material& m, double force, double before, double period) noexcept {
  constexpr double kSoft = 1e18;  // m/N: all of the force is left for the material
  return compressionInSeries(m, kSoft * force, kSoft, before, period);
}

ComplianceMemory::ComplianceMemory(const Scene& scene)
    : isAny_(anySurface(scene, [](const Material& material, const Tap&) { return material.isLayer(); })) {}

// A god object outside the surface does not know how far the surface is from a part that is inside.
void ComplianceMemory::letIn(const Tool& tool, ToolTrack& track) const noexcept {
  for (const Pressed& last : last_)
    for (int part = 0; last.isPunctured != 0.0 && part < tool.count; ++part)
      track.letIn(tool, static_cast<int>(last.obstacle), part);
}

void ComplianceMemory::enter(const Scene& scene, const Tool& tool, const PartRange& bur, double cut,
                             ContactSnapshot& contacts) noexcept {
  if (!isAny_) return;
  std::array<double, kMaxContacts> sharing;
  for (std::size_t i = 0; i < static_cast<std::size_t>(contacts.count); ++i) {
    sharing[i] = contactsAt(contacts.contacts[i], tool, contacts);
    contacts.contacts[i].grip = contacts.contacts[i].sunk = 0.0;
  }
  bool isMoved = false;
  for (int i = 0; i < contacts.count; ++i) {
    Contact& c = contacts.contacts[static_cast<std::size_t>(i)];
    if (!c.material.isLayer()) continue;
    const Obstacle& obstacle = scene.obstacles()[static_cast<std::size_t>(c.obstacle)];
    const auto* solid = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape);
    if (solid != nullptr) c.material.thickness = std::min(c.material.thickness, thicknessAt(obstacle, **solid, c));
    c.compression = kNotCompressed;
    double deepest = 0.0;  // compression of the part, or of the whole bur
    const bool spins = solid != nullptr && bur.has(c.part);
    for (const Pressed& last : last_) {
      if (last.obstacle != c.obstacle) continue;
      c.isPunctured = c.isPunctured || (c.gap < 0.0 && last.isPunctured != 0.0 && std::isfinite(c.material.puncture));
      if (spins && bur.has(static_cast<int>(last.part))) deepest = std::max(deepest, last.compression);
      if (last.part != c.part) continue;
      if (last.key == c.key) c.compression = last.compression;
      deepest = std::max(deepest, last.compression);
    }
    if (c.compression == kNotCompressed && deepest > 0.0) c.compression = deepest;  // a new place of a pressed layer
    if (!c.isPunctured) {
      c.material.stiffness /= sharing[static_cast<std::size_t>(i)];
      if (!spins) continue;
      c.sunk = std::clamp(depthOf(c, bur, contacts), 0.0, std::max(0.0, deepest - cut));
    } else {
      isMoved = true;
      if (!isHeld(c, contacts))
        c.grip = gripOf(c.material, tool.parts[static_cast<std::size_t>(c.part)].radius, -c.gap);
      c.gap += c.material.thickness;
    }
    c.compression = -1.0;
    const Material rigid;
    c.material.stiffness = rigid.stiffness;
    c.material.exponent = rigid.exponent;
    c.material.thickness = rigid.thickness;
    c.material.hysteresis = rigid.hysteresis;
    c.material.puncture = rigid.puncture;
  }
  if (isMoved) sortByDepth(contacts);
  last_ = {};
  for (int i = 0; i < contacts.count; ++i) {
    const Contact& c = contacts.contacts[static_cast<std::size_t>(i)];
    last_[static_cast<std::size_t>(i)] = {static_cast<double>(c.obstacle), static_cast<double>(c.part),
                                          static_cast<double>(c.key), std::max(c.sunk, c.compression),
                                          c.isPunctured ? 1.0 : 0.0};
  }
}

void ComplianceMemory::press(const TickOutput& output, double period, ContactSnapshot& contacts) noexcept {
  if (!isAny_) return;
  const auto& forces = output.normalForces;
  const bool isDivided = std::any_of(forces.begin(), forces.end(), [](double force) { return force > 0.0; });
  for (std::size_t i = 0; i < static_cast<std::size_t>(contacts.count); ++i) {
    Contact& c = contacts.contacts[i];
    if (c.compression < 0.0) continue;
    const double force = isDivided ? forces[i] : i == 0 ? output.normalForce : 0.0;
    c.compression = last_[i].compression = compressionUnder(c.material, force, c.compression, period);
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(contacts.count); ++i) {
    const Contact& c = contacts.contacts[i];
    if (c.compression < 0.0) continue;
    double whole = isDivided ? 0.0 : output.normalForce;  // of the tool on this obstacle
    for (std::size_t j = 0; isDivided && j < static_cast<std::size_t>(contacts.count); ++j)
      if (contacts.contacts[j].obstacle == c.obstacle && contacts.contacts[j].compression >= 0.0) whole += forces[j];
    if (whole > c.material.puncture) last_[i].isPunctured = 1.0;
  }
}

void ComplianceMemory::saveState(double* state) const noexcept {
  if (!isAny_) return;
  for (const Pressed& p : last_)
    for (const double number : {p.obstacle, p.part, p.key, p.compression, p.isPunctured}) *state++ = number;
}

void ComplianceMemory::loadState(const double* state) noexcept {
  if (!isAny_) return;
  bool isSound = true;
  for (Pressed& p : last_)
    for (double* const number : {&p.obstacle, &p.part, &p.key, &p.compression, &p.isPunctured}) {
      *number = *state++;
      isSound = isSound && std::isfinite(*number);
    }
  for (const Pressed& p : last_) isSound = isSound && p.compression >= 0.0;
  if (!isSound) reset();
}

void ComplianceMemory::takeOver(const ComplianceMemory& old, const Scene& before, const Scene& now) noexcept {
  for (std::size_t i = 0; i < last_.size(); ++i)
    if (const double number = old.last_[i].obstacle;
        number >= 0.0 && isSameObstacle(before, now, static_cast<std::size_t>(number)))
      last_[i] = old.last_[i];
}

}  // namespace enamel
