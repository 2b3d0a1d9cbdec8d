#include "enamel/runtime/replay.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "commands.hpp"
#include "enamel/collision/solid_file.hpp"
#include "enamel/core/error.hpp"
#include "program/outputs.hpp"
#include "program/plugin_folder.hpp"
#include "program/program.hpp"
#include "program/recorded.hpp"
#include "replay_page.hpp"

namespace enamel::app {
namespace {

struct ReplayOptions {
  std::string file, renderer, html, beside, solid;
  std::vector<std::string> set;
  std::uint64_t from = 0;
  bool overwrite = false;
};

std::string valueOf(const std::string& what, double value) {
  if (what == "status") return toString(static_cast<Status>(value));
  if (what == "guard's reason") return toString(static_cast<GuardReason>(value));
  if (what == "mode") return toString(static_cast<RenderMode>(value));
  return fmt::format("{}", value);
}

std::string differenceText(const ReplayDifference& d) {
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

// A recording and the loop that replays it. The bur of its scene cuts as it did in the recording.
struct Replayed {
  RecordingReader recording;
  std::shared_ptr<const Mechanism> device;
  SceneFile scene;
  std::unique_ptr<Renderer> renderer;
  std::optional<Drill> drill;
  HapticTick tick;

  Replayed(const std::string& file, const std::string& other, const std::vector<std::string>& set)
      : recording(file),
        device(recordedDevice(recording.header())),
        scene(recordedScene(recording.header())),
        renderer(recordedRenderer(recording.header(), device, scene.scene, other, parseParameters(set))),
        tick(*device, scene.scene, scene.tool, *renderer, recording.header().guard, recording.header().start) {
    if (scene.bur) tick.attach(&drill.emplace(scene.tool, scene.solids, *scene.bur));
  }
};

// Replay a recording. If a page is written, append its side of the page.
ReplayResult play(Replayed& run, std::uint64_t from, const std::string& title, bool isAsked, PageNumbers& numbers,
                  std::vector<nlohmann::json>* sides) {
  if (sides == nullptr) return replay(run.recording, run.tick, from);
  PageSide side(title, run.recording.header(), run.scene, run.drill ? &*run.drill : nullptr, isAsked);
  const ReplayResult result =
      replay(run.recording, run.tick, from,
             [&](const RecordedTick& recorded, const HapticTick& tick) { side.see(recorded, tick); });
  sides->push_back(side.finish(numbers));
  return result;
}

std::shared_ptr<const Solid> onlySolid(const SceneFile& scene, const std::string& file) {
  std::shared_ptr<const Solid> found;
  for (const auto& solid : scene.solids) {
    if (solid && found) throw Error(file + ": --solid needs a scene with one solid, this one has several");
    if (solid) found = solid;
  }
  if (!found) throw Error(file + ": --solid needs a scene with a solid");
  return found;
}

void run(const ReplayOptions& options) {
  const bool hasPage = !options.html.empty(), isOther = !options.renderer.empty() || !options.set.empty();
  if (!options.beside.empty() && !hasPage) throw Error("--beside needs --html");
  if (!options.beside.empty() && isOther) throw Error("--beside cannot be combined with --renderer or --set");
  if (hasPage) checkReplayPage();
  for (const auto& [name, output] : {std::pair("--html", options.html), std::pair("--solid", options.solid)}) {
    for (const std::string& recording : {options.file, options.beside})
      if (std::error_code none;
          !output.empty() &&
          std::filesystem::equivalent(std::filesystem::u8path(output), std::filesystem::u8path(recording), none))
        throw Error(std::string(name) + " must be another file than the recording " + output);
    requireFree(output, options.overwrite);
  }
  std::vector<nlohmann::json> sides;
  PageNumbers numbers;
  if (hasPage && isOther) {  // show the recorded renderer beside the other one
    Replayed recorded(options.file, "", {});
    play(recorded, options.from, recorded.recording.header().renderer, false, numbers, &sides);
  }
  Replayed run(options.file, options.renderer, options.set);
  const std::shared_ptr<const Solid> solid = options.solid.empty() ? nullptr : onlySolid(run.scene, options.file);
  const RecordingHeader& header = run.recording.header();
  const std::string name =
      options.renderer.empty() ? header.renderer : std::filesystem::u8path(options.renderer).stem().u8string();
  const ReplayResult result = play(run, options.from, name, isOther, numbers, hasPage ? &sides : nullptr);
  std::string damage;
  if (!options.beside.empty()) {
    Replayed other(options.beside, "", {});
    const ReplayResult seen = play(other, 0, other.recording.header().renderer, false, numbers, &sides);
    if (seen.damaged > 0) damage = options.beside + ": damaged: " + seen.damage;
  }

  fmt::print("{}: {} on {}, {} s a tick; {} ticks compared, {}\n", options.file, header.renderer, run.device->name(),
             header.guard.period, result.ticks,
             result.states ? "with the renderer's states" : "without the renderer's states (their size differs)");
  if (result.lost > 0) fmt::print("{} ticks were lost during the recording\n", result.lost);
  if (result.restored > 0) fmt::print("{} times the replay continues from a recorded state\n", result.restored);
  if (result.damaged > 0) fmt::print("{} chunks cannot be read: {}\n", result.damaged, result.damage);
  if (!result.closed) fmt::print("the recording was not closed: it ends with its last whole chunk\n");
  if (result.ticks == 0) throw Error(options.file + ": no tick could be compared");
  if (hasPage) {
    writeReplayPage(options.html, sides, numbers);
    fmt::print("page: {}, {:.1f} MB\n", options.html,
               1e-6 * static_cast<double>(std::filesystem::file_size(std::filesystem::u8path(options.html))));
  }
  if (solid) saveSolid(*solid, options.solid);
  if (result.damaged > 0) damage = options.file + ": damaged: only the ticks that could be read were compared";
  if (result.different > 0)
    fmt::print("{} ticks differ, first {}\nlargest difference by joint, N m or N: requested torque {}; command {}\n",
               result.different, differenceText(*result.first), numbersOf(result.requested), numbersOf(result.command));
  if (!damage.empty()) throw Error(damage);
  if (result.different > 0) throw Exit(1, "");
  fmt::print("equal, bit for bit\n");
}

}  // namespace

void addReplay(CLI::App& app) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* command =
      app.add_subcommand("replay",
                         "Runs a renderer on the measurements of a recording (push --record). Compares the renderer's "
                         "answers, the guard's\noutput and the renderer's state bit for bit. The exit status is 0 if "
                         "all are equal, 1 if they differ or the\nrecording is damaged.");
  command->add_option("file", options->file, "recording")->required();
  command->add_option("--renderer", options->renderer,
                      "one renderer, as in enamel push; default: that of the recording");
  command
      ->add_option("--set", options->set,
                   "parameter of the renderer, KEY=VALUE, with the names of its plugin; the others are as recorded")
      ->allow_extra_args(false);
  command->add_option("--from", options->from, "first chunk (128 ticks each, counted from 0)")->capture_default_str();
  command->add_option("--html", options->html,
                      "file for a page that plays the recording in a browser without other files; with --renderer or "
                      "--set it also shows the answers of that renderer");
  command->add_option("--beside", options->beside, "another recording for the right half of the page");
  command->add_option("--solid", options->solid, "file (.solid) for the scene's solid as the bur has cut it");
  addOverwrite(*command, options->overwrite);
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
