// Coulomb friction with stick and slip at the contacts of a tool, for every renderer.
//
// Stick: a spring and a damper along the surface hold the contact, f = -k e - b v. The stretch e is the displacement of
// the tool's material over the obstacle since it took hold. |f| is at most mu_s times the load (elasto-plastic model,
// Hayward and Armstrong 2000).
//
// Slip: the contact slides while k |e| exceeds that bound. The Coulomb part of |f| is then at most mu_k times the load.
// The material's viscosity times the sliding speed adds to it. e is limited to the stretch that the spring can hold.
// The stored energy is therefore at most (mu load)^2 / (2 k).
//
// Load: the larger of the normal force and its mean over about ten ticks. Encoder counts make a light push flicker
// between zero and twice its force, and a light tool hop. A grip based on single ticks would creep. Over any time, the
// sum of the Coulomb part of |f| is at most mu_s times the sum of the normal forces.
//
// Off the surface, e is kept for about ten ticks, as long as the last normal forces would hold the contact. A contact
// that is no longer near is forgotten.
#pragma once

#include <array>

#include "enamel/collision/contact.hpp"
#include "enamel/device/mechanism.hpp"

namespace enamel {

/// Largest number of contacts with friction at the same time.
inline constexpr int kMaxFrictionPoints = kMaxContacts;

/// Memory of one contact. It contains doubles only and is part of a renderer's state.
struct FrictionPoint {
  double obstacle = -1.0, part = -1.0;  ///< obstacle and tool part; -1: unused
  double key = 0.0;                     ///< Contact::key
  std::array<double, 3> point{};        ///< point at the last tick, W, m
  std::array<double, 3> stretch{};      ///< e, W, m
  double load = 0.0;                    ///< mean normal force, N
  double budget = 0.0;                  ///< unused normal force of past ticks, N times ticks
  double slides = 0.0;                  ///< sliding: 0 or 1
};

/// Stiffness and damping of a sticking contact.
struct TangentialGains {
  double stiffness;  ///< k, N/m
  double damping;    ///< b, N s/m
  /// Resolution of the measured motion, m. If less than four steps would make the contact slide, the spring is softer.
  double step = 0.0;
};

/// Motion of the tool's material over the obstacle at a contact, in W.
struct SurfaceMotion {
  Vec3 displacement;  ///< since the last tick, m
  Vec3 predicted;     ///< from now until the torque acts, m
  Vec3 velocity;      ///< when the torque acts, m/s
};

/// Return whether only the walls of a hole hold the tool at a contact (Contact::grip): the ground below carries no
/// force. `normalForce`: with the grip, N. Realtime: yes.
inline bool isHeldByWalls(const Contact& contact, double normalForce) noexcept {
  return contact.grip > 0.0 && normalForce <= contact.grip;
}

/// Friction of all contacts of one tool, from tick to tick.
class FrictionMemory {
 public:
  /// Begin a tick. Realtime: yes.
  void begin() noexcept;

  /// Return the friction force on the tool at a contact, along the surface, W, N. In a hole (Contact::grip) it also
  /// acts along the normal, while the ground carries no force. `normalForce` is in N, with the grip; with zero the
  /// result is zero. Call this once per tick for each near contact, also if it carries no force. A contact is
  /// recognised by its key or, without a key, by its obstacle, tool part and place. Realtime: yes.
  Vec3 force(const Contact& contact, const SurfaceMotion& slide, const TangentialGains& gains,
             double normalForce) noexcept;

  /// End a tick. Contacts without a call of force() in this tick are forgotten. Realtime: yes.
  void end() noexcept { last_ = now_; }

 private:
  std::array<FrictionPoint, kMaxFrictionPoints> last_{}, now_{};
  double count_ = 0.0;  // of now_; a double, so that the state has no padding
};

}  // namespace enamel
