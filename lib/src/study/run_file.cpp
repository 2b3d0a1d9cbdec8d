#include "enamel/study/run_file.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "core/message.hpp"
#include "core/system_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"

namespace enamel {
namespace {

constexpr double kMostFaults = 1e9;  // ticks: more than any run has

// The part of a line that the plan determines.
std::string identity(const StudyPlan& plan, const StudyRun& run) {
  const Vec3 point = queryPoint(plan, run.point);
  return std::to_string(run.scenario) + ',' + plan.columns[run.column].name + ',' + formatNumber(point.x()) + ',' +
         formatNumber(point.y()) + ',' + std::to_string(run.run) + ',' + formatNumber(run.force) + ',';
}

std::string numberOr(const std::optional<double>& value) { return value ? formatNumber(*value) : std::string(); }

double parse(std::string_view text, const std::string& where) {
  double value = 0.0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size() || !std::isfinite(value))
    throw Error(where + ": \"" + std::string(text) + "\" is not a number or not finite");
  return value;
}

Status statusNamed(std::string_view name, const std::string& where) {
  for (int i = 0; i < kStatuses; ++i)
    if (name == toString(static_cast<Status>(i))) return static_cast<Status>(i);
  throw Error(where + ": \"" + std::string(name) + "\" is not a status");
}

FirstImpactVerdict verdictNamed(std::string_view name, const std::string& where) {
  for (int i = 0; i < kVerdicts; ++i)
    if (name == toString(static_cast<FirstImpactVerdict>(i))) return static_cast<FirstImpactVerdict>(i);
  throw Error(where + ": \"" + std::string(name) + "\" is not a verdict on a first impact");
}

StudyResult parseLine(const StudyPlan& plan, std::size_t index, std::string_view line, const std::string& where) {
  StudyResult result;
  result.run = runAt(plan, index);
  const std::string expected = identity(plan, result.run);
  if (line.substr(0, expected.size()) != expected)
    throw Error(where + ": is not run " + std::to_string(index) + " of this study, whose line begins with " + expected);
  line.remove_prefix(expected.size());
  // status, first impact, metrics, faults
  std::array<std::string_view, kMetrics + 3> fields;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::size_t comma = line.find(',');
    if ((comma == std::string_view::npos) != (i + 1 == fields.size()))
      throw Error(where + ": has the wrong number of columns");
    fields[i] = line.substr(0, comma);
    if (comma != std::string_view::npos) line.remove_prefix(comma + 1);
  }
  result.status = statusNamed(fields[0], where);
  PushMetrics& m = result.metrics;
  if (result.status == Status::ok || result.status == Status::stopped) m.verdict = verdictNamed(fields[1], where);
  if (result.status != Status::ok) return result;
  for (std::size_t i = 0; i < allMetrics().size(); ++i) {
    const std::string_view field = fields[2 + i];
    const auto& member = allMetrics()[i].member;
    if (const auto* number = std::get_if<double PushMetrics::*>(&member))
      m.** number = parse(field, where);
    else if (!field.empty())
      m.*std::get<1>(member) = parse(field, where);
  }
  const double faults = parse(fields.back(), where);
  if (!(faults >= 0.0 && faults <= kMostFaults))
    throw Error(where + ": " + formatNumber(faults) + " faults, must be in 0 to " + formatNumber(kMostFaults) +
                " ticks");
  m.faults = static_cast<std::uint64_t>(faults);
  return result;
}

struct Content {
  std::vector<StudyResult> results;
  std::size_t bytes = 0;  // of whole lines
  bool header = false;
};

Content readContent(const StudyPlan& plan, const std::string& path, const RunRange& range) {
  const std::string all = readFile(path, kLargestRunFile);
  Content content;
  for (std::size_t begin = 0, end = 0; (end = all.find('\n', begin)) != std::string::npos; begin = end + 1) {
    const std::string_view line(all.data() + begin, end - begin);
    const std::string where = path + ":" + std::to_string(content.results.size() + content.header + 1);
    if (!content.header) {
      if (line != runHeader()) throw Error(where + ": is not the header of a file of runs");
      content.header = true;
    } else {
      if (content.results.size() >= range.count) throw Error(where + ": more runs than this study has");
      content.results.push_back(parseLine(plan, range.first + content.results.size(), line, where));
      if (runLine(plan, content.results.back()) != line)
        throw Error(where + ": differs from what the study writes for this run");
    }
    content.bytes = end + 1;
  }
  return content;
}

}  // namespace

std::string runHeader() {
  std::string header = "scenario,renderer,x [m],y [m],run,F_c [N],status,first impact";
  for (const Metric& metric : allMetrics()) header += ',' + keyOf(metric);
  return header + ",faults";
}

std::string runLine(const StudyPlan& plan, const StudyResult& result) {
  const bool failed = result.status != Status::ok;
  std::string line = identity(plan, result.run) + toString(result.status) + ',';
  if (!failed || result.status == Status::stopped) line += toString(result.metrics.verdict);
  for (const Metric& metric : allMetrics()) {
    line += ',';
    if (!failed) line += numberOr(valueOf(result.metrics, metric));
  }
  return line + ',' + (failed ? "" : std::to_string(result.metrics.faults));
}

RunRange partOf(const StudyPlan& plan, int number, int parts) {
  require(parts >= 1 && number >= 1 && number <= parts,
          "part " + std::to_string(number) + " of " + std::to_string(parts) +
              ": the number of the part must be in 1 to the number of parts");
  const auto begin = [&](int part) {
    return plan.size() * static_cast<std::size_t>(part) / static_cast<std::size_t>(parts);
  };
  return {begin(number - 1), begin(number) - begin(number - 1)};
}

RunFile::RunFile(const StudyPlan& plan, std::string path, bool resume, const RunRange& range)
    : plan_(plan), path_(std::move(path)), file_(nullptr, &std::fclose) {
  constexpr std::size_t kLongestLine = 400;  // with margin: numbers of 17 digits for every metric
  if (plan.size() > kLargestRunFile / kLongestLine)
    throw Error(path_ + ": would hold " + std::to_string(plan.size()) + " runs, must be at most " +
                std::to_string(kLargestRunFile / kLongestLine));
  const int number = system::openToAppend(path_);
  if (number >= 0) file_.reset(system::streamOf(number, "ab"));
  if (!file_) throw Error(path_ + ": cannot write the file: " + std::strerror(errno));
  if (!system::lock(number))
    throw Error(path_ + ": cannot lock the file (does another study write it?): " + std::strerror(errno));
  const Content content = resume ? readContent(plan, path_, range) : Content{};
  if (!system::setSize(number, content.bytes)) throw Error(path_ + ": cannot write the file: " + std::strerror(errno));
  finished_ = content.results.size();
  if (!content.header) write(runHeader());
}

void RunFile::append(const StudyResult& result) {
  write(runLine(plan_, result));
  ++finished_;
}

void RunFile::write(const std::string& line) {
  errno = 0;
  if (std::fprintf(file_.get(), "%s\n", line.c_str()) < 0 || std::fflush(file_.get()) != 0)
    throw Error(path_ + ": cannot write the file: " + std::strerror(errno));
}

std::vector<StudyResult> readRuns(const StudyPlan& plan, const std::string& path, const RunRange& range) {
  return readContent(plan, path, range).results;
}

}  // namespace enamel
