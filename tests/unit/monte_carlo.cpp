// The study: its runs, their statistics, the file of runs.
#include "enamel/study/monte_carlo.hpp"

#include <atomic>
#include <cmath>
#include <limits>
#include <set>

#include "enamel/core/error.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/study/parallel.hpp"
#include "enamel/study/run_file.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/reference.hpp"
#include "support/temporary_folder.hpp"

namespace enamel::test_monte_carlo {

namespace {

StudyPlan smallPlan(int grid, int runs) {
  StudyPlan plan;
  plan.grid = grid;
  plan.runs = runs;
  plan.setup.duration = 1.1;
  const DeviceParameters device = test::nominal();
  DeviceParameters damped = device;
  addDamping(damped, 4.0 * Vec6::Unit(2));
  const ServoGain gain = test::referenceServo("K");
  plan.columns.push_back({"hold", makeMechanism(device),
                          [gain](std::size_t) { return std::make_unique<HoldRenderer>(gain, 1e-3, HoldOptions{}); }});
  plan.columns.push_back({"impedance", makeMechanism(damped),
                          [](std::size_t) { return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{}); }});
  return plan;
}

// Return runs of one point with given compliances.
std::vector<StudyResult> runsWith(const std::vector<double>& compliances) {
  std::vector<StudyResult> runs(compliances.size());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    runs[i].run.force = 10.0;
    runs[i].metrics.steadyCompliance = compliances[i];
    runs[i].metrics.rmsDepth = 1e-3;
    runs[i].metrics.depth95 = 2e-3;
  }
  return runs;
}

void withoutFirst(StudyResult& result, FirstImpactVerdict verdict) {
  result.metrics.verdict = verdict;
  result.metrics.firstDepth = result.metrics.firstStiffness = result.metrics.limitShare = std::nullopt;
}

// Return all results of a plan without simulation: numbers that depend only on the run.
std::vector<StudyResult> invented(const StudyPlan& plan) {
  std::vector<StudyResult> results;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    StudyResult r;
    r.run = runAt(plan, i);
    const RandomStream random(77, static_cast<std::uint32_t>(i));
    const auto number = [&random](std::uint64_t n) { return random.uniform(RandomStream::Purpose::test, n); };
    r.metrics.verdict = FirstImpactVerdict::measured;
    r.metrics.firstStiffness = 1e4 * (1.0 + number(0));
    r.metrics.firstDepth = 1e-3 * number(1);
    r.metrics.steadyCompliance = 1e-6 * (number(2) - 0.2);
    r.metrics.steadyDepth = r.run.force * r.metrics.steadyCompliance;
    r.metrics.rmsDepth = 1e-3 * number(3) + 1e-9;
    r.metrics.depth95 = 1e-3 * number(4) + 1e-9;
    r.metrics.largestDepth = 1e-3 * number(5);
    r.metrics.work = -number(6) / 3.0;
    r.metrics.limitShare = number(7);
    r.metrics.bounce = 1e-4 * number(8);
    r.metrics.faults = i;
    if (r.run.scenario == 2) withoutFirst(r, FirstImpactVerdict::noStep);
    results.push_back(r);
  }
  return results;
}

}  // namespace

TEST_CASE("query points are those of the paper", "[monte_carlo]") {
  const StudyPlan plan = smallPlan(11, 1);
  REQUIRE(plan.points() == 121);
  for (int j = 0; j < 11; ++j)
    for (int i = 0; i < 11; ++i) {
      const Vec3 p = queryPoint(plan, static_cast<std::size_t>(11 * j + i));
      CHECK(p == Vec3((5 * i - 25) / 1e3, (5 * j - 25) / 1e3, 0.0));
    }
  CHECK(queryPoint(smallPlan(1, 1), 0) == Vec3::Zero());
}

