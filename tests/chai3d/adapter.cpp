// A CHAI3D program renders the same walls as the native loop, and CHAI3D's devices are HapticDevices.
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "chai3d/driver.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "support/catch.hpp"

namespace enamel::test_adapter {

namespace {

using chai3d::cMatrix3d;
using chai3d::cMesh;
using chai3d::cVector3d;
using test::Bench;
using test::Driver;

std::shared_ptr<const Mechanism> device(const std::string& name) {
  return makeMechanism(loadDevice(std::string(ENAMEL_SOURCE_DIR) + "/data/devices/" + name + ".toml"));
}

std::unique_ptr<Renderer> renderer(const std::string& name, const Mechanism& mechanism) {
  if (name == "impedance") return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{2000.0, 1.0});
  return std::make_unique<PositionControlRenderer>(positionControlFor(mechanism, 1e-3, 0, 0));
}

TriangleMesh boxInW() {
  cMesh mesh;
  test::makeBox(mesh);
  TriangleMesh result;
  for (const cVector3d& v : mesh.m_vertices->m_localPos) result.vertices.push_back(fromChai3d(v));
  for (unsigned int i = 0; i < mesh.m_triangles->getNumElements(); ++i) {
    const auto corner = [&](unsigned int k) { return static_cast<int>(mesh.m_triangles->getVertexIndex(i, k)); };
    result.triangles.push_back({corner(0), corner(1), corner(2)});
  }
  return result;
}

Scene nativeScene(bool asMesh) {
  if (!asMesh) return flatWall();
  Scene scene;
  Obstacle box;
  box.name = "box";
  box.shape = std::make_shared<const MeshModel>(boxInW());
  scene.add(box);
  return scene;
}

Tool ball(double radius) {
  Tool tool;
  tool.parts[0].radius = radius;
  return tool;
}

bool sameBits(const JointVector& a, const JointVector& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

cMatrix3d turned(const Vec3& rotationVectorInW) { return toChai3d(rotationFromVector(rotationVectorInW)); }

}  // namespace

TEST_CASE("axes: CHAI3D's x to the user, y right, z up are z, x, y of W; there and back is exact", "[chai3d]") {
  CHECK(fromChai3d(cVector3d(1.0, 2.0, 3.0)) == Vec3(2.0, 3.0, 1.0));
  const cVector3d back = toChai3d(Vec3(2.0, 3.0, 1.0));
  CHECK((back(0) == 1.0 && back(1) == 2.0 && back(2) == 3.0));
  const Mat3 rotation = rotationFromVector(Vec3(0.3, -0.7, 1.1));
  CHECK(fromChai3d(toChai3d(rotation)) == rotation);
  const Vec3 v(0.1, -0.2, 0.3);
  CHECK((fromChai3d(toChai3d(rotation) * toChai3d(v)) - rotation * v).norm() < 1e-16);  // sums in another order
}

TEST_CASE("a push through the tool gives the bits of the native loop: wall and mesh, spring and servo", "[chai3d]") {
  const auto mechanism = device("cartesian-3");
  for (const char* law : {"impedance", "position-control"}) {
    for (const bool asMesh : {false, true}) {
      for (const double cutoff : {0.0, 100.0}) {
        INFO(law << (asMesh ? ", mesh" : ", wall") << ", rates through " << cutoff << " Hz");
        const auto nativeLaw = renderer(law, *mechanism), law3d = renderer(law, *mechanism);
        VirtualDevice native(*mechanism, test::driverSetup());
        const Scene scene = nativeScene(asMesh);
        HapticTick tick(*mechanism, scene, ball(0.5e-3), *nativeLaw, 1e-3, test::driverSetup().start);
        Bench bench(*mechanism, *law3d, cutoff);
        cMesh box;
        test::makeBox(box);
        bench.tool.setRadius(0.5e-3);
        if (asMesh)
          bench.tool.addMesh(&box);
        else
          bench.tool.addObstacle(halfSpace("wall", Vec3::Zero(), Vec3::UnitZ()));
        REQUIRE(bench.tool.start());
        Measurement measurement;
        Command command;
        Vec3 last = Vec3::Zero(), rates = Vec3::Zero();
        double lastTime = 0.0;
        int different = 0, touching = 0;
        for (int i = 0; i < 3000; ++i) {
          REQUIRE(native.measure(measurement) == Status::ok);
          measurement.applied.reset();  // unknown to CHAI3D
          if (cutoff > 0.0) {           // the rates of lib/docs/own-device.md
            const Vec3 q = measurement.q;
            const double passed = measurement.time - lastTime;
            if (i > 0) rates += -std::expm1(-2.0 * M_PI * cutoff * passed) * ((q - last) / passed - rates);
            measurement.rates = rates;
            last = q;
            lastTime = measurement.time;
          }
          REQUIRE(tick(measurement, command) == Status::ok);
          REQUIRE(native.actuate(command) == Status::ok);
          REQUIRE(native.advance(test::pressingHand) == Status::ok);
          bench.tick();
          different += sameBits(command.effort, bench.tool.latest()->command.effort) &&
                               sameBits(command.effort, bench.driver->force)
                           ? 0
                           : 1;
          touching += tick.frame().output.normalForce > 0.1 ? 1 : 0;
        }
        CHECK(different == 0);
        CHECK(touching > 500);
        CHECK(sameBits(native.state().pose().position, bench.driver->physics.state().pose().position));
      }
    }
  }
}

TEST_CASE("a driver of CHAI3D in a loop gives the bits of the same device without it", "[chai3d]") {
  const auto mechanism = device("cartesian-3");
  class Plain final : public HapticDevice {
   public:
    explicit Plain(const Mechanism& m) : physics(m, test::driverSetup()) {}
    Status measure(Measurement& m) noexcept override {
      const Status status = physics.measure(m);
      m.applied.reset();
      return status;
    }
    Status actuate(const Command& command) noexcept override {
      const Status status = physics.actuate(command);
      return status != Status::ok ? status : physics.advance(test::pressingHand);
    }
    VirtualDevice physics;
  };
  for (const char* law : {"impedance", "position-control"}) {
    const auto lawA = renderer(law, *mechanism), lawB = renderer(law, *mechanism);
    const Scene scene = flatWall();
    Plain plain(*mechanism);
    const auto driver = std::make_shared<Driver>(*mechanism);
    Chai3dOptions options;
    options.cutoff = 0.0;
    options.clock = [&driver] { return driver->physics.time(); };
    Chai3dDevice wrapped(driver, *mechanism, options);
    HapticTick a(*mechanism, scene, Tool(), *lawA, 1e-3), b(*mechanism, scene, Tool(), *lawB, 1e-3);
    {
      LoopBody loopA(plain, a, {}), loopB(wrapped, b, {});
      int different = 0;
      double most = 0.0;
      for (int i = 0; i < 2000; ++i) {
        (void)loopA.step();
        (void)loopB.step();
        different += sameBits(loopA.tick().command.effort, loopB.tick().command.effort) ? 0 : 1;
        most = std::max(most, loopB.tick().command.effort.norm());
      }
      CHECK(different == 0);
      CHECK(most > 0.5);
    }
    CHECK(driver->closed == 1);
    CHECK(driver->force.isZero(0.0));  // motors off at the end
  }
}

TEST_CASE("six axes: what the device measures, and a command a native tick gives for it", "[chai3d]") {
  const auto mechanism = device("cartesian-6");
  for (const char* law : {"impedance", "position-control"}) {
    INFO(law);
    const auto nativeLaw = renderer(law, *mechanism), law3d = renderer(law, *mechanism);
    Tool rod;  // beside the TCP, so that the wall turns it
    rod.parts[0] = {Vec3(0.01, 0.0, 0.0), Vec3(0.02, 0.005, 0.0), 1e-3};
    Bench bench(*mechanism, *law3d);
    cMesh box;
    test::makeBox(box);
    bench.tool.setTool(rod);
    bench.tool.addMesh(&box);
    REQUIRE(bench.tool.start());
    const Scene scene = nativeScene(true);
    HapticTick tick(*mechanism, scene, rod, *nativeLaw, 1e-3, test::driverSetup().start);
    Command command;
    int different = 0;
    double worst = 0.0, worstWrench = 0.0, moment = 0.0;
    for (int i = 0; i < 2000; ++i) {
      bench.tick();
      const Measurement& m = bench.tool.latest()->measurement;
      (void)tick(m, command);
      different += sameBits(command.effort, bench.tool.latest()->command.effort) ? 0 : 1;
      worst = std::max(
          {worst, (m.q - bench.driver->measured.q).norm(), 1e-3 * (m.rates - bench.driver->measured.rates).norm()});
      Vec6 sent;
      sent << bench.driver->force, bench.driver->moment;
      worstWrench = std::max(worstWrench, (torqueOf(tick.frame().kinematics.jacobian, sent) - command.effort).norm());
      moment = std::max(moment, bench.driver->moment.norm());
      if (i == 0) continue;  // start() has already measured at this time
      Vec6 shown;
      shown << fromChai3d(bench.tool.getDeviceLocalLinVel()), fromChai3d(bench.tool.getDeviceLocalAngVel());
      worst = std::max(worst, 1e-3 * (shown - twistOf(tick.frame().kinematics.jacobian, m.rates)).norm());
      worst =
          std::max(worst, (fromChai3d(bench.tool.getDeviceLocalRot()) - tick.frame().kinematics.pose.rotation).norm());
    }
    CHECK(different == 0);
    CHECK(worst < 1e-14);        // from a rotation vector to a matrix and back
    CHECK(worstWrench < 1e-14);  // E^T (E^-T tau)
    CHECK(moment > 0.005);
  }
}

TEST_CASE("forces stay within the device's specifications, their direction kept", "[chai3d]") {
  const auto mechanism = device("cartesian-6");
  const auto driver = std::make_shared<Driver>(*mechanism);
  driver->m_specifications.m_maxLinearForce = 2.0;
  driver->m_specifications.m_maxAngularTorque = 0.1;
  driver->moves = false;
  Chai3dDevice wrapped(driver, *mechanism);
  wrapped.open();
  Measurement measurement;
  REQUIRE(wrapped.measure(measurement) == Status::ok);
  Command command{(Vec6() << 3.0, 4.0, 0.0, 0.0, 0.3, 0.0).finished()};
  CHECK(wrapped.actuate(command) == Status::ok);
  CHECK((driver->force - Vec3(1.2, 1.6, 0.0)).norm() < 1e-15);
  CHECK((driver->moment - Vec3(0.0, 0.1, 0.0)).norm() < 1e-15);
  command.effort << 0.3, 0.4, 0.0, 0.0, 0.05, 0.0;
  CHECK(wrapped.actuate(command) == Status::ok);
  CHECK(driver->force == Vec3(0.3, 0.4, 0.0));
  CHECK(driver->moment == Vec3(0.0, 0.05, 0.0));
  wrapped.close();
  driver->m_specifications.m_maxLinearForce = std::numeric_limits<double>::quiet_NaN();
  wrapped.open();
  CHECK(wrapped.actuate(command) == Status::ok);
  CHECK(driver->force.isZero(0.0));

  // In the tool, the guard limits the force first.
  const auto stylus = device("cartesian-3");
  ImpedanceRenderer stiff({2000.0, 0.0});
  Bench bench(*stylus, stiff);
  bench.driver->m_specifications.m_maxLinearForce = 0.4;
  bench.tool.addObstacle(halfSpace("wall", Vec3::Zero(), Vec3::UnitZ()));
  REQUIRE(bench.tool.start());
  int cut = 0;
  for (int i = 0; i < 500; ++i) {
    bench.tick();
    CHECK(bench.driver->force.norm() <= 0.4 * (1.0 + 1e-12));
    cut += bench.tool.latest()->reason == GuardReason::force ? 1 : 0;
  }
  CHECK(cut > 50);

  Tool rod;
  rod.parts[0] = {Vec3(0.01, 0.0, 0.0), Vec3(0.02, 0.005, 0.0), 1e-3};
  Bench turning(*mechanism, stiff);
  turning.driver->m_specifications.m_maxAngularTorque = 0.003;
  turning.tool.setTool(rod);
  turning.tool.addObstacle(halfSpace("wall", Vec3::Zero(), Vec3::UnitZ()));
  REQUIRE(turning.tool.start());
  cut = 0;
  for (int i = 0; i < 500; ++i) {
    turning.tick();
    CHECK(turning.driver->moment.norm() <= 0.003 * (1.0 + 1e-12));
    cut += turning.tool.latest()->reason == GuardReason::force ? 1 : 0;
  }
  CHECK(cut > 50);
}

TEST_CASE("what a device cannot do is a status, and leaves the measurement as it was", "[chai3d]") {
  const auto mechanism = device("cartesian-6");
  const auto driver = std::make_shared<Driver>(*mechanism);
  double now = 1.0;
  Chai3dOptions options;
  options.clock = [&now] { return now; };
  options.enableSwitch = 0;
  Chai3dDevice wrapped(driver, *mechanism, options);
  Measurement m;
  Command command{JointVector::Constant(6, 0.01)};
  CHECK(wrapped.measure(m) == Status::inactive);
  CHECK(wrapped.actuate(command) == Status::inactive);
  wrapped.open();
  m.applied = JointVector::Zero(6);
  REQUIRE(wrapped.measure(m) == Status::ok);
  CHECK(m.enabled);
  CHECK_FALSE(m.applied.has_value());
  CHECK(wrapped.measure(m) == Status::stale);  // the clock does not advance
  const JointVector q = m.q;
  driver->moves = false;
  const auto next = [&] {
    now += 1e-3;
    return wrapped.measure(m);
  };
  driver->lost = true;
  CHECK(next() == Status::stale);
  driver->lost = false;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    driver->offset.y() = bad;
    CHECK(next() == Status::notFinite);
    driver->offset.setZero();
    driver->stretch = bad;
    CHECK(next() == Status::notFinite);
    driver->stretch = 1.0;
  }
  driver->stretch = 1.01;
  CHECK(next() == Status::outOfRange);
  driver->stretch = 1.0;
  driver->offset.x() = 0.5;
  CHECK(next() == Status::unreachable);
  driver->offset.setZero();
  CHECK(m.q == q);
  CHECK(next() == Status::ok);
  driver->switches = 2;
  CHECK(next() == Status::ok);
  CHECK(!m.enabled);
  driver->switches = 1;
  driver->tellsSwitches = false;
  CHECK(next() == Status::ok);
  CHECK(!m.enabled);
  const double then = now;
  now = std::numeric_limits<double>::quiet_NaN();
  CHECK(wrapped.measure(m) == Status::notFinite);

