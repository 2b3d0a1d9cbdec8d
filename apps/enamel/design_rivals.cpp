#include "design_rivals.hpp"

#include <fmt/core.h>

#include <filesystem>

#include "enamel/device/device_file.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/study/controllers.hpp"
#include "enamel/study/parallel.hpp"
#include "plant_option.hpp"

namespace enamel::app {
namespace {

constexpr std::uint32_t kFinalTrial = 40000;  // random numbers that the search has not used

void printHead() {
  fmt::print("{:<12} {:>9} {:>8} {:>8} {:>9} {:>10} {:>10} {:>8} {:>8} {:>10} {:>5}\n", "", "K_z1 N/m", "% limit",
             "% worst", "chatter", "bounce um", "impact um", "ramp um", "drift um", "deepest um", "lost");
}

void printScore(const std::string& name, const WallScore& s) {
  fmt::print("{:<12} {:>9.0f} {:>8.1f} {:>8.1f} {:>9.4f} {:>10.0f} {:>10.0f} {:>8.0f} {:>8.0f} {:>10.0f} {:>5}\n", name,
             s.stiffness, 100.0 * s.share, 100.0 * s.lowestShare, s.chatter, 1e6 * s.bounce, 1e6 * s.impact,
             1e6 * s.ramp, 1e6 * s.drift, 1e6 * s.deepest, s.lost);
  std::fflush(stdout);
}

WallDesignSetup setupOf(const RivalSearchOptions& options) {
  WallDesignSetup setup;
  const DeviceParameters parameters = loadDevice(options.device);
  setup.plant = makeMechanism(modelFor(options.plant, parameters));
  VirtualDeviceSetup device;
  device.seed = options.seed;
  setup.makePlant = makerOf(options.plant, parameters, device);
  setup.jitter = device.jitter;
  setup.lostSamples = device.lostSamples;
  setup.period = options.period;
  setup.halfWidth = options.halfWidth;
  setup.chatter = options.chatter > 0.0 ? options.chatter : 0.025 * setup.plant->limits().effort.minCoeff();
  setup.runs = options.runs;
  if (!options.scene.empty()) setup.scene = loadScene(options.scene);
  setup.seed = options.seed;
  return withinMotors(setup);
}

int threadsOf(const RivalSearchOptions& options) { return options.threads > 0 ? options.threads : availableThreads(); }

void printTask(const WallDesignSetup& setup) {
  fmt::print(
      "pushes of {:.4g} to {:.4g} N inside a tick after {:.4g} N, at the wall's centre and corners; encoders, noise "
      "{:.4g} N\nbounds: chatter {:.3g} (--chatter), bounce {:.0f} um\n'% limit': K_z1 as a share of the physical "
      "limit, lowest of the points' means; '% worst': the same of the lowest run\n\n",
      setup.lowestForce, setup.highestForce, setup.preload, setup.noise, setup.chatter, 1e6 * setup.bounce);
  printHead();
}

std::string ticksText(const Delay& delay) {
  return delay.low == delay.high ? fmt::format("{}", delay.low) : fmt::format("{}..{}", delay.low, delay.high);
}

}  // namespace

std::string designRivals(const RivalSearchOptions& options) {
  const int threads = threadsOf(options);
  WallDesignSetup setup = setupOf(options);
  fmt::print("rivals on {}, each the best of {} generations, evaluated with new random numbers\n", setup.plant->name(),
             options.generations);
  printTask(setup);
  ControllerFile file{std::filesystem::u8path(options.device).filename().u8string(), {}};
  for (const Delay& delay : {Delay{0, 0}, Delay{1, 1}, Delay{2, 2}, Delay{3, 3}, Delay{0, 3}}) {
    setup.delay = delay;
    fmt::print("delay {}\n", ticksText(delay));
    const auto print = [&](const std::string& name, const MakeRenderer& make) {
      WallDesignSetup thorough = setup;
      thorough.runs = 3 * setup.runs;
      printScore(name, evaluateWall(thorough, make, kFinalTrial, threads));
    };
    for (const ControllerSpec& spec : rivalSpecs()) {
      std::vector<double> start;
      for (const ControllerParameter& p : spec.parameters) start.push_back(p.start);
      ControllerValues values{spec.name, delay.low, delay.high, {}};
      values.values = designController(setup, spec, start, options.generations, threads, {});
      print(spec.name, spec.with({setup.plant, setup.period, delay}, values.values));
      std::string text;
      for (std::size_t i = 0; i < start.size(); ++i)
        text += fmt::format("  {} {:.4g} {}", spec.parameters[i].name, values.values[i], spec.parameters[i].unit);
      fmt::print("            {}\n", text);
      file.controllers.push_back(std::move(values));
    }
    const PositionControlOptions ours = positionControlFor(*setup.plant, options.period, delay.low, delay.high);
    print(kPositionControl, [ours] { return std::make_unique<PositionControlRenderer>(ours); });
  }
  return controllersText(file);
}

}  // namespace enamel::app
