#include <fmt/core.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "commands.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/plugin/conformance.hpp"
#include "program/plugin_folder.hpp"
#include "program/program.hpp"
#ifndef ENAMEL_SANITIZED
#include "allocation_counter.hpp"
#endif

namespace enamel::app {
namespace {

constexpr unsigned kTimeLimit = 60;  // s
constexpr int kBroken = 3;           // exit status of the child: a check failed

void list(const std::string& folder) {
  const std::vector<PluginFinding> findings = findPlugins(folder);
  for (const PluginFinding& finding : findings) {
    if (!finding.library) {
      fmt::print("refused: {}\n", finding.reason);
      continue;
    }
    const EnamelDescription& d = finding.library->description();
    fmt::print("{} {}: {}\n  {}\n", d.name, d.version, d.summary, finding.path);
    for (std::size_t i = 0; i < d.parameter_count; ++i) {
      const EnamelParameter& p = d.parameters[i];
      fmt::print("  --set {}={}  {}\n", p.key, *p.value != 0 ? p.value : "...", p.meaning);
    }
  }
  if (findings.empty()) fmt::print("no plugins in {}\n", folder);
}

struct CheckOptions {
  std::string file, device;
  std::vector<std::string> set;
};

// In a process of its own, so that a plugin that crashes or hangs is reported and not followed.
[[noreturn]] void checkInChild(const CheckOptions& options) {
  // What computes for ever ends after a minute, on a slow machine too; what waits for ever, after ten.
  const rlimit computing{kTimeLimit, kTimeLimit + 1};
  setrlimit(RLIMIT_CPU, &computing);
  alarm(10 * kTimeLimit);
  int status = 1;
  try {
    PluginSetup setup;
    setup.parameters = parseParameters(options.set);
    if (options.device.empty())
      setup.deviceText = nominalDeviceText();
    else
      setup.devicePath = options.device;
    ConformanceOptions conformance;
#ifndef ENAMEL_SANITIZED
    conformance.allocationCount = &allocationCount;
#endif
    const bool passed =
        checkPlugin(PluginLibrary::load(options.file), setup, conformance, [](const ConformanceResult& result) {
          const char* verdicts[] = {"passed", "FAILED", "not checked"};
          fmt::print("{:<12} {}{}{}\n", verdicts[static_cast<int>(result.verdict)], result.what,
                     result.detail.empty() ? "" : ": ", result.detail);
          std::fflush(stdout);
        });
    if (passed) fmt::print("the plugin keeps the contract\n");
    status = passed ? 0 : kBroken;
  } catch (const std::exception& error) {
    tell("enamel", error.what());
  }
  std::fflush(nullptr);
  _exit(status);
}

void check(const CheckOptions& options) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child < 0) throw Error(std::string("cannot start a process: ") + std::strerror(errno));
  if (child == 0) checkInChild(options);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    throw Error(
        signal == SIGALRM || signal == SIGXCPU
            ? fmt::format("{}: the check after the last line above took longer than {} s", options.file, kTimeLimit)
            : fmt::format("{}: the check after the last line above ended in a crash ({})", options.file,
                          strsignal(signal)));
  }
  if (WEXITSTATUS(status) == kBroken) throw Error(options.file + ": the plugin does not keep the contract");
  if (WEXITSTATUS(status) != 0) std::exit(1);  // the child has said why
}

}  // namespace

void addPlugins(CLI::App& app) {
  auto folder = std::make_shared<std::string>(pluginFolder());
  CLI::App* plugins =
      app.add_subcommand("plugins", "Lists the renderer plugins of a folder, and why others were refused");
  plugins->add_option("folder", *folder, "default: the plugins that came with this program");
  plugins->callback([folder] { list(*folder); });

  auto options = std::make_shared<CheckOptions>();
  CLI::App* command = app.add_subcommand(
      "check-plugin",
      "Runs a plugin through its whole life and checks the contract: order of calls, reset, state, bad input,\n"
      "allocation, limits. Exits with 0 if it keeps the contract.");
  command->add_option("file", options->file, "plugin (.so)")->required();
  command->add_option("--device", options->device, "device file (TOML); default: the nominal TAU");
  command->add_option("--set", options->set, "parameter of the plugin, KEY=VALUE")->allow_extra_args(false);
  command->callback([options] { check(*options); });
}

}  // namespace enamel::app