  CHECK(wrapped.actuate(command) == Status::ok);
  CHECK(!driver->force.isZero(0.0));
  command.effort[2] = std::numeric_limits<double>::quiet_NaN();
  CHECK(wrapped.actuate(command) == Status::notFinite);
  CHECK(driver->force.isZero(0.0));
  command.effort = JointVector::Constant(3, 0.01);
  CHECK(wrapped.actuate(command) == Status::outOfRange);
  CHECK(driver->force.isZero(0.0));
  driver->refuses = true;
  CHECK(wrapped.actuate(command) == Status::stale);
  wrapped.close();
  wrapped.close();
  CHECK(driver->closed == 1);

  driver->offset.x() = 0.01;  // another position when it is opened again: this is not a motion
  now = then + 0.1;
  wrapped.open();
  REQUIRE(wrapped.measure(m) == Status::ok);
  CHECK(m.rates.isZero(0.0));
}

TEST_CASE("devices that do not fit are refused, with their names", "[chai3d]") {
  using test::ContainsSubstring;
  const auto three = device("cartesian-3"), six = device("cartesian-6"), tau = device("tau-nominal");
  const auto driver = std::make_shared<Driver>(*three);
  CHECK_THROWS_WITH(Chai3dDevice(nullptr, *three), ContainsSubstring("the haptic device is missing"));
  CHECK_THROWS_WITH(Chai3dDevice(driver, *six),
                    ContainsSubstring("driver") && ContainsSubstring("6 axes") && ContainsSubstring("Cartesian, 6"));
  if (tau->joints() != 6) CHECK_THROWS_WITH(Chai3dDevice(driver, *tau), ContainsSubstring("joints, must have 3 or 6"));
  Chai3dOptions options;
  options.cutoff = -1.0;
  CHECK_THROWS_WITH(Chai3dDevice(driver, *three, options), ContainsSubstring("-1") && ContainsSubstring("Hz"));
  options = {};
  options.enableSwitch = 32;
  CHECK_THROWS_WITH(Chai3dDevice(driver, *three, options), ContainsSubstring("32") && ContainsSubstring("-1 to 31"));
  Chai3dDevice wrapped(driver, *three);
  driver->opens = false;
  CHECK_THROWS_WITH(wrapped.open(), ContainsSubstring("driver") && ContainsSubstring("cannot be opened"));
  driver->opens = true;
  driver->calibrates = false;
  CHECK_THROWS_WITH(wrapped.open(), ContainsSubstring("cannot be calibrated"));
  CHECK(driver->closed == 1);
  CHECK(cartesianFor(driver->getSpecifications(), 0.1, 1e-5).halfWidths == Vec3::Constant(0.2));
}

