#include "identify_report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "design_expectation.hpp"
#include "study/page.hpp"

namespace enamel::app {
namespace {

constexpr double kShown = 3.0;  // s, of the traces
constexpr int kFigureWide = 750;
constexpr unsigned kJointColours[] = {viewer::kBlue,   viewer::kVermilion, viewer::kGreen,
                                      viewer::kOrange, viewer::kPurple,    viewer::kSky,
                                      viewer::kBrown,  viewer::kMuted,     viewer::kInk};

bool isLinear(const std::string& joint) { return joint.rfind("axis", 0) == 0; }

// The experiment that shows a number better.
std::string experimentFor(const Estimate& e) {
  const auto is = [&](const char* text) { return e.key.find(text) != std::string::npos; };
  if (is("cable") || is("rotor") || is("lag")) return "faster forces: a larger <code>--share</code>";
  if (is("Coulomb") || is("cogging") || is("periods") || is("viscous") || is("damping"))
    return "a longer and faster way: larger <code>--duration</code> and <code>--speed</code>";
  if (is("geometry") || is("offset") || is("com") || is("gravity"))
    return "a longer way through the workspace: a larger <code>--duration</code>";
  return "stronger and longer motion: larger <code>--share</code> and <code>--duration</code>";
}

void addEstimates(Page& page, const Identification& result) {
  page.heading("Numbers");
  std::vector<std::vector<std::string>> rows;
  for (const Estimate& e : result.estimates)
    rows.push_back({escape(e.key), fmt::format("{:.5g}", e.value), fmt::format("{:.5g} to {:.5g}", e.low, e.high),
                    fmt::format("{:.5g}", e.before), escape(e.unit), e.isSeen ? "seen" : "not seen"});
  page.table({"number", "estimate", "95 % interval", "file before", "unit", ""}, rows);
  std::vector<std::string> hidden;
  for (const Estimate& e : result.estimates)
    if (!e.isSeen) hidden.push_back(escape(e.key) + ": " + experimentFor(e));
  if (hidden.empty()) return;
  page.paragraph(
      "The recording does not show these numbers: their values are close to those of the file. An experiment that "
      "shows more:");
  page.list(hidden);
}

// Torques of the joints: command, and what the model needs for the recorded motion.
Json torqueFigure(const Identification& result) {
  const IdentificationTraces& t = result.traces;
  const Eigen::Index joints = t.torque.rows(), all = t.torque.cols();
  const Eigen::Index count = std::min(all, static_cast<Eigen::Index>(kShown / t.period)), first = (all - count) / 2;
  const Style command, model{viewer::kVermilion, {6, 4}};
  const Json times{{"from", 0.0}, {"step", t.period}};
  Json panels = Json::array();
  for (Eigen::Index joint = 0; joint < joints; ++joint) {
    const auto row = static_cast<std::size_t>(joint);
    std::vector<double> commanded, explained;
    for (Eigen::Index i = first; i < first + count; ++i) {
      commanded.push_back(t.torque(joint, i));
      explained.push_back(t.explained(joint, i));
    }
    Json time = axis("time, s");
    time["numbers"] = joint + 1 == joints;
    panels.push_back(panel(fmt::format("{}: {:.2f} % explained", t.joint[row], 100.0 * result.explained[joint]),
                           kFigureWide, 110, time, axis(isLinear(t.joint[row]) ? "N" : "N m"),
                           {line("command", times, commanded, command), line("model", times, explained, model)}));
  }
  return figure("torques of command and model", 1, {entry("command", command), entry("model", model)}, panels);
}

// Spectra of the residuals, and the density of rounding.
Json residualFigure(const Identification& result) {
  const IdentificationTraces& t = result.traces;
  // A rounding error has the variance step^2 / 12, equally at all frequencies up to 1 / (2 period).
  const JointVector rounding = 1e6 * std::sqrt(t.period / 6.0) * makeMechanism(result.device)->limits().encoderStep;
  std::vector<double> xs;
  for (Eigen::Index k = 1; k < t.frequency.size(); ++k) xs.push_back(t.frequency[k]);
  Json layers = Json::array(), legend = Json::array();
  for (Eigen::Index joint = 0; joint < t.residual.rows(); ++joint) {
    const std::string& name = t.joint[static_cast<std::size_t>(joint)];
    const Style style{kJointColours[static_cast<std::size_t>(joint) % std::size(kJointColours)]};
    std::vector<double> ys;
    for (Eigen::Index k = 1; k < t.frequency.size(); ++k) ys.push_back(1e6 * t.residual(joint, k));
    layers.push_back(line(name, numbers(xs), ys, style));
    layers.push_back(level(rounding[joint], dashed(viewer::kMuted)));
    legend.push_back(entry(name, style));
  }
  legend.push_back(entry("rounding of its encoder", dashed(viewer::kMuted)));
  const std::string unit = !isLinear(t.joint.front()) ? "µrad" : isLinear(t.joint.back()) ? "µm" : "µm or µrad";
  return figure(
      "Spectra of the residuals", 1, legend,
      Json::array({panel("", kFigureWide, 280, axis("frequency, Hz", true), axis(unit + " / √Hz", true), layers)}));
}

void addWalls(Page& page, const Identification& result, const std::vector<WallExpectation>& expected) {
  page.heading("Wall to expect");
  std::vector<std::vector<std::string>> rows;
  for (const WallExpectation& e : expected) {
    const bool isOwn = e.delay >= result.delay.low && e.delay <= result.delay.high;
    rows.push_back({fmt::format("{}{}", e.delay, isOwn ? " (this loop)" : ""),
                    fmt::format("{:.3g}", 1e-3 * e.stiffness.mean), fmt::format("{:.3f}", e.chatter),
                    fmt::format("{:.0f}", 1e6 * e.bounce), fmt::format("{:.3g}", e.safePush),
                    fmt::format("{} of {}", e.lost, e.runs), escape(helpOf(e))});
  }
  page.table(
      {"delay, ticks", "K_d, kN/m", "chatter, N m or N", "bounce, µm", "safe push, N", "lost", "what would help"},
      rows);
  page.note(
      fmt::format("Position control on the identified device, estimated from simulated pushes at home along z. K_d: "
                  "force of a push divided by its deepest point in 0.1 s, mean. Safe push: stays less than {:g} mm "
                  "deep and loses no run.",
                  1e3 * kSafeDepth));
}

}  // namespace

std::string identificationReport(const Identification& result, const std::vector<std::string>& files,
                                 const std::vector<WallExpectation>& expected) {
  Page page;
  if (!result.isUsable()) {
    page.heading("No device file");
    page.paragraph("The recording and the device file do not fit together. The numbers below are not estimates.");
    std::vector<std::string> problems;
    for (const std::string& problem : result.problems) problems.push_back(escape(problem));
    page.list(problems);
  } else {
    const DelayEstimate& d = result.delay;
    page.paragraph(fmt::format(
        "Loop delay: {}{} ticks{}. Samples lost: {:.2g} %.", d.low, d.high > d.low ? fmt::format(" to {}", d.high) : "",
        d.isCertain ? "" : ", not certain: " + escape(d.second) + " fits nearly as well", 100.0 * result.lostSamples));
  }
  if (!result.estimates.empty()) addEstimates(page, result);
  if (result.traces.torque.cols() > 0) {
    page.heading("Prediction");
    page.figure("torques", torqueFigure(result),
                "Torques below 20 Hz in a part of the recording that the fit does not use: the command, and the torque "
                "that gives the model the recorded motion.");
    page.figure("residuals", residualFigure(result),
                "Recorded minus predicted reading. A residual above the encoder's rounding shows an effect that the "
                "model lacks, for example another friction.");
  }
  if (!expected.empty()) addWalls(page, result, expected);
  std::string under;
  for (const std::string& file : files) under += (under.empty() ? "" : ", ") + escape(file);
  return page.whole("Identification of " + escape(makeMechanism(result.device)->name()), under);
}

}  // namespace enamel::app
