#include "enamel/device/delta/model.hpp"

#include <cmath>

#include "enamel/device/delta/kinematics.hpp"

namespace enamel {

DeltaModel makeModel(const DeltaParameters& parameters) {
  checkDelta(parameters);
  const DeltaGeometry& g = parameters.geometry;
  DeltaModel model{};
  for (int i = 0; i < 3; ++i) {
    model.cosPhi[i] = std::cos(g.phi[i]);
    model.sinPhi[i] = std::sin(g.phi[i]);
  }
  model.a = g.a;
  model.b = g.b;
  model.e = g.e;
  model.link = g.d + g.e;
  model.radial = g.r - g.c;
  model.lateral = g.f - g.s;
  model.homeDistance = parameters.homeDistance;

  const UpperLinkParameters& upper = parameters.upperLink;
  model.upperInertia = parameters.motor.rotorInertia + upper.inertia + upper.mass * upper.com * upper.com;
  model.upperMoment = upper.mass * upper.com;
  model.barsMass = 2.0 * parameters.bar.mass;
  model.platformMass = parameters.platform.mass;
  model.friction = parameters.motor.viscousFriction;
  model.damping = parameters.platform.damping;
  model.gravity = parameters.gravity;

  DeltaConfiguration home;
  model.order = 1.0;
  if (inverseKinematics(model, Vec3::Zero(), home) != Status::ok) model.order = -1.0;
  return model;
}

}  // namespace enamel
