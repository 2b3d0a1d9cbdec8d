#include "enamel/render/impedance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/message.hpp"

namespace enamel {
namespace {

void requireNotNegative(double value, const char* name, const char* unit) {
  require(value >= 0.0 && std::isfinite(value), std::string("impedance renderer: ") + name + " is " +
                                                    formatNumber(value) + ", must be at least 0 " + unit +
                                                    " and finite");
}

}  // namespace

double requiredDamping(const ImpedanceOptions& options, double period) noexcept {
  return 0.5 * options.stiffness * period + std::abs(options.damping);
}

ImpedanceRenderer::ImpedanceRenderer(const ImpedanceOptions& options) : options_(options) {
  requireNotNegative(options.stiffness, "stiffness", "N/m");
  requireNotNegative(options.damping, "damping", "N s/m");
}

Status ImpedanceRenderer::render(const TickInput& input, TickOutput& output) noexcept {
  Vec6 wrench = Vec6::Zero();
  output.mode = RenderMode::free;
  for (int i = 0; i < input.contacts.count; ++i) {
    const Contact& contact = input.contacts.contacts[i];
    if (!(contact.gap < 0.0)) continue;
    const double speed = contact.normal.dot(contactVelocity(input.kinematics, contact));
    const double force = std::max(0.0, -options_.stiffness * contact.gap - options_.damping * speed);
    wrench.head<3>() += force * contact.normal;
    wrench.tail<3>() += force * (contact.point - input.kinematics.pose.position).cross(contact.normal);
    if (output.mode == RenderMode::free) output.normalForce = force;  // of the deepest
    output.mode = RenderMode::contact;
  }
  output.torque = staticTorque(input.kinematics, wrench);
  return Status::ok;
}

}  // namespace enamel
