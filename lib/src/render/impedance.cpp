#include "enamel/render/impedance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "core/message.hpp"
#include "enamel/control/impedance_map.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"

namespace enamel {
namespace {

void requireNotNegative(double value, const char* name, const char* unit) {
  if (!(value >= 0.0 && std::isfinite(value)))
    throw Error(std::string("impedance renderer: ") + name + " is " + formatNumber(value) + ", must be at least 0 " +
                unit + " and finite");
}

}  // namespace

DampingBound dampingBound(const ImpedanceOptions& options, double period) noexcept {
  const double required = passiveDamping({options.stiffness, options.damping, 0}, period);
  return {required, options.deviceDamping, options.deviceDamping > required};
}

ImpedanceRenderer::ImpedanceRenderer(const TauModel& model, const ImpedanceOptions& options)
    : model_(model), options_(options) {
  requireNotNegative(options.stiffness, "stiffness", "N/m");
  requireNotNegative(options.damping, "damping", "N s/m");
  requireNotNegative(options.deviceDamping, "device damping", "N s/m");
}

Status ImpedanceRenderer::render(const TickInput& input, TickOutput& output) noexcept {
  TauConfiguration configuration;
  const Status status = inverseKinematics(model_, input.pose, configuration);
  if (status != Status::ok) return status;

  Vec6 wrench = Vec6::Zero();
  for (int i = 0; i < input.contacts.count; ++i) {
    const Contact& contact = input.contacts.contacts[i];
    if (!(contact.gap < 0.0)) continue;
    const Vec3 arm = contact.point - input.pose.position;
    const Vec3 velocity = input.twist.head<3>() + input.twist.tail<3>().cross(arm) - contact.obstacleVelocity;
    const double force =
        std::max(0.0, -options_.stiffness * contact.gap - options_.damping * contact.normal.dot(velocity));
    wrench.head<3>() += force * contact.normal;
    wrench.tail<3>() += force * arm.cross(contact.normal);
    if (output.mode != RenderMode::contact) output.normalForce = force;  // of the deepest
    output.mode = RenderMode::contact;
  }
  if (output.mode != RenderMode::contact) output.mode = RenderMode::free;
  output.torque = staticTorque(model_, configuration, wrench);
  return Status::ok;
}

}  // namespace enamel
