#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>

#include "data_folder.hpp"
#include "enamel/session/open_device.hpp"
#include "program/outputs.hpp"
#include "program/plugin_folder.hpp"
#include "program/program.hpp"
#include "run.hpp"
#include "scan.hpp"
#include "script.hpp"

namespace {

using namespace enamel::viewer;

constexpr const char* kProgram = "enamel-viewer";

void runViewer(int argc, char** argv) {
  const double started = steadySeconds();
  CLI::App app{
      "Shows a virtual device whose tool you push against walls. F1 in the window lists every key. V shows two "
      "renderers\nunder one hand. T starts a tour of that; the first start shows it automatically.\nLengths in scripts "
      "are mm. Frame W: x right, y up, z from the wall to the user."};
  Options options;
  options.scene = dataFolder() + "/scenes/flat-wall.toml";
  options.device = dataFolder() + "/devices/tau-nominal.toml";
  std::string renderer, size = "1280x720";
  std::vector<std::string> set;
  CLI::Option* const live[] = {
      app.add_option("scene", options.scene, "scene file (TOML), a scan (PLY, OBJ, STL, OFF), or a recording (.rec)"),
      app.add_option("--device", options.device,
                     "device file (TOML), or the URL of a device that your hand moves, as in enamel device --connect"),
      app.add_option("--renderer", renderer,
                     "first renderer: position-control (slides, never pulls; default), impedance, hold "
                     "(the paper's controller), passivity (the spring with passivity control), or the name or path of "
                     "a plugin; it replaces a renderer with the same name"),
      app.add_option("--max-force", options.maxForce,
                     "largest force of the renderer on the tool of a connected device, N")
          ->default_str("no limit"),
      app.add_option("--gain", options.gain,
                     "file of enamel design --output with the servo of hold; hold is then the first renderer"),
      app.add_option("--set", set, "parameter of the plugin, KEY=VALUE; may be repeated")->allow_extra_args(false)};
  CLI::Option* const play = app.add_option("--play", options.play, "recording to play instead of a run");
  for (CLI::Option* const option : live) play->excludes(option);
  CLI::Option* const headless =
      app.add_flag("--headless", options.headless, "run the script on simulated time, without a display");
  app.add_option(
      "--target", options.target,
      "closed mesh (mm) in the frame of the first solid: its colours show where it is cut too deep (blue) or "
      "must still be cut (red)");
  app.add_option("--script", options.script, "script: file of steps with times");
  app.add_option("--record", options.record, "folder for pictures (created if missing)");
  app.add_option(
      "--report", options.report,
      "file for statistics of the run: frame rate, timing, memory (JSON); written at the end and at each SIGUSR1");
  app.add_option("--size", size, "size of the picture, WIDTHxHEIGHT");
  app.add_option("--scale", options.scale, "pixels per unit of layout, only with --headless")
      ->check(CLI::Range(1.0, 4.0));
  app.add_option("--frame-rate", options.frameRate, "largest number of pictures a second in the window (60)")
      ->check(CLI::Range(1.0, 240.0))
      ->excludes(headless);
  app.add_flag("--fixed-step", options.fixedStep,
               "show exactly --frame-rate pictures for each second of the script, however long they take")
      ->excludes(headless);
  enamel::app::addOverwrite(app, options.overwrite, {"--report"});
  if (!enamel::app::parse(app, kProgram, argc, argv)) return;
  if (isRecording(options.scene)) {
    for (CLI::Option* const option : live)
      if (option->get_name() != "scene" && option->count() > 0)
        throw enamel::app::Exit(2, option->get_name() + " is not available for a recording");
    options.play = options.scene;
  }
  const bool isConnected = enamel::isDeviceUrl(options.device);
  if (!isConnected && options.maxForce < enamel::kUnlimited)
    throw enamel::Error("--max-force is for connected devices (--device URL)");
  if (isConnected && !options.gain.empty()) throw enamel::Error("--gain is for simulated devices (--device FILE)");
  if (!renderer.empty()) options.renderer = renderer;
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
      throw enamel::Error("--gain " + options.gain + " is for the built-in " + linked[indexOf(RendererSlot::hold)] +
                          ", which the plugin replaces");
  }
  if (!options.plugin && !set.empty())
    throw enamel::Error("--set is for plugins only, but --renderer does not name a plugin");
  try {
    options.size = parseSize(size);
  } catch (const enamel::Error& error) {
    throw enamel::app::Exit(2, std::string("--size ") + error.what());
  }
  if (const int signal = options.headless ? runHeadless(options, started) : runInWindow(options, started); signal != 0)
    throw enamel::app::Exit(128 + signal, "");  // exit status as in a shell
}  // namespace

}  // namespace

int main(int argc, char** argv) {
  return enamel::app::runProgram(kProgram, [&] { runViewer(argc, argv); });
}
