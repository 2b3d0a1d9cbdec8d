// Between the structs of enamel.h and the C++ types.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <exception>

#include "enamel/c/enamel.h"
#include "enamel/collision/cut_comparison.hpp"
#include "enamel/session/session.hpp"
#include "plugin/own_device.hpp"

struct EnamelSolid {
  std::shared_ptr<const enamel::Solid> solid;
  enamel::CutComparison compared;  // the last one
  std::vector<std::int32_t> prepared;
};

namespace enamel::c {

static_assert(ENAMEL_MAX_TOOL_PARTS == kMaxToolParts && ENAMEL_MAX_LAYERS == kMaxSolidLayers);
static_assert(ENAMEL_UNUSUAL_SIZE == static_cast<int>(EventKind::unusualSize));

inline void copyText(const char* text, const EnamelMessage& message) noexcept {
  if (message.text == nullptr || message.size == 0) return;
  const std::size_t length = std::min(std::strlen(text), message.size - 1);
  std::memcpy(message.text, text, length);
  message.text[length] = 0;
}

/// Run `work`, which may throw. `message` receives the reason.
template <typename Work>
std::int32_t attempt(const EnamelMessage& message, const Work& work) noexcept {
  try {
    work();
    return ENAMEL_OK;
  } catch (const std::exception& error) {
    copyText(error.what(), message);
  } catch (...) {
    copyText("an unknown exception", message);
  }
  return ENAMEL_FAILED;
}

inline std::int32_t resultOf(Status status) noexcept {
  return status == Status::stopped ? std::int32_t{ENAMEL_STOPPED} : static_cast<std::int32_t>(status);
}

inline Pose poseOf(const EnamelPose& pose) noexcept {
  return {Eigen::Map<const Vec3>(pose.position), Eigen::Map<const RowMajor>(pose.rotation)};
}
inline Vec6 twistOf(const double* twist) noexcept {
  return twist == nullptr ? Vec6(Vec6::Zero()) : Vec6(Eigen::Map<const Vec6>(twist));
}
inline std::optional<Suspension> suspensionOf(const EnamelSuspension* s) {
  if (s == nullptr) return std::nullopt;
  return Suspension{Eigen::Map<const Vec3>(s->centre), Eigen::Map<const Vec6>(s->inertia),
                    Eigen::Map<const Vec6>(s->stiffness), Eigen::Map<const Vec6>(s->damping)};
}

inline Material materialOf(const EnamelMaterial& m) noexcept {
  Material material{m.stiffness, m.friction, m.sliding_friction, m.viscosity};
  if (m.exponent != 0.0) material.exponent = m.exponent;
  if (m.thickness != 0.0) material.thickness = m.thickness;
  material.hysteresis = m.hysteresis;
  if (m.puncture != 0.0) material.puncture = m.puncture;
  material.stribeck = m.stribeck;
  material.roughness = m.roughness;
  material.wavelength = m.wavelength;
  return material;
}

/// Fill in a snapshot or an event.
void toPlain(const Snapshot& in, EnamelSnapshot& out) noexcept;
void toPlain(const SessionEvent& in, EnamelEvent& out) noexcept;

/// Read definitions. Throw Error for a wrong size, a missing pointer, or an index outside its range.
Tool toolOf(const EnamelTool& tool);
Bur burOf(const EnamelBur& bur);
SessionObstacle obstacleOf(const EnamelObstacleDef& def);
MeshModel targetOf(const EnamelObstacleDef& def);
std::vector<Guide> guidesOf(const EnamelGuide* guides, std::size_t count);
std::map<std::string, std::string> parametersOf(const EnamelParameter* parameters, std::size_t count);

/// Fill in the triangles of a brick. Return false if no brick has changed. Throw Error as above.
bool takeSurface(Session& session, ObstacleId id, EnamelSurface& surface);

/// Make a mechanism of callbacks. Throw Error as above.
std::shared_ptr<const Mechanism> makeMechanism(const EnamelMechanism& mechanism);

}  // namespace enamel::c
