#include <fmt/core.h>

#include <algorithm>

#include "study/numbers.hpp"
#include "study/report.hpp"

namespace enamel::app {
namespace {

std::string definitionOf(const Study& study, std::size_t column) {
  const ImpedanceOptions& spring = study.options.impedance;
  const std::string wall = fmt::format("a spring of {} N/m", givenText(spring.stiffness));
  switch (study.labels[column].kind) {
    case ColumnKind::positionControl:
      return "the renderer of Enamel, a servo in contact space. It keeps the tool at the wall's surface along the "
             "normal. It pushes, never pulls, and lets the tool slide.";
    case ColumnKind::hold:
      return "the paper's proposal, a linear-quadratic servo with integrators, designed once at home. It keeps every "
             "joint at its position at the touch.";
    case ColumnKind::scheduled: return "hold with a servo designed at every query point instead of once at home.";
    case ColumnKind::impedance:
      return "the paper's baseline: " + wall +
             " (K_r) in place of the wall. Its force is proportional to the depth of the tool.";
    case ColumnKind::passivity:
      return wall + " and a damper that removes the energy that the spring has been observed to generate.";
    case ColumnKind::edge: return "a spring whose ticks are a quarter as long, as stiff as eq. 16 (below) allows.";
    case ColumnKind::bestSpring:
      return "the spring with the largest mean K_d that loses no run, found by a search with other random numbers.";
    case ColumnKind::rival: return "a rival controller with parameters tuned for this device and delay.";
    case ColumnKind::plugin: break;
  }
  return "a renderer from a shared library.";
}

}  // namespace

void addTerms(Page& page, const Study& study) {
  const StudyPlan& plan = study.plan;
  const PushSetup& setup = plan.setup;
  const auto has = [&](int scenario) { return std::count(plan.scenarios.begin(), plan.scenarios.end(), scenario) > 0; };
  page.heading("Method");
  page.paragraph(
      fmt::format("A haptic device is a small robot. A person holds it by its <b>tool</b>. The <b>renderer</b> is the "
                  "program that commands the motors at every <b>tick</b> ({} ms) so that the tool stops at a virtual "
                  "object. Here it is <b>the wall</b>, the plane z = 0, and the person is above it. The study "
                  "simulates a person who pushes the tool into the wall at each of {} <b>query points</b>, {} times "
                  "with different forces and noise. Forces and noise are the same for every renderer.",
                  givenText(1e3 * setup.period), plan.points(), plan.runs));
  std::vector<std::pair<std::string, std::string>> terms;
  terms.emplace_back(
      "Conditions",
      fmt::format("the delay from a measurement to the torque that answers it: {}. The person leans on the wall with "
                  "{} N before the push (preload). Joint angles are {}. The seed of the random numbers is {}. Home is "
                  "the pose in the middle of the workspace, with the tool's centre at x = y = z = 0. A motor saturates "
                  "if the renderer commands more than its limit. The guard stops a renderer that becomes unsafe.",
                  delayText(study.options.delay), givenText(study.options.preload),
                  study.options.encoders ? "rounded to the steps of the encoders" : "known exactly", setup.seed));
  for (std::size_t c = 0; c < study.labels.size(); ++c)
    terms.emplace_back("Renderer: " + escape(study.labels[c].title), definitionOf(study, c));
  const std::string noise = givenText(setup.hand.noise);
  if (has(1))
    terms.emplace_back(
        "Scenario 1",
        fmt::format("a step. At 1 s the person's force jumps to F_c, which is drawn uniformly from {} to {} N for each "
                    "run. It stays there, with white noise of {} N (standard deviation), until the end at {} s.",
                    givenText(plan.lowestForce), givenText(plan.highestForce), noise, givenText(setup.duration)));
  if (has(2))
    terms.emplace_back(
        "Scenario 2",
        fmt::format(
            "a hand that moves through a spring of {} N/m and a damper of {} N s/m. Its force rises smoothly from 1 s "
            "to 2 s to F_c{}, with white noise of {} N from 2 s until the end at {} s.",
            givenText(kPaperGrip.stiffness), givenText(kPaperGrip.damping),
            has(1) ? "" : fmt::format(" ({} to {} N)", givenText(plan.lowestForce), givenText(plan.highestForce)),
            noise, givenText(setup.duration)));
  terms.emplace_back("Depth", "distance of the tool's centre inside the wall; also called penetration.");
  if (has(1)) {
    terms.emplace_back("First impact: D_z1 and K_z1",
                       "D_z1 is the depth of the first reversal of the continuous motion (also between ticks), "
                       "measured from the mean depth in the 0.1 s before the step. The stiffness K_z1 is the force at "
                       "that time divided by D_z1. A push that rings, slips or never returns has no K_z1.");
    terms.emplace_back("Depth stiffness: K_d",
                       "the force of the step divided by the deepest point of the continuous motion in the 0.1 s after "
                       "it, measured from the same mean depth. Every push has a K_d, also one that slips or rings.");
    terms.emplace_back("Share of the limit",
                       "K_z1 divided by the largest that physics allows without a force sensor. That limit is for the "
                       "push's force, preload and largest delay, and for a step at the beginning of a tick. With a "
                       "shorter delay or a step inside a tick, K_z1 can exceed it.");
  }
  terms.emplace_back(
      "Steady state: D_zs, C_zs and K_zs",
      fmt::format("D_zs is the signed mean depth {}. The compliance C_zs is D_zs divided by F_c. The stiffness K_zs is "
                  "1 divided by the magnitude of the mean C_zs of a point's runs. That mean can be zero: K_zs is "
                  "resolved, and given, only if the mean exceeds two standard errors.",
                  has(1) && has(2) ? "from 1 s (scenario 1) or 2 s (scenario 2) to the end"
                  : has(1)         ? "from 1 s to the end"
                                   : "from 2 s to the end"));
  terms.emplace_back("Eq. 16 of the paper",
                     "a rendered spring K_r with a damper B_r is passive (it never returns more energy than it "
                     "received), and so stable, if b_m &gt; K_r T_s / 2 + |B_r|. Here b_m is the device's own damping "
                     "along the wall's normal, and T_s the tick.");
  terms.emplace_back("a ± b",
                     "a mean over the runs of a query point and its 95 % interval by Student's t, both rounded to the "
                     "interval's second digit. “a (b to c)” is an asymmetric interval.");
  page.terms(terms);
}

}  // namespace enamel::app
