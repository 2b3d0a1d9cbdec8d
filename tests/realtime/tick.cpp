// A whole tick (forward kinematics, contact, renderer) never allocates: valid input, invalid input, faults and resets.
#include "enamel/render/tick.hpp"

#include "enamel/render/passivity.hpp"
#include "enamel/render/virtual_coupling.hpp"
#include "enamel/runtime/recorder.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "support/allocation_counter.hpp"
#include "support/catch.hpp"
#include "support/pushes.hpp"

namespace enamel::test_tick {

TEST_CASE("a tick of every renderer allocates nothing, with inertia or without", "[realtime]") {
  // Requires the inertia and reads it.
  class Heavy final : public Renderer {
   public:
    bool needsInertia() const noexcept override { return true; }

   private:
    void prepare(double) override {}
    Status render(const TickFrame& input, TickOutput& output) noexcept override {
      output.torque = input.kinematics.gravity + 1e-3 * input.kinematics.inertia.diagonal();
      output.mode = input.contacts.count > 0 ? RenderMode::contact : RenderMode::free;
      return Status::ok;
    }
    void resetState() noexcept override {}
    StateBlock stateBlock() noexcept override { return {nullptr, 0}; }
  };
  const TauMechanism device(test::nominal());
  const Scene wall = flatWall();
  Scene movable;  // on springs, with a layer that breaks; the tool touches it twice
  Suspension suspension;
  suspension.inertia.fill(2e-3);
  suspension.stiffness.fill(5e4);
  Obstacle block = wall.obstacles()[0];
  block.suspension = std::make_shared<const Suspension>(suspension);
  block.material.stiffness = 5e4;
  block.material.exponent = 1.5;
  block.material.thickness = 1e-3;
  block.material.hysteresis = 1.0;
  block.material.puncture = 2.0;
  block.material.roughness = 5e-6;
  block.material.wavelength = 3e-4;
  movable.add(block);
  Tool lying;
  lying.parts[0] = {{-2e-3, 0.0, 0.0}, {2e-3, 0.0, 0.0}, 0.0};
  HoldRenderer hold = test::holdRenderer();
  ImpedanceRenderer spring({6000.0, 0.0});
  PassivityRenderer passive(std::make_unique<ImpedanceRenderer>(ImpedanceOptions{6000.0, 0.0}));
  PassivityRenderer remembering(std::make_unique<ImpedanceRenderer>(ImpedanceOptions{6000.0, 0.0}),
                                PassivityBound::memory);
  PositionControlRenderer servo = test::positionControl(device, 0, 3);
  VirtualCouplingRenderer coupling({3000.0, 2.0, 0.02});
  HoldOptions late;
  late.commandGain = Eigen::MatrixXd::Constant(6, 12, 1e-3);
  HoldRenderer foreseeing = test::holdRenderer(late);
  Heavy heavy;
  for (Renderer* renderer :
       {static_cast<Renderer*>(&hold), static_cast<Renderer*>(&servo), static_cast<Renderer*>(&spring),
        static_cast<Renderer*>(&passive), static_cast<Renderer*>(&remembering), static_cast<Renderer*>(&coupling),
        static_cast<Renderer*>(&foreseeing), static_cast<Renderer*>(&heavy)}) {
    const bool atMovable = renderer == &servo || renderer == &spring;
    HapticTick tick(device, atMovable ? movable : wall, atMovable ? lying : Tool(), *renderer, 1e-3);
    Encoders encoders({true, RateSource::lowPass, 100.0}, device.limits().encoderStep, 1e-3);
    const RandomStream stream(1, 0);
    Motors motors({0, 3}, JointVector::Zero(6));
    std::vector<unsigned char> state(renderer->stateSize());
    Measurement m;
    Command command;
    Kinematics k;
    int ok = 0, contact = 0;
    double sum = 0.0;
    const long before = test::allocationCount();
    for (std::uint64_t i = 0; i < 5000; ++i) {
      Pose pose;
      pose.position.z() = 2e-4 * std::sin(0.01 * static_cast<double>(i));
      if (device.reach(pose, Vec6::Zero(), false, k) != Status::ok) continue;
      m.time = 1e-3 * static_cast<double>(i);
      encoders.measure(k.q, k.rates, m);
      if (i % 100 == 7) m.q[2] = std::nan("");
      if (i % 100 == 9) m.q[2] += 2.0;
      if (i % 100 == 11) m.q.conservativeResize(4);
      const Status status = tick(m, command);
      if (status != Status::ok) tick.reset();
      ok += status == Status::ok;
      contact += tick.frame().output.mode == RenderMode::contact;
      sum += motors.actuate(i, command.effort, stream)[0] + stream.normal(RandomStream::Purpose::noise, i);
      renderer->saveState(state.data());
      renderer->loadState(state.data());
      if (i % 1000 == 999) renderer->reset();
    }
    const long allocated = test::allocationCount() - before;
    CHECK(allocated == 0);
    CHECK(ok > 4000);
    CHECK(contact > 1000);
    CHECK(std::isfinite(sum));
  }
}

TEST_CASE("taps with transients allocate nothing", "[tick]") {
  const TauMechanism device(test::nominal());
  Obstacle enamel = halfSpace("enamel", Vec3::Zero(), Vec3::UnitZ());
  enamel.tap = tapOf("enamel");
  Scene scene;
  scene.add(enamel);
  ImpedanceRenderer spring({6000.0, 0.0});
  PositionControlRenderer servo = test::positionControl(device, 0, 0);
  for (Renderer* renderer : {static_cast<Renderer*>(&servo), static_cast<Renderer*>(&spring)}) {
    HapticTick tick(device, scene, Tool(), *renderer, 1e-3);
    std::vector<double> state(tick.stateSize() / sizeof(double) + 1);
    Measurement m;
    Command command;
    Kinematics k;
    int vibrates = 0;
    const long before = test::allocationCount();
    for (int i = 0; i < 2000; ++i) {
      Pose pose;
      Vec6 twist = Vec6::Zero();
      pose.position.z() = 2e-4 + 4e-4 * std::sin(0.25 * i);
      twist[2] = 0.1 * std::cos(0.25 * i);
      if (device.reach(pose, twist, false, k) != Status::ok) continue;
      m.time = 1e-3 * i;
      m.q = k.q;
      m.rates = k.rates;
      if (tick(m, command) != Status::ok) tick.reset();
      vibrates += tick.tap().force() != 0.0;
      tick.saveState(state.data());
      tick.loadState(state.data());
    }
    CHECK(test::allocationCount() == before);
    CHECK(vibrates > 500);
  }
}

TEST_CASE("guides allocate nothing, also when a scene with others comes", "[tick]") {
  const TauMechanism device(test::nominal());
  Scene scene = flatWall(), other = scene;
  const Guide line{Polyline{{{-0.01, 0.0, 0.0}, {0.01, 0.0, 0.0}, {0.01, 0.01, 0.0}}}, {}, 200.0, 1.0},
      plane{Plane{}, {}, 200.0, 1.0}, wall{HalfSpace{}, {}, 200.0, 1.0}, box{Box{{1e-5, 1e-5, 1e-5}}, {}, 200.0, 1.0};
  scene.setGuides({line, plane, wall, box});
  other.setGuides({box});
  ImpedanceRenderer spring({6000.0, 0.0});
  HapticTick tick(device, scene, Tool(), spring, 1e-3);
  TickScene next(other, Tool());
  std::vector<double> state(tick.stateSize() / sizeof(double) + 1);
  Measurement m;
  Command command;
  Kinematics k;
  int pulls = 0;
  const long before = test::allocationCount();
  for (int i = 0; i < 2000; ++i) {
    Pose pose;
    pose.position = {0.0, 1e-3 * std::sin(0.01 * i), 1e-3 * std::cos(0.01 * i)};
    if (device.reach(pose, Vec6::Zero(), false, k) != Status::ok) continue;
    m.time = 1e-3 * i;
    m.q = k.q;
    m.rates = k.rates;
    if (tick(m, command) != Status::ok) tick.reset();
    pulls += wrenchOf(k, command.effort - k.gravity).head<3>().norm() > 0.01;
    tick.saveState(state.data());
    tick.loadState(state.data());
    if (i % 500 == 499) tick.exchange(next);
  }
  CHECK(test::allocationCount() == before);
  CHECK(pulls > 1000);
}

TEST_CASE("a loop on the virtual device allocates nothing", "[realtime]") {
  const TauMechanism device(test::nominal());
  HoldRenderer hold = test::holdRenderer();
  PositionControlRenderer servo = test::positionControl(device, 0, 3);
  LoopSetup setup;
  Obstacle rough = flatWall().obstacles()[0];
  rough.material = {1e5, 0.5, 0.4, 1.0};
  setup.scene = Scene();
  setup.scene.add(rough);
  setup.delay = {0, 3};
  setup.encoders = {true, RateSource::lowPass, 100.0};
  for (Renderer* renderer : {static_cast<Renderer*>(&hold), static_cast<Renderer*>(&servo)}) {
    VirtualLoop loop(device, *renderer, setup);
    TickRecord record;
    const auto push = [](double, const Pose& pose, const Vec6& twist) {
      Vec6 wrench = -0.05 * twist;  // the guard stops hold under this delay, and then the hand keeps the tool
      wrench.head<3>() += Vec3(0.0, 0.0, -5.0) - 1000.0 * pose.position - 5.0 * twist.head<3>();
      return wrench;
    };
    const long before = test::allocationCount();
    int ok = 0;
    for (int i = 0; i < 1000; ++i) ok += loop.tick(push, record) == Status::ok;
    CHECK(test::allocationCount() == before);
    CHECK(ok == 1000);
  }
}

TEST_CASE("recording a tick allocates nothing, also while ticks are lost", "[realtime]") {
  const TauMechanism device(test::nominal());
  const Scene wall = flatWall();
  PositionControlRenderer servo = test::positionControl(device);
  HapticTick tick(device, wall, Tool(), servo, 1e-3);
  Recorder recorder([written = 0](const char*, std::size_t size) mutable { return ++written < 20 ? size : 0; },
                    "a disk", {}, tick);
  std::vector<char> state(tick.stateSize());
  Measurement m;
  Command command;
  Kinematics k;
  const long before = test::allocationCount();
  for (std::uint64_t i = 0; i < 12000; ++i) {
    Pose pose;
    pose.position.z() = 2e-4 * std::sin(0.01 * static_cast<double>(i));
    if (device.reach(pose, Vec6::Zero(), false, k) != Status::ok) continue;
    m.time = 1e-3 * static_cast<double>(i);
    m.q = k.q;
    m.rates = k.rates;
    const Status status = tick(m, command);
    recorder.add(i, m, tick, command, status);
    if (i % 100 != 0) continue;
    tick.saveState(state.data());
    tick.loadState(state.data());
  }
  CHECK(test::allocationCount() == before);
  CHECK(recorder.lost() > 0);
  const RecordingResult result = recorder.close();
  CHECK(result.ticks > 0);
  CHECK(result.ticks + result.lost == 12000);
}

}  // namespace enamel::test_tick
