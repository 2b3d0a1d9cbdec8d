// A haptic tick between an arbitrary driver and host: measurements, poses and velocities of obstacles, states, cuts and
// resets in any order.
#include "enamel/render/tick.hpp"

#include <array>
#include <memory>

#include "enamel/collision/mesh_file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "support/meshes.hpp"
#include "surfaces.hpp"

namespace enamel::attack {

namespace {

constexpr double kPeriod = 1e-3;

// Everything that a tick needs, made once; restart() and restore() reset it.
struct Setup {
  explicit Setup(std::unique_ptr<Renderer> madeRenderer, std::shared_ptr<const Mechanism> madeDevice)
      : device(std::move(madeDevice)), renderer(std::move(madeRenderer)) {
    scene = flatWall();
    SolidOptions options;
    options.cell = 5e-4;
    solid =
        std::make_shared<Solid>(MeshModel(test::boxMesh(Vec3::Constant(4e-3))), std::vector<SolidLayer>{{}}, options);
    scene.add({"solid", solid, {Vec3(0.0, 0.0, 4e-3), Mat3::Identity()}, Vec6::Zero(), {}});
    tool.parts[0].radius = 1e-3;
    drill = std::make_unique<Drill>(tool, std::vector<std::shared_ptr<Solid>>{nullptr, solid});
    start.position = {0.0, 0.0, 10e-3};
    tick = std::make_unique<HapticTick>(*device, scene, tool, *renderer, guardFor(*device, kPeriod), start);
    first.resize(tick->stateSize() / sizeof(double) + 1);
    tick->saveState(first.data());
  }

  std::shared_ptr<const Mechanism> device;
  std::unique_ptr<Renderer> renderer;
  Scene scene;
  std::shared_ptr<Solid> solid;
  Tool tool;
  std::unique_ptr<Drill> drill;
  Pose start;
  std::unique_ptr<HapticTick> tick;
  std::vector<double> first;
};

// Return springs and position control, on a device with three axes, and on one that senses six and drives three.
Setup& setupOf(int number) {
  const auto setups = [](const char* file) {
    const std::shared_ptr<const Mechanism> device = makeMechanism(idealOf(loadDevice(test::deviceFile(file))));
    std::array<std::unique_ptr<Setup>, 2> made;
    made[0] = std::make_unique<Setup>(std::make_unique<ImpedanceRenderer>(ImpedanceOptions{3000.0, 2.0}), device);
    made[1] = std::make_unique<Setup>(
        std::make_unique<PositionControlRenderer>(positionControlFor(*device, kPeriod, 0, 0)), device);
    return made;
  };
  static const auto axes = setups("cartesian-3.toml"), stylus = setups("stylus.toml");
  return *(number < 2 ? axes : stylus)[static_cast<std::size_t>(number % 2)];
}

class Session {
 public:
  explicit Session(Setup& setup) : setup_(setup), tick_(*setup.tick), joints_(setup.device->joints()) {
    for (int i = 0; i < 2; ++i) (void)setup_.scene.move(i, {Vec3(0.0, 0.0, 4e-3 * i), Mat3::Identity()}, Vec6::Zero());
    setup_.solid->restore();
    tick_.attach(nullptr);
    tick_.restart(setup_.start);
    m_.q = JointVector::Zero(joints_);
    m_.q[2] = setup_.start.position.z();
    m_.rates = JointVector::Zero(joints_);
    last_ = JointVector::Zero(joints_);
  }

  void act(Numbers& numbers) {
    switch (numbers.pick(10)) {
      case 0: spoil(numbers); break;
      case 1: moveObstacle(numbers); break;
      case 2: tick_.attach(numbers.pick(2) == 0 ? setup_.drill.get() : nullptr); break;
      case 3: setup_.drill->spin(numbers.pick(2) == 0); break;
      case 4: jumpBack(numbers); break;
      case 5:
        if (numbers.pick(4) == 0) {
          tick_.restart(setup_.start);
          last_.setZero();
        } else {
          tick_.reset();
        }
        break;
      default: move(numbers); break;
    }
  }