TEST_CASE("runs: every one once, forces uniform in 8 to 15 N and the same for every renderer", "[monte_carlo]") {
  const StudyPlan plan = smallPlan(11, 20);
  REQUIRE(plan.size() == 9680);
  std::set<std::uint32_t> streams;
  std::set<std::tuple<int, std::size_t, std::size_t, int>> seen;
  double sum = 0.0, low = 1e9, high = 0.0;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const StudyRun run = runAt(plan, i);
    seen.insert({run.scenario, run.column, run.point, run.run});
    if (run.column == 0) {
      streams.insert(run.stream);
      sum += run.force;
      low = std::min(low, run.force);
      high = std::max(high, run.force);
    } else {
      const StudyRun other = runAt(plan, i - plan.points() * 20);
      CHECK((other.column == 0 && other.force == run.force && other.stream == run.stream));
    }
  }
  CHECK(seen.size() == plan.size());
  CHECK(streams.size() == plan.size() / 2);
  CHECK(low >= 8.0);
  CHECK(high < 15.0);
  // Five standard errors of the mean of 4840 uniform numbers.
  CHECK(sum / 4840 == Approx(11.5).margin(5.0 * 7.0 / std::sqrt(12.0 * 4840)));
  // More runs keep the earlier ones.
  CHECK(runAt(smallPlan(11, 30), 30 * 7 + 3).force == runAt(plan, 20 * 7 + 3).force);
}

TEST_CASE("statistics agree with independent formulas", "[monte_carlo]") {
  const StudyPlan plan = smallPlan(1, 9);
  std::vector<StudyResult> runs = invented(plan);
  runs.resize(9);  // scenario 1, first column
  withoutFirst(runs[2], FirstImpactVerdict::rings);
  runs[5].status = Status::unreachable;
  runs[5].metrics = {};
  const PointStatistics s = statisticsOf(runs);
  CHECK(s.runs == 9);
  CHECK(s.failed == 1);
  const Spread& first = s.of(&PushMetrics::firstStiffness);
  CHECK(first.count == 7);
  CHECK(s.of(&PushMetrics::firstDepth).count == 7);
  CHECK(s.of(&PushMetrics::steadyCompliance).count == 8);
  // Welford's recursion in long double, in another way.
  long double mean = 0, squares = 0, overRms = 0;
  int n = 0;
  double largest = 0;
  for (int i : {8, 7, 6, 4, 3, 2, 1, 0}) {
    const PushMetrics& m = runs[static_cast<std::size_t>(i)].metrics;
    largest = std::max(largest, m.largestDepth);
    overRms += runs[static_cast<std::size_t>(i)].run.force / m.rmsDepth / 8.0L;
    if (!m.firstStiffness) continue;
    const long double d = *m.firstStiffness - mean;
    mean += d / ++n;
    squares += d * (*m.firstStiffness - mean);
  }
  CHECK(first.mean == Approx(static_cast<double>(mean)).epsilon(1e-14));
  CHECK(first.deviation == Approx(std::sqrt(static_cast<double>(squares) / 6)).epsilon(1e-13));
  CHECK(s.forceOverRms.mean == Approx(static_cast<double>(overRms)).epsilon(1e-14));
  CHECK(s.largestDepth == largest);
  // Every metric comes from its own member: each run's work is another third of a number.
  double work = 0.0;
  for (const int i : {0, 1, 2, 3, 4, 6, 7, 8}) work += runs[static_cast<std::size_t>(i)].metrics.work / 8.0;
  CHECK(s.of(&PushMetrics::work).mean == Approx(work).epsilon(1e-14));
}

