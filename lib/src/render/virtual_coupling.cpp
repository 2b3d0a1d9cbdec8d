#include "enamel/render/virtual_coupling.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/message.hpp"
#include "render/contact_forces.hpp"

namespace enamel {
namespace {

// Regularisation, as a share of a contact's own response, so that dependent contacts share the force.
constexpr double kDependent = 1e-6;

void requirePositive(double value, bool zero, const char* name, const char* unit) {
  require((value > 0.0 || (zero && value == 0.0)) && std::isfinite(value),
          std::string("virtual coupling: ") + name + " is " + formatNumber(value) + ", must be " +
              (zero ? "at least" : "above") + " 0 " + unit + " and finite");
}

}  // namespace

VirtualCouplingRenderer::VirtualCouplingRenderer(const VirtualCouplingOptions& options) : options_(options) {
  requirePositive(options.stiffness, false, "the stiffness", "N/m");
  requirePositive(options.damping, true, "the damping", "N s/m");
  requirePositive(options.mass, false, "the virtual tool's mass", "kg");
}

void VirtualCouplingRenderer::stateLoaded() noexcept {
  if (!isFinite(stateBlock())) resetState();
}

Status VirtualCouplingRenderer::render(const TickFrame& frame, TickOutput& output) noexcept {
  const Kinematics& k = frame.kinematics;
  const double ahead = frame.age * period_;  // since the sample, s
  const Vec3 speed = k.twist.head<3>(), device = k.pose.position + ahead * speed;
  Eigen::Map<Vec3> position(state_.position.data()), velocity(state_.velocity.data());
  if (state_.started == 0.0) {
    position = device;
    velocity = speed;
    state_.started = 1.0;
  }
  const double K = options_.stiffness, B = options_.damping, T = period_, inertia = options_.mass / T,
               whole = inertia + B + K * T;
  const Vec3 free = (inertia * velocity + B * speed - K * (position - device)) / whole;  // velocity without contacts

  ContactProblem problem;
  problem.most = 1e6;
  problem.motors = 0;
  problem.contacts = std::min(frame.contacts.count, kMaxActiveContacts);
  const Contact* const contacts = frame.contacts.contacts.data();
  for (int i = 0; i < problem.contacts; ++i) {
    const double gap = contacts[i].gap - ahead * contacts[i].normal.dot(contacts[i].obstacleVelocity);
    problem.r[i] = -(gap + contacts[i].normal.dot(position + T * free - k.pose.position));
    for (int j = 0; j < problem.contacts; ++j) problem.G[i][j] = T / whole * contacts[i].normal.dot(contacts[j].normal);
    problem.G[i][i] *= 1.0 + kDependent;
    problem.G[i][i] += 1.0 / contacts[i].material.stiffness;
  }
  const ContactSolution solution = solveContacts(problem);

  Vec3 push = Vec3::Zero(), moment = Vec3::Zero();
  output.mode = RenderMode::free;
  for (int i = 0; i < problem.contacts; ++i) {
    if (!(solution.force[i] > 0.0)) continue;
    const Vec3 force = solution.force[i] * contacts[i].normal;
    push += force;
    moment += (contacts[i].point - k.pose.position).cross(force);
    output.mode = RenderMode::contact;
  }
  velocity = free + push / whole;
  position += T * velocity;
  Vec6 wrench;
  wrench << K * (position - device) + B * (velocity - speed), moment;
  if (output.mode == RenderMode::contact) output.normalForce = contacts[0].normal.dot(Vec3(wrench.head<3>()));
  output.torque = staticTorque(k, wrench);
  return Status::ok;
}

}  // namespace enamel
