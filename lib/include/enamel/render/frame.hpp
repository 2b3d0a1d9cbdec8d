// The frame of a tick: everything that one tick knows and computes, each quantity once. HapticTick (tick.hpp) sends it
// through the stages, in this order; each stage fills its own part and reads those before it.
//
//   sense -> find contacts -> contact rows and responses -> render -> guard -> cut
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "enamel/collision/contact.hpp"
#include "enamel/core/cholesky.hpp"
#include "enamel/core/status.hpp"
#include "enamel/device/mechanism.hpp"
#include "enamel/render/guard_reason.hpp"

namespace enamel {

/// One number a joint, in plain storage.
using JointRow = std::array<double, kMaxJoints>;

/// What a unit force on the tool at a contact does, along its normal n and, where the contact has friction, along two
/// directions t of its surface. M is the joint-space inertia, D takes out the joints without a motor.
struct ContactRow {
  JointRow normal{};         ///< N = J^T [n; r x n]: joint torques of the force, N m or N for 1 N
  JointRow response{};       ///< M^-1 D N: joint accelerations that the motors give for it, rad/s^2 or m/s^2
  double mass = 0.0;         ///< 1 / (N^T response): effective mass along the normal, kg
  Mat3 axes = Mat3::Zero();  ///< columns t1, t2, n in W; zero without friction
  std::array<JointRow, 2> tangent{}, tangentResponse{};  ///< the same of t1 and t2; zero without friction
};

/// Joint-space inertia and contacts as a renderer with needsInertia() reads them.
struct ContactRows {
  int count = -1;                ///< rows that are filled: that of the contacts; -1: nobody asked for them
  Cholesky<kMaxJoints> inertia;  ///< factors of M
  std::array<ContactRow, kMaxContacts> row;
};

/// What a renderer is doing.
enum class RenderMode : std::uint8_t {
  free = 0,  ///< no contact: gravity is balanced
  contact,   ///< a wall is rendered
  fault,     ///< the frame was unusable: see the status
};

/// Name of a mode in plain words. Realtime: yes.
const char* toString(RenderMode mode) noexcept;

/// What a renderer answers.
struct TickOutput {
  JointVector torque;  ///< N m or N, gravity included; finite and within +-maxTorque whatever the status
  RenderMode mode = RenderMode::fault;
  bool saturated = false;    ///< a motor's limit cut the torque
  double normalForce = 0.0;  ///< of the wall on the tool along the deepest contact's normal, N
};

/// What is known at a tick. All in SI; poses, twists and contacts in W. Joint vectors have n entries.
///
/// A tick without a new sample has `age` k > 0. Kinematics and contacts are then those of the last sample, k periods
/// old. A renderer predicts from them and answers with a torque as at any other tick; it neither restarts nor learns.
/// The time between two ticks may differ from the period: a sample may be late, and where ticks are missing, the last
/// torque acted until this one.
struct TickFrame {
  // Sense.
  double time = 0.0;                   ///< s, strictly increasing
  int age = 0;                         ///< periods since the sample; 0: a new sample
  Kinematics kinematics;               ///< measured; the inertia where the renderer asked for it
  JointVector maxTorque;               ///< limit of every motor, N m or N; 0: a joint without a motor
  std::optional<JointVector> applied;  ///< torque that acted since the last tick, N m or N; empty: not known

  // Find contacts; contact rows and responses.
  ContactSnapshot contacts;  ///< at the pose; the deepest first
  ContactRows rows;

  // Render.
  TickOutput output;

  // Guard.
  JointVector command;                     ///< what reaches the motors, N m or N
  GuardReason reason = GuardReason::none;  ///< why it is not what was requested
};

/// The stage `contact rows and responses`: factors the inertia and fills the rows of all contacts. Status outOfRange
/// where the inertia is missing, not positive definite or of a joint outside 1e-12 to 1e6 kg m^2 or kg, or the
/// contacts' count cannot be; the frame then has no rows. Realtime: yes.
[[nodiscard]] Status fillContactRows(TickFrame& frame) noexcept;

}  // namespace enamel