TEST_CASE("runs without a first impact are counted by the reason", "[monte_carlo]") {
  const StudyPlan plan = smallPlan(2, 3);
  std::vector<StudyResult> results = invented(plan);
  // Scenario 1, first column: runs 0 to 11, three per point.
  withoutFirst(results[0], FirstImpactVerdict::rings);
  withoutFirst(results[4], FirstImpactVerdict::rings);
  withoutFirst(results[5], FirstImpactVerdict::slips);
  withoutFirst(results[9], FirstImpactVerdict::noReturn);
  withoutFirst(results[10], FirstImpactVerdict::noReturn);
  withoutFirst(results[11], FirstImpactVerdict::noReturn);
  results[2].status = Status::unreachable;
  results[2].metrics = {};  // the verdict of a run that never returned
  const auto points = pointStatistics(plan, results);
  CHECK(points[0].verdicts == VerdictCounts{1, 0, 0, 1, 0});
  CHECK(points[1].verdicts == VerdictCounts{1, 0, 0, 1, 1});
  CHECK(points[2].verdicts == VerdictCounts{3, 0, 0, 0, 0});
  CHECK(points[3].verdicts == VerdictCounts{0, 0, 3, 0, 0});
  CHECK(std::isnan(points[3].of(&PushMetrics::firstStiffness).mean));
  const auto walls = summarise(plan, points);
  CHECK(walls[0].verdicts == VerdictCounts{5, 0, 3, 2, 1});
  CHECK(walls[0].withoutFirst() == 6);
  CHECK(walls[0].failed == 1);
  CHECK(walls[1].withoutFirst() == 0);
  for (const std::size_t secondScenario : {2u, 3u}) {
    CHECK(walls[secondScenario].verdicts == VerdictCounts{0, 12, 0, 0, 0});
    CHECK(walls[secondScenario].withoutFirst() == 0);
  }
}

TEST_CASE("K_zs is unresolved below two standard errors, and never zero or infinite", "[monte_carlo]") {
  // Two values m +- d: deviation sqrt(2) d, standard error d.
  CHECK_FALSE(statisticsOf(runsWith({1.99e-6 + 1e-6, 1.99e-6 - 1e-6})).steadyStiffness.has_value());
  CHECK(statisticsOf(runsWith({2.01e-6 + 1e-6, 2.01e-6 - 1e-6})).steadyStiffness.value() ==
        Approx(1.0 / 2.01e-6).epsilon(1e-12));
  // A tool that is pushed out on average has a negative compliance.
  CHECK(statisticsOf(runsWith({-2e-6, -2.1e-6})).steadyStiffness.value() == Approx(1.0 / 2.05e-6).epsilon(1e-12));
  CHECK_FALSE(statisticsOf(runsWith({0.0, 0.0})).steadyStiffness.has_value());
  CHECK_FALSE(statisticsOf(runsWith({1e-6})).steadyStiffness.has_value());
  CHECK(statisticsOf(runsWith({1e-6, 1e-6})).steadyStiffness.value() == Approx(1e6));
}

TEST_CASE("where every run failed there are no figures, and extremes do not see them", "[monte_carlo]") {
  const StudyPlan plan = smallPlan(2, 3);
  std::vector<StudyResult> results = invented(plan);
  for (StudyResult& r : results)
    if (r.run.column == 1 && r.run.point != 2) r.status = Status::singular;
  const auto points = pointStatistics(plan, results);
  REQUIRE(points.size() == 2 * 2 * 4);
  for (const PointStatistics& p : points) {
    const bool lost = p.column == 1 && p.point != 2;
    CHECK(p.failed == (lost ? 3 : 0));
    CHECK(std::isnan(p.of(&PushMetrics::steadyCompliance).mean) == lost);
    CHECK(std::isnan(p.of(&PushMetrics::firstStiffness).mean) == (lost || p.scenario == 2));
  }
  const auto walls = summarise(plan, points);
  REQUIRE(walls.size() == 4);
  for (const WallSummary& w : walls) {
    double low = 1e300, high = 0.0, lowShare = 1e300, bounce = 0.0;
    int unresolved = 0;
    for (const PointStatistics& p : points) {
      if (p.scenario != w.scenario || p.column != w.column) continue;
      const double first = p.of(&PushMetrics::firstStiffness).mean;
      if (first < low) low = first;
      if (first > high) high = first;
      unresolved += !p.steadyStiffness;
      const double share = p.of(&PushMetrics::limitShare).mean, gap = p.of(&PushMetrics::bounce).mean;
      if (share < lowShare) lowShare = share;
      if (gap > bounce) bounce = gap;
    }
    CHECK(w.bounce == bounce);
    CHECK(w.lowestShare.has_value() == (w.scenario == 1));
    REQUIRE(w.lowestCompliance.has_value());
    CHECK(w.highestCompliance->value >= w.lowestCompliance->value);
    if (w.column == 1) CHECK((w.lowestCompliance->point == 2 && w.highestCompliance->point == 2));
    if (w.lowestShare) CHECK(w.lowestShare->value == lowShare);
    CHECK(w.unresolved == unresolved);
    CHECK(w.lowestFirst.has_value() == (w.scenario == 1));
    if (!w.lowestFirst) continue;
    CHECK(w.lowestFirst->value == low);
    CHECK(w.highestFirst->value == high);
    CHECK(w.failed == (w.column == 1 ? 9 : 0));
    if (w.column == 1) CHECK(w.lowestFirst->point == 2);
  }
  for (StudyResult& r : results) r.status = Status::singular;
  for (const WallSummary& w : summarise(plan, pointStatistics(plan, results))) {
    CHECK_FALSE((w.lowestFirst || w.lowestShare || w.lowestSteady || w.lowestCompliance || w.highestCompliance));
    CHECK((std::isnan(w.lowestOverRms) && std::isnan(w.lowestOver95)));
  }
}

