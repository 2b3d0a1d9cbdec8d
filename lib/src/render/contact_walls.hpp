// Walls that position control holds the tool at: which of them count, and the forces that keep the tool outside.
#pragma once

#include <array>

#include "enamel/render/friction.hpp"
#include "render/contact_projection.hpp"
#include "render/predicted_modes.hpp"

namespace enamel {

inline constexpr int kMostWalls = 2 * kMaxContacts;  ///< of contacts, and those that vanished recently
static_assert(kMostWalls <= kMaxWalls);

/// A plane that the tool must not cross, in joint coordinates: row . (q - here) + gap >= 0. Plain numbers.
struct Wall {
  JointRow row{};
  double gap = 0.0;        ///< at present, m
  double speed = 0.0;      ///< of the obstacle along the normal, m/s
  double rest = 0.0;       ///< the same without its motion in its suspension, which is that of the time of the command
  double after = 0.0;      ///< the same after a tick without a contact force
  double softness = 0.0;   ///< of the material at its last compression, m/N
  double name = 0.0;       ///< identifies the wall from tick to tick
  double retreated = 0.0;  ///< m: of a wall that has vanished
  double contact = -1.0;   ///< index in the frame; -1: vanished
  double movable = -1.0;   ///< number of the obstacle if it is movable, else -1
  double force = 0.0;      ///< of the last tick, N
  double holds = 0.0;      ///< the tool has reached it, and the hand has not left it since
};

/// Walls of the last tick. Plain numbers.
struct WallMemory {
  double count = 0.0;
  std::array<Wall, kMostWalls> wall{};
};

/// A wall in mode coordinates, at the place to which the hand would move the tool.
struct Target {
  Lane row;
  double gap, size;   ///< m; norm of the row in the metric 1 / stiffness
  double compliance;  ///< of the material and of a movable obstacle, relative to size^2
  double apart;       ///< of the movable obstacle alone
  double offset;      ///< m: the tangent of the material's law begins so much deeper
  double reach;       ///< s: a speed of the obstacle times this is a distance, relative to size
  double doubt;       ///< uncertainty of the gap: half a step of the reading, and the deflection by a tremor, m
  int wall;
  bool isLayer;  ///< the material is not linear
};

/// How far a push moves the tool before a command answers.
struct Rebound {
  double reaction;          ///< reactionTime(), s
  JointVector encoderStep;  ///< rad or m

  /// Return the distance that a push of F N moves a mass: unseen for half a step of the reading, then until a command
  /// acts, m. Realtime: yes.
  double distance(double push, double mass, double step) const noexcept;
  /// Return the step of the reading along a row of the joints, m. Realtime: yes.
  double readingStep(const JointRow& row) const noexcept;
};

/// Collect the walls of this tick: those of the contacts, then those that vanished recently. The torque stays
/// continuous when contacts are not. Walls that appear or vanish move only as fast as the tool does plus what a tremor
/// of the hand would cause. lastReading: joints. Returns their number, at most kMostWalls. Realtime: yes.
int collectWalls(const TickFrame& frame, const PredictedModes& modes, const JointRow& lastReading, WallMemory& memory,
                 Wall* walls) noexcept;

/// Return the walls that may carry a force: the tool has reached them or will within a tick. near: a contact that stays
/// farther outside carries none, m. Realtime: yes.
int placeTargets(const TickFrame& frame, const PredictedModes& modes, const Rebound& rebound, double near, Wall* walls,
                 int count, Target* targets) noexcept;

/// Compute forces, N, that move the modes from where the hand would take them to the nearest point of the free space.
/// If walls contradict each other, all of them give way. Movable obstacles give way as their inertia allows, compliant
/// materials by their law. Changes the materials' part of the targets. Realtime: yes.
void contactForces(const TickFrame& frame, const PredictedModes& modes, const Wall* walls, Target* targets, int count,
                   double* force) noexcept;

/// Return the friction torque at the contacts, under the loads of the last tick. lastEstimate: joints at the last tick.
/// Realtime: yes.
JointRow frictionTorque(const TickFrame& frame, const PredictedModes& modes, const Wall* walls, JointRow& lastEstimate,
                        FrictionMemory& memory) noexcept;

}  // namespace enamel
