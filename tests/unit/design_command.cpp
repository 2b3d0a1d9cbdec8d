// `enamel design` as a user runs it.
#include <sstream>

#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/study/controllers.hpp"
#include "enamel/study/stability.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/control_systems.hpp"
#include "support/devices.hpp"
#include "support/json.hpp"
#include "support/relative_error.hpp"
#include "support/skip.hpp"

namespace enamel::test_design_command {

using test::run;

namespace {

std::string design(const std::string& rest) {
  return "design --device '" + test::deviceFile("tau-nominal.toml") + "' " + rest;
}

}  // namespace

TEST_CASE("design writes the reference servo, with its poles, margins and requirements", "[design]") {
  const test::TemporaryFolder folder;
  const auto result = run(design("--output '" + (folder / "servo.json") + "'"));
  INFO(result.output);
  REQUIRE(result.status == 0);
  const auto servo = test::parseJson(test::readFile(folder / "servo.json"));
  const auto reference = test::referenceFile("servo-nominal.json");
  for (const auto& [key, value] : reference.items()) {
    INFO(key);
    REQUIRE(servo.contains(key));
    if (!value.is_array()) continue;
    // The project's limits: 1e-8 for the model, 1e-9 for the discrete model, 1e-7 for the gain.
    const double bar = key == "Ad" || key == "Bd" ? 1e-9 : key == "K" || key == "P" ? 1e-7 : 1e-8;
    if (value[0].is_array())
      CHECK(test::relativeError(test::matrixFrom(servo[key]), test::matrixFrom(value)) < bar);
    else
      CHECK(test::relativeError(test::vectorFrom(servo[key]), test::vectorFrom(value)) < bar);
  }
  CHECK(servo.at("model") == "tau-nominal.toml");
  CHECK(servo.at("period") == 1e-3);
  CHECK(servo.at("poles").size() == 18);
  CHECK(servo.at("spectral_radius").get<double>() == Approx(0.9582).margin(5e-5));
  CHECK(servo.at("margins").at("tolerated_delay") == 1);
  CHECK(servo.at("margins").at("inputs").size() == 6);
  REQUIRE(servo.at("requirements").size() == 6);
  CHECK(servo.at("requirements")[0].at("met") == false);
  CHECK(servo.at("requirements")[0].at("worst").get<double>() == Approx(3.0).margin(0.05));
  CHECK(result.output.find("NOT MET") != std::string::npos);
  CHECK(result.output.find("disk margin") != std::string::npos);
}

TEST_CASE("design writes what loadServo() reads, to the last bit", "[design]") {
  const test::TemporaryFolder folder;
  REQUIRE(run(design("--output '" + (folder / "servo.json") + "'")).status == 0);
  const ServoFile servo = loadServo(folder / "servo.json");
  const auto mechanism = makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml")));
  CHECK(servo.model == "tau-nominal.toml");
  CHECK(servo.period == 1e-3);
  CHECK(servo.gain == designServo(mechanism, Pose{}, 1e-3).K);
}

TEST_CASE("design without a file to write prints its report", "[design]") {
  const auto report = run(design(""));
  INFO(report.output);
  CHECK(report.status == 0);
  for (const char* part :
       {"TAU nominal at (0, 0, 0) m: ", "closed loop: spectral radius 0.9582",
        "disk margin: ", "delay: stable up to 1 samples", "first impact, 12 N: ", "q6 ", "Table II", "NOT MET",
        "Position control, estimated from 90 simulated pushes", "twice the rate: +", "passive spring"})
    CHECK_THAT(report.output, test::ContainsSubstring(part));
  // With a file the report is the same, without the simulated pushes, which take nearly all of its time.
  const test::TemporaryFolder folder;
  const auto summary = [&](const std::string& options) {
    return run(design(options + " --overwrite --output '" + (folder / "servo.json") + "'")).output;
  };
  const std::string plain = summary("");
  CHECK_THAT(plain, test::ContainsSubstring("Table II"));
  CHECK_THAT(report.output, test::ContainsSubstring(plain));
  // The model is linear: the stiffness is that of any push, its limit falls with the push, and no push may exceed the
  // motors.
  CHECK_THAT(summary("--force 50"), test::ContainsSubstring("first impact, 50 N: "));
  CHECK_THAT(summary("--force 100"), test::ContainsSubstring("the motors cannot hold the push"));
  CHECK(summary("--device-damping 4") != plain);
}

TEST_CASE("design compares position control with the best springs", "[design]") {
  const auto report = run("design --best-spring --device '" + test::deviceFile("cartesian-3.toml") + "' --force 1");
  INFO(report.output);
  REQUIRE(report.status == 0);
  const std::size_t table = report.output.find("The best spring that a search");
  REQUIRE(table != std::string::npos);
  std::istringstream lines(report.output.substr(table));
  std::string line;
  for (int i = 0; i < 3; ++i) std::getline(lines, line);
  double before = 1e9;
  for (int delay = 0; delay <= 3; ++delay) {
    int ticks = -1, lost = -1;
    double stiffness = 0.0, spring = 0.0, damping = 0.0, ratio = 0.0;
    REQUIRE(static_cast<bool>(lines >> ticks >> stiffness >> spring >> damping >> lost >> ratio));
    std::getline(lines, line);
    CHECK(ticks == delay);
    CHECK(stiffness < before);
    CHECK(ratio > 1.0);
    before = stiffness;
  }
}

TEST_CASE("design takes other weights, rates and places", "[design]") {
  const test::TemporaryFolder folder;
  const auto result =
      run(design("--rate 2000 --q-velocity 2 --q-position 500 --q-integral 1e6 --r 4 --at 0.01,-0.01,0.005 "
                 "--output '" +
                 (folder / "servo.json") + "'"));
  INFO(result.output);
  REQUIRE(result.status == 0);
  const auto servo = test::parseJson(test::readFile(folder / "servo.json"));
  CHECK(servo.at("period") == 5e-4);
  CHECK(servo.at("weights").at("torque") == 4.0);
  CHECK(servo.at("position")[1] == -0.01);
  const Eigen::MatrixXd Ad = test::matrixFrom(servo.at("Ad")), Bd = test::matrixFrom(servo.at("Bd")),
                        K = test::matrixFrom(servo.at("K")), P = test::matrixFrom(servo.at("P"));
  Eigen::VectorXd q(18);
  q << Eigen::VectorXd::Constant(6, 2.0), Eigen::VectorXd::Constant(6, 500.0), Eigen::VectorXd::Constant(6, 1e6);
  const Eigen::MatrixXd closed = Ad - Bd * K, Q = q.asDiagonal();
  // The cost of the gain satisfies its Stein equation, which does not amplify the rounding of P.
  CHECK(test::relativeError(closed.transpose() * P * closed + Q + 4.0 * K.transpose() * K, P) < 1e-12);
}

TEST_CASE("design writes the stability map of the impedance wall", "[design]") {
  const test::TemporaryFolder folder;
  const auto result = run(design("--device-damping 4 --impedance-map '" + (folder / "map.csv") + "'"));
  INFO(result.output);
  REQUIRE(result.status == 0);
  std::istringstream lines(test::readFile(folder / "map.csv"));
  std::string line;
  std::getline(lines, line);
  CHECK(line == "delay_samples,stiffness_N_per_m,damping_Ns_per_m,stable,eq16_damping_Ns_per_m,eq16_met");
  int rows = 0, passive = 0, passiveAndUnstable = 0;
  while (std::getline(lines, line)) {
    ++rows;
    int delay = 0, stable = 0, met = 0;
    double stiffness = 0.0, damping = 0.0, needed = 0.0;
    REQUIRE(std::sscanf(line.c_str(), "%d,%lf,%lf,%d,%lf,%d", &delay, &stiffness, &damping, &stable, &needed, &met) ==
            6);
    CHECK(needed == Approx(0.5e-3 * stiffness + damping).epsilon(1e-5));  // as printed
    CHECK(met == (needed < 4.0));
    passive += met;
    passiveAndUnstable += delay == 0 && met == 1 && stable == 0;
  }
  CHECK(rows == 4 * 25 * 14);
  CHECK(passive > 0);
  CHECK(passive < rows);
  CHECK(passiveAndUnstable == 0);
  CHECK_THAT(result.output, test::ContainsSubstring("mechanical damping 4 N s/m"));
}

TEST_CASE("design --stability prints and draws the errors at which position control is stable", "[design]") {
  const test::TemporaryFolder folder;
  const auto result = run("design --device '" + test::deviceFile("cartesian-6.toml") + "' --rate 500 --stability '" +
                          (folder / "map.html") + "'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  const LinearLoop loop(loadDevice(test::deviceFile("cartesian-6.toml")), 2e-3, 1);
  std::istringstream lines(result.output);
  std::string line;
  int rows = 0;
  while (std::getline(lines, line)) {
    int delay = 0;
    double radius = 0.0, low = 0.0, high = 0.0;
    const std::size_t jumps = line.find(" jumps ");
    if (jumps == std::string::npos || std::sscanf(line.c_str(), "%d", &delay) != 1) continue;
    REQUIRE(std::sscanf(line.c_str() + jumps, " jumps %lf %lf to %lf", &radius, &low, &high) == 3);
    ++rows;
    if (delay != 1) continue;
    const Scope scope = line.find("without") == std::string::npos ? Scope::all : Scope::quiet;
    const StableRange range = stableRange(loop, &DeviceErrors::mass, scope);
    CHECK(radius == Approx(loop.radius({}, scope)).margin(5.1e-4));
    CHECK(low == Approx(range.low).margin(5.1e-3));
    CHECK(high == Approx(range.high).margin(5.1e-3));
  }
  CHECK(rows == 8);
  const std::string picture = test::readFile(folder / "map.html");
  if (picture.find("built without Vega") != std::string::npos) return test::skipTest("Vega is not installed");
  for (const char* text : {"\"cells\"", "delay 0", "delay 3", "mass over the file's", "delay error, ticks"})
    CHECK_THAT(picture, test::ContainsSubstring(text));
  CHECK_THAT(picture, !test::ContainsSubstring("cable-errors"));
}

TEST_CASE("design --rivals tunes every controller at every delay, and study takes its file", "[design]") {
  const test::TemporaryFolder folder;
  const std::string path = folder / "rivals.json";
  const auto result = test::run("design --rivals --device '" + test::deviceFile("tau-nominal.toml") +
                                "' --generations 0 --runs 1 --output '" + path + "'");
  INFO(result.output);
  REQUIRE(result.status == 0);
  for (const char* text : {"delay 0..3", "virtual-coupling", "hold-delay", "position-control"})
    CHECK_THAT(result.output, test::ContainsSubstring(text));
  const nlohmann::json file = test::parseJson(test::readFile(path));
  CHECK(file.at("controllers").size() == 5 * rivalSpecs().size());
}

TEST_CASE("design says in one line what is wrong", "[design]") {
  const test::TemporaryFolder folder;
  const std::string output = " --output '" + (folder / "servo.json") + "'";
  for (const auto& [arguments, message] : std::vector<std::pair<std::string, std::string>>{
           {design("--at 0,0,1" + output), "device plant: the pose is"},
           {design("--r 0" + output), "weight of the torque must be positive"},
           {design("--q-integral 0" + output), "no stabilising solution"},
           {design("--q-position -1" + output), "negative"},
           {design("--rate 0" + output), "--rate"},
           {design("--rate nan" + output), "--rate"},
           {design("--force 0" + output), "--force"},
           {design("--device-damping -1" + output), "--device-damping"},
           {design("--output /nonexistent/servo.json"), "/nonexistent/servo.json"},
           {"design --device /nonexistent.toml" + output, "/nonexistent.toml"}}) {
    INFO(arguments);
    const auto result = run(arguments);
    INFO(result.output);
    CHECK(result.status != 0);
    CHECK(result.output.find(message) != std::string::npos);
    CHECK(std::count(result.output.begin(), result.output.end(), '\n') == 1);
  }
}

}  // namespace enamel::test_design_command