TEST_CASE("the order of results does not depend on threads, and stopping leaves a prefix", "[monte_carlo]") {
  for (const int threads : {1, 2, 7}) {
    std::vector<int> worked(500, 0);
    std::vector<std::size_t> order;
    const std::size_t reached = parallelInOrder(
        3, worked.size(), threads, [&](std::size_t i) { ++worked[i]; }, [&](std::size_t i) { order.push_back(i); },
        [] { return false; });
    CHECK(reached == worked.size());
    REQUIRE(order.size() == 497);
    for (std::size_t i = 0; i < order.size(); ++i) CHECK(order[i] == i + 3);
    for (std::size_t i = 0; i < worked.size(); ++i) CHECK(worked[i] == (i < 3 ? 0 : 1));
  }
  std::atomic<std::size_t> done{0};
  std::vector<std::size_t> order;
  const std::size_t reached = parallelInOrder(
      0, 10000, 2, [](std::size_t) {}, [&](std::size_t i) { order.push_back(i), done = i; },
      [&] { return done >= 20; });
  CHECK(reached == order.size());
  CHECK(reached >= 20);
  CHECK(reached < 10000);
  for (std::size_t i = 0; i < order.size(); ++i) CHECK(order[i] == i);
  // Failing indices never complete; the exception arrives here.
  CHECK_THROWS_WITH(parallelInOrder(
                        0, 100, 2,
                        [](std::size_t i) {
                          if (i == 50) throw Error("fifty");
                        },
                        [](std::size_t) {}, [] { return false; }),
                    "fifty");
  CHECK_THROWS_WITH(parallelFor(1, 0, [](std::size_t) {}), "threads is 0, must be in 1 to 256");
  CHECK_THROWS_WITH(parallelFor(1, 257, [](std::size_t) {}), "threads is 257, must be in 1 to 256");
  const auto none = [](std::size_t) {};
  CHECK_THROWS_WITH(parallelInOrder(0, 1, std::numeric_limits<int>::max(), none, none, [] { return false; }),
                    "threads is 2147483647, must be in 1 to 256");
}

TEST_CASE("runs have the same bits in any thread and order", "[monte_carlo]") {
  const StudyPlan plan = smallPlan(2, 1);
  std::vector<std::string> forward(plan.size()), backward(plan.size());
  for (std::size_t i = 0; i < plan.size(); ++i) forward[i] = runLine(plan, performRun(plan, runAt(plan, i)));
  parallelFor(plan.size(), 3, [&](std::size_t i) {
    const std::size_t k = plan.size() - 1 - i;
    backward[k] = runLine(plan, performRun(plan, runAt(plan, k)));
  });
  CHECK(forward == backward);
  CHECK(std::set<std::string>(forward.begin(), forward.end()).size() == plan.size());
}