TEST_CASE("meshes that are none, and a tool that cannot start, are refused", "[chai3d]") {
  using test::ContainsSubstring;
  const auto mechanism = device("cartesian-3");
  ImpedanceRenderer spring({1000.0, 0.0});
  Bench bench(*mechanism, spring);
  cMesh box, empty, astray, notANumber;
  test::makeBox(box);
  empty.m_name = "hollow";
  astray.m_name = "astray";
  for (int i = 0; i < 3; ++i) astray.newVertex(0.0, i, i * i);
  astray.newTriangle(0, 1, 3);
  notANumber.m_name = "nan";
  for (int i = 0; i < 3; ++i) notANumber.newVertex(0.0, std::nan(""), i);
  notANumber.newTriangle(0, 1, 2);
  Chai3dTool alone(&bench.world, *mechanism, spring, guardFor(*mechanism, 1e-3));
  CHECK_THROWS_WITH(alone.addMesh(&box), ContainsSubstring("setHapticDevice()"));
  CHECK(!alone.start());
  CHECK_THROWS_WITH(bench.tool.addMesh(static_cast<cMesh*>(nullptr)), ContainsSubstring("the mesh to add is missing"));
  CHECK_THROWS_WITH(bench.tool.addMesh(static_cast<chai3d::cMultiMesh*>(nullptr)),
                    ContainsSubstring("the mesh to add is missing"));
  CHECK_THROWS_WITH(bench.tool.addMesh(&empty), ContainsSubstring("hollow") && ContainsSubstring("triangle"));
  CHECK_THROWS_WITH(bench.tool.addMesh(&astray),
                    ContainsSubstring("astray") && ContainsSubstring("triangle 0") && ContainsSubstring("vertex 3"));
  CHECK_THROWS_WITH(bench.tool.addMesh(&notANumber), ContainsSubstring("nan") && ContainsSubstring("finite"));
  CHECK(bench.tool.addMesh(&box) == 0);
  REQUIRE(bench.tool.setWorkspaceScaleFactor(2.0));
  CHECK_THROWS_WITH(bench.tool.addMesh(&box), ContainsSubstring("scale is 2") && ContainsSubstring("was 1"));
  CHECK_THROWS_WITH(bench.tool.start(), ContainsSubstring("scale is 2"));
  CHECK(bench.driver->closed == 1);
  REQUIRE(bench.tool.setWorkspaceScaleFactor(1.0));

  bench.driver->opens = false;
  CHECK(!bench.tool.start());
  CHECK(bench.tool.latest() == nullptr);
  CHECK(bench.tool.status() == Status::inactive);
  bench.driver->opens = true;
  bench.driver->offset.x() = std::nan("");
  CHECK_THROWS_WITH(bench.tool.start(),
                    ContainsSubstring("first pose of \"driver\"") && ContainsSubstring(toString(Status::notFinite)));
  CHECK(bench.driver->closed == 2);
  bench.driver->offset.setZero();
  REQUIRE(bench.tool.start());
  bench.tick();
  CHECK(bench.tool.status() == Status::stale);  // start() has already measured at this time
  bench.tick();
  CHECK(bench.tool.status() == Status::ok);
  bench.driver->force = Vec3::Ones();
  bench.tool.stop();
  CHECK(bench.driver->closed == 3);
  CHECK(bench.driver->force.isZero(0.0));
}

