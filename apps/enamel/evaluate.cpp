#include <CLI/CLI.hpp>
#include <memory>

#include "commands.hpp"
#include "evaluate_rows.hpp"
#include "program/outputs.hpp"

namespace enamel::app {

void addEvaluate(CLI::App& app) {
  struct Options {
    std::string device, input, output;
    bool overwrite = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "evaluate",
      "Computes kinematics and dynamics of a TAU at given poses.\n"
      "Input: JSON list of rows, or an object with the list \"rows\". A row has position [m] and euler_xyz [rad]\n"
      "(R = Rz(gamma) Ry(beta) Rx(alpha), world axes) or q [rad]; if both are given, the pose is used. Optional,\nbut "
      "only together: qdot [rad/s], torque [N m], tcp_wrench [N, N m; at the TCP, world axes].\n"
      "Output rows: q, elbow, position, euler_xyz, jacobian (V = J q', V = [v; w]), mass_matrix [kg m^2],\n"
      "gravity_torque [N m], and qddot [rad/s^2] if the optional keys are given. A row that cannot be evaluated\nhas "
      "only \"status\" with the reason.");
  command->add_option("--device", options->device, "device file (TOML) of kind tau")->required();
  command->add_option("--input", options->input, "rows to evaluate (JSON)")->required();
  command->add_option("--output", options->output, "file for the results (JSON)")->required();
  addOverwrite(*command, options->overwrite, {"--output"});
  command->callback([options] { evaluateRows(options->device, options->input, options->output); });
}

}  // namespace enamel::app
