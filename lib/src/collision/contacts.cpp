#include "enamel/collision/contacts.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>

#include "enamel/core/error.hpp"
#include "part_contacts.hpp"

namespace enamel {

using namespace kernel;

Status checkTool(const Tool& tool) noexcept {
  if (tool.count < 0 || tool.count > kMaxToolParts) return Status::outOfRange;
  for (int k = 0; k < tool.count; ++k) {
    const ToolPart& part = tool.parts[k];
    if (!part.a.allFinite() || !part.b.allFinite() || !std::isfinite(part.radius)) return Status::notFinite;
    if (!(std::max(part.a.cwiseAbs().maxCoeff(), part.b.cwiseAbs().maxCoeff()) <= kLargestTool && part.radius >= 0.0 &&
          part.radius <= kLargestTool))
      return Status::outOfRange;
  }
  return Status::ok;
}

ToolCache::ToolCache() = default;
ToolCache::ToolCache(const ToolCache& other) = default;
ToolCache::ToolCache(ToolCache&& other) noexcept = default;
ToolCache& ToolCache::operator=(const ToolCache& other) = default;
ToolCache& ToolCache::operator=(ToolCache&& other) noexcept = default;
ToolCache::~ToolCache() = default;

ToolCache makeToolCache(const Scene& scene, const Tool& tool) {
  if (const Status status = checkTool(tool); status != Status::ok)
    throw Error("the tool is " + std::string(status == Status::notFinite ? "not finite" : "out of range") +
                ": it must have 0 to " + std::to_string(kMaxToolParts) +
                " parts, their ends within 1 m of the TCP along every axis, their radius in 0 to 1 m");
  ToolCache cache;
  for (const Obstacle& obstacle : scene.obstacles()) {
    const bool isMesh = std::holds_alternative<std::shared_ptr<const MeshModel>>(obstacle.shape);
    cache.parts_.emplace_back(isMesh ? static_cast<std::size_t>(tool.count) : 0);
  }
  return cache;
}

Status findContacts(const Scene& scene, const Tool& tool, const Pose& pose, double margin, ToolCache* cache,
                    ContactSnapshot& contacts) noexcept {
  const auto visit = [](const Obstacle& obstacle, const Segment& axis, double radius, PartCache* known,
                        Collector& out) { addPart(obstacle, axis, radius, known, out); };
  return forEachPart(scene, tool, pose, margin, cache, contacts, visit);
}

Contact nearestContact(const Scene& scene, const Tool& tool, const Pose& pose, ToolCache* cache) noexcept {
  ContactSnapshot contacts;
  const auto visit = [](const Obstacle& obstacle, const Segment& axis, double radius, PartCache* known,
                        Collector& out) { addNearest(obstacle, axis, radius, known, out); };
  if (forEachPart(scene, tool, pose, kNoLimit, cache, contacts, visit) != Status::ok || contacts.count == 0) {
    Contact none;
    none.gap = kNoLimit;
    return none;
  }
  return contacts.contacts[0];
}

}  // namespace enamel