TEST_CASE("a pose that is none ramps the force out; reset() goes on", "[chai3d]") {
  const auto mechanism = device("cartesian-3");
  PositionControlRenderer servo(positionControlFor(*mechanism, 1e-3, 0, 0));
  Bench bench(*mechanism, servo);
  bench.tool.addObstacle(halfSpace("wall", Vec3::Zero(), Vec3::UnitZ()));
  REQUIRE(bench.tool.start());
  REQUIRE(bench.press(0.5));
  bench.driver->offset.x() = std::nan("");
  double largest = 0.0;
  for (int i = 0; i < 100; ++i) {
    bench.tick();
    CHECK(bench.driver->force.allFinite());
    largest = std::max(largest, bench.driver->force.norm());
  }
  CHECK(bench.tool.status() == Status::notFinite);
  CHECK(bench.tool.latest()->reason == GuardReason::device);
  CHECK(bench.driver->force.isZero(0.0));
  CHECK(largest < 3.0);
  bench.driver->offset.setZero();
  for (int i = 0; i < 10; ++i) bench.tick();
  CHECK(bench.driver->force.isZero(0.0));  // until reset()
  bench.tool.reset();
  double again = 0.0;
  for (int i = 0; i < 2000; ++i) {
    bench.tick();
    again = std::max(again, bench.driver->force.z());
  }
  CHECK(again > 0.5);
}

