#include "enamel/render/passivity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/message.hpp"

namespace enamel {
namespace {

// Doubles only.
struct Port {
  double energy = 0.0;  // J
  double started = 0.0;
  std::array<double, kMaxJoints> q{}, torque{};  // of the last tick; the torque beyond gravity
};

Port portOf(const std::vector<unsigned char>& state) noexcept {
  Port port;
  std::memcpy(&port, state.data(), sizeof(port));
  return port;
}

}  // namespace

PassivityRenderer::PassivityRenderer(std::unique_ptr<Renderer> wall) : wall_(std::move(wall)) {
  require(wall_ != nullptr, "passivity: there is no wall");
  state_.resize(sizeof(Port));
}

double PassivityRenderer::energy() const noexcept { return portOf(state_).energy; }

void PassivityRenderer::prepare(double period) {
  wall_->activate(period);
  period_ = period;
  loaded_.resize(wall_->stateSize());
  state_.resize(sizeof(Port) + loaded_.size());
}

void PassivityRenderer::resetState() noexcept {
  wall_->reset();
  const Port port;
  std::memcpy(state_.data(), &port, sizeof(port));
  wall_->saveState(state_.data() + sizeof(port));
}

void PassivityRenderer::stateLoaded() noexcept {
  unsigned char* const wall = state_.data() + sizeof(Port);
  wall_->loadState(wall);
  wall_->saveState(loaded_.data());  // that after reset(), where no wall has such bytes
  if (!isFinite({state_.data(), sizeof(Port)}) || std::memcmp(loaded_.data(), wall, loaded_.size()) != 0) resetState();
}

Status PassivityRenderer::render(const TickInput& input, TickOutput& output) noexcept {
  const Kinematics& k = input.kinematics;
  const auto n = k.q.size();
  const Status status = wall_->step(input, output);
  if (status != Status::ok) return status;
  Port port = portOf(state_);
  // The motion at the deepest contact that is the obstacle's is no work of the wall.
  Vec6 carried = Vec6::Zero();
  if (input.contacts.count > 0) carried.head<3>() = input.contacts.contacts[0].obstacleVelocity;
  const JointVector carriedRates = k.inverseTransposed.transpose() * carried;
  if (port.started != 0.0)
    for (Eigen::Index i = 0; i < n; ++i) {
      const double acted = input.applied.size() == n ? input.applied[i] - k.gravity[i] : port.torque[i];
      port.energy -= acted * (k.q[i] - port.q[i] - period_ * carriedRates[i]);
    }
  port.started = 1.0;
  if (output.mode != RenderMode::contact) port.energy = std::min(port.energy, 0.0);
  const JointVector rendered = output.torque - k.gravity;
  const double given = period_ * rendered.dot(k.rates - carriedRates);
  const double share = given > 0.0 ? std::clamp(port.energy / given, 0.0, 1.0) : 1.0;
  output.torque = k.gravity + share * rendered;
  output.normalForce *= share;
  for (Eigen::Index i = 0; i < n; ++i) {
    port.q[i] = k.q[i];
    port.torque[i] = share * rendered[i];
  }
  std::memcpy(state_.data(), &port, sizeof(port));
  wall_->saveState(state_.data() + sizeof(port));
  return Status::ok;
}

}  // namespace enamel
