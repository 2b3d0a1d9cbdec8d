#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "commands.hpp"
#include "enamel/identify/surface_friction.hpp"

namespace enamel::app {
namespace {

void print(const Estimate& e) {
  fmt::print("{:<42} # {:.4g} to {:.4g}{}{}\n", fmt::format("{} = {:.4g}", e.key, e.value), e.low, e.high,
             e.unit.empty() ? "" : " ", e.unit);
}

}  // namespace

void addFriction(CLI::App& app) {
  auto file = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "friction",
      "Estimates the friction of a surface from slides that a force sensor measured, and prints the keys of a scene\n"
      "file with their 95 % intervals. lib/docs/surfaces.md describes the model.");
  command->add_option("slides", *file, "a line per sample: speed (m/s), normal force, friction (N)")->required();
  command->callback([file] {
    const SurfaceFriction result = fitFriction(loadSlides(*file));
    print(result.rest);
    print(result.sliding);
    if (result.stribeck.isSeen) print(result.stribeck);
    print(result.viscosity);
    if (!result.hidden.empty()) fmt::print("# {}\n", result.hidden);
    fmt::print("# residual: {:.3g} N root mean square\n", result.error);
  });
}

}  // namespace enamel::app