TEST_CASE("a clock that tells no time ramps the force out too", "[chai3d]") {
  const auto mechanism = device("cartesian-3");
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    INFO(bad);
    PositionControlRenderer servo(positionControlFor(*mechanism, 1e-3, 0, 0));
    Bench bench(*mechanism, servo);
    bench.tool.addObstacle(halfSpace("wall", Vec3::Zero(), Vec3::UnitZ()));
    REQUIRE(bench.tool.start());
    REQUIRE(bench.press(0.5));
    bench.later = bad;
    for (int i = 0; i < 100; ++i) bench.tick();
    CHECK(bench.tool.status() == Status::notFinite);
    CHECK(bench.driver->force.isZero(0.0));
    bench.later = 0.0;
    bench.tool.reset();
    CHECK(bench.press(0.5));
  }
}

TEST_CASE("switch and setForcesOFF() take the force away, and it ramps in again", "[chai3d]") {
  const auto mechanism = device("cartesian-3");
  ImpedanceRenderer spring({1000.0, 1.0});
  Bench bench(*mechanism, spring);
  bench.tool.addObstacle(halfSpace("wall", Vec3::Zero(), Vec3::UnitZ()));
  REQUIRE(bench.tool.start());
  REQUIRE(bench.press(0.5));
  CHECK(bench.tool.getUserSwitches() == 1);
  REQUIRE(bench.tool.setForcesOFF());
  for (int i = 0; i < 30; ++i) bench.tick();
  CHECK(bench.driver->force.isZero(0.0));
  CHECK(bench.tool.latest()->reason == GuardReason::disabled);
  REQUIRE(bench.tool.setForcesON());
  bench.tick();
  CHECK(bench.driver->force.norm() < 0.1);
}

