#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>

#include "commands.hpp"

namespace {

// CLI11 reads "010" as eight and -1 as the largest unsigned number, and takes "0x10" and "nan": here numbers are
// decimal and finite.
void requireDecimalNumbers(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    const std::string type = option->get_type_name().substr(0, 3);
    if (type != "INT" && type != "UIN" && type != "FLO") continue;
    option->check([type](const std::string& text) -> std::string {
      const std::string_view digits = std::string_view(text).substr(type == "INT" && text[0] == '-' ? 1 : 0);
      if (type != "FLO")
        return digits.find_first_not_of("0123456789") == digits.npos && (digits.size() == 1 || digits[0] != '0')
                   ? ""
                   : "\"" + text + "\" is not a whole number" + (type == "INT" ? "" : " without sign");
      double value = 0.0;
      const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      return error == std::errc{} && *rest == 0 && std::isfinite(value)
                 ? ""
                 : "\"" + text + "\" is not a finite decimal number";
    });
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Enamel: stiff contact on haptic devices.\n"
      "Units are SI unless a name says otherwise; frames: W has x right, y up, z from the wall to the user."};
  app.require_subcommand(1);
  enamel::app::addEvaluate(app);
  enamel::app::addDesign(app);
  enamel::app::addPush(app);
  enamel::app::addStudy(app);
  enamel::app::addMesh(app);
  enamel::app::addPlugins(app);
  enamel::app::addBench(app);
  for (CLI::App* command : app.get_subcommands({})) requireDecimalNumbers(*command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "enamel: %s (see enamel --help)\n", error.what());
    return 2;
  } catch (const enamel::app::Interrupted& error) {
    std::fprintf(stderr, "enamel: %s\n", error.what());
    return error.exitStatus();
  } catch (const std::exception& error) {
    std::string message = error.what();
    for (char& c : message)
      if (c == '\n') c = ' ';
    std::fprintf(stderr, "enamel: %s\n", message.c_str());
    return 1;
  }
  return 0;
}
