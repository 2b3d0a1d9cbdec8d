#include "enamel/runtime/replay.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "commands.hpp"
#include "enamel/core/error.hpp"
#include "plugin_folder.hpp"
#include "program.hpp"
#include "recorded.hpp"

namespace enamel::app {
namespace {

struct ReplayOptions {
  std::string file, renderer;
  std::vector<std::string> set;
  std::uint64_t from = 0;
};

std::string valueOf(const std::string& what, double value) {
  if (what == "status") return toString(static_cast<Status>(value));
  if (what == "guard's reason") return toString(static_cast<GuardReason>(value));
  if (what == "mode") return toString(static_cast<RenderMode>(value));
  return fmt::format("{}", value);
}

std::string textOf(const ReplayDifference& d) {
  std::string text = fmt::format("tick {} ({} s): {}", d.tick, d.time, d.what);
  if (d.joint >= 0) text += fmt::format(" of joint {}", d.joint + 1);
  if (d.joint < 0 && std::isnan(d.recorded) && std::isnan(d.replayed)) return text;  // a state has no number
  return text + fmt::format(": recorded {}, replayed {}", valueOf(d.what, d.recorded), valueOf(d.what, d.replayed));
}

std::string numbersOf(const JointVector& v) {
  std::string text;
  for (const double value : v) text += fmt::format("{}{:.3g}", text.empty() ? "" : ", ", value);
  return text;
}

void run(const ReplayOptions& options) {
  RecordingReader recording(options.file);
  const RecordingHeader& header = recording.header();
  const auto device = recordedDevice(header);
  const SceneFile scene = recordedScene(header);
  const auto renderer = recordedRenderer(header, device, scene.scene, options.renderer, parseParameters(options.set));
  HapticTick tick(*device, scene.scene, scene.tool, *renderer, header.guard, header.start);
  const ReplayResult result = replay(recording, tick, options.from);

  fmt::print("{}: {} on {}, {} s a tick; {} ticks compared, {}\n", options.file, header.renderer, device->name(),
             header.guard.period, result.ticks,
             result.states ? "with the renderer's states" : "without the renderer's states (of another size)");
  if (result.lost > 0) fmt::print("{} ticks were lost when it was recorded\n", result.lost);
  if (result.restored > 0) fmt::print("{} times it goes on from a recorded state\n", result.restored);
  if (result.damaged > 0) fmt::print("{} chunks cannot be read: {}\n", result.damaged, result.damage);
  if (!result.closed) fmt::print("it was not closed: it ends with its last whole chunk\n");
  if (result.ticks == 0) throw Error(options.file + ": no tick could be compared");
  if (result.different == 0) {
    fmt::print("equal, bit for bit\n");
    return;
  }
  fmt::print("{} ticks differ, first {}\nlargest difference by joint, N m or N: requested torque {}; command {}\n",
             result.different, textOf(*result.first), numbersOf(result.requested), numbersOf(result.command));
  throw Exit(1, "");
}

}  // namespace

void addReplay(CLI::App& app) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command = app.add_subcommand("replay",
                                         "Runs a renderer on the measurements of a recording (push --record) and "
                                         "compares bit for bit what it answers, what\n"
                                         "the guard made of it, and the renderer's state. Status 0: equal; 1: not.");
  command->add_option("file", options->file, "recording")->required();
  command->add_option("--renderer", options->renderer,
                      "as of enamel push, one of them; without it that of the recording");
  command
      ->add_option("--set", options->set,
                   "parameter of the renderer, KEY=VALUE, as of its plugin; the others as recorded")
      ->allow_extra_args(false);
  command->add_option("--from", options->from, "chunk to begin with (128 ticks each, counted from 0)")
      ->capture_default_str();
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
