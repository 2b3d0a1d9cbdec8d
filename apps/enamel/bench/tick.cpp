#include "enamel/render/tick.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>

#include "bench/measurement.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/device/tau/mechanism.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/runtime/recorder.hpp"
#include "enamel/sim/push.hpp"
#include "program/plugin_folder.hpp"

namespace enamel::bench {
namespace {

constexpr double kPeriod = 1e-3;  // s

struct Percentiles {
  double p50, p99, p999;  // us
};

Percentiles percentilesOf(std::vector<double> times_us) {
  std::sort(times_us.begin(), times_us.end());
  return {percentile(times_us, 0.5), percentile(times_us, 0.99), percentile(times_us, 0.999)};
}

// Time every call alone, each after a preparation. The times include the clock (about 20 ns).
template <typename Prepare, typename Call>
Percentiles timeEach(int calls, const Prepare& prepare, const Call& call) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times_us(static_cast<std::size_t>(calls));
  for (int i = 0; i < calls; ++i) {
    prepare(i);
    const auto start = Clock::now();
    call(i);
    times_us[static_cast<std::size_t>(i)] = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  }
  return percentilesOf(std::move(times_us));
}

template <typename Call>
Percentiles timeEach(int calls, const Call& call) {
  return timeEach(
      calls, [](int) {}, call);
}

// A tool that moves in and out of the wall, as measured at 1 kHz.
struct Path {
  std::vector<enamel::Measurement> measured;
  std::vector<Pose> poses;
};

// `sideways`: amplitude along the wall, m. `height`: mean height above the wall, m. `deep`: amplitude across it, m.
Path pathThroughTheWall(const Mechanism& mechanism, int ticks, double sideways = 0.01, double height = 0.0,
                        double deep = 2e-4, double rate = 25.0) {
  Path path;
  for (int i = 0; i < ticks; ++i) {
    const double t = kPeriod * i;
    Pose pose;
    pose.position = {sideways * std::sin(2.0 * t), sideways * std::cos(3.0 * t), height + deep * std::sin(rate * t)};
    Vec6 twist = Vec6::Zero();
    twist.head<3>() << 2.0 * sideways * std::cos(2.0 * t), -3.0 * sideways * std::sin(3.0 * t),
        deep * rate * std::cos(rate * t);
    Kinematics k;
    if (mechanism.reach(pose, twist, false, k) != Status::ok) throw std::logic_error("path outside the workspace");
    enamel::Measurement measured;
    measured.time = t;
    measured.q = k.q;
    measured.rates = k.rates;
    path.measured.push_back(measured);
    path.poses.push_back(pose);
  }
  return path;
}

// Time the linked renderer and its plugin in turns of 100 ticks, so that other load on the machine affects both. Return
// the times per tick over the turns. Add the ticks with a status other than ok to `faults`.
std::pair<Percentiles, Percentiles> timeLinkedAndPlugin(const std::vector<TickFrame>& inputs, Renderer& linked,
                                                        Renderer* plugin, int& faults) {
  using Clock = std::chrono::steady_clock;
  constexpr std::size_t kTurn = 100;
  std::vector<double> times_us[2];
  for (std::size_t first = 0; first + kTurn <= inputs.size(); first += kTurn)
    for (const std::size_t order : {0u, 1u}) {
      const std::size_t which = (order + first / kTurn) % 2;  // alternate which one is first
      Renderer* renderer = which == 0 ? &linked : plugin;
      if (renderer == nullptr) continue;
      TickOutput output;
      const auto start = Clock::now();
      for (std::size_t i = first; i < first + kTurn; ++i) faults += renderer->step(inputs[i], output) != Status::ok;
      times_us[which].push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count() / kTurn);
    }
  return {percentilesOf(times_us[0]), plugin == nullptr ? Percentiles{} : percentilesOf(times_us[1])};
}

// A plate on three balls, each between two pins: six contacts whose normals hold all six axes (Maxwell's coupling).
struct Coupling {
  Scene pins;
  Tool plate;
};

