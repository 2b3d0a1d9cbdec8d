// A driver of the CHAI3D substitute with a virtual device and a hand, and possible faults.
#pragma once

#include <chai3d.h>

#include <cmath>
#include <enamel_chai3d.hpp>
#include <limits>

#include "enamel/sim/virtual_device.hpp"

namespace enamel::test {

/// A hand that presses along -z of W with a varying force, moves along x, and holds the tool's orientation.
inline const auto pressingHand = [](double time, const Pose& pose, const Vec6& twist) {
  Vec6 wrench = Vec6::Zero();
  const Vec3 goal(0.004 * std::sin(9.0 * time), 0.0, 0.001 - 0.004 * std::sin(6.0 * time));
  wrench.head<3>() = 400.0 * (goal - pose.position) - 8.0 * twist.head<3>();
  const Vec3 turn(0.3 * std::sin(5.0 * time), 0.2 * std::sin(7.0 * time), 0.0);
  wrench.tail<3>() = 0.5 * (turn - rotationVector(pose.rotation)) - 0.02 * twist.tail<3>();
  return wrench;
};

inline VirtualDeviceSetup driverSetup() {
  VirtualDeviceSetup setup;
  setup.start.position = Vec3(0.0, 0.0, 0.002);
  return setup;
}

/// Sending the force ends a tick of the device.
class Driver final : public chai3d::cGenericHapticDevice {
 public:
  explicit Driver(const Mechanism& mechanism) : mechanism_(mechanism), physics(mechanism, driverSetup()) {
    const bool turns = mechanism.joints() == 6;
    m_specifications.m_modelName = "driver";
    m_specifications.m_maxLinearForce = mechanism.limits().effort[0];
    m_specifications.m_maxAngularTorque = turns ? mechanism.limits().effort[3] : 0.0;
    m_specifications.m_sensedPosition = m_specifications.m_actuatedPosition = true;
    m_specifications.m_sensedRotation = m_specifications.m_actuatedRotation = turns;
  }
  bool open() override { return m_deviceReady = opens; }
  bool close() override {
    ++closed;
    return !(m_deviceReady = false);
  }
  bool calibrate(bool) override { return calibrates; }
  bool getPosition(chai3d::cVector3d& position) override {
    if (lost || !m_deviceReady || physics.measure(measured) != Status::ok) return chai3d::C_ERROR;
    if (mechanism_.track(measured.q, measured.rates, false, kinematics_) != Status::ok) return chai3d::C_ERROR;
    position = toChai3d(Vec3(kinematics_.pose.position + offset));
    return chai3d::C_SUCCESS;
  }
  bool getRotation(chai3d::cMatrix3d& rotation) override {
    rotation = toChai3d(Mat3(stretch * hold * kinematics_.pose.rotation));
    return chai3d::C_SUCCESS;
  }
  bool getLinearVelocity(chai3d::cVector3d& velocity) override {
    velocity = toChai3d(Vec3(kinematics_.twist.head<3>()));
    return chai3d::C_SUCCESS;
  }
  bool getAngularVelocity(chai3d::cVector3d& velocity) override {
    velocity = toChai3d(Vec3(kinematics_.twist.tail<3>()));
    return chai3d::C_SUCCESS;
  }
  bool getUserSwitches(unsigned int& held) override {
    held = switches;
    return tellsSwitches;
  }
  bool setForceAndTorqueAndGripperForce(const chai3d::cVector3d& f, const chai3d::cVector3d& m, double) override {
    if (refuses) return chai3d::C_ERROR;
    force = fromChai3d(f);
    moment = fromChai3d(m);
    if (!moves) return chai3d::C_SUCCESS;
    Vec6 wrench;
    wrench << force, moment;
    return physics.actuate({torqueOf(kinematics_.jacobian, wrench)}) == Status::ok &&
           physics.advance(pressingHand) == Status::ok;
  }

 private:
  const Mechanism& mechanism_;
  Kinematics kinematics_;

 public:
  VirtualDevice physics;
  Measurement measured;
  bool opens = true, calibrates = true, lost = false, refuses = false, moves = true, tellsSwitches = true;
  int closed = 0;
  unsigned int switches = 1;
  Vec3 offset = Vec3::Zero();
  double stretch = 1.0;
  Mat3 hold = Mat3::Identity();                      // rotation of a stylus that senses it
  Vec3 force = Vec3::Zero(), moment = Vec3::Zero();  // last sent, N, N m, in W
};

/// Make a box whose front is at x = 0 of CHAI3D, z = 0 of W: twelve triangles, outwards. Lengths times `scale`.
inline void makeBox(chai3d::cMesh& mesh, double scale = 1.0) {
  for (int i = 0; i < 8; ++i)
    mesh.newVertex((i & 1) != 0 ? 0.0 : -0.02 * scale, (i & 2) != 0 ? 0.05 * scale : -0.05 * scale,
                   (i & 4) != 0 ? 0.05 * scale : -0.05 * scale);
  for (const auto& t : {"046", "062", "137", "175", "015", "054", "273", "267", "023", "031", "457", "476"}) {
    const auto corner = [&t](int k) { return static_cast<unsigned int>(t[k] - '0'); };
    mesh.newTriangle(corner(0), corner(1), corner(2));
  }
}

/// A tool on a driver, in simulated time; `cutoff`: as in Chai3dOptions.
struct Bench {
  Bench(const Mechanism& mechanism, Renderer& renderer, double cutoff = 0.0)
      : driver(std::make_shared<Driver>(mechanism)),
        tool(&world, mechanism, renderer, guardFor(mechanism, 1e-3), optionsFor(cutoff)) {
    tool.setHapticDevice(driver);
    tool.setRadius(0.0);
  }
  Chai3dOptions optionsFor(double cutoff) {
    Chai3dOptions options;
    options.cutoff = cutoff;
    options.clock = [this] { return driver->physics.time() + later; };
    return options;
  }
  void tick() {
    tool.updateFromDevice();
    tool.computeInteractionForces();
    tool.applyToDevice();
  }

  /// Tick until it is pressed with `force`, N. Return false after 2 s.
  bool press(double force) {
    for (int i = 0; i < 2000; ++i) {
      tick();
      if (driver->force.z() > force) return true;
    }
    return false;
  }

  chai3d::cWorld world;
  std::shared_ptr<Driver> driver;
  double later = 0.0;  // s, offset of the clock
  Chai3dTool tool;
};

}  // namespace enamel::test
