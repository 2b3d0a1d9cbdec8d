// Rough surfaces: a height over each place of an obstacle, as a sum of waves. Equations and sources:
// lib/docs/surfaces.md.
#pragma once

#include <algorithm>

#include "enamel/collision/scene.hpp"
#include "enamel/collision/tool.hpp"
#include "enamel/render/frame.hpp"

namespace enamel {

/// Return the share of a wave that ticks render: 0 with at most 4 samples a wave, 1 with 8 or more. Realtime: yes.
inline double sampledShare(double samples) noexcept { return std::clamp(0.25 * samples - 1.0, 0.0, 1.0); }

/// Height of a rough surface over the smooth one, m, and its gradient, in the same frame.
struct SurfaceHeight {
  double height = 0.0;
  Vec3 gradient = Vec3::Zero();
};

/// Return the height of a rough surface at a place of the obstacle's frame, m:
///
///   h(p) = sum_k a_k cos(q_k . p + phi_k),   a_k ~ L_k^H,   L_k = 2 pi / |q_k|,   H = 0.8
///
/// The waves are from the material's wavelength down to a tenth of it, evenly spaced in log L, in all directions. The
/// root mean square over all places is Material::roughness. Two things reduce the waves:
///
/// - a ball of `radius` m does not reach the bottom between two crests: a_k is at most L_k^2 / (16 radius);
/// - `passed` m per tick: waves below 4 of them do not exist, those from 8 on are complete.
///
/// Realtime: yes.
SurfaceHeight heightAt(const Material& material, const Vec3& place, double radius, double passed) noexcept;

/// Return whether an obstacle of the scene, or a layer of a solid in it, is rough. Realtime: yes.
bool isRough(const Scene& scene) noexcept;

/// Move the contacts to the rough surface: subtract the height from the gap, and tilt the normal by its slope. `passed`
/// of a contact is the larger of the tool's way in a period and of an encoder step of all joints, along the surface.
/// `smooth` are parts of the tool that feel no roughness (a bur that cuts it away). Realtime: yes.
void roughen(const Scene& scene, const Tool& tool, const Kinematics& kinematics, const JointVector& encoderStep,
             double period, const PartRange& smooth, ContactSnapshot& contacts) noexcept;

}  // namespace enamel