Coupling plateOnSixPins(const Material& material = {}) {
  constexpr double kArm = 0.02, kBall = 2e-3, kPin = 3e-3, kAside = 3.5e-3;  // m
  const double low = kBall - std::sqrt((kBall + kPin) * (kBall + kPin) - kAside * kAside);
  Coupling coupling;
  coupling.plate.count = 3;
  for (std::size_t ball = 0; ball < 3; ++ball) {
    const double angle = 2.0 * M_PI / 3.0 * static_cast<double>(ball);
    const Vec3 outward(std::cos(angle), std::sin(angle), 0.0), aside(-std::sin(angle), std::cos(angle), 0.0);
    ToolPart& part = coupling.plate.parts[ball];
    part.a = part.b = kArm * outward + kBall * Vec3::UnitZ();
    part.radius = kBall;
    for (const double side : {-1.0, 1.0}) {
      Obstacle pin{"pin " + std::to_string(coupling.pins.obstacles().size()), Sphere{kPin}, Pose{}, Vec6::Zero(),
                   material};
      pin.pose.position = kArm * outward + side * kAside * aside + low * Vec3::UnitZ();
      coupling.pins.add(std::move(pin));
    }
  }
  return coupling;
}

// Time whole ticks on `path`. `error`: ticks that are not ok or whose number of contacts is not `contacts`.
Measurement timeTicks(const std::string& name, const Path& path, int contacts, HapticTick& tick) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> times_us;
  int wrong = 0;
  Command command;
  for (const enamel::Measurement& measured : path.measured) {
    const auto start = Clock::now();
    const Status status = tick(measured, command);
    times_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    wrong += status != Status::ok || tick.frame().contacts.count != contacts;
  }
  return rowOf(name, std::move(times_us), wrong, "ticks not ok, or with more or fewer contacts");
}

// As stiff as gum, lib/docs/compliant.md.
Material gum() {
  Material m;
  m.stiffness = 1500.0;
  m.exponent = 1.5;
  m.thickness = 2e-3;
  m.hysteresis = 1.0;
  return m;
}

// Compare the same renderer without contacts, with six, and with six at a compliant layer.
void addNumbersOfContacts(const Mechanism& mechanism, int ticks, const GuardOptions& guarded,
                          const std::vector<std::pair<const char*, Renderer*>>& renderers,
                          std::vector<Measurement>& rows) {
  const Scene wall = flatWall();
  const Coupling coupling = plateOnSixPins(), soft = plateOnSixPins(gum());
  const Path above = pathThroughTheWall(mechanism, ticks, 0.01, 5e-3);
  const Path through = pathThroughTheWall(mechanism, ticks, 5e-5, -1e-4);
  for (const auto& [name, renderer] : renderers) {
    HapticTick inTheAir(mechanism, wall, Tool{}, *renderer, guarded);
    rows.push_back(timeTicks(std::string("whole tick, 0 contacts, ") + name, above, 0, inTheAir));
    HapticTick onPins(mechanism, coupling.pins, coupling.plate, *renderer, guarded);
    rows.push_back(timeTicks(std::string("whole tick, 6 contacts, ") + name, through, 6, onPins));
    const double reference_us = rows.back().median_us;
    HapticTick onSoft(mechanism, soft.pins, soft.plate, *renderer, guarded);
    rows.push_back(timeTicks(std::string("whole tick, 6 contacts, compliant, ") + name, through, 6, onSoft));
    rows.back().reference_us = reference_us;
    renderer->reset();
  }
}

// Compare each renderer at scenes with one contact. The first scene is the reference.
void compareScenes(const Mechanism& mechanism, const Path& path, const GuardOptions& guarded,
                   const std::vector<std::pair<const char*, Renderer*>>& renderers,
                   const std::vector<std::pair<const char*, const Scene*>>& scenes, std::vector<Measurement>& rows) {
  for (const auto& [name, renderer] : renderers) {
    const std::size_t reference = rows.size();
    for (const auto& [where, scene] : scenes) {
      HapticTick tick(mechanism, *scene, Tool{}, *renderer, guarded);
      rows.push_back(timeTicks(std::string("whole tick, ") + where + ", " + name, path, 1, tick));
      if (rows.size() > reference + 1) rows.back().reference_us = rows[reference].median_us;
    }
    renderer->reset();
  }
}

