// A stiff wall in CHAI3D: a box, touched through a Chai3dTool in the usual loop of a CHAI3D program.
#include <cstdio>
#include <enamel/device/cartesian/mechanism.hpp>
#include <enamel/render/position_control.hpp>
#include <enamel/sim/virtual_device.hpp>
#include <enamel_chai3d.hpp>

using namespace enamel;

// Takes the place of a CHAI3D driver: a person's hand presses a stylus of 45 g. Each command advances it by 1 ms.
class SimulatedStylus final : public chai3d::cGenericHapticDevice {
 public:
  SimulatedStylus() {
    m_specifications.m_maxLinearForce = 3.3;    // N
    m_specifications.m_workspaceRadius = 0.08;  // m
    m_specifications.m_sensedPosition = m_specifications.m_actuatedPosition = true;
    mechanism = std::make_unique<CartesianMechanism>(cartesianFor(m_specifications, 0.045, 1e-5));
    VirtualDeviceSetup setup;
    setup.start.position = Vec3(0.0, 0.0, 0.002);  // 2 mm in front of the wall
    setup.encoders.quantised = true;
    physics = std::make_unique<VirtualDevice>(*mechanism, setup);
  }
  bool open() override { return m_deviceReady = true; }
  bool close() override { return !(m_deviceReady = false); }
  bool getPosition(chai3d::cVector3d& position) override {
    if (physics->measure(measured) == Status::ok) position = toChai3d(Vec3(measured.q));
    return m_deviceReady;
  }
  bool setForceAndTorqueAndGripperForce(const chai3d::cVector3d& force, const chai3d::cVector3d&, double) override {
    const auto hand = [](double time, const Pose& pose, const Vec6& twist) {
      Vec6 push = Vec6::Zero();
      const Vec3 goal(0.004 * std::sin(6.0 * time), 0.0, -0.001 + 0.003 * std::cos(4.0 * time));
      push.head<3>() = 400.0 * (goal - pose.position) - 8.0 * twist.head<3>();  // N
      return push;
    };
    return physics->actuate({fromChai3d(force)}) == Status::ok && physics->advance(hand) == Status::ok;
  }
  std::unique_ptr<CartesianMechanism> mechanism;
  std::unique_ptr<VirtualDevice> physics;
  Measurement measured;
};

int main() try {
  const auto stylus = std::make_shared<SimulatedStylus>();  // use instead: cHapticDeviceHandler().getDevice(stylus, 0)
  const CartesianMechanism mechanism(cartesianFor(stylus->getSpecifications(), 0.045, 1e-5));
  PositionControlRenderer servo(positionControlFor(mechanism, 1e-3, 0, 0));
  Chai3dOptions options;
  options.clock = [&stylus] { return stylus->physics->time(); };  // leave it out: the default is a real clock
  chai3d::cWorld world;
  auto* box = new chai3d::cMesh;  // front at x = 0
  for (int i = 0; i < 8; ++i) box->newVertex(i & 1 ? 0.0 : -0.02, i & 2 ? 0.05 : -0.05, i & 4 ? 0.05 : -0.05);
  for (const auto& t : {"046", "062", "137", "175", "015", "054", "273", "267", "023", "031", "457", "476"})
    box->newTriangle(t[0] - '0', t[1] - '0', t[2] - '0');
  world.addChild(box);
  auto* tool = new Chai3dTool(&world, mechanism, servo, guardFor(mechanism, 1e-3), options);
  world.addChild(tool);
  tool->setHapticDevice(stylus);
  tool->setRadius(0.002);  // the ball touches at x = 2 mm
  tool->addMesh(box);      // once, before the loop
  if (!tool->start()) throw Error("the stylus cannot be opened");

  double most = 0.0, deepest = 0.0;
  for (int i = 1; i <= 3000; ++i) {
    tool->updateFromDevice();
    tool->computeInteractionForces();
    tool->applyToDevice();
    const double force = tool->getDeviceGlobalForce()(0), depth = 0.002 - tool->getDeviceGlobalPos()(0);
    if (tool->isInContact(box)) deepest = std::max(deepest, depth);
    most = std::max(most, force);
    if (i % 100 == 0)
      std::printf("%.1f s %8.3f mm deep %6.2f N  %s\n", 1e-3 * i, 1e3 * depth, force,
                  std::string(static_cast<std::size_t>(20.0 * std::max(force, 0.0)), '#').c_str());
  }
  tool->stop();
  std::printf("pressed with up to %.2f N, %.3f mm into the wall\n", most, 1e3 * deepest);
  return most > 1.0 && deepest < 0.1e-3 ? 0 : 1;
} catch (const Error& error) {
  return std::fprintf(stderr, "wall: %s\n", error.what()), 1;
}
