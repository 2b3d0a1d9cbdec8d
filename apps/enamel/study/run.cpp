#include <fmt/core.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/run_file.hpp"
#include "program/interrupt.hpp"
#include "program/outputs.hpp"
#include "program/program.hpp"
#include "program/system.hpp"
#include "study/pairs.hpp"
#include "study/report.hpp"

namespace enamel::app {

namespace fs = std::filesystem;

namespace {

// ---- progress ----------------------------------------------------------------------------------------------------

std::string durationText(double seconds) {
  return seconds < 99.5 ? fmt::format("{:.0f} s", seconds)
                        : fmt::format("{:.0f} min {:02.0f} s", std::floor(seconds / 60.0), std::fmod(seconds, 60.0));
}

// Shows the progress: on a terminal as one line that is overwritten, otherwise as a line for every tenth.
class Progress {
 public:
  Progress(std::size_t first, std::size_t count)
      : first_(first), count_(count), terminal_(isTerminal(2)), begun_(Clock::now()), shown_(begun_) {}

  void report(std::size_t finished) {
    const auto now = Clock::now();
    const double passed = std::chrono::duration<double>(now - begun_).count();
    const bool tenth = 10 * finished / count_ > 10 * (finished - 1) / count_;
    if (terminal_ ? finished < count_ && now - shown_ < std::chrono::milliseconds(200) : !tenth) return;
    shown_ = now;
    const double left = passed / static_cast<double>(finished - first_) * static_cast<double>(count_ - finished);
    fmt::print(stderr, "{}{} of {} runs, {} %, {} left{}", terminal_ ? "\r\033[K" : "", finished, count_,
               100 * finished / count_, durationText(left), terminal_ && finished < count_ ? "" : "\n");
    std::fflush(stderr);
  }

