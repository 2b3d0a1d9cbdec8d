// Coulomb friction with stick and slip at the contacts of a tool, for every renderer.
//
// A contact that sticks is held by a spring and a damper along the surface, f = -k e - b v: e is the way that the
// tool's material has gone over the obstacle's since it took hold (Hayward and Armstrong 2000: elasto-plastic). |f| is
// at most mu_s times the load; where k |e| would exceed that, the contact slides: |f| is at most mu_k times the load,
// and e is kept at what the spring can carry, so that no energy is stored beyond (mu load)^2 / (2 k). The load is the
// normal force or, where that is larger, its mean of some ten ticks: counts of encoders make a light push flicker
// between nothing and twice its force, and a light tool hop; a grip that went by single ticks would creep with them.
// Over any time the sum of |f| is at most mu_s times that of the normal forces. Off the surface e is kept for as long
// as those it last had would hold it, some ten ticks; a contact that is not near any more is forgotten.
#pragma once

#include <array>

#include "enamel/collision/contact.hpp"
#include "enamel/device/mechanism.hpp"

namespace enamel {

/// Most contacts with friction at once.
inline constexpr int kMaxFrictionPoints = kMaxContacts;

/// What is remembered of one contact. Doubles only: part of a renderer's state.
struct FrictionPoint {
  double obstacle = -1.0, part = -1.0;  ///< whose; -1: none
  double key = 0.0;                     ///< Contact::key
  std::array<double, 3> point{};        ///< where it was at the last tick, W, m
  std::array<double, 3> stretch{};      ///< e, W, m
  double load = 0.0;                    ///< the mean normal force that holds it, N
  double budget = 0.0;                  ///< what normal forces have not been used for yet, N times ticks
  double slides = 0.0;                  ///< 0 or 1
};

/// How firmly a contact sticks.
struct TangentialGains {
  double stiffness;  ///< k, N/m
  double damping;    ///< b, N s/m
  /// Step in which the motion is seen, m: where less than four of them would make it slide, the spring is softer.
  double step = 0.0;
};

/// Motion of the tool's material over the obstacle's at a contact, in W.
struct SurfaceMotion {
  Vec3 displacement;  ///< since the last tick, m
  Vec3 predicted;     ///< from now until the force acts, m
  Vec3 velocity;      ///< when the force acts, m/s
};

/// The contacts of one tool from tick to tick.
class FrictionMemory {
 public:
  /// Begins a tick.
  void begin() noexcept;

  /// Force on the tool along the surface at a contact with the normal force `normalForce` (N), W; zero where that is
  /// zero. Called once a tick for each contact that is near, also where it carries no force at this tick; finds the
  /// contact again by its key, or, where it has none, by its obstacle, its tool part and its place. Realtime: yes.
  Vec3 force(const Contact& contact, const SurfaceMotion& slide, const TangentialGains& gains,
             double normalForce) noexcept;

  /// Ends a tick: contacts that were not asked for are forgotten.
  void end() noexcept { last_ = now_; }

 private:
  std::array<FrictionPoint, kMaxFrictionPoints> last_{}, now_{};
  double count_ = 0.0;  // of now_; a double, so that a state has no padding
};

}  // namespace enamel