TEST_CASE("the scale of the world is none of the wall", "[chai3d]") {
  const auto mechanism = device("cartesian-3");
  constexpr double kScale = 12.5;
  std::vector<Vec3> forces[2];
  for (int scaled = 0; scaled < 2; ++scaled) {
    const double scale = scaled == 0 ? 1.0 : kScale;
    PositionControlRenderer servo(positionControlFor(*mechanism, 1e-3, 0, 0));
    Bench bench(*mechanism, servo);
    REQUIRE(bench.tool.setWorkspaceScaleFactor(scale));
    cMesh box;
    test::makeBox(box, scale);
    box.setLocalPos(0.001 * scale, 0.0, 0.0);
    bench.tool.setRadius(0.5e-3 * scale);
    bench.tool.addMesh(&box);
    REQUIRE(bench.tool.start());
    for (int i = 0; i < 300; ++i) {
      bench.tick();
      forces[scaled].push_back(bench.driver->force);
    }
    const Vec3 shown = fromChai3d(bench.tool.getDeviceLocalPos()), is = bench.driver->measured.q;
    CHECK((shown - scale * is).norm() < 1e-15);
    REQUIRE(bench.tool.setWorkspaceScaleFactor(2.0 * scale));  // too late: no measurement fits this scale
    for (int i = 0; i < 50; ++i) bench.tick();
    CHECK(bench.tool.status() == Status::outOfRange);
    CHECK(bench.driver->force.isZero(0.0));
  }
  double most = 0.0, off = 0.0;
  for (std::size_t i = 0; i < forces[0].size(); ++i) {
    most = std::max(most, forces[0][i].norm());
    off = std::max(off, (forces[0][i] - forces[1][i]).norm());
  }
  CHECK(most > 0.5);
  CHECK(off < 1e-6);  // rounding of 1e-18 m, times a stiff wall
}

