// Time-domain passivity: a wall that never returns more energy than it took, with any spring.
#pragma once

#include <cstdint>
#include <memory>

#include "enamel/render/renderer.hpp"

namespace enamel {

/// Bound on the energy that a wall may return.
enum class PassivityBound : std::uint8_t {
  energy,  ///< energy taken at any depth
  memory,  ///< at each depth, the energy taken at that depth
};

/// Passivity observer and controller (Hannaford and Ryu 2002, eq. 6 and 12) around another renderer. They act at the
/// port between its torques and the joints. The observer computes the energy that the wall has taken from the tool:
///
///   E_k = E_(k-1) - r_(k-1)^T (q_k - q_(k-1)),   r = acting torque - gravity
///
/// The work of a moving obstacle is subtracted.
///
/// Before a torque r acts, the controller predicts the energy that it will return at the present rates, r^T q' T. It
/// compares this energy with E one tick ahead (Ryu, Preusche, Hannaford and Hirzinger 2005). If it exceeds E, one
/// factor reduces r; the factor is zero while E < 0. The effect is the controller's damper along the force, never
/// larger than the force. The wall therefore neither pulls nor changes the direction of the force. When the tool leaves
/// the wall, a positive E is forgotten. A negative E remains: the next contact must first take this energy.
///
/// PassivityBound::memory keeps E in layers of 40 um of the deepest contact's depth. The idea is that of Ryu and Yoon
/// 2014, who store the force over the depth on the way in and stay below it on the way out. Here each layer stores
/// energy, so a motion that turns within a layer is counted exactly. On the way out, the layer with the least energy
/// for its part of the next motion determines the factor. When the tool has left a layer, the remaining energy of the
/// layer is forgotten. A debt of the layer is kept. All depths above 5.1 mm are one layer.
///
/// Without delay no contact returns energy. With delay, the observer sees the effect of a late torque only afterwards.
/// The wall then returns nothing until its debt is paid. This bounds the energy but nothing else.
class PassivityRenderer final : public Renderer {
 public:
  /// Throws Error if `wall` is null.
  explicit PassivityRenderer(std::unique_ptr<Renderer> wall, PassivityBound bound = PassivityBound::energy);

  bool needsInertia() const noexcept override { return wall_->needsInertia(); }
  Delay delay() const noexcept override { return wall_->delay(); }

  /// Return E, J; with PassivityBound::memory the sum over the layers. Realtime: yes.
  double energy() const noexcept;

 private:
  void prepare(double period) override;
  Status render(const TickFrame& frame, TickOutput& output) noexcept override;
  void resetState() noexcept override;
  StateBlock stateBlock() noexcept override { return {state_.data(), state_.size()}; }
  void stateLoaded() noexcept override;

  std::unique_ptr<Renderer> wall_;
  PassivityBound bound_;
  double period_ = 0.0;
  std::vector<unsigned char> state_;   // of the port, then of the wall
  std::vector<unsigned char> loaded_;  // state of the wall, as the wall accepted it
};

}  // namespace enamel
