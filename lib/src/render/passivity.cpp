#include "enamel/render/passivity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#include "core/message.hpp"

namespace enamel {
namespace {

constexpr std::size_t kLayers = 128;
constexpr double kThickness = 40e-6;  // m: a few counts of an encoder

// Doubles only, so that it has no padding.
struct Port {
  std::array<double, kLayers> energy{};  // J; without memory all of it is in the first layer
  double depth = 0.0;                    // m
  double started = 0.0;
  std::array<double, kMaxJoints> q{};       // of the last sample
  std::array<double, kMaxJoints> torque{};  // without gravity, mean since the last sample
  double ticks = 0.0;                       // since the last sample
};

std::size_t layerAt(double depth) noexcept {
  return static_cast<std::size_t>(std::clamp(depth / kThickness, 0.0, kLayers - 1.0));
}

// Call each(layer, share) for the layers between two depths, with the share of the distance in each.
template <typename Each>
void alongLayers(double from, double to, const Each& each) noexcept {
  const double low = std::min(from, to), high = std::max(from, to);
  const std::size_t first = layerAt(low), last = layerAt(high);
  if (first == last) return each(first, 1.0);
  for (std::size_t i = first; i <= last; ++i) {
    const double top = i == first ? low : static_cast<double>(i) * kThickness;
    const double bottom = i == last ? high : static_cast<double>(i + 1) * kThickness;
    each(i, (bottom - top) / (high - low));
  }
}

Port portOf(const std::vector<unsigned char>& state) noexcept {
  Port port;
  std::memcpy(&port, state.data(), sizeof(port));
  return port;
}

}  // namespace

PassivityRenderer::PassivityRenderer(std::unique_ptr<Renderer> wall, PassivityBound bound)
    : wall_(std::move(wall)), bound_(bound) {
  require(wall_ != nullptr, "passivity: the wall's renderer is missing");
  state_.resize(sizeof(Port));
}

double PassivityRenderer::energy() const noexcept {
  const auto layers = portOf(state_).energy;
  return std::accumulate(layers.begin(), layers.end(), 0.0);
}

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
  wall_->saveState(loaded_.data());  // differs if the wall rejects these bytes
  if (!isFinite({state_.data(), sizeof(Port)}) || std::memcmp(loaded_.data(), wall, loaded_.size()) != 0) resetState();
}

Status PassivityRenderer::render(const TickFrame& frame, TickOutput& output) noexcept {
  const Kinematics& k = frame.kinematics;
  const auto n = k.q.size();
  const Status status = wall_->step(frame, output);
  if (status != Status::ok) return status;
  Port port = portOf(state_);
  // Motion with the obstacle at the deepest contact is not work of the wall.
  Vec6 carried = Vec6::Zero();
  double depth = 0.0, inward = 0.0;  // m, m/s; without memory everything is one layer
  if (frame.contacts.count > 0) {
    const Contact& deepest = frame.contacts.contacts[0];
    carried.head<3>() = deepest.obstacleVelocity;
    if (bound_ == PassivityBound::memory) {
      depth = std::max(0.0, -deepest.gap);
      inward = -deepest.normal.dot(contactVelocity(k, deepest));
    }
  }
  const JointVector carriedRates = k.inverseTransposed.transpose() * carried;
  const bool isSample = frame.age == 0;  // without a sample the motion is unknown
  if (isSample && port.started != 0.0) {
    const JointVector* told = nullptr;  // the torque of the last tick; others may have changed the output
    if (port.ticks == 1.0 && frame.applied)
      told = &*frame.applied;
    else if (port.ticks == 1.0 && frame.command.size() == n)
      told = &frame.command;
    double taken = 0.0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double acted = told != nullptr ? (*told)[i] - k.gravity[i] : port.torque[i];
      taken -= acted * (k.q[i] - port.q[i] - port.ticks * period_ * carriedRates[i]);
    }
    alongLayers(port.depth, depth, [&](std::size_t i, double share) { port.energy[i] += share * taken; });
  }
  // Forget energy of layers that the tool has left.
  const std::size_t present = output.mode == RenderMode::contact ? layerAt(depth) + 1 : 0;
  for (std::size_t i = present; i < kLayers; ++i) port.energy[i] = std::min(port.energy[i], 0.0);
  port.started = 1.0;
  port.depth = depth;
  port.ticks = isSample ? 1.0 : port.ticks + 1.0;
  const JointVector rendered = output.torque - k.gravity;
  const double giving = period_ * rendered.dot(k.rates - carriedRates);
  double share = 1.0;
  if (giving > 0.0)
    alongLayers(depth, std::max(0.0, depth + period_ * inward), [&](std::size_t i, double part) {
      if (part > 0.0) share = std::min(share, std::max(0.0, port.energy[i]) / (part * giving));
    });
  output.torque = k.gravity + share * rendered;
  output.normalForce *= share;
  for (Eigen::Index i = 0; i < n; ++i) {
    port.q[i] = k.q[i];
    const double given = share * rendered[i];
    port.torque[i] = isSample ? given : port.torque[i] + (given - port.torque[i]) / port.ticks;
  }
  std::memcpy(state_.data(), &port, sizeof(port));
  wall_->saveState(state_.data() + sizeof(port));
  return Status::ok;
}

}  // namespace enamel