TEST_CASE("a multi-mesh is one obstacle, its parts where they are; removed triangles are gone", "[chai3d]") {
  const auto mechanism = device("cartesian-3");
  ImpedanceRenderer spring({1000.0, 0.0});
  Bench bench(*mechanism, spring);
  chai3d::cMultiMesh two;
  const Vec3 turn(0.0, 0.4, 0.0), shift(0.01, 0.0, -0.005);
  for (int i = 0; i < 2; ++i) test::makeBox(*two.newMesh());
  two.getMesh(1)->setLocalPos(toChai3d(shift));
  two.getMesh(1)->setLocalRot(turned(turn));
  two.getMesh(0)->newTriangle(0, 1, 2);
  two.getMesh(0)->removeTriangle(12);
  Material rough;
  rough.friction = 0.3;
  REQUIRE(bench.tool.setWorkspaceScaleFactor(2.0));
  CHECK(bench.tool.addMesh(&two, rough, 0.004) == 0);
  REQUIRE(bench.tool.start());
  const Obstacle& obstacle = bench.tool.scene().obstacles()[0];
  CHECK(obstacle.material.friction == 0.3);
  CHECK(obstacle.thickness == 0.002);
  const TriangleMesh& mesh = std::get<std::shared_ptr<const MeshModel>>(obstacle.shape)->mesh();
  const TriangleMesh one = boxInW();
  REQUIRE(mesh.vertices.size() == 16);
  REQUIRE(mesh.triangles.size() == 24);
  for (std::size_t i = 0; i < 8; ++i) {
    CHECK(2.0 * mesh.vertices[i] == one.vertices[i]);
    CHECK((2.0 * mesh.vertices[8 + i] - (shift + rotationFromVector(turn) * one.vertices[i])).norm() < 1e-16);
  }
  for (std::size_t i = 0; i < 12; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(mesh.triangles[i][k] == one.triangles[i][k]);
      CHECK(mesh.triangles[12 + i][k] == one.triangles[i][k] + 8);
    }
}

TEST_CASE("obstacles follow their objects, as the tool sees them", "[chai3d]") {
  const auto mechanism = device("cartesian-3");
  ImpedanceRenderer spring({1000.0, 0.0});
  Bench bench(*mechanism, spring);
  chai3d::cGenericObject camera;  // it carries the tool
  camera.addChild(&bench.tool);
  cMesh box;
  test::makeBox(box);
  box.setLocalPos(toChai3d(Vec3(0.0, 0.0, -0.01)));
  bench.tool.addMesh(&box);
  REQUIRE(bench.tool.start());
  bench.tick();
  const Obstacle& obstacle = bench.tool.scene().obstacles()[0];
  CHECK(obstacle.pose.position == Vec3(0.0, 0.0, -0.01));

  // The object approaches at 0.02 m/s and turns at 0.1 rad/s.
  for (int i = 1; i <= 10; ++i) {
    box.setLocalPos(toChai3d(Vec3(0.0, 0.0, -0.01 + 2e-5 * i)));
    box.setLocalRot(turned(Vec3(0.0, 0.0, 1e-4 * i)));
    box.computeGlobalPositionsFromRoot();
    bench.tick();
  }
  CHECK((obstacle.pose.position - Vec3(0.0, 0.0, -0.0098)).norm() < 1e-16);
  const Obstacle& seen = bench.tool.haptics()->scene().scene().obstacles()[0];
  CHECK((seen.twist - (Vec6() << 0.0, 0.0, 0.02, 0.0, 0.0, 0.1).finished()).norm() < 1e-10);
  bench.tick();
  CHECK(seen.twist.isZero(0.0));

  // The camera turns: the world turns in the opposite direction.
  const Vec3 turn(0.0, 0.02, 0.0), way(0.003, 0.0, 0.001);
  camera.setLocalPos(toChai3d(way));
  camera.setLocalRot(turned(turn));
  bench.tool.computeGlobalPositionsFromRoot();
  for (int i = 0; i < 3; ++i) bench.tick();
  const Mat3 back = rotationFromVector(turn).transpose();
  CHECK((obstacle.pose.position - back * (Vec3(0.0, 0.0, -0.0098) - way)).norm() < 1e-16);
  CHECK((obstacle.pose.rotation - back * rotationFromVector(Vec3(0.0, 0.0, 1e-3))).norm() < 1e-15);
  CHECK((fromChai3d(bench.tool.getDeviceGlobalPos()) -
         (way + rotationFromVector(turn) * fromChai3d(bench.tool.getDeviceLocalPos())))
            .norm() < 1e-16);

  cMatrix3d none = turned(Vec3::Zero());
  none(0, 0) = 2.0;
  box.setLocalRot(none);
  box.computeGlobalPositionsFromRoot();
  bench.tick();
  CHECK(bench.tool.status() == Status::outOfRange);
  camera.removeChild(&bench.tool);
}

