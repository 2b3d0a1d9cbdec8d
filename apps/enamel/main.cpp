#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "commands.hpp"

int main(int argc, char** argv) {
  CLI::App app{
      "Enamel: stiff contact on haptic devices.\n"
      "Units are SI unless a name says otherwise; frames: W has x right, y up, z from the wall to the user."};
  app.require_subcommand(1);
  enamel::app::addEvaluate(app);
  enamel::app::addDesign(app);
  enamel::app::addPush(app);
  enamel::app::addMesh(app);
  enamel::app::addPlugins(app);
  enamel::app::addBench(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "enamel: %s (see enamel --help)\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::string message = error.what();
    for (char& c : message)
      if (c == '\n') c = ' ';
    std::fprintf(stderr, "enamel: %s\n", message.c_str());
    return 1;
  }
  return 0;
}