 private:
  // Run ticks of a hand that moves at a constant speed.
  void move(Numbers& numbers) {
    const int ticks = 1 + numbers.pick(20);
    for (int i = 0; i < 3; ++i) m_.rates[i] = 2e-3 * numbers.next<signed char>();
    for (int i = 0; i < ticks; ++i) {
      m_.time += kPeriod;
      m_.q += kPeriod * m_.rates;
      m_.age = 0;
      step(m_);
    }
  }
  // Run a tick with one value that no device should report.
  void spoil(Numbers& numbers) {
    Measurement bad = m_;
    bad.time += kPeriod;
    m_.time = bad.time;
    const int joint = numbers.pick(joints_);
    switch (numbers.pick(9)) {
      case 0: bad.q[joint] = numbers.next<double>(); break;
      case 1: bad.rates[joint] = numbers.next<double>(); break;
      case 2: bad.time = numbers.next<double>(); break;
      case 3: bad.age = numbers.next<std::int32_t>(); break;
      case 4: bad.applied = JointVector::Constant(joints_, numbers.next<double>()); break;
      case 5: bad.q.resize(numbers.pick(8)); break;
      case 6: bad.enabled = false; break;
      case 7: bad.failed = true; break;
      default: bad.applied = JointVector::Constant(numbers.pick(8), numbers.next<float>()); break;
    }
    step(bad);
  }
  void moveObstacle(Numbers& numbers) {
    const int obstacle = numbers.pick(3);
    Pose pose;
    for (int i = 0; i < 3; ++i) pose.position[i] = 1e-4 * numbers.next<signed char>();
    Vec6 twist = Vec6::Zero();
    const double raw = numbers.next<double>();
    if (numbers.pick(2) == 0) pose.rotation = test::rotationAbout(Vec3::UnitX(), 0.02 * numbers.next<signed char>());
    if (numbers.pick(4) == 0) pose.position[numbers.pick(3)] = raw;
    if (numbers.pick(4) == 0) pose.rotation(numbers.pick(3), numbers.pick(3)) = raw;
    if (numbers.pick(4) == 0) twist[numbers.pick(6)] = raw;
    if (obstacle < 2) (void)setup_.scene.move(obstacle, pose, twist);
    if (obstacle == 2) (void)setup_.scene.move(numbers.next<std::int32_t>() | 2, pose, twist);
  }
  // Load a state with some changed numbers: the next ticks need not match the earlier ones.
  void jumpBack(Numbers& numbers) {
    std::vector<double> state(setup_.first);
    if (numbers.pick(2) == 0) tick_.saveState(state.data());
    for (int changes = numbers.pick(4); changes > 0; --changes)
      state[numbers.next<std::uint16_t>() % state.size()] = numbers.next<double>();
    tick_.loadState(state.data());
    last_.resize(0);
  }
  void step(const Measurement& measurement) {
    Command command;
    const Status status = tick_(measurement, command);
    const GuardOptions& options = tick_.guard().options();
    requireWithin(command.effort, options.torque);
    if (last_.size() > 0)
      require(((command.effort - last_).cwiseAbs() - kPeriod * options.slew).maxCoeff() <= 1e-9,
              "commands do not jump");
    require(tick_.guard().fault() == GuardReason::none || status != Status::ok, "a fault is no ok");
    last_ = command.effort;
  }

  Setup& setup_;
  HapticTick& tick_;
  int joints_;
  Measurement m_;
  JointVector last_;
};

void attackTick(std::string_view bytes) {
  Numbers numbers(bytes);
  Session session(setupOf(numbers.pick(4)));
  while (!numbers.empty()) session.act(numbers);
}

const Registration kTick{"tick", attackTick};

}  // namespace

}  // namespace enamel::attack
