#include "push_report.hpp"

#include <fmt/format.h>  // format_to: Clang does not find it in a libfmt built with GCC

#include <algorithm>
#include <nlohmann/json.hpp>

#include "enamel/core/error.hpp"
#include "renderer_option.hpp"

namespace enamel::app {
namespace {

// The paper's extreme values in scenario 1, in the units of the table.
struct PaperFigure {
  const char *symbol, *servo, *spring;
};
const PaperFigure kPaper[] = {
    {"K_z1", "lowest 17.2", "highest 3.11"},
    {"C_zs", "highest 0.0108", "lowest 0.162"},
    {"largest depth", "below 1", "-"},
};

const char* paperFigure(const std::string& renderer, const std::string& symbol) {
  for (const PaperFigure& figure : kPaper)
    if (symbol == figure.symbol) return renderer == kImpedance ? figure.spring : figure.servo;
  return "-";
}

std::string cell(const PushMetrics& metrics, const Metric& metric) {
  const std::optional<double> value = valueOf(metrics, metric);
  return value ? fmt::format("{:.4g}", *value * metric.displayScale) : toString(metrics.verdict);
}

}  // namespace

std::string tableOf(const std::vector<PushOutcome>& outcomes, int scenario) {
  std::string text;
  const auto line = [&](const std::string& title, const auto& value, const auto& figure) {
    text += fmt::format("{:<56}", title);
    for (const PushOutcome& o : outcomes)
      text += fmt::format("{:>18}{:>16}", value(o), scenario == 1 && o.ofPaper ? figure(o) : "");
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
  };
  line(
      "", [](const PushOutcome& o) { return o.renderer; }, [](const PushOutcome&) { return "(paper*)"; });
  for (const Metric& metric : allMetrics())
    line(
        fmt::format("{}{}{} [{}]", metric.symbol, *metric.meaning != 0 ? ", " : "", metric.meaning, metric.displayUnit),
        [&](const PushOutcome& o) { return cell(o.metrics, metric); },
        [&](const PushOutcome& o) { return paperFigure(o.renderer, metric.symbol); });
  line(
      "faults [ticks]", [](const PushOutcome& o) { return std::to_string(o.metrics.faults); },
      [](const PushOutcome&) { return "-"; });
  if (scenario == 1 && std::any_of(outcomes.begin(), outcomes.end(), [](const PushOutcome& o) { return o.ofPaper; }))
    text += "* extremes over the paper's 121 query points on its own device: compare only magnitudes\n";
  return text;
}

std::string jsonOf(const std::vector<PushOutcome>& outcomes) {
  auto json = nlohmann::ordered_json::object();
  for (const PushOutcome& outcome : outcomes) {
    nlohmann::ordered_json& of = json[outcome.renderer];
    of["first impact"] = toString(outcome.metrics.verdict);
    for (const Metric& metric : allMetrics()) {
      const std::optional<double> value = valueOf(outcome.metrics, metric);
      of[keyOf(metric)] = value ? nlohmann::ordered_json(*value) : nullptr;
    }
    of["faults"] = outcome.metrics.faults;
  }
  return json.dump(2) + "\n";
}

TickFile::TickFile(const std::string& path, const Mechanism& device) : file_(path) {
  line_ =
      "t [s],x [m],y [m],z [m],alpha [rad],beta [rad],gamma [rad],vx [m/s],vy [m/s],vz [m/s],wx [rad/s],"
      "wy [rad/s],wz [rad/s],gap [m],person fx [N],person fy [N],person fz [N],rendered fx [N],rendered fy "
      "[N],rendered fz [N],wall force [N]";
  // If J is the identity, the joints are the axes of the TCP, and the first three slide. All other joints turn.
  const Jacobian& J = device.home().jacobian;
  const bool axes = J.isApprox(Jacobian::Identity(6, J.cols()));
  for (const auto& [name, ofTurn, ofSlide] : {std::tuple{"q", "rad", "m"}, {"tau", "N m", "N"}})
    for (int i = 0; i < device.joints(); ++i)
      line_ += fmt::format(",{}{} [{}]", name, i + 1, axes && i < 3 ? ofSlide : ofTurn);
  file_.write(line_ + ",mode,saturated,status,guard\n");
}

void TickFile::write(const TickRecord& t) {
  line_ = fmt::format("{}", t.time);
  const Vec3 euler = eulerFromRotation(t.pose.rotation);
  append(t.pose.position.data(), 3);
  append(euler.data(), 3);
  append(t.twist.data(), 6);
  append(&t.nearest.gap, 1);
  append(t.handWrench.data(), 3);
  append(t.rendered.data(), 3);
  append(&t.normalForce, 1);
  append(t.q.data(), t.q.size());
  append(t.torque.data(), t.torque.size());
  line_ += fmt::format(",{},{},{},{}\n", toString(t.mode), t.saturated ? 1 : 0, toString(t.status), toString(t.guard));
  file_.write(line_);
}

void TickFile::append(const double* values, Eigen::Index count) {
  for (Eigen::Index i = 0; i < count; ++i) fmt::format_to(std::back_inserter(line_), ",{}", values[i]);
}

}  // namespace enamel::app