// Compare a tick at a rigid, fixed block with one at the same block on springs, as stiff as a tooth on its ligament.
// Then compare it with one at a compliant layer.
void addBlocks(const Mechanism& mechanism, int ticks, const GuardOptions& guarded,
               const std::vector<std::pair<const char*, Renderer*>>& renderers, std::vector<Measurement>& rows) {
  Obstacle block{"block", Box{{0.02, 0.02, 0.01}}, Pose{}, Vec6::Zero(), {}};
  block.pose.position.z() = -0.01;
  Scene fixed, movable, compliant;
  fixed.add(block);
  Suspension tooth;
  tooth.inertia << 2e-3, 2e-3, 2e-3, 6e-8, 6e-8, 3e-8;
  tooth.stiffness << 9.8e4, 9.8e4, 2.5e5, 14.0, 14.0, 14.0;
  block.suspension = std::make_shared<const Suspension>(tooth);
  movable.add(block);
  block.suspension = nullptr;
  block.material = gum();
  compliant.add(block);
  compareScenes(mechanism, pathThroughTheWall(mechanism, ticks, 5e-5, -1e-4), guarded, renderers,
                {{"fixed block", &fixed}, {"movable block", &movable}, {"compliant block", &compliant}}, rows);
}

// Compare a tick at a wall with one at the same wall of enamel: 40 taps at 0.1 m/s a second, each with its transient.
void addTaps(const Mechanism& mechanism, int ticks, const GuardOptions& guarded,
             const std::vector<std::pair<const char*, Renderer*>>& renderers, std::vector<Measurement>& rows) {
  Obstacle wall = halfSpace("wall", Vec3::Zero(), Vec3::UnitZ());
  Scene plain, enamel;
  plain.add(wall);
  wall.tap = tapOf("enamel");
  enamel.add(wall);
  compareScenes(mechanism, pathThroughTheWall(mechanism, ticks, 5e-5, 2e-4, 4e-4, 250.0), guarded, renderers,
                {{"taps", &plain}, {"taps with transients", &enamel}}, rows);
}

// Compare a tick at a wall with one at the same wall with the roughness of a coarse diamond, lib/docs/surfaces.md.
void addRough(const Mechanism& mechanism, int ticks, const GuardOptions& guarded,
              const std::vector<std::pair<const char*, Renderer*>>& renderers, std::vector<Measurement>& rows) {
  Obstacle wall = halfSpace("wall", Vec3::Zero(), Vec3::UnitZ());
  Scene smooth, rough;
  smooth.add(wall);
  wall.material.roughness = 6e-6;
  wall.material.wavelength = 3e-4;
  rough.add(wall);
  compareScenes(mechanism, pathThroughTheWall(mechanism, ticks, 5e-3, -1e-4, 5e-5), guarded, renderers,
                {{"smooth wall", &smooth}, {"rough wall", &rough}}, rows);
}

// Compare a tick at a wall with one at the same wall with eight guides, one of them a line of 64 corners.
void addGuides(const Mechanism& mechanism, int ticks, const GuardOptions& guarded,
               const std::vector<std::pair<const char*, Renderer*>>& renderers, std::vector<Measurement>& rows) {
  const Scene plain = flatWall();
  Scene guided = plain, line = plain;
  Polyline round;
  for (std::size_t i = 0; i < kMaxGuidePoints; ++i)
    round.points.emplace_back(5e-3 * std::cos(0.1 * static_cast<double>(i)),
                              5e-3 * std::sin(0.1 * static_cast<double>(i)), 0.0);
  std::vector<Guide> guides = {{round, {}, 200.0, 1.0}};
  line.setGuides(guides);
  guides.resize(kMaxGuides, {Plane{}, {}, 50.0, 1.0});
  guided.setGuides(guides);
  compareScenes(mechanism, pathThroughTheWall(mechanism, ticks, 5e-5, -1e-4), guarded, renderers,
                {{"wall", &plain}, {"wall and a line of 64 corners", &line}, {"wall and 8 guides", &guided}}, rows);
}

// The measurements and their common inputs.
struct TickBench {
  std::shared_ptr<const TauMechanism> mechanism;
  Path path;
  Scene wall = flatWall();
  GuardOptions guarded;
  std::vector<Measurement> rows;

  int ticks() const { return static_cast<int>(path.measured.size()); }
  void add(std::string name, const Percentiles& p, double error, const char* errorOf, double goal_us = kNoGoal) {
    Measurement row;
    row.name = std::move(name);
    row.median_us = p.p50;
    row.p99_us = p.p99;
    row.p999_us = p.p999;
    row.error = error;
    row.errorOf = errorOf;
    row.goal_us = goal_us;
    rows.push_back(std::move(row));
  }
};