TEST_CASE("a step inside its tick: another instant each run, no other number", "[monte_carlo]") {
  StudyPlan plan = smallPlan(1, 200), inside = plan;
  inside.insideTick = true;
  double sum = 0.0;
  std::set<double> instants;
  for (int i = 0; i < plan.runs; ++i) {
    const StudyRun run = runAt(inside, static_cast<std::size_t>(i));
    CHECK(run.force == runAt(plan, static_cast<std::size_t>(i)).force);
    const double instant = randomInstant(plan.setup.seed, run.stream);
    REQUIRE((instant >= 0.0 && instant < 1.0));
    instants.insert(instant);
    sum += instant / plan.runs;
  }
  CHECK(instants.size() == 200);
  CHECK(sum == Approx(0.5).margin(5.0 / std::sqrt(12.0 * plan.runs)));
  const StudyRun run = runAt(plan, 3);
  std::vector<double> before, after;
  (void)performRun(plan, run, [&](const TickRecord& t) { before.push_back(t.handWrench[2]); });
  (void)performRun(inside, run, [&](const TickRecord& t) { after.push_back(t.handWrench[2]); });
  REQUIRE(before.size() == after.size());
  for (std::size_t i = 0; i < before.size(); ++i)
    CHECK(after[i] == Approx(before[i] + (i == 1000 ? run.force : 0.0)).margin(1e-12));
}

TEST_CASE("a file of runs survives being torn, and takes nobody else's runs", "[monte_carlo]") {
  const test::TemporaryFolder folder;
  const std::string path = folder / "runs.csv";
  const StudyPlan plan = smallPlan(2, 3);
  std::vector<StudyResult> results = invented(plan);
  results[4].status = Status::unreachable;
  const auto writeAll = [&](std::size_t first) {
    RunFile file(plan, path, first > 0);
    REQUIRE(file.finished() == first);
    for (std::size_t i = first; i < results.size(); ++i) file.append(results[i]);
  };
  writeAll(0);
  const std::string whole = test::readFile(path);
  const std::vector<StudyResult> read = readRuns(plan, path);
  REQUIRE(read.size() == results.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    CHECK(runLine(plan, read[i]) == runLine(plan, results[i]));  // exact, so that the statistics are equal
    CHECK(read[i].metrics.firstStiffness.has_value() == (results[i].metrics.firstStiffness.has_value() && i != 4));
  }
  // Torn anywhere, it continues after the last whole line and gives the same bytes.
  for (std::size_t length = 0; length < whole.size(); length += 97) {
    test::writeFile(path, whole.substr(0, length));
    const auto lines =
        static_cast<std::size_t>(std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length), '\n'));
    RunFile file(plan, path, true);
    REQUIRE(file.finished() == (lines == 0 ? 0 : lines - 1));
    for (std::size_t i = file.finished(); i < results.size(); ++i) file.append(results[i]);
    REQUIRE(test::readFile(path) == whole);
  }
  // While one process writes, no other one does.
  {
    RunFile file(plan, path, true);
    CHECK_THROWS_WITH(RunFile(plan, path, true), test::ContainsSubstring("does another study write it?"));
    CHECK(test::readFile(path) == whole);
  }
  StudyPlan otherSeed = smallPlan(2, 3);
  otherSeed.setup.seed = 2;
  CHECK_THROWS_WITH(RunFile(otherSeed, path, true), test::ContainsSubstring("runs.csv:2: is not run 0 of this study"));
  CHECK_THROWS_WITH(RunFile(smallPlan(2, 1), path, true), test::ContainsSubstring("is not run"));
  CHECK(test::readFile(path) == whole);
  const std::size_t second = whole.find('\n', whole.find('\n') + 1);
  const auto damaged = [&](const std::string& text) {
    test::writeFile(path, text);
    return [&] { (void)readRuns(plan, path); };
  };
  CHECK_THROWS_WITH(damaged(whole + "1,hold\n")(), test::ContainsSubstring("more runs than this study has"));
  CHECK_THROWS_WITH(damaged("a,b\n" + whole)(),
                    test::ContainsSubstring("runs.csv:1: is not the header of a file of runs"));
  CHECK_THROWS_WITH(damaged(whole.substr(0, second) + ",1" + whole.substr(second))(),
                    test::ContainsSubstring("runs.csv:2: has the wrong number of columns"));
  std::string letters = whole;
  letters.replace(second - 1, 1, "x");
  CHECK_THROWS_WITH(damaged(letters)(), test::ContainsSubstring("is not a number"));
}

