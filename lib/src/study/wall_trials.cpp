#include "enamel/study/wall_trials.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/message.hpp"
#include "enamel/control/first_impact.hpp"
#include "enamel/control/tuning.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/study/metrics.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/tap_metrics.hpp"

namespace enamel {
namespace {

constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();
constexpr double kOutside = 0.04;     // m: deeper in the wall is lost
constexpr double kTouch = 2e-5;       // m: nearer counts as a touch
constexpr double kImpactTime = 0.03;  // s after the touch; the impact is then over
constexpr double kPreload = 1.0;      // N
constexpr std::size_t kMaxFigures = 4;
using Figures = std::array<double, kMaxFigures>;

struct Context {
  const WallTrialSetup& setup;
  double share;         // of the forces
  double mass;          // effective along z at home, kg
  double most;          // largest force of the motors there, N
  double late;          // longest time from a sample to the first force that answers it, s
  RandomStream random;  // of the run
  int run;
};

int ticks(const Context& c, double time) { return static_cast<int>(std::lround(time / c.setup.period)); }

// The hand: a force for every tick, constant during the tick. It may jump once inside a tick.
struct Hand {
  Vec3 normal = Vec3::UnitZ();
  std::optional<Vec3> second;  // normal of another wall through the same point
  Tap tap = {};                // of the wall
  double height = 0.0;         // of the start above the wall, m
  double duration = 1.0;
  int jump = -1;                                                             // tick of the jump
  double instant = 0.0;                                                      // share of that tick
  std::function<Vec3(int tick, bool jumped, const TickRecord& last)> force;  // N
};

// `seen` returns whether to continue. Returns false if the run is lost.
bool perform(const Context& c, const Hand& hand, const std::function<bool(int, const TickRecord&)>& seen) {
  const WallTrialSetup& s = c.setup;
  LoopSetup loopSetup;
  loopSetup.scene = Scene();
  Obstacle wall = halfSpace("wall", Vec3::Zero(), hand.normal);
  wall.tap = hand.tap;
  loopSetup.scene.add(wall);
  if (hand.second) loopSetup.scene.add(halfSpace("second wall", Vec3::Zero(), *hand.second));
  loopSetup.start.position = hand.height * hand.normal;
  loopSetup.encoders = {true, RateSource::difference};
  loopSetup.wrapper = s.wrapper;
  loopSetup.delay = s.delay;
  loopSetup.period = s.period;
  loopSetup.seed = s.seed;
  loopSetup.run = static_cast<std::uint32_t>(c.run);
  loopSetup.guarded = false;
  const std::unique_ptr<Renderer> renderer = s.renderer();
  VirtualLoop loop(s.makePlant ? s.makePlant(loopSetup.run)
                               : std::make_unique<ClosedFormPlant>(*s.plant, loopSetup.integrator, loopSetup.substeps),
                   *s.model, *renderer, loopSetup);
  TickRecord tick;
  tick.pose = loopSetup.start;
  for (int i = 0; i < ticks(c, hand.duration); ++i) {
    const Vec3 noise =
        s.noise * c.share * c.random.normal(RandomStream::Purpose::noise, static_cast<std::uint64_t>(i)) * hand.normal;
    const auto load = [&](const Vec3& force) {
      return [&loopSetup, &hand, force](double, const Pose& pose, const Vec6& twist) {
        Vec6 wrench = guidingWrench(pose, twist, loopSetup.start, hand.normal);
        wrench.head<3>() += force;
        return wrench;
      };
    };
    const TickRecord last = tick;
    const auto before = load(hand.force(i, i > hand.jump && hand.jump >= 0, last) + noise);
    const Status status =
        i == hand.jump ? loop.tick(before, hand.instant * s.period, load(hand.force(i, true, last) + noise), tick)
                       : loop.tick(before, tick);
    if (status != Status::ok || tick.status != Status::ok || tick.nearest.gap < -kOutside) return false;
    if (!seen(i, tick)) break;
  }
  return true;
}

// Force of the hand along the wall's outward normal z, N.
Vec3 along(double force) { return {0.0, 0.0, force}; }

double instantOf(const Context& c) { return c.random.uniform(RandomStream::Purpose::instant, 0); }

bool step(const Context& c, Figures& figures) {
  const int onset = ticks(c, 0.5), quiet = ticks(c, 0.25), rest = ticks(c, ImpactMonitor::kRestWindow);
  const double force = c.share * (8.0 + 7.0 * c.random.uniform(RandomStream::Purpose::force, 0)),
               preload = c.share * kPreload;
  Hand hand;
  hand.duration = 1.25;
  hand.jump = onset;
  hand.instant = instantOf(c);
  hand.force = [&](int, bool jumped, const TickRecord&) { return along(jumped ? -force : -preload); };
  ImpactMonitor watch(c.setup.period);
  std::vector<JointVector> commands;
  const int end = ticks(c, hand.duration);
  const bool stayed = perform(c, hand, [&](int i, const TickRecord& tick) {
    const ImpactTick seen{tick.nearest.gap, tick.gapRate, -tick.handWrench[2], 0.0, tick.saturated, {}};
    if (i >= onset - rest && i < onset) watch.rest(seen);
    if (i > onset) watch.push(seen);
    if (i >= end - quiet) commands.push_back(tick.command);
    return true;
  });
  if (watch.verdict() == FirstImpactVerdict::measured)
    figures[0] =
        watch.stiffness() / firstImpactLimit(c.mass, c.setup.period, c.setup.delay.high, force, c.most, preload);
  figures[1] = watch.bounce();
  figures[2] = chatterOf(commands);
  return stayed;
}

bool ramp(const Context& c, Figures& figures) {
  const int onset = ticks(c, 0.5), rest = ticks(c, 0.1);
  Hand hand;
  hand.duration = 0.8;
  hand.force = [&](int i, bool, const TickRecord&) {
    return along(-c.share * (kPreload + 10.0 * std::clamp((i - onset) * c.setup.period / 0.05, 0.0, 1.0)));
  };
  double gap = 0.0;
  figures[0] = 0.0;
  return perform(c, hand, [&](int i, const TickRecord& tick) {
    if (i >= onset - rest && i < onset) gap += tick.nearest.gap / rest;
    if (i >= onset) figures[0] = std::max(figures[0], gap - tick.nearest.gap);
    return true;
  });
}

// Move the tool to the wall at a speed, then hold it with the preload. `isThrown`: free except for noise on the last
// 0.3 mm. Otherwise the hand moves it until it touches, and its integral term overcomes the friction of the device.
// `seen` also gets whether the tool has touched the wall. `trace` gets the tap.
bool strike(const Context& c, double speed, bool isThrown, const Tap& tap, std::vector<TapSample>& trace,
            const std::function<void(const TickRecord&, bool)>& seen) {
  constexpr double kGain = 60.0;  // 1/s
  bool touched = false;
  double behind = 0.0;  // m
  Hand hand;
  hand.height = 0.02;
  hand.duration = 0.06 / speed + 0.4;
  hand.tap = tap;
  hand.force = [&](int, bool, const TickRecord& last) {
    if (touched) return along(-c.share * kPreload);
    if (isThrown && last.pose.position.z() <= 3e-4 + speed * c.late) return along(0.0);
    const double tooSlow = last.twist[2] + speed;
    if (!isThrown) behind += tooSlow * c.setup.period;
    return along(-kGain * c.mass * (tooSlow + 0.25 * kGain * behind));  // critically damped
  };
  const bool stayed = perform(c, hand, [&](int, const TickRecord& tick) {
    if (!trace.empty()) trace.back().acceleration = (tick.gapRate - trace.back().rate) / c.setup.period;
    trace.push_back({tick.time, tick.nearest.gap, tick.gapRate, 0.0, tick.rendered[2]});
    touched = touched || tick.nearest.gap < kTouch;
    seen(tick, touched);
    return true;
  });
  return stayed && touched;
}

bool impact(const Context& c, double speed, Figures& figures) {
  double deepest = 0.0, early = 0.0;  // m
  int since = 0;                      // ticks
  figures[1] = 0.0;
  std::vector<TapSample> trace;
  const bool stayed = strike(c, speed, true, {}, trace, [&](const TickRecord& tick, bool touched) {
    const double gap = tick.nearest.gap;
    // The wall may push from kTouch and the way of a tick on.
    if (since == 0 && tick.rendered[2] > 0.3) early = std::max(early, gap - (kTouch - c.setup.period * tick.gapRate));
    if (!touched) return;
    if (++since < ticks(c, kImpactTime)) deepest = std::max(deepest, -gap);
    figures[1] = std::max(figures[1], gap);
  });
  figures[0] = deepest / (speed * c.late + 0.5 * c.mass * speed * speed / (c.most - c.share * kPreload));
  figures[2] = early;
  figures[3] = tapMetrics(trace, c.setup.tap).extendedRateHardness;
  return stayed;
}

bool tapAt(const Context& c, const Tap& tap, Figures& figures) {
  const double speed = 0.1 + 0.4 * c.random.uniform(RandomStream::Purpose::force, 0);
  std::vector<TapSample> trace;
  const bool stayed = strike(c, speed, false, tap, trace, [](const TickRecord&, bool) {});
  const TapMetrics m = tapMetrics(trace, c.setup.tap);
  figures = {m.rateHardness, m.extendedRateHardness, m.dynamicStiffness, m.match};
  return stayed;
}

bool plainTap(const Context& c, Figures& figures) { return tapAt(c, {}, figures); }
bool transientTap(const Context& c, Figures& figures) { return tapAt(c, c.setup.tap, figures); }
bool slowImpact(const Context& c, Figures& figures) { return impact(c, 0.05, figures); }
bool middleImpact(const Context& c, Figures& figures) { return impact(c, 0.2, figures); }
bool fastImpact(const Context& c, Figures& figures) { return impact(c, 0.5, figures); }

bool release(const Context& c, Figures& figures) {
  constexpr double kOut = 1e-3;  // m
  const double push = 12.0 * c.share, pull = 1.0 * c.share;
  Hand hand;
  hand.duration = 0.7;
  hand.jump = ticks(c, 0.5);
  hand.instant = instantOf(c);
  hand.force = [&](int, bool jumped, const TickRecord&) { return along(jumped ? pull : -push); };
  double rest = 0.0, lastGap = 0.0, lastRate = 0.0;
  figures[1] = 0.0;
  const bool stayed = perform(c, hand, [&](int i, const TickRecord& tick) {
    const double gap = tick.nearest.gap, rate = tick.gapRate;
    figures[1] = std::max(figures[1], -tick.rendered[2]);
    if (i <= hand.jump) {
      rest = gap;
    } else if (std::isnan(figures[0]) && gap - rest > kOut) {
      // Speed at this place: forces are constant during a tick, so its square is linear in the way.
      const double share = (kOut - (lastGap - rest)) / (gap - lastGap);
      const double speed = std::sqrt(lastRate * lastRate + share * (rate * rate - lastRate * lastRate));
      const double thrown = (push + pull) / c.mass * c.late, way = 0.5 * thrown * c.late;
      figures[0] = speed / std::sqrt(thrown * thrown + 2.0 * pull / c.mass * std::max(0.0, kOut - way));
      figures[2] = figures[0];
    }
    lastGap = gap;
    lastRate = rate;
    return std::isnan(figures[0]);
  });
  return stayed;
}

bool slide(const Context& c, Figures& figures) {
  const double turn = 2.0 * M_PI / 10.0 * (c.run % 10), tilt = 0.5;
  Hand hand;
  hand.normal = Vec3(std::sin(tilt) * std::cos(turn), std::sin(tilt) * std::sin(turn), std::cos(tilt));
  const Vec3 way = hand.normal.cross(Vec3::UnitX()).normalized();
  const int onset = ticks(c, 0.2);
  hand.duration = 0.5;
  hand.force = [&](int i, bool, const TickRecord& last) {
    const double pressed = 10.0 * c.share * std::min(1.0, i * c.setup.period / 0.05);
    const double drag = i < ticks(c, 0.1) ? 0.0 : 20.0 * (0.1 - way.dot(last.twist.head<3>()));
    // Cancel the guide, which would hold it back.
    const Vec3 held = kGuideGrip.stiffness * last.pose.position + kGuideGrip.damping * Vec3(last.twist.head<3>());
    return Vec3(-pressed * hand.normal + (drag + way.dot(held)) * way);
  };
  double tangential = 0.0, pressed = 0.0, squares = 0.0;
  int count = 0;
  const bool stayed = perform(c, hand, [&](int i, const TickRecord& tick) {
    if (i < onset) return true;
    const Vec3 force = tick.rendered.head<3>();
    const double normal = hand.normal.dot(force);
    tangential += (force - normal * hand.normal).norm();
    pressed += normal;
    squares += tick.nearest.gap * tick.nearest.gap;
    ++count;
    return true;
  });
  if (count > 0) figures = {tangential / std::abs(pressed), std::sqrt(squares / count), kUnseen};
  return stayed;
}

bool corner(const Context& c, Figures& figures) {
  Hand hand;
  const double turn = 2.0 * M_PI / 10.0 * (c.run % 10);
  const Vec3 side(std::cos(turn), std::sin(turn), 0.0);
  hand.normal = (Vec3::UnitZ() + side).normalized();
  hand.second = (Vec3::UnitZ() - side).normalized();
  hand.duration = 1.0;
  hand.force = [&](int i, bool, const TickRecord&) {
    return along(-10.0 * c.share * std::min(1.0, i * c.setup.period / 0.05));
  };
  const int settled = ticks(c, 0.5);
  std::vector<JointVector> commands;
  figures = {0.0, kUnseen, kUnseen};
  const bool stayed = perform(c, hand, [&](int i, const TickRecord& tick) {
    if (i < settled) return true;
    figures[0] = std::max(figures[0], -tick.nearest.gap);
    commands.push_back(tick.command);
    return true;
  });
  figures[1] = chatterOf(commands);
  return stayed;
}

bool pulse(const Context& c, Figures& figures) {
  const int begin = ticks(c, 0.6), end = ticks(c, 0.61);
  Hand hand;
  hand.duration = 1.2;
  hand.force = [&](int i, bool, const TickRecord&) {
    return along(i >= begin && i < end ? -1.5 * c.most : -c.share * kPreload);
  };
  Kinematics k = c.setup.model->home();
  figures = {0.0, 0.0, kUnseen};
  return perform(c, hand, [&](int, const TickRecord& tick) {
    const JointVector& torque = tick.requested;
    figures[0] = std::max(figures[0], (torque.array().abs() / c.setup.plant->limits().effort.array()).maxCoeff());
    if (c.setup.model->track(tick.q, JointVector::Zero(tick.q.size()), false, k) != Status::ok) return false;
    const Vec3 force = wrenchOf(k, torque - k.gravity).head<3>();
    if (force.norm() > c.share) figures[1] = std::max(figures[1], std::atan2(force.head<2>().norm(), force.z()));
    return true;
  });
}

bool overload(const Context& c, Figures& figures) {
  const int onset = ticks(c, 0.3), falls = ticks(c, 1.3);
  Hand hand;
  hand.duration = 1.8;
  hand.force = [&](int i, bool, const TickRecord&) {
    const double fallen = std::clamp((i - falls) * c.setup.period / 0.02, 0.0, 1.0);
    return along(-c.share * (i < onset ? kPreload : 45.0 - 35.0 * fallen));
  };
  figures = {0.0, kUnseen, kUnseen};
  return perform(c, hand, [&](int i, const TickRecord& tick) {
    if (i >= falls) figures[0] = std::max(figures[0], tick.nearest.gap);
    return true;
  });
}

struct FigureKind {
  const char* name;
  const char* unit;
  double scale;  // from SI to the unit
  bool lowestIsWorst = false, isMean = false;
};

struct Kind {
  const char* name;
  bool (*run)(const Context&, Figures&);
  std::vector<FigureKind> figures;
};

const std::vector<Kind>& kinds() {
  const std::vector<FigureKind> impactFigures = {{"depth of the allowed", "%", 100.0},
                                                 {"bounce", "um", 1e6},
                                                 {"pushed too early", "um", 1e6},
                                                 {"extended rate-hardness", "kN/m", 1e-3, true}};
  const std::vector<FigureKind> tapFigures = {{"mean rate-hardness", "kN/m", 1e-3, true, true},
                                              {"mean extended rate-hardness", "kN/m", 1e-3, true, true},
                                              {"mean dynamic stiffness", "kN/m", 1e-3, true, true},
                                              {"mean match", "%", 100.0, true, true}};
  static const std::vector<Kind> all = {
      {"step", step, {{"share of the limit", "%", 100.0, true}, {"bounce", "um", 1e6}, {"chatter", "N m", 1.0}}},
      {"ramp", ramp, {{"depth", "um", 1e6}}},
      {"impact 0.05 m/s", slowImpact, impactFigures},
      {"impact 0.2 m/s", middleImpact, impactFigures},
      {"impact 0.5 m/s", fastImpact, impactFigures},
      {"tap plain", plainTap, tapFigures},
      {"tap transient", transientTap, tapFigures},
      {"release",
       release,
       {{"speed over the unavoidable", "", 1.0},
        {"pull", "N", 1.0},
        {"mean speed over the unavoidable", "", 1.0, false, true}}},
      {"slide", slide, {{"tangential force", "%", 100.0}, {"rms depth", "um", 1e6}}},
      {"corner", corner, {{"depth", "um", 1e6}, {"chatter", "N m", 1.0}}},
      {"pulse", pulse, {{"torque of the limit", "%", 100.0}, {"turned", "deg", 180.0 / M_PI}}},
      {"overload", overload, {{"bounce", "um", 1e6}}},
  };
  return all;
}

}  // namespace

double forceShare(const Mechanism& plant) {
  Kinematics k = plant.home();
  require(plant.reach(k.pose, Vec6::Zero(), true, k) == Status::ok, "wall trials: the home pose cannot be reached");
  return std::min(1.0, 0.3 * largestForce(k, plant.limits().effort, k.pose.position, Vec3::UnitZ()) / 15.0);
}

std::vector<std::string> wallTrialNames() {
  std::vector<std::string> names;
  for (const Kind& kind : kinds()) names.emplace_back(kind.name);
  return names;
}

std::vector<WallFigure> runWallTrials(const WallTrialSetup& setup, const std::string& filter, int threads) {
  require(setup.plant && setup.model && setup.renderer, "wall trials: a plant, a model and a renderer are needed");
  require(setup.runs >= 1 && setup.runs <= 10000,
          "wall trials: the runs are " + std::to_string(setup.runs) + ", must be in 1 to 10000");
  const double share = forceShare(*setup.plant);
  Kinematics home = setup.plant->home();
  require(setup.plant->reach(home.pose, Vec6::Zero(), true, home) == Status::ok,
          "wall trials: the home pose cannot be reached");
  const double mass = effectiveMass(home, home.pose.position, Vec3::UnitZ()),
               most = largestForce(home, setup.plant->limits().effort, home.pose.position, Vec3::UnitZ()),
               late = (setup.delay.high + 1) * setup.period;

  std::vector<const Kind*> chosen;
  for (const Kind& kind : kinds())
    if (std::string(kind.name).find(filter) != std::string::npos) chosen.push_back(&kind);
  const auto runs = static_cast<std::size_t>(setup.runs);
  std::vector<Figures> figures(chosen.size() * runs, Figures{kUnseen, kUnseen, kUnseen, kUnseen});
  std::vector<char> stayed(figures.size());
  parallelFor(figures.size(), threads, [&](std::size_t i) {
    const int run = static_cast<int>(i % runs);
    const Context context{setup, share, mass, most, late, RandomStream(setup.seed, static_cast<std::uint32_t>(run)),
                          run};
    stayed[i] = chosen[i / runs]->run(context, figures[i]);
  });

  std::vector<WallFigure> rows;
  for (std::size_t k = 0; k < chosen.size(); ++k)
    for (std::size_t f = 0; f < chosen[k]->figures.size(); ++f) {
      const FigureKind& kind = chosen[k]->figures[f];
      WallFigure row{chosen[k]->name, kind.name, kind.unit, kUnseen, 0};
      double sum = 0.0;
      int count = 0;
      for (std::size_t i = k * runs; i < (k + 1) * runs; ++i) {
        row.lost += stayed[i] == 0;
        const double value = kind.scale * figures[i][f];
        if (stayed[i] == 0 || std::isnan(value)) continue;
        sum += value;
        ++count;
        if (std::isnan(row.value) || (kind.lowestIsWorst ? value < row.value : value > row.value)) row.value = value;
      }
      if (kind.isMean && count > 0) row.value = sum / count;
      rows.push_back(row);
    }
  return rows;
}

}  // namespace enamel
