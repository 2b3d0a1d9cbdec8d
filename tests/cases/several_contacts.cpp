// A tool with several contacts at once: which are reported, and how steadily.
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enamel/collision/contacts.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/render/tick.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test_several_contacts {

namespace {

// Return a block whose upper face is a straight groove along x. Both sides rise by `slope` (rad) from the x axis.
TriangleMesh grooveMesh(double slope) {
  constexpr double kHalfLength = 8e-3, kHalfWidth = 3e-3, kBottom = -1e-3;  // m
  const double rim = kHalfWidth * std::tan(slope);
  TriangleMesh mesh;
  for (const double x : {-kHalfLength, kHalfLength})
    for (const auto& [y, z] : {std::pair(0.0, 0.0), std::pair(-kHalfWidth, rim), std::pair(-kHalfWidth, kBottom),
                               std::pair(kHalfWidth, kBottom), std::pair(kHalfWidth, rim)})
      mesh.vertices.emplace_back(x, y, z);
  for (int i = 0; i < 5; ++i) {  // the sides, from one end to the other
    const int next = (i + 1) % 5;
    mesh.triangles.push_back({i, next, next + 5});
    mesh.triangles.push_back({i, next + 5, i + 5});
  }
  for (int i = 1; i < 4; ++i) {  // the ends, as fans around the bottom of the groove
    mesh.triangles.push_back({0, i + 1, i});
    mesh.triangles.push_back({5, i + 5, i + 6});
  }
  return mesh;
}

struct GrooveRun {
  int ticksInContact = 0;
  int changes = 0;  // of the number of contacts
  bool finished = false;
};

// Let a ball of 1 mm slide in the groove under 3 N, at 10 mm/s for 1 s.
GrooveRun slideAlong(Obstacle groove) {
  const auto mechanism = makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml")));
  PositionControlRenderer controller(positionControlFor(*mechanism, 1e-3, 0, 0));
  LoopSetup setup;
  setup.scene = Scene();
  setup.scene.add(std::move(groove));
  setup.tool.parts[0].a = setup.tool.parts[0].b = Vec3(0.0, 0.0, 1e-3);
  setup.tool.parts[0].radius = 1e-3;
  setup.start.position = {-5e-3, 0.0, 3e-4};
  setup.encoders = {true, RateSource::lowPass};
  VirtualLoop loop(*mechanism, controller, setup);
  TickRecord record;
  GrooveRun slide;
  int before = 0;
  for (int i = 0; i < 1300; ++i) {
    Pose guide = setup.start;
    guide.position.x() += 1e-5 * std::max(0, i - 300);
    const auto hand = [&](double, const Pose& pose, const Vec6& twist) {
      Vec6 wrench = guidingWrench(pose, twist, guide, Vec3::UnitZ());
      wrench.z() -= 3.0 + 3.0 * twist.z();
      return wrench;
    };
    if (loop.tick(hand, record) != Status::ok) return slide;
    const int contacts = loop.frame().contacts.count;
    if (i > 300) {
      slide.ticksInContact += contacts > 0;
      slide.changes += contacts != before;
    }
    before = contacts;
  }
  slide.finished = true;
  return slide;
}

constexpr double kSlope = 14.5 * M_PI / 180.0;

std::shared_ptr<const MeshModel> grooveModel() { return std::make_shared<const MeshModel>(grooveMesh(kSlope)); }

GrooveRun slideAlongMesh() { return slideAlong({"groove", grooveModel(), Pose{}, Vec6::Zero(), {}}); }

GrooveRun slideAlongSolid() {
  const auto solid = std::make_shared<const Solid>(
      *grooveModel(), std::vector<SolidLayer>{{"enamel", {}, 3e9, 0.0, nullptr}}, SolidOptions{1e-4, 16});
  return slideAlong({"groove", solid, Pose{}, Vec6::Zero(), {}});
}

constexpr int kPins = 12;

// A bar along a row of twelve pins.
struct BarOnPins {
  Scene scene;
  Tool bar;
  BarOnPins() {
    for (int i = 0; i < kPins; ++i) {
      Obstacle pin{"pin " + std::to_string(i), Sphere{1e-3}, Pose{}, Vec6::Zero(), {}};
      pin.pose.position = Vec3(2e-3 * (i - 0.5 * (kPins - 1)), 0.0, -1.5e-3);
      scene.add(std::move(pin));
    }
    bar.parts[0] = {Vec3(-0.012, 0.0, 0.0), Vec3(0.012, 0.0, 0.0), 0.5e-3};
  }
};

Status contactsOfBar(ContactSnapshot& contacts) {
  const BarOnPins setup;
  Pose pose;
  pose.position.z() = -1e-6;
  return findContacts(setup.scene, setup.bar, pose, 1e-3, nullptr, contacts);
}

struct Tilting {
  double force = 0.0, moment = 0.0;  // mean along z and largest about y, N, N m
  double jump = 0.0;                 // largest change of the moment in a tick, N m
  int faults = 0;                    // ticks with a status other than ok
};

// Lower the bar 5 um into the pins, then tilt it by 0.4 urad to each side: its ends move by 5 nm.
Tilting tiltOnPins() {
  const auto mechanism = makeMechanism(loadDevice(test::deviceFile("cartesian-6.toml")));
  const BarOnPins setup;
  PositionControlRenderer controller(positionControlFor(*mechanism, 1e-3, 0, 0));
  Pose start;
  start.position.z() = 5e-4;
  HapticTick tick(*mechanism, setup.scene, setup.bar, controller, 1e-3, start);
  Measurement sample;
  sample.q = sample.rates = JointVector::Zero(6);
  Command command;
  Tilting result;
  double before = 0.0;
  for (int i = 0; i < 400; ++i) {
    sample.time = 1e-3 * (i + 1);
    sample.q[2] = std::max(5e-4 - 2e-6 * i, -5e-6);
    sample.q[4] = i < 300 ? 0.0 : (i / 20) % 2 == 0 ? -4e-7 : 4e-7;
    result.faults += tick(sample, command) != Status::ok;
    if (i >= 300) {
      result.force += command.effort[2] / 100.0;
      result.moment = std::max(result.moment, std::abs(command.effort[4]));
      result.jump = std::max(result.jump, std::abs(command.effort[4] - before));
    }
    before = command.effort[4];
  }
  return result;
}

}  // namespace

TEST_CASE("case 11: in a groove of a mesh the number of contacts is steady", "[cases]") {
  const GrooveRun slide = slideAlongMesh();
  CHECK(slide.finished);
  CHECK(slide.ticksInContact == 999);
  CHECK(slide.changes <= 10);
}

TEST_CASE("case 11: in a groove of a solid the number of contacts is steady", "[cases]") {
  const GrooveRun slide = slideAlongSolid();
  CHECK(slide.finished);
  CHECK(slide.ticksInContact == 999);
  CHECK(slide.changes <= 10);
}

TEST_CASE("case 12: a bar on twelve pins touches at least eight of them and is pushed out", "[cases]") {
  ContactSnapshot contacts;
  (void)contactsOfBar(contacts);
  CHECK(contacts.count >= 8);
  const Tilting tilting = tiltOnPins();
  CHECK(tilting.faults == 0);
  CHECK(tilting.force > 0.1);
}

TEST_CASE("case 12: a bar on twelve pins has all contacts, or the number of missing ones is reported", "[cases]") {
  ContactSnapshot contacts;
  CHECK(contactsOfBar(contacts) == Status::ok);
  CHECK(contacts.count + contacts.omitted == kPins + 2);  // the ends of the bar are near the outer pins, too
}

TEST_CASE("case 12: a tilt of a bar on twelve pins by 0.8 urad changes the moment by less than 5 mN m", "[cases]") {
  const Tilting tilting = tiltOnPins();
  CAPTURE(tilting.jump, tilting.moment, tilting.force);
  CHECK(tilting.jump < 5e-3);
}

}  // namespace enamel::test_several_contacts
