#include "enamel/render/tick.hpp"

namespace enamel {

Status hapticTick(const TauModel& model, const Scene& scene, const Tool& tool, double time, const Vec6& q,
                  const Vec6& rates, TickMemory& memory, Renderer& renderer, TickInput& input,
                  TickOutput& output) noexcept {
  output = TickOutput{};
  Status status = forwardKinematics(model, q, memory.tracked).status;
  if (status != Status::ok) return status;
  input.time = time;
  input.q = q;
  input.rates = rates;
  input.pose = memory.tracked.pose;
  input.twist = twistFromRates(model, memory.tracked, rates);
  status = findContacts(scene, tool, input.pose, kContactMargin, &memory.contacts, input.contacts);
  if (status != Status::ok) return status;
  input.maxTorque = model.maxTorque;
  return renderer.step(input, output);
}

}  // namespace enamel
