#include "enamel/identify/identify.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>

#include "commands.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/identify/device_text.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/runtime/recorder.hpp"
#include "enamel/session/open_device.hpp"
#include "enamel/study/parallel.hpp"
#include "identify_report.hpp"
#include "plant_option.hpp"
#include "program/interrupt.hpp"
#include "program/outputs.hpp"
#include "program/plugin_folder.hpp"
#include "renderer_option.hpp"

namespace enamel::app {
namespace {

struct IdentifyOptionsOfCommand {
  std::vector<std::string> recordings, weighted;
  std::string device, output, plan, record, truth, plant, delay = "none", connect, report;
  bool makesPlan = false, overwrite = false;
  ExcitationOptions excitation;
  double rate_Hz = 1000.0, weight = 0.0;
  std::uint64_t seed = 1;
};

std::string absolute(const std::string& path) {
  return std::filesystem::absolute(std::filesystem::u8path(path)).u8string();
}

// Percentage of a half interval, for people.
std::string precisionOf(const Estimate& e) {
  const double half = 0.5 * (e.high - e.low);
  if (!e.isSeen) return "not seen";
  return e.value != 0.0 ? fmt::format("+- {:.2g} %", 100.0 * half / std::abs(e.value))
                        : fmt::format("+- {:.2g} {}", half, e.unit);
}

void makePlan(const IdentifyOptionsOfCommand& options) {
  const DeviceParameters device = loadDevice(options.device);
  ExcitationOptions how = options.excitation;
  how.period = 1.0 / options.rate_Hz;
  const Excitation excitation = designExcitation(*makeMechanism(device), how);
  const std::vector<Estimate> expected = expectedPrecision(excitation, device);
  writeFile(options.output, textOf(excitation));
  fmt::print(
      "{}: {} s; the guard limits the force to {:.3g} N, the tool to {:.3g} x {:.3g} x {:.3g} mm, its speed to "
      "{:.2g} m/s\nexpected 95 % intervals with the numbers of {}:\n",
      options.output, excitation.duration, excitation.force, 2e3 * excitation.workspace.x(),
      2e3 * excitation.workspace.y(), 2e3 * excitation.workspace.z(), excitation.speed, options.device);
  for (const Estimate& e : expected) fmt::print("  {:<34} {}\n", e.key, precisionOf(e));
}

RecordingHeader headerOf(const IdentifyOptionsOfCommand& options) {
  RecordingHeader header;
  header.deviceFile = absolute(options.device);
  header.deviceText = readFile(options.device);
  header.renderer = "impedance";
  return header;
}

// Run a plan on a virtual device, and record it.
void runPlan(const IdentifyOptionsOfCommand& options) {
  const Excitation excitation = loadExcitation(options.plan);
  const DeviceParameters truth = loadDevice(options.truth);
  const std::shared_ptr<const Mechanism> believed = makeMechanism(loadDevice(options.device)),
                                         built = makeMechanism(truth);
  VirtualDeviceSetup setup;
  setup.period = excitation.period;
  setup.encoders = {true, RateSource::difference, 100.0};
  setup.delay = parseDelay(options.delay);
  setup.seed = options.seed;
  const MakePlant makeOne = makerOf(options.plant.empty() ? plantOf(truth) : options.plant, truth, setup);
  VirtualDevice device(makeOne ? makeOne(0) : std::make_unique<ClosedFormPlant>(*built), setup);
  NewRecording place(options.record, options.overwrite);
  std::optional<Recorder> recorder;
  const auto each = [&](std::uint64_t number, const Measurement& measurement, const HapticTick& haptics,
                        const Command& command, Status status) {
    if (!recorder) recorder.emplace(place.place(), headerOf(options), haptics);
    recorder->makeRoom();
    Measurement seen = measurement;
    seen.applied.reset();  // most devices do not report it
    recorder->add(number, seen, haptics, command, status);
  };
  const auto nothing = [](double, const Pose&, const Vec6&) { return Vec6(Vec6::Zero()); };
  const GuardReason reason = runExcitation(excitation, *believed, device, nothing, each);
  const RecordingResult recorded = recorder->close();
  if (!recorded.problem.empty()) throw Error(recorded.problem);
  place.keep();
  fmt::print("recording: {}, {} ticks\n", options.record, recorded.ticks);
  if (reason != GuardReason::none)
    throw Error(
        fmt::format("the guard stopped the excitation at {:.3g} s: {}; make a plan with a smaller --share or "
                    "--speed",
                    device.time(), toString(reason)));
}

// Play a plan on a device in real time, and record it.
void playPlan(const IdentifyOptionsOfCommand& options) {
  const Excitation excitation = loadExcitation(options.plan);
  const std::shared_ptr<const Mechanism> mechanism = makeMechanism(loadDevice(options.device));
  OpenDeviceOptions open;
  open.period = excitation.period;
  open.pluginFolder = pluginFolder();
  const OpenedDevice opened = openDevice(options.connect, open);
  if (opened.mechanism->joints() != mechanism->joints())
    throw Error(fmt::format("{} has {} joints, {} has {}", options.connect, opened.mechanism->joints(), options.device,
                            mechanism->joints()));
  ImpedanceRenderer renderer({100.0, 0.0});  // without a wall: balances gravity
  const Scene scene;
  const Tool tool;
  HapticTick haptics(*mechanism, scene, tool, renderer, guardFor(*mechanism, excitation));
  removeOld(options.record, options.overwrite);
  Recorder recorder(options.record, headerOf(options), haptics);
  ExcitationPlayer player(excitation, haptics, &recorder);
  HapticLoopOptions how;
  how.period = opened.poll;
  how.sink = &player;
  const InterruptGuard interruptions(InterruptGuard::Second::isIgnored);
  {
    const HapticLoop loop(*opened.device, haptics, how);
    while (!player.isOver() && interruption() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const RecordingResult recorded = recorder.close();
  if (!recorded.problem.empty()) throw Error(recorded.problem);
  fmt::print("recording: {}, {} ticks, {} lost\n", options.record, recorded.ticks, recorded.lost);
  if (const GuardReason reason = haptics.guard().fault(); reason != GuardReason::none)
    throw Error(fmt::format("the guard stopped the excitation: {}; make a plan with a smaller --share or --speed",
                            toString(reason)));
}

void estimate(const IdentifyOptionsOfCommand& options) {
  const std::string text = readFile(options.device);
  const DeviceParameters device = parseDevice(text, options.device);
  const int joints = makeMechanism(device)->joints();
  std::vector<RecordedMotion> motions;
  for (const std::string& file : options.recordings)
    for (RecordedMotion& motion : loadMotions(file, joints)) motions.push_back(std::move(motion));
  for (const std::string& file : options.weighted)
    for (RecordedMotion& motion : loadMotions(file, joints)) {
      motion.weight = options.weight;
      motions.push_back(std::move(motion));
    }
  const Identification result = identifyDevice(motions, device);
  if (!options.report.empty()) {
    std::vector<std::string> files = options.recordings;
    files.insert(files.begin(), options.device);
    files.insert(files.end(), options.weighted.begin(), options.weighted.end());
    std::vector<WallExpectation> expected;
    if (result.isUsable())
      expected = expectWall(result.device, motions.front().period, std::max(2, result.delay.high), availableThreads());
    writeFile(options.report, identificationReport(result, files, expected));
    fmt::print("report: {}\n", options.report);
  }
  if (!result.isUsable()) {
    std::string problems;
    for (const std::string& problem : result.problems) problems += (problems.empty() ? "" : "; ") + problem;
    throw Error("no device file is written: " + problems);
  }
  writeFile(options.output, identifiedText(text, result));
  fmt::print("{}", tableOf(result));
  for (Eigen::Index i = 0; i < result.explained.size(); ++i)
    fmt::print("torque {}: {:.2f} % of the variance below 20 Hz is explained\n", i + 1, 100.0 * result.explained[i]);
  fmt::print("device file: {}\n", options.output);
}

void run(const IdentifyOptionsOfCommand& options) {
  const int modes = (options.makesPlan ? 1 : 0) + (options.plan.empty() ? 0 : 1) + (options.recordings.empty() ? 0 : 1);
  if (modes != 1) throw Error("give one of --plan, --run PLAN, or recordings");
  const int devices = (options.truth.empty() ? 0 : 1) + (options.connect.empty() ? 0 : 1);
  if (devices != (options.plan.empty() ? 0 : 1)) throw Error("--run needs either --virtual or --connect");
  if (options.plan.empty() == !options.record.empty()) throw Error("--record is for --run, which needs it");
  if (!options.report.empty() && options.recordings.empty()) throw Error("--report is for recordings");
  if (options.plan.empty() == options.output.empty()) throw Error("--output is needed, but not with --run");
  if (options.makesPlan) return makePlan(options);
  if (options.plan.empty()) return estimate(options);
  options.connect.empty() ? runPlan(options) : playPlan(options);
}

}  // namespace

void addIdentify(CLI::App& app) {
  auto options = std::make_shared<IdentifyOptionsOfCommand>();
  CLI::App* command = app.add_subcommand(
      "identify",
      "Estimates masses, friction, cables, delay and other numbers of a device from recordings, and writes a device\n"
      "file with them. --plan designs a motion that shows these numbers; --run plays it on a device.\n"
      "Step by step: lib/docs/identify.md.");
  command->add_option("recordings", options->recordings, "recordings of the device in free motion");
  command->add_option("--device", options->device, "device file (TOML); its numbers may be wrong")->required();
  command->add_option("--output", options->output, "device file with the estimates, or the plan");
  CLI::Option* weight = command->add_option("--weight", options->weight, "known mass that was attached at the TCP, kg")
                            ->check(CLI::Range(1e-3, 10.0));
  CLI::Option* weighted = command->add_option("--weighted", options->weighted,
                                              "recordings with --weight attached: they show the scale of all forces");
  weight->needs(weighted);
  weighted->needs(weight);
  command->add_flag("--plan", options->makesPlan, "design an excitation, and print the expected precision");
  command->add_option("--duration", options->excitation.duration, "duration of the plan, s")->capture_default_str();
  command->add_option("--rate", options->rate_Hz, "rate of the ticks, Hz")
      ->check(CLI::Range(500.0, 10000.0))
      ->capture_default_str();
  command->add_option("--share", options->excitation.share, "largest share of the motors' torque for fast forces")
      ->capture_default_str();
  command->add_option("--speed", options->excitation.speed, "largest speed of the slow motion, m/s")
      ->capture_default_str();
  command->add_option("--report", options->report,
                      "page (HTML) with the estimates, predictions and the wall to expect");
  command->add_option("--run", options->plan, "plan to play");
  command->add_option("--record", options->record, "file for the recording of --run");
  command->add_option("--virtual", options->truth, "device file of the virtual device of --run: the true numbers");
  command->add_option("--connect", options->connect, "URL of the device of --run; enamel devices lists the forms");
  command->add_option("--plant", options->plant, kPlantHelp)
      ->check(CLI::Validator(checkPlant, ""))
      ->default_str("imperfect if the file of --virtual has [imperfections]");
  command->add_option("--delay", options->delay, "delay of the virtual device, ticks: none, constant:D or random:A..B")
      ->capture_default_str();
  command->add_option("--seed", options->seed, "seed of all random numbers")->capture_default_str();
  addOverwrite(*command, options->overwrite, {"--output", "--report"});
  command->callback([options] {
    options->excitation.seed = options->seed;
    run(*options);
  });
}

}  // namespace enamel::app
