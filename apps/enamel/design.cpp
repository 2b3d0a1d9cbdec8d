#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>

#include "commands.hpp"
#include "design_expectation.hpp"
#include "design_file.hpp"
#include "design_results.hpp"
#include "design_rivals.hpp"
#include "design_stability.hpp"
#include "enamel/control/tuning.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/study/parallel.hpp"
#include "plant_option.hpp"
#include "program/outputs.hpp"
#include "program/program.hpp"
#include "renderer_option.hpp"

namespace enamel::app {
namespace {

constexpr int kLargestDelay = 3;

struct DesignOptions {
  std::string device, output, impedanceMap, stability;
  double rate = 1000.0;
  ServoWeights weights;
  std::vector<double> at{0.0, 0.0, 0.0};
  bool tune = false, rivals = false, bestSpring = false, hasPlant = false, overwrite = false;
  RivalSearchOptions search;
  TuneRequirements required;
  double deviceDamping = 0.0, push = 12.0;
};

// The device at its operating point.
struct Device {
  DeviceParameters parameters;
  std::shared_ptr<const Mechanism> mechanism;
  Pose pose;
  DevicePlant plant;
  Linearisation linear;
  TuneProblem problem;
};

Device makeDevice(const DesignOptions& options) {
  DeviceParameters parameters = loadDevice(options.device);
  addDamping(parameters, options.deviceDamping * Vec6::Unit(2));
  Device device;
  device.parameters = parameters;
  device.mechanism = makeMechanism(parameters);
  device.pose.position = Vec3(options.at[0], options.at[1], options.at[2]);
  device.plant = devicePlant(device.mechanism, device.pose);
  device.linear = linearise(device.plant.f, device.plant.h, device.plant.x0, device.plant.u0);
  const JointLimits& limits = device.mechanism->limits();
  device.problem = {outputsAsStates(device.linear),
                    device.plant.jacobian,
                    1.0 / options.rate,
                    limits.encoderStep,
                    limits.effort,
                    options.push};
  return device;
}

DesignedServo measure(const DesignOptions& options, const Device& device, const ServoDesign& design) {
  const Eigen::MatrixXd closed = closedLoop(design.augmented, design.K, 0);
  return {std::filesystem::u8path(options.device).filename().u8string(),
          device.pose.position,
          options.deviceDamping,
          device.linear.error,
          device.plant,
          design,
          continuousPoles(closed, design.period),
          spectralRadius(closed),
          measureMargins(runningLoop(design), design.K, design.period),
          requirementsOf(design, device.plant)};
}

// --- the terminal -------------------------------------------------------------------------------------------------

// Return the largest first-impact stiffness that any controller can reach for the push of the report, N/m.
double limitOf(const Device& device, int delay) {
  return firstImpactLimit(device.plant.effectiveMass, device.problem.period, delay, device.problem.push,
                          device.plant.largestForce);
}

void printSummary(const Device& device, const DesignedServo& servo) {
  const ServoWeights& w = servo.design.weights;
  fmt::print("{} at ({:.4g}, {:.4g}, {:.4g}) m: effective mass {:.3g} kg, largest force {:.3g} N along z\n",
             device.mechanism->name(), servo.position.x(), servo.position.y(), servo.position.z(),
             device.plant.effectiveMass, device.plant.largestForce);
  fmt::print("servo: Q = diag({:.4g} I, {:.4g} I, {:.4g} I) for q', q, integral; R = {:.4g} I; period {:.6g} s\n",
             w.velocity, w.position, w.integral, w.torque, servo.design.period);
  fmt::print("linear model: relative error {:.0e} (estimated)\n", servo.linearisationError);
  fmt::print("closed loop: spectral radius {:.4f}, fastest pole {:.0f} rad/s, slowest {:.3g} rad/s\n",
             servo.spectralRadius, std::abs(servo.poles.front()), std::abs(servo.poles.back()));
  const Margins& m = servo.margins;
  fmt::print("disk margin: {:.3f} at {:.0f} rad/s\n", m.disk, m.diskFrequency);
  fmt::print("delay: stable up to {} samples (spectral radius {:.3f} at {})\n", m.toleratedDelay, m.radiusBeyond,
             m.toleratedDelay + 1);
  const double limit = limitOf(device, 0);
  if (const auto servoScore = evaluateServo(device.problem, 0, w); servoScore && limit > 0.0)
    fmt::print(
        "first impact, {:.4g} N: {:.4g} N/m ({:.0f} % of the limit); chatter {:.3f} N m (encoders, differenced "
        "velocity)\n",
        device.problem.push, servoScore->stiffness, 100.0 * servoScore->stiffness / limit, servoScore->chatter);
  else
    fmt::print("first impact, {:.4g} N: not measured, {}\n", device.problem.push,
               limit > 0.0 ? "the wall does not stop the push" : "the motors cannot hold the push: see --force");
  fmt::print("\n{:<6} {:>10} {:>10} {:>10}\n", "input", "gain up", "gain down", "phase deg");
  for (std::size_t i = 0; i < m.channel.size(); ++i)
    fmt::print("q{:<5} {:>10.3f} {:>10.4f} {:>10.1f}\n", i + 1, m.channel[i].gainUp, m.channel[i].gainDown,
               m.channel[i].phase * 180.0 / M_PI);
  fmt::print("\n{:<48} {:>10} {:>8} {:<4} {}\n", "Table II (worst of joints or axes)", "measured", "limit", "", "");
  for (const Requirement& r : servo.requirements)
    fmt::print("{:<48} {:>10.4g} {:>8.4g} {:<4} {}\n", r.name, r.worst(), r.limit, r.unit, r.met() ? "met" : "NOT MET");
}

// Print one line of the trade-off and return the servo.
std::optional<TunedServo> printTuned(const Device& device, const TuneRequirements& required) {
  std::optional<TunedServo> tuned = tuneServo(device.problem, required);
  const char* rows = required.stepResponse ? "yes" : "no";
  if (!tuned) {
    fmt::print("{:>5} {:>8}   not reachable\n", required.delay, rows);
    return tuned;
  }
  const ServoWeights& w = tuned->design.weights;
  const auto table = requirementsOf(tuned->design, device.plant);
  std::string met;
  for (const Requirement& r : table) met += r.met() ? '+' : '-';
  fmt::print("{:>5} {:>8} {:>11.4g} {:>7.0f} {:>6} {:>7.3f} {:>9.4f}   {:<7} {:>10.3g} {:>10.3g} {:>10.3g}\n",
             required.delay, rows, tuned->stiffness, 100.0 * tuned->stiffness / limitOf(device, required.delay),
             tuned->toleratedDelay, tuned->diskMargin, tuned->chatter, met, w.velocity, w.position, w.integral);
  return tuned;
}

std::optional<TunedServo> printTradeOff(const Device& device, const DesignOptions& options) {
  fmt::print(
      "Stiffest servos with disk margin >= {:.3g} and chatter <= {:.3g} N m, for each delay that acts in the loop.\n",
      options.required.diskMargin, options.required.chatter);
  fmt::print("K_z1: {:.4g} N along -z, linear model, exact measurements. Chatter: encoders, differenced velocity.\n",
             options.push);
  fmt::print(
      "Table II: + met, - not met: overshoot, rise, settling; then, under 10 N or 0.1 N m, deviation of joints,\n"
      "TCP position, TCP orientation. 'step': the search required the first three (measured without delay).\n\n");
  fmt::print("{:>5} {:>8} {:>11} {:>7} {:>6} {:>7} {:>9}   {:<7} {:>10} {:>10} {:>10}\n", "delay", "step", "K_z1 N/m",
             "% limit", "stable", "disk", "chatter", "TableII", "q-velocity", "q-position", "q-integral");
  std::optional<TunedServo> chosen;
  for (int delay = 0; delay <= kLargestDelay; ++delay)
    for (const bool step : {false, true}) {
      TuneRequirements required = options.required;
      required.delay = delay;
      required.stepResponse = step;
      const auto tuned = printTuned(device, required);
      if (delay == options.required.delay && step == options.required.stepResponse) chosen = tuned;
    }
  fmt::print("\n'stable': the largest delay, in samples, up to which the loop is stable.\n");
  return chosen;
}

void writeImpedanceMap(const DesignOptions& options, const Device& device) {
  std::vector<double> stiffnesses, dampings{0.0};
  for (int i = 0; i <= 24; ++i) stiffnesses.push_back(500.0 * std::pow(200.0, i / 24.0));  // 500 to 100 000 N/m
  for (int i = 0; i <= 12; ++i) dampings.push_back(0.1 * std::pow(1000.0, i / 12.0));      // 0.1 to 100 N s/m
  const WallDevice wallDevice =
      wallDeviceOf(device.plant, dampingAlong(*device.mechanism, device.pose, Vec3::UnitZ()), device.problem.period);
  std::string text = "delay_samples,stiffness_N_per_m,damping_Ns_per_m,stable,eq16_damping_Ns_per_m,eq16_met\n";
  const auto map = mapWallStability(wallDevice, stiffnesses, dampings, {0, 1, 2, 3});
  int stable = 0, passive = 0, broken = 0;
  for (const WallStability& entry : map) {
    const ImpedanceOptions wall{entry.wall.stiffness, entry.wall.damping};
    const bool met = dampingWarning(wall, wallDevice.period, wallDevice.damping).empty();
    text += fmt::format("{},{:.6g},{:.6g},{},{:.6g},{}\n", entry.wall.delay, wall.stiffness, wall.damping,
                        int{entry.stable}, requiredDamping(wall, wallDevice.period), int{met});
    stable += entry.stable;
    passive += met;
    broken += met && !entry.stable;
  }
  writeFile(options.impedanceMap, text);
  fmt::print(
      "impedance wall: effective mass {:.3g} kg, mechanical damping {:.3g} N s/m: {} of {} walls are stable; {} meet "
      "eq. 16, and {} of these are unstable (with delay)\n",
      wallDevice.mass, wallDevice.damping, stable, map.size(), passive, broken);
}

void run(DesignOptions options) {
  if (options.rivals) {
    RivalSearchOptions& search = options.search;
    search.device = options.device;
    search.period = 1.0 / options.rate;
    const std::string file = designRivals(search);
    if (!options.output.empty()) writeFile(options.output, file);
    return;
  }
  const int threads = options.search.threads == 0 ? availableThreads() : options.search.threads;
  const bool writesOthers = !options.output.empty() || options.tune;
  if (!options.stability.empty()) {
    writeStability(loadDevice(options.device), 1.0 / options.rate, kLargestDelay, threads, options.stability);
    if (options.impedanceMap.empty() && !writesOthers) return;
  }
  const Device device = makeDevice(options);
  if (!options.impedanceMap.empty()) {
    writeImpedanceMap(options, device);
    if (!writesOthers) return;
  }
  ServoDesign design;
  if (options.tune) {
    auto tuned = printTradeOff(device, options);
    if (options.output.empty()) return;
    if (!tuned)
      throw Error(
          "no servo meets the requirements, nothing is written: relax --disk-margin, --chatter or --step-response");
    fmt::print("\n");
    design = tuned->design;
  } else {
    design = designServo(device.problem.plant, device.problem.period, options.weights);
  }
  if (!writesOthers)
    printExpectation(
        expectWall(options.hasPlant ? modelFor(options.search.plant, device.parameters) : device.parameters,
                   device.problem.period, kLargestDelay, threads, options.bestSpring),
        device.problem.period, dampingAlong(*device.mechanism, device.mechanism->home().pose, Vec3::UnitZ()),
        options.bestSpring);
  const DesignedServo servo = measure(options, device, design);
  if (!options.output.empty()) writeFile(options.output, jsonOf(servo));
  printSummary(device, servo);
}

void addServoOptions(CLI::App& command, DesignOptions& options) {
  command.add_option("--rate", options.rate, "ticks per second, Hz")
      ->check(CLI::Range(10.0, 100000.0))
      ->capture_default_str();
  command.add_option("--q-velocity", options.weights.velocity, "weight of q'")->capture_default_str();
  command.add_option("--q-position", options.weights.position, "weight of q")->capture_default_str();
  command.add_option("--q-integral", options.weights.integral, "weight of the integral of the error")
      ->capture_default_str();
  command.add_option("--r", options.weights.torque, "weight of the torque")->capture_default_str();
  command.add_option("--at", options.at, "operating point: TCP position x,y,z, m")
      ->delimiter(',')
      ->expected(3)
      ->capture_default_str();
  command.add_flag("--tune", options.tune, "search the weights (the options --q-... and --r are ignored)");
  command.add_option("--disk-margin", options.required.diskMargin, "--tune: smallest disk margin")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command.add_option("--delay", options.required.delay, "--tune: delay of the servo to write, samples")
      ->check(CLI::Range(0, kLargestDelay))
      ->capture_default_str();
  command.add_flag("--step-response", options.required.stepResponse,
                   "--tune: the servo to write meets the step-reference rows of Table II");
  command.add_option("--impedance-map", options.impedanceMap, "file for the stability map of impedance walls (CSV)");
  command.add_option("--stability", options.stability,
                     "page for maps of the device errors at which position control is stable (HTML); prints them too");
  command.add_option("--force", options.push, "force of the push for the reported first impact, N")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command
      .add_option("--device-damping", options.deviceDamping,
                  "damping of the TCP along z, N s/m, added to that of the device file (4 for the paper's spring)")
      ->check(CLI::Range(0.0, 1000.0))
      ->capture_default_str();
}

void addSearchOptions(CLI::App& command, DesignOptions& options) {
  command.add_flag("--best-spring", options.bestSpring,
                   "search the stiffest spring at each delay, and compare position control with it (minutes)");
  command.add_flag("--rivals", options.rivals,
                   "tune the rivals of position control in simulation, each at every delay (an hour);\n--output writes "
                   "the values for --tuned of study and compare");
  options.search.plant = kClosedForm;
  takeOldNames(command
                   .add_option("--plant", options.search.plant,
                               std::string("the estimate and --rivals: ") + kPlantHelp +
                                   "; the estimate without --plant is on imperfect if the file has imperfections")
                   ->check(CLI::Validator(checkPlant, ""))
                   ->capture_default_str(),
               "plant");
  command.add_option("--scene", options.search.scene,
                     "--rivals: scene file (TOML); the search also pushes there, and the tool must not slide off the "
                     "obstacle nearest to start");
  command.add_option("--half-width", options.search.halfWidth, "--rivals: half width of the wall, m")
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str();
  command.add_option("--generations", options.search.generations, "--rivals: generations of the search, 8 servos each")
      ->check(CLI::Range(0, 10000))
      ->capture_default_str();
  command.add_option("--runs", options.search.runs, "--rivals: steps of force at each point to evaluate a servo")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  command
      .add_option("--threads", options.search.threads, "number of threads, 0: all; the result does not depend on it")
      ->check(CLI::Range(0, kMaxThreads))
      ->capture_default_str();
  command.add_option("--seed", options.search.seed, "--rivals: seed of the random numbers")->capture_default_str();
}

}  // namespace

void addDesign(CLI::App& app) {
  auto options = std::make_shared<DesignOptions>();
  CLI::App* command = app.add_subcommand(
      "design",
      "Estimates by simulated pushes what position control reaches on a device, and what limits it.\nThen designs the "
      "paper's servo for the device (the renderer hold): linearisation, zero-order hold, Riccati equation,\nmargins "
      "and Table II.\n--output writes the design (JSON: models, K, P, poles, margins, requirements) for --gain of push "
      "and study.\n--tune searches the weights and prints the stiffest servo for each delay; with --output, it writes "
      "that of --delay.\n--impedance-map writes which impedance walls are stable (CSV).\n--stability prints and draws "
      "at which errors of mass, cables and delay position control is stable.");
  command->add_option("--device", options->device, "device file (TOML)")->required();
  command->add_option("--output", options->output, "file for the design (JSON)");
  addServoOptions(*command, *options);
  command
      ->add_option_function<double>(
          "--chatter", [options](double most) { options->required.chatter = options->search.chatter = most; },
          "--tune, --rivals: largest chatter, N m or N (default: " + fmt::format("{:g}", options->required.chatter) +
              "; with --rivals 2.5 % of the weakest motor)")
      ->check(CLI::PositiveNumber);
  addSearchOptions(*command, *options);
  addOverwrite(*command, options->overwrite, {"--output", "--impedance-map", "--stability"});
  command->callback([options, command] {
    options->hasPlant = command->count("--plant") > 0;
    run(*options);
  });
}

}  // namespace enamel::app
