#include "enamel/render/tick.hpp"

namespace enamel {

Status hapticTick(const DeviceModel& model, const Scene& scene, double time, const Vec6& q, const Vec6& rates,
                  Configuration& tracked, Renderer& renderer, TickInput& input, TickOutput& output) noexcept {
  output = TickOutput{};
  const Status status = forwardKinematics(model, q, tracked).status;
  if (status != Status::ok) return status;
  input.time = time;
  input.q = q;
  input.rates = rates;
  input.pose = tracked.pose;
  input.twist = twistFromRates(model, tracked, rates);
  queryContacts(scene, tracked.pose.position, input.contacts);
  input.maxTorque = model.maxTorque;
  return renderer.step(input, output);
}

}  // namespace enamel
