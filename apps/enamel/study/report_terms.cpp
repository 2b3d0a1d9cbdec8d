#include <fmt/core.h>

#include <algorithm>

#include "study/numbers.hpp"
#include "study/report_parts.hpp"

namespace enamel::app {
namespace {

std::string definitionOf(const Study& study, std::size_t column) {
  const ImpedanceOptions& spring = study.options.impedance;
  const std::string wall = fmt::format("a spring of {} N/m", givenText(spring.stiffness));
  switch (study.labels[column].kind) {
    case ColumnKind::positionControl:
      return "Enamel's own: a servo in contact space. It holds the tool on the wall's surface along the normal, "
             "pushes and never pulls, and lets the tool slide.";
    case ColumnKind::hold:
      return "the paper's proposal: a linear-quadratic servo with integrators, designed once at home, holds every "
             "joint where it was at the touch.";
    case ColumnKind::scheduled: return "hold with a servo designed at every query point instead of once at home.";
    case ColumnKind::impedance:
      return "the paper's baseline: " + wall +
             " (K_r) stands for the wall; its force follows from the depth of the tool.";
    case ColumnKind::passivity:
      return wall + " and a damper that takes back the energy that the spring was seen to make.";
    case ColumnKind::edge: return "a spring whose ticks are a quarter as long, as stiff as eq. 16 (below) allows.";
    case ColumnKind::rival: return "a rival controller with the values that were found for this device and delay.";
    case ColumnKind::plugin: break;
  }
  return "a renderer from a shared library.";
}

}  // namespace

void addTerms(Page& page, const Study& study) {
  const StudyPlan& plan = study.plan;
  const PushSetup& setup = plan.setup;
  const auto has = [&](int scenario) { return std::count(plan.scenarios.begin(), plan.scenarios.end(), scenario) > 0; };
  page.heading("What was done");
  page.paragraph(fmt::format(
      "A haptic device is a small robot that a person holds by its <b>tool</b>. Its <b>renderer</b> is the program "
      "that "
      "commands the motors at every <b>tick</b> ({} ms) so that the tool stops where it touches something that is not "
      "there: here <b>the wall</b>, the plane z = 0, with the person above it. At each of {} <b>query points</b> on "
      "the wall a person was simulated who pushes the tool into it, {} times with other forces and other noise, the "
      "same for every renderer.",
      givenText(1e3 * setup.period), plan.points(), plan.runs));
  std::vector<std::pair<std::string, std::string>> terms;
  terms.emplace_back(
      "Conditions",
      fmt::format("the delay from a measurement to the torque that answers it: {}; the person leans on the wall with "
                  "{} N before the push (preload); joint angles are {}; the random numbers are those of seed {}. Home "
                  "is the pose in the middle of the workspace, with the tool's centre at x = y = z = 0. A motor "
                  "saturates where it is asked for more than its limit. The guard stops a renderer that becomes "
                  "unsafe.",
                  delayText(study.options.delay), givenText(study.options.preload),
                  study.options.encoders ? "read in the steps of the encoders" : "known exactly", setup.seed));
  for (std::size_t c = 0; c < study.labels.size(); ++c)
    terms.emplace_back("Renderer: " + escape(study.labels[c].title), definitionOf(study, c));
  const std::string noise = givenText(setup.hand.noise);
  if (has(1))
    terms.emplace_back(
        "Scenario 1",
        fmt::format("a step: at 1 s the person's force jumps to F_c, drawn evenly from {} to {} N for each run, and "
                    "stays, with white noise of {} N (standard deviation), to the end at {} s.",
                    givenText(plan.lowestForce), givenText(plan.highestForce), noise, givenText(setup.duration)));
  if (has(2))
    terms.emplace_back(
        "Scenario 2",
        fmt::format(
            "a hand: through a spring of {} N/m and a damper of {} N s/m its movement brings a force that rises "
            "smoothly from 1 s to 2 s to F_c{}; white noise of {} N from 2 s to the end at {} s.",
            givenText(kPaperGrip.stiffness), givenText(kPaperGrip.damping),
            has(1) ? "" : fmt::format(" ({} to {} N)", givenText(plan.lowestForce), givenText(plan.highestForce)),
            noise, givenText(setup.duration)));
  terms.emplace_back("Depth", "how far the tool's centre is inside the wall; penetration is the same.");
  if (has(1)) {
    terms.emplace_back(
        "First impact: D_z1 and K_z1",
        "D_z1 is the deepest point of the continuous motion, between ticks too, up to its first return, from the mean "
        "depth in the 0.1 s before the step; the stiffness K_z1 is the force then over D_z1. A push that rings, slips "
        "or never returns has none.");
    terms.emplace_back("Depth stiffness: K_d",
                       "the force of the step over the deepest point of the continuous motion in the 0.1 s after it, "
                       "from the same mean depth. Every push has one, also one that slips or rings.");
    terms.emplace_back(
        "Share of the limit",
        "K_z1 over the largest that physics allows without a force sensor, for the push's force, preload and largest "
        "delay, and a step at the beginning of a tick; a shorter delay or a step inside a tick can exceed it.");
  }
  terms.emplace_back(
      "Steady state: D_zs, C_zs and K_zs",
      fmt::format("D_zs is the mean depth {}, signed; the compliance C_zs is D_zs over F_c; the stiffness K_zs is 1 "
                  "over the magnitude of the mean C_zs of a point's runs. That mean can be zero: a K_zs is resolved, "
                  "and given, only where it exceeds two standard errors.",
                  has(1) && has(2) ? "from 1 s (scenario 1) or 2 s (scenario 2) to the end"
                  : has(1)         ? "from 1 s to the end"
                                   : "from 2 s to the end"));
  terms.emplace_back(
      "Eq. 16 of the paper",
      "a rendered spring K_r with a damper B_r is passive (gives no energy that it has not received), and so stable, "
      "where b_m &gt; K_r T_s / 2 + |B_r|: b_m is the device's own damping along the wall's normal, T_s the tick.");
  terms.emplace_back(
      "a ± b",
      fmt::format(
          "a mean over the runs of a query point and its 95 % interval by Student's t, both rounded to the interval's "
          "second digit; “a (b to c)” is an interval with unequal arms. The lowest or highest of the {} points has "
          "the interval of its own mean, which does not count that it was chosen. What has no interval is no mean: "
          "the largest of all runs, or one simulation without noise.",
          plan.points()));
  page.terms(terms);
}

}  // namespace enamel::app