TEST_CASE("plans that cannot be run are refused", "[monte_carlo]") {
  const auto refuse = [](auto change, const std::string& message) {
    StudyPlan plan = smallPlan(3, 1);
    change(plan);
    CHECK_THROWS_WITH(checkStudy(plan), message);
  };
  refuse([](StudyPlan& p) { p.grid = 0; }, "grid is 0, must be in 1 to 101 query points a side");
  refuse([](StudyPlan& p) { p.grid = 102; }, "grid is 102, must be in 1 to 101 query points a side");
  refuse([](StudyPlan& p) { p.runs = 0; }, "runs is 0, must be in 1 to 10000 a query point");
  refuse([](StudyPlan& p) { p.columns.clear(); }, "the study has no renderer");
  refuse([](StudyPlan& p) { p.scenarios.clear(); }, "the study has no scenario");
  refuse([](StudyPlan& p) { p.scenarios = {3}; }, "scenario is 3, must be 1 or 2");
  refuse([](StudyPlan& p) { p.setup.delay = {2, 1}; }, "delay is 2..1, must be in 0 to 63 ticks, the smaller first");
  refuse([](StudyPlan& p) { p.halfWidth = 0.3; }, "query point (-300, -300) mm is unreachable");
  CHECK_NOTHROW(checkStudy(smallPlan(3, 1)));
}

TEST_CASE("a column may have shorter ticks: delay and density of the noise stay", "[monte_carlo]") {
  StudyPlan plan = smallPlan(1, 1);
  plan.setup.delay = {0, 3};
  plan.setup.duration = 1.3;
  plan.columns[1].period = 0.25e-3;
  plan.columns[1].make = [](std::size_t) { return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{1e3, 0.0}); };
  const StudyRun run = runAt(plan, 1);
  REQUIRE(run.column == 1);
  const PushSetup fast = setupOf(plan, run), slow = setupOf(plan, runAt(plan, 0));
  CHECK(slow.period == plan.setup.period);
  CHECK(fast.period == 0.25e-3);
  CHECK(fast.delay.high == 12);
  CHECK(fast.hand.noise == 2.0 * slow.hand.noise);  // a quarter of the time per sample, the same power per hertz
  std::size_t ticks = 0;
  REQUIRE(performRun(plan, run, [&](const TickRecord&) { ++ticks; }).status == Status::ok);
  CHECK(ticks == 5200);
  plan.columns[1].period = 0.3e-3;
  CHECK_THROWS_WITH(setupOf(plan, run), test::ContainsSubstring("not a multiple"));
}

TEST_CASE("a run that the guard stops says so and is not measured", "[monte_carlo]") {
  StudyPlan plan = smallPlan(1, 1);
  plan.setup.delay = {8, 8};  // a stiff spring with delay gives energy
  plan.columns[1].plant = plan.columns[0].plant;
  plan.columns[1].make = [](std::size_t) { return std::make_unique<ImpedanceRenderer>(ImpedanceOptions{5e4, 0.0}); };
  std::size_t ticks = 0;
  const StudyResult result = performRun(plan, runAt(plan, 1), [&](const TickRecord&) { ++ticks; });
  CHECK(ticks > 0);
  CHECK(ticks < 1100);
  CHECK(result.status == Status::stopped);
  CHECK(result.metrics.largestDepth == PushMetrics().largestDepth);
}

TEST_CASE("parts of a study are the whole, once", "[monte_carlo]") {
  const StudyPlan plan = smallPlan(3, 7);
  for (const int parts : {1, 2, 5, 1000}) {
    std::size_t next = 0, least = plan.size(), most = 0;
    for (int part = 1; part <= parts; ++part) {
      const RunRange range = partOf(plan, part, parts);
      CHECK(range.first == next);
      next += range.count;
      least = std::min(least, range.count);
      most = std::max(most, range.count);
    }
    CHECK(next == plan.size());
    CHECK(most <= least + 1);
  }
  CHECK_THROWS_AS(partOf(plan, 0, 2), Error);
  CHECK_THROWS_AS(partOf(plan, 3, 2), Error);
}

}  // namespace enamel::test_monte_carlo
