// The frame of a tick: all data of one tick, each quantity computed once. HapticTick (tick.hpp) passes the frame
// through these stages in order. Each stage fills its own part and reads the parts before it.
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

/// One number per joint, in plain storage.
using JointRow = std::array<double, kMaxJoints>;

/// Effect of a unit force on the tool at a contact. The force acts along the normal n or, with friction, along two
/// tangents t. M is the joint-space inertia. D removes the joints without a motor.
struct ContactRow {
  JointRow normal{};         ///< N = J^T [n; r x n]: joint torques of the force, N m or N per N
  JointRow response{};       ///< M^-1 D N: joint accelerations caused by the motors for it, rad/s^2 or m/s^2
  double mass = 0.0;         ///< 1 / (N^T response): effective mass along the normal, kg
  Mat3 axes = Mat3::Zero();  ///< columns t1, t2, n in W; zero without friction
  std::array<JointRow, 2> tangent{}, tangentResponse{};  ///< the same for t1 and t2; zero without friction
};

/// Joint-space inertia and contacts for a renderer with needsInertia().
struct ContactRows {
  int count = -1;                ///< number of filled rows, one per contact; -1: not computed
  Cholesky<kMaxJoints> inertia;  ///< factors of M
  std::array<ContactRow, kMaxContacts> row;
};

/// Movable obstacles (Suspension) at the contacts of a tick of T s. Forces f on the tool along the normals change the
/// speeds of the obstacles along them by -T A f. Contacts with other obstacles have zeros.
struct ContactYield {
  bool isAny = false;                          ///< false: the other members are not set
  double inverse[kMaxContacts][kMaxContacts];  ///< A: inverse mass of the obstacles over a tick, 1/kg
  std::array<double, kMaxContacts> across;     ///< the largest one along the surface, at most, 1/kg
  /// Velocity of the motion in the suspension at the contact, W, m/s: now, and after a tick without a contact force.
  std::array<Vec3, kMaxContacts> velocity, after;
  Vec3 response[kMaxContacts][kMaxContacts];  ///< acceleration at contact i by a unit force at contact j, W, 1/kg

  /// Return the velocity at a contact after a tick of `period` s under normal forces, N. Realtime: yes.
  Vec3 afterUnder(const std::array<double, kMaxContacts>& forces, int contact, int contacts,
                  double period) const noexcept;
};

/// State of a renderer.
enum class RenderMode : std::uint8_t {
  free = 0,  ///< no contact; the torque balances gravity
  contact,   ///< a wall is rendered
  fault,     ///< the frame was invalid; see the status
};

/// Return the name of a mode in plain words. Realtime: yes.
const char* toString(RenderMode mode) noexcept;

/// Output of a renderer.
struct TickOutput {
  JointVector torque;  ///< with gravity, N m or N; finite and within +-maxTorque with any status
  RenderMode mode = RenderMode::fault;
  bool saturated = false;    ///< a motor's limit reduced the torque
  double normalForce = 0.0;  ///< force of the wall on the tool along the deepest contact's normal, N
  /// The same for each contact: how the force divides between movable obstacles. All 0: it acts at the deepest contact.
  std::array<double, kMaxContacts> normalForces{};
  double cables = 0.0;  ///< ln(stiffness of the cables over the device file's), as the renderer has learnt it
  int delay = -1;       ///< constant delay of the commands, ticks, as the renderer has learnt it; -1: not known
};

/// Data of one tick, in SI units. Poses, twists and contacts are in W. Joint vectors have n entries.
///
/// A tick without a new sample has `age` k > 0. Kinematics and contacts are then those of the last sample, k periods
/// old. The renderer predicts from them and returns a torque as at any other tick. It neither restarts nor learns.
///
/// The time between two ticks may differ from the period, for example if a sample is late. If ticks are missing, the
/// last torque acted until this tick.
struct TickFrame {
  // Sense.
  double time = 0.0;                   ///< s, strictly increasing
  int age = 0;                         ///< age of the sample, periods; 0: a new sample
  Kinematics kinematics;               ///< from the measurement; with the inertia if the renderer needs it
  JointVector maxTorque;               ///< limit of each motor, N m or N; 0: a joint without a motor
  std::optional<JointVector> applied;  ///< torque that acted since the last tick, N m or N; empty: not reported

  // Find contacts, contact rows and responses.
  ContactSnapshot contacts;  ///< at the pose, deepest first
  ContactRows rows;
  ContactYield yield;

  // Render.
  /// Torque of the guides, which the tick adds to the renderer's, N m or N; empty: none. A renderer must hold the walls
  /// against it.
  JointVector guide;
  TickOutput output;

  /// Force that the guides of the scene had on the TCP on the way since the last sample, without damping, W, N. It is
  /// the slope of an energy that they store, so the guard lets them return its work.
  Vec3 guided = Vec3::Zero();

  // Guard.
  /// Torque added to the renderer's last one after a tap, N m or N; empty: zero or unknown. `command` contains it.
  JointVector added;
  JointVector command;  ///< torque for the motors, N m or N; for the renderer: that of the last tick, empty: unknown
  GuardReason reason = GuardReason::none;  ///< why the command differs from the requested torque
};

/// Factor the inertia and fill the rows of all contacts (stage `contact rows and responses`). Status outOfRange in
/// these cases; the frame then has no rows:
///
/// - the inertia is missing or not positive definite;
/// - the inertia of a joint is outside 1e-12 to 1e6 kg m^2 or kg;
/// - the number of contacts is invalid.
///
/// Realtime: yes.
[[nodiscard]] Status fillContactRows(TickFrame& frame) noexcept;

}  // namespace enamel
