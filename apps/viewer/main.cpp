#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

#include "data_folder.hpp"
#include "enamel/render/surface_file.hpp"
#include "plugin_folder.hpp"
#include "viewer.hpp"

int main(int argc, char** argv) {
  using namespace enamel::viewer;
  const double started = steadySeconds();
  CLI::App app{
      "Push the tool of a virtual TAU against a wall and see what stiff means. F1 in the window lists every key.\n"
      "Lengths in scripts are mm; W has x right, y up, z from the wall to the user."};
  Options options;
  options.scene = dataFolder() + "/scenes/flat-wall.toml";
  options.device = dataFolder() + "/devices/tau-nominal.toml";
  std::string renderer, size = "1280x720";
  app.add_option("scene", options.scene, "scene file (TOML)");
  app.add_option("--device", options.device, "device file (TOML)");
  std::vector<std::string> set;
  app.add_option(
      "--renderer", renderer,
      "the renderer to begin with: position-control (slides, never pulls; default), impedance, hold (the paper's "
      "law), or the name or path of a plugin, which takes the place of one of its name");
  app.add_option("--gain", options.gain,
                 "servo of enamel design --output: with --surface for position-control, without for hold, which is "
                 "then begun with");
  app.add_option("--set", set, "parameter of the plugin, KEY=VALUE; once a parameter")->allow_extra_args(false);
  app.add_flag("--headless", options.headless, "no display: run the script on simulated time");
  app.add_option("--script", options.script, "what to do, with times");
  app.add_option("--record", options.record, "folder for pictures (made if it is missing)");
  app.add_option("--report", options.report, "how the run went: frame rate, timing, memory (JSON)");
  app.add_option("--size", size, "WIDTHxHEIGHT of the picture");
  app.add_option("--scale", options.scale, "pixels per unit of layout, headless")->check(CLI::Range(1.0, 4.0));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "enamel-viewer: %s (see enamel-viewer --help)\n", error.what());
    return 2;
  }
  try {
    const RendererSlot gainOf =
        enamel::isSurfaceServo(options.gain) ? RendererSlot::positionControl : RendererSlot::hold;
    const auto linked = rendererNames(nullptr);
    const auto found = std::find(linked.begin(), linked.end(), renderer);
    if (renderer.empty()) {
      if (!options.gain.empty()) options.begin = gainOf;
    } else if (found != linked.end()) {
      options.begin = static_cast<RendererSlot>(found - linked.begin());
    } else {
      options.plugin = enamel::findPlugin(renderer, enamel::app::pluginFolder());
      options.pluginParameters = enamel::app::parseParameters(set);
      options.begin = slotOf(*options.plugin);
      if (!options.gain.empty() && options.begin == gainOf)
        throw enamel::Error("--gain " + options.gain + " is for the linked " + linked[indexOf(gainOf)] +
                            ", whose place the plugin takes");
    }
    if (!options.plugin && !set.empty()) throw enamel::Error("--set is for plugins, and --renderer names none");
    try {
      options.size = parseSize(size);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "enamel-viewer: --size %s\n", error.what());
      return 2;
    }
    const int signal = options.headless ? runHeadless(options, started) : runInWindow(options, started);
    return signal == 0 ? 0 : 128 + signal;  // as a shell tells it
  } catch (const std::exception& error) {
    std::string message = error.what();
    for (char& c : message)
      if (c == '\n') c = ' ';
    std::fprintf(stderr, "enamel-viewer: %s\n", message.c_str());
    return 1;
  }
}
