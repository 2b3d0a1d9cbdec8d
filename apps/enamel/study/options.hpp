// Settings and options that `enamel study` and `enamel compare` share.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "enamel/sim/push.hpp"
#include "plant_option.hpp"
#include "renderer_option.hpp"

namespace CLI {
class App;
}

namespace enamel::app {

/// Name of hold with a servo designed at every query point instead of once at home (gain scheduling).
inline constexpr const char* kScheduled = "hold-scheduled";
/// Name of a spring with ticks of a quarter period, nearly as stiff as eq. 16 allows: K = 0.95 * 2 b / T for a device
/// damping b.
inline constexpr const char* kEdge = "impedance-edge";
inline constexpr const char* kBestSpring = "best-spring";
/// "tuned:NAME": a rival (rivalSpecs()) with the parameters that --tuned has for the delay.
inline constexpr const char* kTuned = "tuned:";

struct StudyOptions {
  std::string scene;  ///< empty: the wall z = 0
  std::string device, designDevice, gain, tuned, output, delay = "none", plant = kClosedForm;
  std::vector<std::string> set;                              ///< parameters of plugins
  std::vector<std::string> deviceDamping = {"impedance=4"};  ///< B, or NAME=B ...; the paper's baseline has 4 N s/m
  std::vector<int> scenarios = {1, 2};
  std::vector<std::string> renderers = {kPositionControl, kHold, kImpedance};
  int runs = 20, grid = 11, threads = 0;
  std::uint64_t seed = 1;
  std::vector<double> tip_mm{0.0, 0.0, 0.0};
  double preload = 0.0;                     ///< N
  double noise = HandModel().noise;         ///< standard deviation of the person's force, N
  double inertia = 1.0;                     ///< inertia of the renderers' model, relative to the plant's
  std::vector<double> force = {8.0, 15.0};  ///< range of the uniformly distributed F_c, N
  ImpedanceOptions impedance;               ///< of the renderers impedance and passivity
  bool arm = false;                         ///< scenario 1 pushes through an arm
  bool rest = false;                        ///< a finger rests on a tooth (kFingerRest)
  bool insideTick = false;                  ///< the step comes at a random instant within its tick
  bool encoders = false, resume = false, overwrite = false;
  int part = 1, parts = 1;                ///< this process performs part `part` of `parts` of the runs
  bool convergence = true, whole = true;  ///< perform the convergence study; everything else
  bool guard = true;                      ///< run the guard in the loop
  std::vector<std::string> arguments;     ///< of the command, as argumentsOf()
  bool release = false;                   ///< the hold ends when the wall would pull; the paper's hold never ends
};

/// Add the options that both commands have; their defaults are the values of `options`.
void addStudyOptions(CLI::App& command, const std::shared_ptr<StudyOptions>& options);

/// Derive the part from the rank if Open MPI started the process and --part is not given.
void takeRank(const CLI::App& command, StudyOptions& options);

/// Return the given options of a command in its own order, except those that do not change the results: --output,
/// --threads, --part, --resume, --overwrite.
std::vector<std::string> argumentsOf(const CLI::App& command);

/// Return a command as one types it in a shell.
std::string shellText(const std::string& command, const std::vector<std::string>& arguments);

/// Repeat a sample of the runs in a study's folder and compare all bits. Throws Error: another study, a difference.
void verifyStudy(StudyOptions options);

/// Perform the study and write its folder. Throws Error, and Exit after a signal.
void runStudy(StudyOptions options);

}  // namespace enamel::app