// A renderer of the bench. `plugin`: file of the plugin with the same renderer, with its parameters.
struct BenchRenderer {
  const char* name;
  Renderer* renderer;
  const char* plugin;
  std::map<std::string, std::string> parameters;
};

void addTrack(TickBench& bench) {
  Kinematics tracked = bench.mechanism->home();
  const Path& path = bench.path;
  const auto track = [&](std::size_t i) {
    return bench.mechanism->track(path.measured[i].q, path.measured[i].rates, false, tracked);
  };
  const Percentiles p = timeEach(bench.ticks(), [&](int i) {
    keep(track(static_cast<std::size_t>(i)));
    keep(tracked);
  });
  tracked = bench.mechanism->home();
  double error = 0.0;
  for (std::size_t i = 0; i < path.poses.size(); ++i) {
    if (track(i) != Status::ok) error = 1.0;
    error = std::max(error, (tracked.pose.position - path.poses[i].position).norm());
  }
  bench.add("its track", p, error, "position, m");
}

// Add the ticks with a status other than ok to `faults`.
Percentiles timeWhole(const TickBench& bench, Renderer& renderer, const GuardOptions& guard, int& faults) {
  HapticTick tick(*bench.mechanism, bench.wall, Tool{}, renderer, guard);
  Command command;
  return timeEach(bench.ticks(), [&](int i) {
    faults += tick(bench.path.measured[static_cast<std::size_t>(i)], command) != Status::ok;
  });
}

// Time the guard alone. As in a tick, the other stages have just written its frame. `error`: ticks whose request it
// changed.
void addGuard(TickBench& bench, const BenchRenderer& one, const std::vector<TickFrame>& frames) {
  Guard guard(*bench.mechanism, bench.guarded);
  int changed = 0;
  TickFrame frame;
  const Percentiles alone = timeEach(
      bench.ticks(), [&](int i) { frame = frames[static_cast<std::size_t>(i)]; },
      [&](int i) {
        guard.step(bench.path.measured[static_cast<std::size_t>(i)], Status::ok, frame);
        changed += frame.reason != GuardReason::none;
      });
  bench.add(std::string("its guard, ") + one.name, alone, changed, "ticks that it touched", 0.5);
}

// Time the renderer alone, and the same renderer as a plugin if that was built.
void addStep(TickBench& bench, const BenchRenderer& one, const std::vector<TickFrame>& frames, int& faults) {
  one.renderer->reset();
  const std::string file = app::pluginFolder() + one.plugin;
  std::unique_ptr<Renderer> plugin;
  if (std::filesystem::exists(std::filesystem::u8path(file))) {
    PluginSetup setup;
    setup.deviceText = nominalDeviceText();
    setup.parameters = one.parameters;
    plugin = makeRenderer(PluginLibrary::load(file), setup);
    plugin->activate(kPeriod);
  }
  const auto [part, across] = timeLinkedAndPlugin(frames, *one.renderer, plugin.get(), faults);
  bench.add(std::string("its renderer, ") + one.name, part, faults, "ticks that were not ok");
  if (!plugin) return;
  one.renderer->reset();
  plugin->reset();
  TickOutput output, linked;
  int different = 0;
  for (const TickFrame& in : frames) {
    const bool same = plugin->step(in, output) == one.renderer->step(in, linked);
    different += !same || output.torque != linked.torque;
  }
  bench.add(std::string("the same as a plugin, ") + one.name, across, different,
            "ticks that differ from the linked one", part.p50 + 0.1);
}

void addRenderer(TickBench& bench, const BenchRenderer& one) {
  int faults = 0;
  const Percentiles whole = timeWhole(bench, *one.renderer, bench.guarded, faults);
  bench.add(std::string("whole tick, ") + one.name, whole, faults, "ticks that were not ok", 3.0);
  GuardOptions off = bench.guarded;
  off.on = false;
  const Percentiles bare = timeWhole(bench, *one.renderer, off, faults);
  bench.add(std::string("the same, guard off, ") + one.name, bare, faults, "ticks that were not ok");
  HapticTick tick(*bench.mechanism, bench.wall, Tool{}, *one.renderer, bench.guarded);
  Command command;
  std::vector<TickFrame> frames;
  for (const enamel::Measurement& measured : bench.path.measured) {
    faults += tick(measured, command) != Status::ok;
    frames.push_back(tick.frame());
  }
  addGuard(bench, one, frames);
  addStep(bench, one, frames, faults);
}

