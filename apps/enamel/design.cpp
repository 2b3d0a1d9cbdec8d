#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "design_results.hpp"
#include "enamel/control/margins.hpp"
#include "enamel/control/tuning.hpp"
#include "enamel/core/error.hpp"
#include "json_matrices.hpp"

namespace enamel::app {
namespace {

using Eigen::MatrixXd;
using Json = nlohmann::ordered_json;

constexpr double kPush = 12.0;  // N, of the stiffness that is reported
constexpr int kLargestDelay = 3;

struct DesignOptions {
  std::string device, output, impedanceMap;
  double rate = 1000.0;
  ServoWeights weights;
  std::vector<double> at{0.0, 0.0, 0.0};
  bool tune = false;
  TuneRequirements required;
  double damping = 4.0;
};

// Everything that is known about the device at its operating point.
struct Device {
  TauModel model;
  DevicePlant plant;
  Linearisation linear;
  TuneProblem problem;
};

Device makeDevice(const DesignOptions& options) {
  Device device{makeModel(loadTau(options.device)), {}, {}, {}};
  Pose pose;
  pose.position = Vec3(options.at[0], options.at[1], options.at[2]);
  device.plant = devicePlant(device.model, pose);
  device.linear = linearise(device.plant.f, device.plant.h, device.plant.x0, device.plant.u0);
  device.problem = {outputsAsStates(device.linear), device.plant.jacobian, 1.0 / options.rate,
                    2.0 * M_PI / device.model.encoderCounts, device.model.maxTorque};
  return device;
}

// --- servo.json ---------------------------------------------------------------------------------------------------

struct Report {
  std::vector<std::complex<double>> poles;
  double radius;
  Margins margins;
  std::vector<Requirement> requirements;
};

Report reportOn(const ServoDesign& design, const Device& device) {
  const MatrixXd closed = closedLoop(design.augmented, design.K, 0);
  return {continuousPoles(closed, design.period), spectralRadius(closed),
          measureMargins(runningLoop(design), design.K, design.period), requirementsOf(design, device.plant)};
}

Json jsonOf(const DesignOptions& options, const Device& device, const ServoDesign& design, const Report& report) {
  const ServoWeights& w = design.weights;
  Json out;
  out["note"] =
      "Linear model at the operating point, state y=[qdot;q-q0], input torque minus gravity torque; augmented with "
      "xi' = r - q, zero-order hold, LQR with Q=diag(velocity I, position I, integral I), R=torque I; "
      "u = -K [qdot; q-q0; xi]. Poles in rad/s, delays in samples; null stands for infinite.";
  out["model"] = std::filesystem::path(options.device).filename().string();
  out["position"] = options.at;
  out["period"] = design.period;
  out["weights"] = {{"velocity", w.velocity}, {"position", w.position}, {"integral", w.integral}, {"torque", w.torque}};
  out["linearisation_error"] = device.linear.error;
  out["q0"] = listOf(device.plant.angles);
  out["gravity_torque"] = listOf(device.plant.u0);
  out["A"] = rowsOf(design.plant.A);
  out["B"] = rowsOf(design.plant.B);
  out["Ad"] = rowsOf(design.augmented.A);
  out["Bd"] = rowsOf(design.augmented.B);
  out["K"] = rowsOf(design.K);
  out["P"] = rowsOf(design.P);
  out["spectral_radius"] = report.radius;
  out["poles"] = Json::array();
  for (const auto& pole : report.poles) out["poles"].push_back({pole.real(), pole.imag()});
  Json& margins = out["margins"];
  margins["disk"] = report.margins.disk;
  margins["disk_frequency"] = report.margins.diskFrequency;
  margins["tolerated_delay"] = report.margins.toleratedDelay;
  margins["spectral_radius_beyond"] = report.margins.radiusBeyond;
  margins["inputs"] = Json::array();
  for (const ChannelMargins& c : report.margins.channel)
    margins["inputs"].push_back({{"gain_up", c.gainUp}, {"gain_down", c.gainDown}, {"phase", c.phase}});
  out["requirements"] = toJson(report.requirements);
  return out;
}

void writeText(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  if (!file) throw Error(path + ": cannot write the file");
}

// --- the terminal -------------------------------------------------------------------------------------------------

// Stiffness in N/m and as a share of what no controller can pass.
std::string stiffnessText(const Device& device, double stiffness, int delay) {
  const double limit =
      firstImpactLimit(device.plant.effectiveMass, device.problem.period, delay, kPush, device.plant.largestForce);
  return fmt::format("{:.4g} N/m ({:.0f} % of the limit)", stiffness, 100.0 * stiffness / limit);
}

void printSummary(const Device& device, const ServoDesign& design, const Report& report) {
  const ServoWeights& w = design.weights;
  fmt::print("servo: Q = diag({:.4g} I, {:.4g} I, {:.4g} I) for q', q, integral; R = {:.4g} I; period {:.6g} s\n",
             w.velocity, w.position, w.integral, w.torque, design.period);
  fmt::print("linear model: relative error {:.0e} (estimated)\n", device.linear.error);
  fmt::print("closed loop: spectral radius {:.4f}, fastest pole {:.0f} rad/s, slowest {:.3g} rad/s\n", report.radius,
             std::abs(report.poles.front()), std::abs(report.poles.back()));
  const Margins& m = report.margins;
  fmt::print("disk margin: {:.3f} at {:.0f} rad/s\n", m.disk, m.diskFrequency);
  fmt::print("delay: stable up to {} samples (spectral radius {:.3f} at {})\n", m.toleratedDelay, m.radiusBeyond,
             m.toleratedDelay + 1);
  if (const auto judged = judgeServo(device.problem, 0, w))
    fmt::print("first impact, {:.0f} N: {}; chatter {:.3f} N m (encoders, differenced velocity)\n", kPush,
               stiffnessText(device, judged->stiffness, 0), judged->chatter);
  fmt::print("\n{:<6} {:>10} {:>10} {:>10}\n", "input", "gain up", "gain down", "phase deg");
  for (std::size_t i = 0; i < m.channel.size(); ++i)
    fmt::print("q{:<5} {:>10.3f} {:>10.4f} {:>10.1f}\n", i + 1, m.channel[i].gainUp, m.channel[i].gainDown,
               m.channel[i].phase * 180.0 / M_PI);
  fmt::print("\n{:<48} {:>10} {:>8} {:<4} {}\n", "Table II (worst of joints or axes)", "measured", "limit", "", "");
  for (const Requirement& r : report.requirements)
    fmt::print("{:<48} {:>10.4g} {:>8.4g} {:<4} {}\n", r.name, r.worst(), r.limit, r.unit, r.met() ? "met" : "NOT MET");
}

// One line of the trade-off; returns the servo.
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
  const double limit = firstImpactLimit(device.plant.effectiveMass, device.problem.period, required.delay, kPush,
                                        device.plant.largestForce);
  fmt::print("{:>5} {:>8} {:>11.4g} {:>7.0f} {:>6} {:>7.3f} {:>9.4f}   {:<7} {:>10.3g} {:>10.3g} {:>10.3g}\n",
             required.delay, rows, tuned->stiffness, 100.0 * tuned->stiffness / limit, tuned->toleratedDelay,
             tuned->diskMargin, tuned->chatter, met, w.velocity, w.position, w.integral);
  return tuned;
}

std::optional<TunedServo> printTradeOff(const Device& device, const DesignOptions& options) {
  fmt::print(
      "Stiffest servos with disk margin >= {:.3g} and chatter <= {:.3g} N m, for each delay that acts in the loop.\n",
      options.required.diskMargin, options.required.chatter);
  fmt::print(
      "K_z1: {:.0f} N along -z, nominal linear model, exact measurements. Chatter: encoders, differenced velocity.\n",
      kPush);
  fmt::print(
      "Table II: + met, - not met: overshoot, rise, settling; then, under 10 N or 0.1 N m, deviation of joints,\n"
      "TCP position, TCP orientation. 'step': the first three were required (they are measured without delay).\n\n");
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
  const WallDevice wallDevice = wallDeviceOf(device.plant, options.damping, device.problem.period);
  std::string text = "delay_samples,stiffness_N_per_m,damping_Ns_per_m,stable,eq16_damping_Ns_per_m,eq16_met\n";
  const auto map = mapWallStability(wallDevice, stiffnesses, dampings, {0, 1, 2, 3});
  int stable = 0, passive = 0, broken = 0;
  for (const WallStability& entry : map) {
    text += fmt::format("{},{:.6g},{:.6g},{},{:.6g},{}\n", entry.wall.delay, entry.wall.stiffness, entry.wall.damping,
                        int{entry.stable}, entry.passiveDamping, int{entry.passive});
    stable += entry.stable;
    passive += entry.passive;
    broken += entry.passive && !entry.stable;
  }
  writeText(options.impedanceMap, text);
  fmt::print(
      "impedance wall: effective mass {:.3g} kg, mechanical damping {:.3g} N s/m: of {} walls {} are stable; {} "
      "meet eq. 16, of which {} (with delay) are unstable\n",
      wallDevice.mass, wallDevice.damping, map.size(), stable, passive, broken);
}

void run(const DesignOptions& options) {
  if (options.output.empty() && !options.tune && options.impedanceMap.empty())
    throw Error("nothing to do: give --output, --tune or --impedance-map");
  const Device device = makeDevice(options);
  if (!options.impedanceMap.empty()) writeImpedanceMap(options, device);
  ServoDesign design;
  if (options.tune) {
    auto tuned = printTradeOff(device, options);
    if (options.output.empty()) return;
    if (!tuned) throw Error("no servo meets the requirements: nothing is written");
    fmt::print("\n");
    design = tuned->design;
  } else if (!options.output.empty()) {
    design = designServo(device.problem.plant, device.problem.period, options.weights);
  } else {
    return;
  }
  const Report report = reportOn(design, device);
  writeText(options.output, jsonOf(options, device, design, report).dump(1) + "\n");
  printSummary(device, design, report);
}

}  // namespace