  void interrupt() const {
    if (terminal_) fmt::print(stderr, "\n");
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::size_t first_, count_;
  bool terminal_;
  Clock::time_point begun_, shown_;
};

// ---- the folder --------------------------------------------------------------------------------------------------

// Create the folder, and report problems before the runs: missing permission or too little space.
void prepareFolder(const Study& study) {
  const std::string& folder = study.options.output;
  std::error_code error;
  fs::create_directories(fs::u8path(folder), error);
  if (!fs::is_directory(fs::u8path(folder)))
    throw Error(folder + ": cannot make the folder: " + (error ? error.message() : "a file of that name exists"));
  if (!canWriteInto(folder)) throw Error(folder + ": cannot write into the folder: " + std::strerror(errno));
  const fs::space_info space = fs::space(fs::u8path(folder), error);
  const double needed = 350.0 * static_cast<double>(study.plan.size()) + 8e6;  // lines of runs; figures, report
  if (!error && static_cast<double>(space.available) < needed)
    throw Error(fmt::format("{}: {:.1f} MB are free, the study needs about {:.1f} MB", folder,
                            1e-6 * static_cast<double>(space.available), 1e-6 * needed));
}

// Return the first setting that differs between two studies.
std::string differenceOf(const Json& there, const Json& here) {
  for (const auto& [key, value] : here.items())
    if (!there.contains(key) || there.at(key) != value)
      return fmt::format("its {} is {}, here it is {}", key, there.contains(key) ? there.at(key).dump() : "not given",
                         value.dump());
  return "it has other settings";
}

// Return the files that the study writes into the folder.
std::vector<std::string> resultsOf(const StudyOptions& options) {
  std::vector<std::string> names;
  if (options.whole) names = {"runs.csv", "points.csv", "summary.json", "report.html"};
  if (options.convergence) names.push_back("convergence.csv");
  if (!options.whole) names.push_back("convergence.html");
  return names;
}

// Return whether runsPath() could have made this name: the file holds a part of a study's runs.
bool isPartOfRuns(const std::string& name) {
  int part = 0, parts = 0, length = -1;
  return std::sscanf(name.c_str(), "runs-%9d-of-%9d.csv%n", &part, &parts, &length) == 2 &&
         length == static_cast<int>(name.size());
}

// Remove the results of another study and its unfinished parts, which would otherwise be joined to this study's runs.
void removeResults(const Study& study) {
  for (const std::string& name : resultsOf(study.options)) fs::remove(fs::u8path(study.path(name)));
  for (const auto& entry : fs::directory_iterator(fs::u8path(study.options.output)))
    if (isPartOfRuns(entry.path().filename().u8string())) fs::remove(entry.path());
}

// Write study.json, which identifies the study: only the same study may continue the runs in the folder.
void claimFolder(const Study& study) {
  const StudyOptions& options = study.options;
  const std::string path = study.path("study.json"), runs = study.path("runs.csv");
  const bool hasRuns = fs::exists(fs::symlink_status(fs::u8path(runs)));
  if (options.overwrite) {
    removeResults(study);
  } else {
    if (hasRuns && !options.resume && options.parts == 1)
      throw Error(runs + ": exists; --resume continues it, --overwrite replaces it");
    if (fs::exists(fs::u8path(path)) || (hasRuns && options.resume)) {
      requireSame(study);
      if (hasRuns || options.parts > 1) return;
    }
    for (const std::string& name : resultsOf(options)) requireFree(study.path(name), false);
  }
  writeFile(path, study.manifest);
  writeFile(study.path(kCommandFile),
            Json(study.options.arguments).dump(-1, ' ', false, Json::error_handler_t::replace) + '\n');
}

// ---- the command -------------------------------------------------------------------------------------------------

void perform(const Study& study) {
  const RunRange range = study.range();
  const std::string path = study.runsPath(study.options.part);
  RunFile file(study.plan, path, study.options.resume || study.options.parts > 1, range);
  const std::size_t first = file.finished(), count = range.count;
  if (first > 0) fmt::print(stderr, "{} of {} runs exist already\n", first, count);
  Progress progress(first, count);
  std::vector<StudyResult> results(count);
  const InterruptGuard guard(InterruptGuard::Second::endsProcess);
  const std::size_t finished = parallelInOrder(
      first, count, study.options.threads,
      [&](std::size_t i) { results[i] = performRun(study.plan, runAt(study.plan, range.first + i)); },
      [&](std::size_t i) {
        file.append(results[i]);
        progress.report(i + 1);
      },
      [] { return interruption() != 0; });
  if (finished < count) {
    progress.interrupt();
    throw Exit(128 + interruption(),
               fmt::format("interrupted after {} of {} runs, saved in {}: continue with the same command and --resume",
                           finished, count, path));
  }
}

// Join the parts to runs.csv. Return false if some parts are missing.
bool joinParts(const Study& study) {
  const std::string path = study.path("runs.csv");
  if (fs::exists(fs::u8path(path))) {  // already joined, or left by a process without --part
    const std::size_t there = readRuns(study.plan, path).size();
    if (there == study.plan.size()) return true;
    throw Error(fmt::format("{}: has {} of {} runs of a process without --part: continue it with --resume", path, there,
                            study.plan.size()));
  }
  std::string text = runHeader() + '\n';
  for (int part = 1; part <= study.options.parts; ++part) {
    const RunRange range = partOf(study.plan, part, study.options.parts);
    if (!fs::exists(fs::u8path(study.runsPath(part)))) return false;
    const std::vector<StudyResult> runs = readRuns(study.plan, study.runsPath(part), range);
    if (runs.size() < range.count) return false;
    for (const StudyResult& run : runs) text += runLine(study.plan, run) + '\n';
  }
  writeFile(path, text);
  return true;
}

void printSummary(const Study& study, const std::vector<WallSummary>& walls, const std::vector<Claim>& claims) {
  fmt::print("{}: {} query points x {} runs x {} scenarios, preload {} N, delay {}, encoders {}, seed {}\n",
             nameOf(study.device), study.plan.points(), study.plan.runs, study.plan.scenarios.size(),
             study.options.preload, study.options.delay, study.options.encoders ? "on" : "off", study.plan.setup.seed);
  constexpr const char* kRow =
      "{:<9}{:<28}{:>9}{:>13}{:>13}{:>12}{:>12}{:>8}{:>13}{:>13}{:>11}{:>9}{:>9}{:>9}{:>9}{}\n";
  fmt::print(kRow, "scenario", "renderer", "damping", "lowest K_z1", "highest", "lowest K_d", "mean K_d", "limit",
             "lowest K_zs", "highest", "unresolved", "depth", "bounce", "chatter", "drift", "");
  fmt::print(kRow, "", "", "N s/m*", "N/m", "N/m", "N/m", "N/m", "%**", "N/m", "N/m", "points", "mm", "mm", "N m", "mm",
             "");
  const auto value = [](const std::optional<Extreme>& e) { return e ? fmt::format("{:.5g}", e->value) : "-"; };
  for (const WallSummary& w : walls) {
    const std::string without = withoutFirstText(w);
    const auto largest = [any = anyFinished(study, w)](double v) { return any ? fmt::format("{:.3f}", v) : "-"; };
    fmt::print(kRow, w.scenario, study.plan.columns[w.column].name,
               fmt::format("{:.3g}", study.labels[w.column].damping), value(w.lowestFirst), value(w.highestFirst),
               value(w.lowestDepthStiffness),
               w.depthStiffness.count > 0 ? fmt::format("{:.5g}", w.depthStiffness.mean) : "-",
               w.lowestShare ? fmt::format("{:.1f}", 100.0 * w.lowestShare->value) : "-", value(w.lowestSteady),
               value(w.highestSteady), w.unresolved, largest(1e3 * w.largestDepth), largest(1e3 * w.bounce),
               largest(w.chatter), largest(1e3 * w.drift),
               (without.empty() ? "" : "  runs without K_z1: " + without) + (w.failed > 0 ? "  " + lostText(w) : ""));
  }
  fmt::print(
      "* mechanical, of the plant along z at home  ** lowest mean of K_z1 divided by the physical limit for a step at "
      "the\nbeginning of a tick\n");
  for (const Claim& claim : claims)
    fmt::print("{}: {} ({})\n", claim.verdict == "does not hold" ? "DOES NOT HOLD" : claim.verdict, claim.text,
               claim.measured);
}

void printConvergence(const Convergence& convergence) {
  if (convergence.cheapest == convergence.methods.size()) {
    fmt::print("integration: no method keeps every metric within {:.2g} %\n", 100.0 * convergence.allowed);
    return;
  }
  const MethodError& m = convergence.methods[convergence.cheapest];
  fmt::print(
      "integration: the cheapest with every metric within {:.2g} % is {} with {} step{} a tick ({:.1e}, {:.2f} ms "
      "per simulated second)\n",
      100.0 * convergence.allowed, nameOf(m.method.integrator), m.method.substeps, m.method.substeps > 1 ? "s" : "",
      m.worst, 1e3 * m.secondsPerSecond);
}

void writeReport(const Study& study, const Findings& findings) {
  const std::string path = study.path(findings.whole ? "report.html" : "convergence.html");
  writeFile(path, reportOf(study, findings, figuresOf(study, findings)));
  fmt::print("report: {}\n", path);
}

}  // namespace

void requireSame(const Study& study) {
  const std::string path = study.path("study.json");
  const Json there = fs::exists(fs::u8path(path)) ? Json::parse(readJson(path), nullptr, false) : Json();
  if (!there.is_object())
    throw Error(path + ": is missing or damaged, so the study of runs.csv is unknown; --overwrite replaces it");
  const Json here = Json::parse(study.manifest);
  if (there != here) throw Error(fmt::format("{}: holds another study: {}", path, differenceOf(there, here)));
}

bool completeRuns(const Study& study) {
  prepareFolder(study);
  claimFolder(study);
  if (study.options.parts == 1) {
    perform(study);
    return true;
  }
  if (!fs::exists(fs::u8path(study.path("runs.csv")))) perform(study);
  const FolderLock lock(study.options.output, true);
  return joinParts(study);
}

void runStudy(StudyOptions options) {
  if (options.threads == 0) options.threads = availableThreads();
  const Study study = prepareStudy(options);
  if (const std::size_t spring = study.column(ColumnKind::impedance); spring < study.labels.size())
    if (const std::string warning =
            dampingWarning(options.impedance, study.plan.setup.period, study.labels[spring].damping);
        !warning.empty())
      fmt::print(stderr, "enamel: warning: {}\n", warning);
  prepareFolder(study);
  std::optional<FolderLock> lock;
  if (options.parts == 1) lock.emplace(options.output, false);
  Findings findings;
  findings.whole = options.whole;
  if (!findings.whole)
    for (const std::string& name : resultsOf(options)) requireFree(study.path(name), options.overwrite);
  if (findings.whole) {
    if (!completeRuns(study)) {
      fmt::print("part {} of {} is done; the last part to finish writes the report\n", options.part, options.parts);
      return;
    }
    if (!lock) lock.emplace(options.output, true);
    // Read the file, so that an interrupted study gives the same bytes.
    const std::vector<StudyResult> runs = readRuns(study.plan, study.path("runs.csv"));
    findings.points = pointStatistics(study.plan, runs);
    findings.walls = summarise(study.plan, findings.points);
    findings.pairs = comparePairs(study.plan, runs, referenceOf(study), reportQuestions());
    findings.claims = claimsOf(study, runs, findings.walls);
    writeFile(study.path("points.csv"), pointsTable(study, findings.points));
    writeFile(study.path("summary.json"), summaryOf(study, findings.walls, findings.claims));
    printSummary(study, findings.walls, findings.claims);
  }
  if (options.convergence) {
    findings.convergence = measureConvergence(study);
    writeFile(study.path("convergence.csv"), convergenceTable(*findings.convergence));
    printConvergence(*findings.convergence);
  }
  writeReport(study, findings);
}

}  // namespace enamel::app