// Time whole ticks of position control for motors with lag, and with rotors behind cables as in tau-detailed.toml.
void addCables(TickBench& bench) {
  PositionControlOptions options = positionControlFor(*bench.mechanism, kPeriod, 0, 0);
  options.drive = {1000.0, 1.35e-4, 1000.0, 0.037, 0.004, false};
  PositionControlRenderer servo(options);
  int faults = 0;
  const Percentiles whole = timeWhole(bench, servo, bench.guarded, faults);
  bench.add("whole tick, position-control with cables", whole, faults, "ticks that were not ok", 5.0);
}

// Time recording between whole ticks. The file's thread discards the data. `error`: lost ticks.
void addRecording(TickBench& bench, Renderer& renderer) {
  using Clock = std::chrono::steady_clock;
  HapticTick tick(*bench.mechanism, bench.wall, Tool{}, renderer, bench.guarded);
  Recorder recorder([](const char*, std::size_t size) { return size; }, "bench", {}, tick);
  Command command;
  std::vector<double> times_us;
  for (const enamel::Measurement& measured : bench.path.measured) {
    const Status status = tick(measured, command);
    recorder.makeRoom();
    const auto start = Clock::now();
    recorder.add(times_us.size(), measured, tick, command, status);
    times_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
  }
  bench.add("recording a tick, position-control", percentilesOf(std::move(times_us)),
            static_cast<double>(recorder.close().lost), "ticks that were lost", 0.5);
}

void addPush(TickBench& bench, Renderer& renderer, int pushes) {
  PushSetup setup;
  const auto finalPose = [&](int substeps) {
    setup.substeps = substeps;
    Pose pose;
    (void)runPush(*bench.mechanism, renderer, setup, [&](const TickRecord& t) { pose = t.pose; });
    return pose;
  };
  const double error = (finalPose(1).position - finalPose(8).position).norm();
  setup.substeps = 1;
  const Percentiles p = timeEach(
      pushes, [&](int) { (void)runPush(*bench.mechanism, renderer, setup, [](const TickRecord& t) { keep(t); }); });
  bench.add("a push of 3 s on the virtual device", p, error, "last position, m, against 8 substeps", 10e3);
}

}  // namespace

std::vector<Measurement> measureTick(double scale) {
  TickBench bench;
  bench.mechanism = std::make_shared<TauMechanism>(nominalDevice());
  const int ticks = std::max(2000, static_cast<int>(50000 * scale));
  bench.path = pathThroughTheWall(*bench.mechanism, ticks);
  // The path does not depend on the torques: checks of energy and oscillation would be meaningless.
  bench.guarded = guardFor(*bench.mechanism, kPeriod);
  bench.guarded.energy = bench.guarded.oscillation = kUnlimited;
  HoldRenderer hold(designServo(bench.mechanism, Pose{}, kPeriod).K, kPeriod, {});
  PositionControlRenderer servo(positionControlFor(*bench.mechanism, kPeriod, 0, 0));
  ImpedanceRenderer spring(ImpedanceOptions{});

  bench.add("nothing (the clock's own cost)", timeEach(ticks, [](int) {}), 0.0, "-");
  addTrack(bench);
  addRenderer(bench, {"position-control", &servo, "/enamel_position_control.so", {}});
  addCables(bench);
  addRenderer(bench, {"hold", &hold, "/enamel_position_control.so", {{"mode", "hold"}}});
  addRenderer(bench, {"impedance", &spring, "/enamel_impedance.so", {}});
  addNumbersOfContacts(*bench.mechanism, ticks, bench.guarded, {{"position-control", &servo}, {"impedance", &spring}},
                       bench.rows);
  addBlocks(*bench.mechanism, ticks, bench.guarded, {{"position-control", &servo}, {"impedance", &spring}}, bench.rows);
  addTaps(*bench.mechanism, ticks, bench.guarded, {{"position-control", &servo}, {"impedance", &spring}}, bench.rows);
  addRough(*bench.mechanism, ticks, bench.guarded, {{"position-control", &servo}, {"impedance", &spring}}, bench.rows);
  addGuides(*bench.mechanism, ticks, bench.guarded, {{"position-control", &servo}, {"impedance", &spring}}, bench.rows);
  addRecording(bench, servo);
  addPush(bench, hold, std::max(10, static_cast<int>(100 * scale)));
  return std::move(bench.rows);
}

}  // namespace enamel::bench