void addDesign(CLI::App& app) {
  auto options = std::make_shared<DesignOptions>();
  CLI::App* command = app.add_subcommand(
      "design",
      "Position servo of a device: linearise, hold, Riccati; margins and Table II.\n"
      "--output writes the design (JSON: models, K, P, poles, margins, requirements). --tune searches the weights and\n"
      "prints how stiff the servo can be for each delay; with --output the servo of --delay is written.\n"
      "--impedance-map writes where an impedance wall is stable (CSV).");
  command->add_option("--device", options->device, "device file (TOML)")->required();
  command->add_option("--output", options->output, "where the design goes (JSON)");
  command->add_option("--rate", options->rate, "ticks per second, Hz")
      ->check(CLI::Range(10.0, 100000.0))
      ->capture_default_str();
  command->add_option("--q-velocity", options->weights.velocity, "weight of q'")->capture_default_str();
  command->add_option("--q-position", options->weights.position, "weight of q")->capture_default_str();
  command->add_option("--q-integral", options->weights.integral, "weight of the integral of the error")
      ->capture_default_str();
  command->add_option("--r", options->weights.torque, "weight of the torque")->capture_default_str();
  command->add_option("--at", options->at, "operating point: TCP position x,y,z, m")
      ->delimiter(',')
      ->expected(3)
      ->capture_default_str();
  command->add_flag("--tune", options->tune, "search the weights (they are then not read)");
  command->add_option("--disk-margin", options->required.diskMargin, "--tune: least disk margin")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  command->add_option("--chatter", options->required.chatter, "--tune: largest chatter, N m")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--delay", options->required.delay, "--tune: delay of the servo to write, samples")
      ->check(CLI::Range(0, kLargestDelay))
      ->capture_default_str();
  command->add_flag("--step-response", options->required.stepResponse,
                    "--tune: the servo to write meets the step-reference rows of Table II");
  command->add_option("--impedance-map", options->impedanceMap, "where the stability map goes (CSV)");
  command->add_option("--damping", options->damping, "--impedance-map: mechanical damping of the TCP, N s/m")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
