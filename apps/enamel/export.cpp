#include <fmt/format.h>  // format_to: Clang does not find it in a libfmt built with GCC

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "program/outputs.hpp"
#include "program/recorded.hpp"

namespace enamel::app {
namespace {

struct ExportOptions {
  std::string file, csv;
  bool overwrite = false;
};

std::string titleOf(const Mechanism& device) {
  std::string line = "tick,t [s]";
  const Jacobian& J = device.home().jacobian;
  const bool axes = J.isApprox(Jacobian::Identity(6, J.cols()));  // then the joints are the axes of the TCP
  for (const auto& [name, ofTurn, ofSlide] : {std::tuple{"q", "rad", "m"},
                                              {"rate", "rad/s", "m/s"},
                                              {"applied", "N m", "N"},
                                              {"requested", "N m", "N"},
                                              {"command", "N m", "N"}})
    for (int i = 0; i < device.joints(); ++i)
      line += fmt::format(",{}{} [{}]", name, i + 1, axes && i < 3 ? ofSlide : ofTurn);
  return line +
         ",wall force [N],enabled,saturated,reset,mode,status,guard,state,x [m],y [m],z [m],alpha [rad],beta [rad],"
         "gamma [rad],buttons,gripper [rad],heat,conditions\n";
}

void run(const ExportOptions& options) {
  RecordingReader recording(options.file);
  const auto device = recordedDevice(recording.header());
  if (device->joints() != recording.header().joints)
    throw Error(fmt::format("{}: the device has {} joints, its ticks have {}", options.file, device->joints(),
                            recording.header().joints));
  std::error_code none;
  if (std::filesystem::equivalent(std::filesystem::u8path(options.file), std::filesystem::u8path(options.csv), none))
    throw Error(options.csv + ": is the recording itself, --csv must be another file");
  requireFree(options.csv, options.overwrite);
  FileWriter file(options.csv);
  file.write(titleOf(*device));
  Kinematics k = device->home();
  RecordedChunk chunk;
  std::string line;
  std::uint64_t ticks = 0, lost = 0;
  bool closed = false;
  const auto list = [&line](const auto& values, Eigen::Index columns) {  // missing values stay empty
    for (Eigen::Index i = 0; i < columns; ++i)
      if (i < values.size())
        fmt::format_to(std::back_inserter(line), ",{}", values[i]);
      else
        line += ',';
  };
  for (std::uint64_t i = 0; i < recording.chunks(); ++i) {
    if (const std::string problem = recording.read(i, chunk); !problem.empty()) {
      fmt::print(stderr, "{}: {}\n", options.file, problem);
      continue;
    }
    lost += chunk.lost;
    closed = chunk.last;
    for (const RecordedTick& t : chunk.ticks) {
      line = fmt::format("{},{}", t.number, t.measurement.time);
      const JointVector applied = t.measurement.applied.value_or(JointVector());
      for (const JointVector* v : {&t.measurement.q, &t.measurement.rates, &applied, &t.requested, &t.command})
        list(*v, device->joints());
      fmt::format_to(std::back_inserter(line), ",{},{},{},{},{},{},{},{:016x}", t.normalForce,
                     t.measurement.enabled ? 1 : 0, t.saturated ? 1 : 0, t.reset ? 1 : 0, toString(t.mode),
                     toString(t.status), toString(t.reason), t.stateHash);
      const bool isPose = device->track(t.measurement.q, t.measurement.rates, false, k) == Status::ok;
      list(k.pose.position.head(isPose ? 3 : 0), 3);
      list(eulerFromRotation(k.pose.rotation).head(isPose ? 3 : 0), 3);
      const std::optional<double>& gripper = t.measurement.gripper;
      fmt::format_to(std::back_inserter(line), ",{},{},{},{}", t.measurement.buttons,
                     gripper ? fmt::format("{}", *gripper) : std::string(), t.measurement.heat,
                     t.measurement.conditions);
      file.write(line + "\n");
      ++ticks;
    }
  }
  file.close();
  fmt::print(stderr, "{}: {} ticks, {} lost{}\n", options.file, ticks, lost,
             closed ? "" : "; not closed: the recording ends with its last whole chunk");
}

}  // namespace

void addExport(CLI::App& app) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* command = app.add_subcommand("export",
                                         "Writes the ticks of a recording (push --record) as CSV: one line a tick; the "
                                         "first line names columns and units.\nThe pose is the forward kinematics of "
                                         "the measured joints. It is empty if the kinematics have no solution.");
  command->add_option("file", options->file, "recording")->required();
  command->add_option("--csv", options->csv, "file to write, or /dev/stdout")->required();
  addOverwrite(*command, options->overwrite);
  command->callback([options] { run(*options); });
}

}  // namespace enamel::app
