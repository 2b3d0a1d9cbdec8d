// Between the structs of enamel.h and the C++ types.
#pragma once

#include <algorithm>
#include <cstdint>

#include "enamel/c/enamel.h"
#include "enamel/session/session.hpp"
#include "plugin/convert.hpp"

namespace enamel::c {

static_assert(ENAMEL_MAX_TOOL_PARTS == kMaxToolParts && ENAMEL_MAX_LAYERS == kMaxSolidLayers);
static_assert(ENAMEL_UNUSUAL_SIZE == static_cast<int>(EventKind::unusualSize));

/// Return whether a struct was initialised for this library.
template <typename Struct>
bool isKnown(const Struct& given) noexcept {
  return given.size == sizeof(Struct);
}

inline std::int32_t resultOf(Status status) noexcept {
  return status == Status::stopped ? std::int32_t{ENAMEL_STOPPED} : static_cast<std::int32_t>(status);
}
inline Status statusOf(std::int32_t result) noexcept {
  return result >= ENAMEL_OK && result <= ENAMEL_INACTIVE ? static_cast<Status>(result) : Status::inactive;
}

inline Pose poseOf(const EnamelPose& pose) noexcept {
  return {Eigen::Map<const Vec3>(pose.position), Eigen::Map<const RowMajor>(pose.rotation)};
}
inline Vec6 twistOf(const double* twist) noexcept {
  return twist == nullptr ? Vec6(Vec6::Zero()) : Vec6(Eigen::Map<const Vec6>(twist));
}
inline Material materialOf(const EnamelMaterial& m) noexcept {
  return {m.stiffness, m.friction, m.sliding_friction, m.viscosity};
}

inline Measurement measurementOf(const EnamelMeasurement& in, int joints) noexcept {
  Measurement out;
  out.time = in.time;
  enamel::fromPlain(in.q, joints, out.q);
  enamel::fromPlain(in.rates, joints, out.rates);
  if (in.applied_known != 0) enamel::fromPlain(in.applied, joints, out.applied.emplace());
  out.enabled = in.enabled != 0;
  out.buttons = in.buttons;
  if (in.has_gripper != 0) out.gripper = in.gripper;
  out.failed = in.failed != 0;
  out.age = out.failed ? std::max(in.age, std::int32_t{1}) : in.age;
  return out;
}
inline void toPlain(const Measurement& in, EnamelMeasurement& out) noexcept {
  out = EnamelMeasurement{};
  out.size = sizeof out;
  out.age = in.age;
  out.time = in.time;
  enamel::toPlain(in.q, out.q);
  enamel::toPlain(in.rates, out.rates);
  if (in.applied) enamel::toPlain(*in.applied, out.applied);
  out.applied_known = in.applied ? 1 : 0;
  out.gripper = in.gripper.value_or(0.0);
  out.has_gripper = in.gripper ? 1 : 0;
  out.enabled = in.enabled ? 1 : 0;
  out.failed = in.failed ? 1 : 0;
  out.buttons = in.buttons;
}

/// Fill in a snapshot or an event.
void toPlain(const Snapshot& in, EnamelSnapshot& out) noexcept;
void toPlain(const SessionEvent& in, EnamelEvent& out) noexcept;

/// Read definitions. Throw Error for a wrong size, a missing pointer, or an index outside its range.
Tool toolOf(const EnamelTool& tool);
Bur burOf(const EnamelBur& bur);
SessionObstacle obstacleOf(const EnamelObstacleDef& def);
std::map<std::string, std::string> parametersOf(const EnamelParameter* parameters, std::size_t count);

/// Fill in the triangles of a brick. Return false if no brick has changed. Throw Error as above.
bool takeSurface(Session& session, ObstacleId id, EnamelSurface& surface);

/// Make a mechanism or a device of callbacks. Throw Error as above.
std::shared_ptr<const Mechanism> makeMechanism(const EnamelMechanism& mechanism);
std::unique_ptr<HapticDevice> makeDevice(const EnamelDevice& device, int joints);

}  // namespace enamel::c