TEST_CASE("a mesh of the world is felt where it is seen, and the tool says so", "[chai3d]") {
  const auto mechanism = device("cartesian-3");
  ImpedanceRenderer spring({1000.0, 1.0});
  Bench bench(*mechanism, spring);
  cMesh box, far;
  test::makeBox(box);
  test::makeBox(far);
  far.setLocalPos(-0.5, 0.0, 0.0);
  bench.tool.addMesh(&far);
  REQUIRE(bench.tool.start());
  bench.tick();
  CHECK(bench.tool.addMesh(&box) == 1);  // also after start(): the ticks start again
  CHECK(bench.tool.latest()->number == 0);
  do bench.tick();
  while (bench.driver->measured.q[2] > 0.8e-3);
  CHECK(bench.tool.haptics()->frame().contacts.count > 0);
  CHECK(!bench.tool.isInContact(&box));  // only within its margin
  REQUIRE(bench.press(0.2));
  CHECK(bench.tool.isInContact(&box));
  CHECK(!bench.tool.isInContact(&far));
  CHECK(bench.tool.getDeviceGlobalForce()(0) > 0.19);  // towards the user
  CHECK(std::abs(bench.tool.getDeviceGlobalForce()(2)) < 1e-12);
  CHECK(bench.tool.getDeviceGlobalPos()(0) < 0.0);
  bench.driver->hold = rotationFromVector(Vec3(0.2, 0.1, 0.0));  // a sensed rotation is shown, with three axes too
  bench.tick();
  CHECK(fromChai3d(bench.tool.getDeviceLocalRot()) == bench.driver->hold);
  CHECK(bench.tool.status() == Status::ok);
}

TEST_CASE("a tick a period, however often the thread asks", "[chai3d]") {
  const auto mechanism = device("cartesian-3");
  ImpedanceRenderer spring({1000.0, 1.0});
  Bench bench(*mechanism, spring);
  bench.driver->moves = false;
  bench.tool.addObstacle(halfSpace("wall", Vec3::Zero(), Vec3::UnitZ()));
  REQUIRE(bench.tool.start());
  for (int i = 0; i < 4000; ++i) {  // at 4 kHz
    bench.later += 0.25e-3;
    bench.tick();
  }
  CHECK(std::abs(static_cast<double>(bench.tool.latest()->number) - 1000.0) <= 1.0);
  const auto before = bench.tool.latest()->number;
  for (int i = 0; i < 1000; ++i) {  // at 1 kHz, with calls late by up to 0.4 ms
    bench.later += i % 2 == 0 ? 1.4e-3 : 0.6e-3;
    bench.tick();
  }
  CHECK(bench.tool.latest()->number - before == 1000);
  CHECK(bench.tool.latest()->reason == GuardReason::none);
  for (int i = 0; i < 100; ++i) {  // at 500 Hz: too slow for the renderer
    bench.later += 2e-3;
    bench.tick();
  }
  CHECK(bench.tool.latest()->reason == GuardReason::deadlines);
  bench.tool.stop();
  bench.later = 0.0;  // a clock that restarts with the device
  REQUIRE(bench.tool.start());
  for (int i = 0; i < 10; ++i) {
    bench.later += 1e-3;
    bench.tick();
  }
  CHECK(bench.tool.latest()->number == 10);
}

TEST_CASE("the page shows lines of the example, which is below 80", "[chai3d]") {
  const auto linesOf = [](const std::string& file) {
    std::ifstream stream(std::string(ENAMEL_SOURCE_DIR) + "/plugins/chai3d/" + file);
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);) lines.push_back(line.erase(0, line.find_first_not_of(' ')));
    return lines;
  };
  const std::vector<std::string> example = linesOf("example.cpp"), page = linesOf("README.md");
  CHECK(example.size() < 80);
  const std::set<std::string> known(example.begin(), example.end());
  auto line = std::find(page.begin(), page.end(), "```cpp");
  int shown = 0;
  for (++line; line != page.end() && *line != "```"; ++line) {
    if (line->rfind("//", 0) == 0) continue;
    INFO(*line);
    CHECK(known.count(*line) == 1);
    ++shown;
  }
  CHECK(shown > 8);
}

}  // namespace enamel::test_adapter
