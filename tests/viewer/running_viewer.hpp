// A viewer that runs concurrently with the test. The test requests reports and waits for states.
#pragma once

#include <algorithm>

#include "support/process.hpp"
#include "viewer/support.hpp"

namespace enamel::test {

/// A viewer started with a report. It leaves report.json in `folder`, and its output in said.txt. `before`:
/// environment.
class RunningViewer {
 public:
  RunningViewer(const TemporaryFolder& folder, const std::string& arguments, const std::string& before)
      : report_(folder / "report.json"),
        said_(folder / "said.txt"),
        viewer_("cd '" + folder / "" + "' && exec env " + before + " '" + ENAMEL_VIEWER + "' --overwrite --report '" +
                report_ + "' " + arguments + " > '" + said_ + "' 2>&1") {
    INFO("the viewer has printed: " << said());
    REQUIRE(eventually([this] { return viewer_.handles(SIGUSR1) || !viewer_.isRunning(); }));
    REQUIRE(viewer_.isRunning());
  }

  std::string said() const { return readFile(said_); }

  /// Return the report of a picture that includes every event until now.
  nlohmann::json report() {
    std::filesystem::remove(report_);
    viewer_.signal(SIGUSR1);
    const bool reported = eventually([this] { return std::filesystem::exists(report_) || !viewer_.isRunning(); });
    INFO("the viewer has printed: " << said());
    REQUIRE(reported);
    REQUIRE(viewer_.isRunning());
    return nlohmann::json::parse(readFile(report_));
  }

  /// Wait for a state and return its report.
  template <typename Condition>
  nlohmann::json until(const std::string& what, const Condition& condition) {
    nlohmann::json last;
    const bool reached = eventually([&] { return condition(last = report()); });
    INFO("waited for " << what << "; the last report: " << last.dump(1));
    REQUIRE(reached);
    return last;
  }
  /// Wait until a list of shown texts has an entry with this text.
  nlohmann::json untilShown(const char* list, const std::string& text) {
    return until(std::string(list) + " with " + text,
                 [&](const nlohmann::json& report) { return isAmong(report.at("shown").at(list), text); });
  }
  /// Wait until it has printed a text.
  void untilSaid(const std::string& text) {
    const bool has = eventually([&] { return said().find(text) != std::string::npos || !viewer_.isRunning(); });
    INFO("waited for " << text << "; the viewer has printed: " << said());
    REQUIRE(has);
    REQUIRE(viewer_.isRunning());
  }
  /// Wait for pictures that include every event until now.
  void untilDrawn(int pictures) {
    for (int i = 0; i < pictures; ++i) report();
  }

  void signal(int number) const { viewer_.signal(number); }
  /// Wait for the end; return the exit status.
  int wait() { return viewer_.wait(); }
  /// Return the last report after the end.
  nlohmann::json lastReport() const { return nlohmann::json::parse(readFile(report_)); }

  static bool isAmong(const nlohmann::json& list, const std::string& text) {
    return std::any_of(list.begin(), list.end(), [&text](const nlohmann::json& one) {
      return one.get<std::string>().find(text) != std::string::npos;
    });
  }

 private:
  std::string report_, said_;
  Process viewer_;
};

/// A separate X server for a window.
class XServer {
 public:
  explicit XServer(const TemporaryFolder& folder)
      : number_((std::filesystem::remove(folder / "display"), folder / "display")),
        server_("exec Xvfb -displayfd 3 -screen 0 1280x720x24 -nolisten tcp 3>'" + number_ + "' >/dev/null 2>&1") {
    REQUIRE(eventually([this] { return readFile(number_).find('\n') != std::string::npos; }));
  }
  /// Return the environment for a command.
  std::string environment() const {
    const std::string number = readFile(number_);
    return "DISPLAY=:" + number.substr(0, number.find('\n')) + " ";
  }

 private:
  std::string number_;
  Process server_;
};

}  // namespace enamel::test
