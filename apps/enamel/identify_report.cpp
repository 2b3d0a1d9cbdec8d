#include "identify_report.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "design_expectation.hpp"
#include "study/page.hpp"
#include "study/svg.hpp"

namespace enamel::app {
namespace {

constexpr double kShown = 3.0;  // s, of the traces
constexpr const char* kColours[] = {kBlue, kVermilion, kGreen, kOrange, kPurple, kSky, kBrown, kMuted, kInk, kRed};
constexpr double kLeft = 90.0, kPanelWidth = Svg::kWidth - kLeft - 20.0;

const char* colourOf(Eigen::Index joint) { return kColours[static_cast<std::size_t>(joint) % std::size(kColours)]; }

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

// Torques of one joint: command, and what the model needs for the recorded motion.
std::string torqueFigure(const Identification& result) {
  const IdentificationTraces& t = result.traces;
  const Eigen::Index joints = t.torque.rows(), all = t.torque.cols();
  const Eigen::Index count = std::min(all, static_cast<Eigen::Index>(kShown / t.period)), first = (all - count) / 2;
  constexpr double kHeight = 110.0, kStride = 150.0, kTop = 40.0;
  Svg svg;
  addLegend(svg, {kLeft, 10.0}, kPanelWidth, {{"command", {kInk, 1.5, false}}, {"model", {kVermilion, 1.5, true}}});
  std::vector<double> times;
  for (Eigen::Index i = 0; i < count; ++i) times.push_back(static_cast<double>(i) * t.period);
  for (Eigen::Index joint = 0; joint < joints; ++joint) {
    const auto row = static_cast<std::size_t>(joint);
    Extent extent;
    std::vector<double> command, model;
    for (Eigen::Index i = first; i < first + count; ++i) {
      command.push_back(t.torque(joint, i));
      model.push_back(t.explained(joint, i));
      extent.see(command.back());
      extent.see(model.back());
    }
    Axis time{"time, s", 0.0, times.back()};
    time.numbers = joint + 1 == joints;
    if (!time.numbers) time.title.clear();
    Panel panel(svg, {kLeft, kTop + kStride * static_cast<double>(joint)}, kPanelWidth, kHeight, time,
                extent.axis(isLinear(t.joint[row]) ? "N" : "N m", 0.1),
                fmt::format("{}: {:.2f} % explained", t.joint[row], 100.0 * result.explained[joint]));
    panel.curve(times, command, {kInk, 1.5, false});
    panel.curve(times, model, {kVermilion, 1.5, true});
  }
  return svg.whole("Torques of command and model", kTop + kStride * static_cast<double>(joints) + 20.0);
}

// Spectra of the residuals, and the density of rounding.
std::string residualFigure(const Identification& result) {
  const IdentificationTraces& t = result.traces;
  // A rounding error has the variance step^2 / 12, equally at all frequencies up to 1 / (2 period).
  const JointVector rounding = 1e6 * std::sqrt(t.period / 6.0) * makeMechanism(result.device)->limits().encoderStep;
  Svg svg;
  Extent frequencies, densities;
  std::vector<double> xs;
  for (Eigen::Index k = 1; k < t.frequency.size(); ++k) {
    xs.push_back(t.frequency[k]);
    frequencies.see(xs.back());
  }
  std::vector<LegendEntry> entries;
  for (Eigen::Index joint = 0; joint < t.residual.rows(); ++joint) {
    entries.push_back({t.joint[static_cast<std::size_t>(joint)], {colourOf(joint), 1.5, false}});
    densities.see(rounding[joint]);
    for (Eigen::Index k = 1; k < t.frequency.size(); ++k) densities.see(1e6 * t.residual(joint, k));
  }
  entries.push_back({"rounding of its encoder", {kMuted, 1.0, true}});
  const double legend = addLegend(svg, {kLeft, 10.0}, kPanelWidth, entries);
  const std::string unit = !isLinear(t.joint.front()) ? "µrad" : isLinear(t.joint.back()) ? "µm" : "µm or µrad";
  Panel panel(svg, {kLeft, 30.0 + legend}, kPanelWidth, 280.0, frequencies.axis("frequency, Hz", 0.0, true),
              densities.axis(unit + " / √Hz", 0.1, true));
  for (Eigen::Index joint = 0; joint < t.residual.rows(); ++joint) {
    std::vector<double> ys;
    for (Eigen::Index k = 1; k < t.frequency.size(); ++k) ys.push_back(1e6 * t.residual(joint, k));
    panel.curve(xs, ys, {colourOf(joint), 1.5, false});
    panel.level(rounding[joint], {kMuted, 1.0, true});
  }
  return svg.whole("Spectra of the residuals", 30.0 + legend + 280.0 + 50.0);
}

void addWalls(Page& page, const Identification& result, const std::vector<WallExpectation>& expected) {
  page.heading("Wall to expect");
  std::vector<std::vector<std::string>> rows;
  for (const WallExpectation& e : expected) {
    const bool isOwn = e.delay >= result.delay.low && e.delay <= result.delay.high;
    rows.push_back({fmt::format("{}{}", e.delay, isOwn ? " (this loop)" : ""),
                    fmt::format("{:.3g}", 1e-3 * e.stiffness), fmt::format("{:.3f}", e.chatter),
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
    page.figure(torqueFigure(result),
                "Torques below 20 Hz in a part of the recording that the fit does not use: the command, and the torque "
                "that gives the model the recorded motion.");
    page.figure(residualFigure(result),
                "Recorded minus predicted reading. A residual above the encoder's rounding shows an effect that the "
                "model lacks, for example another friction.");
  }
  if (!expected.empty()) addWalls(page, result, expected);
  std::string under;
  for (const std::string& file : files) under += (under.empty() ? "" : ", ") + escape(file);
  return page.whole("Identification of " + escape(makeMechanism(result.device)->name()), under);
}

}  // namespace enamel::app
