#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>

#include "data_folder.hpp"
#include "program/outputs.hpp"
#include "program/plugin_folder.hpp"
#include "program/program.hpp"
#include "run.hpp"
#include "script.hpp"

namespace {

using namespace enamel::viewer;

constexpr const char* kProgram = "enamel-viewer";

void runViewer(int argc, char** argv) {
  const double started = steadySeconds();
  CLI::App app{
      "Push the tool of a virtual TAU against a wall and see what stiff means. F1 in the window lists every key;\n"
      "V shows two renderers under one hand, T a tour of that, which the first start shows by itself.\n"
      "Lengths in scripts are mm; W has x right, y up, z from the wall to the user."};
  Options options;
  options.scene = dataFolder() + "/scenes/flat-wall.toml";
  options.device = dataFolder() + "/devices/tau-nominal.toml";
  std::string renderer, size = "1280x720";
  std::vector<std::string> set;
  CLI::Option* const live[] = {
      app.add_option("scene", options.scene, "scene file (TOML)"),
      app.add_option("--device", options.device, "device file (TOML)"),
      app.add_option(
          "--renderer", renderer,
          "the renderer to begin with: position-control (slides, never pulls; default), impedance, hold "
          "(the paper's controller), passivity (the spring with passivity control), or the name or path of a "
          "plugin, which takes the place of one of its name"),
      app.add_option("--gain", options.gain,
                     "file of enamel design --output: the servo of hold, which is then begun with"),
      app.add_option("--set", set, "parameter of the plugin, KEY=VALUE; once a parameter")->allow_extra_args(false)};
  CLI::Option* const play = app.add_option("--play", options.play, "recording to look at, instead of a run");
  for (CLI::Option* const option : live) play->excludes(option);
  CLI::Option* const headless =
      app.add_flag("--headless", options.headless, "no display: run the script on simulated time");
  app.add_option("--script", options.script, "what to do, with times");
  app.add_option("--record", options.record, "folder for pictures (made if it is missing)");
  app.add_option("--report", options.report,
                 "how the run went: frame rate, timing, memory (JSON); written at the end and at each SIGUSR1");
  app.add_option("--size", size, "WIDTHxHEIGHT of the picture");
  app.add_option("--scale", options.scale, "pixels per unit of layout, headless")->check(CLI::Range(1.0, 4.0));
  app.add_option("--frame-rate", options.frameRate, "pictures a second of the window, at most (60)")
      ->check(CLI::Range(1.0, 240.0))
      ->excludes(headless);
  app.add_flag("--fixed-step", options.fixedStep,
               "a second of the script is so many pictures of the window as --frame-rate says, however long they take")
      ->excludes(headless);
  enamel::app::addOverwrite(app, options.overwrite, {"--report"});
  if (!enamel::app::parse(app, kProgram, argc, argv)) return;
  const auto linked = rendererNames(nullptr);
  const auto found = std::find(linked.begin(), linked.end(), renderer);
  if (renderer.empty()) {
    if (!options.gain.empty()) options.begin = RendererSlot::hold;
  } else if (found != linked.end()) {
    options.begin = static_cast<RendererSlot>(found - linked.begin());
  } else {
    options.plugin = enamel::findPlugin(renderer, enamel::app::pluginFolder());
    options.pluginParameters = enamel::app::parseParameters(set);
    options.begin = slotOf(*options.plugin);
    if (!options.gain.empty() && options.begin == RendererSlot::hold)
      throw enamel::Error("--gain " + options.gain + " is for the linked " + linked[indexOf(RendererSlot::hold)] +
                          ", whose place the plugin takes");
  }
  if (!options.plugin && !set.empty()) throw enamel::Error("--set is for plugins, and --renderer names none");
  try {
    options.size = parseSize(size);
  } catch (const enamel::Error& error) {
    throw enamel::app::Exit(2, std::string("--size ") + error.what());
  }
  if (const int signal = options.headless ? runHeadless(options, started) : runInWindow(options, started); signal != 0)
    throw enamel::app::Exit(128 + signal, "");  // exit status as in a shell
}

}  // namespace

int main(int argc, char** argv) {
  return enamel::app::runProgram(kProgram, [&] { runViewer(argc, argv); });
}
