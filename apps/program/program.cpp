#include "program/program.hpp"

#include <CLI/CLI.hpp>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <new>
#include <string_view>
#include <system_error>

#include "enamel/core/old_names.hpp"
#include "enamel/plugin/abi.h"
#include "program/system.hpp"

namespace enamel::app {
namespace {

// CLI11 reads "010" as eight and -1 as the largest unsigned number, and accepts "0x10" and "nan". Here numbers must be
// decimal and finite.
void requireDecimalNumbers(CLI::App& command) {
  for (CLI::Option* option : command.get_options()) {
    const std::string type = option->get_type_name().substr(0, 3);
    if (type != "INT" && type != "UIN" && type != "FLO") continue;
    option->check([type](const std::string& text) -> std::string {
      const std::string_view digits = std::string_view(text).substr(type == "INT" && text[0] == '-' ? 1 : 0);
      if (type != "FLO")
        return !digits.empty() && digits.find_first_not_of("0123456789") == digits.npos &&
                       (digits.size() == 1 || digits[0] != '0')
                   ? ""
                   : "\"" + text + "\" is not a whole number" + (type == "INT" ? "" : " without sign");
      double value = 0.0;
      const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      return error == std::errc{} && *rest == 0 && std::isfinite(value)
                 ? ""
                 : "\"" + text + "\" is not a finite decimal number";
    });
  }
  for (CLI::App* sub : command.get_subcommands({})) requireDecimalNumbers(*sub);
}

}  // namespace

void tell(const std::string& name, const std::string& reason) noexcept {
  std::fprintf(stderr, "%s: %s\n", name.c_str(), printable(reason).c_str());
}

int runProgram(const std::string& name, const std::function<void()>& body) noexcept {
  prepareStreams();
  int status = 0;
  const auto fail = [&](int code, const std::string& reason) {
    std::fflush(stdout);
    if (!reason.empty()) tell(name, reason);
    status = code;
  };
  try {
    body();
  } catch (const Exit& end) {
    fail(end.status(), end.what());
  } catch (const std::system_error& error) {
    if (!std::ferror(stdout)) fail(1, error.what());  // otherwise fmt::print() failed: reported below
  } catch (const std::bad_alloc&) {
    fail(1, "not enough memory");
  } catch (const std::exception& error) {
    fail(1, error.what());
  }
  errno = 0;
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return status;
  tell(name, std::string("cannot write to the standard output") + (errno == 0 ? "" : ": ") +
                 (errno == 0 ? "" : std::strerror(errno)));
  return status == 0 ? 1 : status;
}

const char* buildText() noexcept {
  static_assert(ENAMEL_ABI_VERSION == 3u);
  return ENAMEL_BUILD ", plugin ABI 3";
}

void takeOldNames(CLI::Option* option, const std::string& kind) {
  const auto replace = [kind, where = option->get_name()](std::string& name) -> std::string {
    if (const std::string warning = oldNameWarning(kind, name, where); !warning.empty())
      tell("enamel", "warning: " + warning);
    name = std::string(presentName(kind, name));
    return "";
  };
  option->transform(CLI::Validator(replace, ""));
}

bool parse(CLI::App& app, const std::string& name, int argc, char** argv) {
  requireDecimalNumbers(app);
  app.set_version_flag("--version", name + " " + buildText() + "\n");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) throw Exit(2, std::string(error.what()) + " (see " + name + " --help)");
    app.exit(error);
    return false;
  }
  return true;
}

}  // namespace enamel::app
