// A wall that never gives more energy than it took, whatever its spring: passivity in the time domain.
#pragma once

#include <cstdint>
#include <memory>

#include "enamel/render/renderer.hpp"

namespace enamel {

/// What a wall may give.
enum class PassivityBound : std::uint8_t {
  energy,  ///< what it has taken, anywhere
  memory,  ///< at a depth what it has taken at that depth
};

/// Passivity observer and controller (Hannaford and Ryu 2002, eq. 6 and 12) around another renderer, at the port
/// between its torques and the joints:
///   E_k = E_(k-1) - r_(k-1)^T (q_k - q_(k-1)),   r = torque that really acted - gravity,
/// is what the wall has taken from the tool, less the work of a moving obstacle. Before a torque r acts, the energy
/// that it will give at the present rates, r^T q' T, is compared with E (a tick ahead: Ryu, Preusche, Hannaford and
/// Hirzinger 2005), and r becomes smaller by one factor where that is more: to nothing while E < 0. That is the damper
/// of the controller along the force, no firmer than the force, so that the wall neither turns nor pulls. Off the wall
/// what it took is forgotten, what it gave too much is not: the next contact owes it.
///
/// With PassivityBound::memory, E is kept in layers of 40 um of the deepest contact's depth (the idea of Ryu and Yoon
/// 2014, who remember the force over the depth on the way in and stay below it on the way out; here the energy of a
/// layer, so that a wall that turns within one is counted exactly). On the way out the factor is that of the layer that
/// has least for its part of the next tick's motion; what a layer has left when the tool is out of it is forgotten,
/// what it owes is not. All deeper than 5.1 mm is one layer.
///
/// Without delay no contact gives energy. With one, a wall sees what a late torque gave when it is done: it then gives
/// nothing until the debt is paid, which bounds the energy and no more.
class PassivityRenderer final : public Renderer {
 public:
  /// Throws Error: no wall.
  explicit PassivityRenderer(std::unique_ptr<Renderer> wall, PassivityBound bound = PassivityBound::energy);

  bool needsInertia() const noexcept override { return wall_->needsInertia(); }

  /// E, with memory the sum over the layers, J. Realtime: yes.
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
  std::vector<unsigned char> state_;   // the port's, then the wall's
  std::vector<unsigned char> loaded_;  // the wall's, as it took it
};

}  // namespace enamel
