#include "design_surface.hpp"

#include <fmt/core.h>

#include <filesystem>

#include "enamel/device/device_file.hpp"
#include "enamel/render/surface_file.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/surface_design.hpp"

namespace enamel::app {
namespace {

constexpr std::uint32_t kFinalTrial = 40000;  // random numbers that the search has not seen

void printHead() {
  fmt::print("{:<12} {:>9} {:>8} {:>8} {:>9} {:>10} {:>10} {:>8} {:>10} {:>5}\n", "", "K_z1 N/m", "% limit", "% worst",
             "chatter", "bounce um", "impact um", "ramp um", "deepest um", "lost");
}

void printScore(const std::string& name, const SurfaceScore& s) {
  fmt::print("{:<12} {:>9.0f} {:>8.1f} {:>8.1f} {:>9.4f} {:>10.0f} {:>10.0f} {:>8.0f} {:>10.0f} {:>5}\n", name,
             s.stiffness, 100.0 * s.share, 100.0 * s.lowestShare, s.chatter, 1e6 * s.bounce, 1e6 * s.impact,
             1e6 * s.ramp, 1e6 * s.deepest, s.lost);
  std::fflush(stdout);
}

}  // namespace

std::string designSurface(const SurfaceDesignOptions& options) {
  const int threads = options.threads > 0 ? options.threads : availableThreads();
  SurfaceDesignSetup setup;
  setup.plant = makeMechanism(loadDevice(options.device));
  setup.period = options.period;
  setup.delay = options.delay;
  setup.inertiaError = options.inertiaError;
  setup.halfWidth = options.halfWidth;
  setup.chatter = options.chatter > 0.0 ? options.chatter : 0.025 * setup.plant->limits().torque.minCoeff();
  setup.seed = options.seed;
  setup = withinMotors(setup);
  const SurfaceServoOptions start =
      surfaceServoFor(setup.plant->limits().count, options.period, options.delay.low, options.delay.high);

  fmt::print("surface servo for {}: delay {}..{} ticks of {:.6g} s, inertia wrong by up to {:.0f} %\n",
             setup.plant->name(), options.delay.low, options.delay.high, options.period, 100.0 * options.inertiaError);
  fmt::print(
      "pushes of {:.4g} to {:.4g} N inside a tick after {:.4g} N, at the wall's centre and corners; encoders, noise "
      "{:.4g} N\n'% limit': K_z1 as a share of what physics allows, lowest of the points' means; '% worst': lowest "
      "run\n\n",
      setup.lowestForce, setup.highestForce, setup.preload, setup.noise);
  printHead();
  const SurfaceServoOptions best =
      designSurfaceServo(setup, start, options.generations, threads, [](int generation, const SurfaceScore& score) {
        if (generation % 10 == 0) printScore(fmt::format("search {}", generation), score);
      });

  // The trade-off: stiffer or quieter by the observer's trust in the push's constancy.
  SurfaceDesignSetup judged = setup;
  judged.runs = 3 * setup.runs;
  fmt::print("\non new random numbers, and with another `wander` (what the observer expects of the push):\n");
  printHead();
  for (const double factor : {0.25, 0.5, 2.0, 4.0}) {
    SurfaceServoOptions other = best;
    other.wander *= factor;
    printScore(fmt::format("wander x {}", factor), judgeSurfaceServo(judged, other, kFinalTrial, threads));
  }
  printScore("start", judgeSurfaceServo(judged, start, kFinalTrial, threads));
  printScore("this servo", judgeSurfaceServo(judged, best, kFinalTrial, threads));
  fmt::print("\n");
  for (const SurfaceServoParameter& p : surfaceServoParameters())
    fmt::print("{:<17} {:.6g}{}\n", p.name, best.*p.value, p.unit);
  return surfaceServoText({std::filesystem::path(options.device).filename().string(), best});
}

}  // namespace enamel::app
