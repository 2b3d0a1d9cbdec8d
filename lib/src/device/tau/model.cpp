#include "enamel/device/tau/model.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "core/message.hpp"
#include "device/inertia.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/tau/dynamics.hpp"
#include "enamel/device/tau/kinematics.hpp"
#include "loop.hpp"

namespace enamel {
namespace {

// Parallel-axis theorem: tensor about a point from the tensor about the centre of mass.
Mat3 inertiaAboutOrigin(const Mat3& inertia, double mass, const Vec3& com) {
  const Mat3 symmetric = 0.5 * (inertia + inertia.transpose());
  return symmetric + mass * (com.squaredNorm() * Mat3::Identity() - com * com.transpose());
}

constexpr double kSmallestHomeMeasure = 1e-4;  // dimensionless loop measure at home

}  // namespace

TauModel makeModel(const TauParameters& parameters) {
  checkTau(parameters);
  TauModel model{};
  for (std::size_t i = 0; i < 3; ++i) {
    const ChainParameters& p = parameters.chain[i];
    ChainModel& c = model.chain[i];
    c.base = p.base;
    c.platform = p.platform;
    c.length1 = p.link1.length;
    c.length2 = p.link2.length;
    c.elbow = p.elbow;
    c.mass2 = p.link2.mass;
    c.moment1 = p.link1.mass * p.link1.com;
    c.moment2 = p.link2.mass * p.link2.com;
    c.inertia1 = inertiaAboutOrigin(p.link1.inertia, p.link1.mass, p.link1.com);
    c.inertia2 = inertiaAboutOrigin(p.link2.inertia, p.link2.mass, p.link2.com);
    model.side[i] = (p.platform - parameters.chain[(i + 1) % 3].platform).norm();
  }

  const PlatformParameters& platform = parameters.platform;
  model.platformMass = platform.mass;
  model.platformMoment = platform.mass * platform.com;
  model.platformInertia = inertiaAboutOrigin(platform.inertia, platform.mass, platform.com);
  model.damping = platform.damping;
  model.gravity = parameters.gravity;
  model.maxTorque = parameters.motor.maxTorque;
  model.rotorInertia = parameters.motor.rotorInertia;
  model.viscousFriction = parameters.motor.viscousFriction;
  model.encoderCounts = parameters.motor.encoderCounts;

  const Vec3 side1 = model.chain[1].platform - model.chain[0].platform;
  const Vec3 side2 = model.chain[2].platform - model.chain[0].platform;
  Mat3 triad;
  triad << side1, side2, side1.cross(side2);
  model.triadInverse = triad.inverse();
  model.platformCentre = (model.chain[0].platform + model.chain[1].platform + model.chain[2].platform) / 3.0;

  const auto refuse = [&parameters](const std::string& problem) {
    throw ConfigurationError("device \"" + parameters.name + "\"", 0, "", problem);
  };
  const Status status = inverseKinematics(model, Pose{}, model.home);
  if (status != Status::ok) refuse(std::string("the home pose is ") + toString(status));
  model.homeAngles = jointAngles(model.home);
  const double measure = loopMeasure(model, model.home);
  if (!(std::abs(measure) > kSmallestHomeMeasure))
    refuse("the home pose is a parallel singularity: its measure is " + formatNumber(std::abs(measure)) +
           ", must be greater than " + formatNumber(kSmallestHomeMeasure));
  model.homeSign = measure > 0.0 ? 1.0 : -1.0;
  Cholesky<kMaxJoints> inertia;
  if (!factorInertia(taskInertia(model, model.home), inertia))
    refuse("the mass matrix at home is not positive definite: give the platform or the links more inertia");
  return model;
}

}  // namespace enamel
