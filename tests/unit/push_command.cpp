// `enamel push` as a user runs it.
#include <sstream>

#include "enamel/device/nominal_device.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/study/metrics.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/json.hpp"
#include "support/reference.hpp"

namespace enamel::test_push_command {

using test::ContainsSubstring;
using test::run;

namespace {

std::string push(const std::string& arguments) {
  return "push --device '" + test::deviceFile("tau-nominal.toml") + "' " + arguments;
}

// Return the stdout of a push; stderr goes to a file.
test::CommandResult printed(const std::string& arguments, const std::string& errors = "/dev/null") {
  return test::runCommand("{ '" ENAMEL_TOOL "' " + push(arguments) + " 2>'" + errors + "'; }");
}

// Push with options that are refused, each with the required message.
void refuses(const std::vector<std::pair<std::string, std::string>>& cases) {
  for (const auto& [options, message] : cases) {
    const auto result = run(push(options));
    INFO(options << "\n" << result.output);
    CHECK(result.status == 1);
    CHECK_THAT(result.output, ContainsSubstring(message));
  }
}

// Return a column of a CSV file by its name.
std::vector<std::string> column(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  std::string line, cell;
  std::getline(lines, line);
  int wanted = -1, index = 0;
  for (std::istringstream cells(line); std::getline(cells, cell, ','); ++index)
    if (cell == name) wanted = index;
  REQUIRE(wanted >= 0);
  std::vector<std::string> values;
  while (std::getline(lines, line)) {
    std::istringstream cells(line);
    for (int i = 0; i <= wanted; ++i) std::getline(cells, cell, ',');
    values.push_back(cell);
  }
  return values;
}

}  // namespace

TEST_CASE("push reproduces the reference runs, with a gain designed from the device file", "[push_command]") {
  const test::TemporaryFolder folder;
  for (const test::ReferenceRun& reference : test::referenceRuns()) {
    const std::string renderer = reference.servo ? "hold" : "impedance --device-damping 4";
    const auto result =
        run(push("--renderer " + renderer +
                 " --release off --guide off --noise 0 --force 12 --duration 1.3 --overwrite --output '" +
                 (folder / "run.csv") + "'"));
    INFO(result.output);
    REQUIRE(result.status == 0);
    const std::string csv = test::readFile(folder / "run.csv");
    CHECK(csv.rfind("t [s],x [m],y [m],z [m],", 0) == 0);
    const auto z = column(csv, "z [m]"), t = column(csv, "t [s]");
    REQUIRE(z.size() == reference.z.size());
    CHECK(std::stod(t[1001]) == Approx(1.001).epsilon(1e-15));
    double worst = 0.0;
    for (std::size_t i = 0; i < z.size(); ++i) worst = std::max(worst, std::abs(std::stod(z[i]) - reference.z[i]));
    CHECK(worst < 1e-9);
  }
}

TEST_CASE("push: plants by name", "[push_command]") {
  const std::string device = "push --device '" + test::deviceFile("tau-detailed.toml") +
                             "' --renderer impedance --device-damping 4 --json --plant ";
  const auto stiffness = [&](const std::string& plant) {
    const auto result = run(device + plant);
    INFO(result.output);
    REQUIRE(result.status == 0);
    return test::parseJson(result.output).at("impedance").at("K_z1 [N/m]").get<double>();
  };
  const double closed = stiffness("closed-form"), imperfect = stiffness("imperfect");
  CHECK(imperfect != closed);
  CHECK(imperfect == Approx(closed).epsilon(0.2));
  CHECK(stiffness("imperfect --seed 2") != imperfect);
  CHECK(run(device + "ideal").status != 0);
  // Ticks without a sample of the device are missing in a recording.
  const test::TemporaryFolder folder;
  REQUIRE(run(device + "imperfect --record '" + (folder / "imperfect.rec") + "'").status == 0);
  CHECK_THAT(run("replay '" + (folder / "imperfect.rec") + "'").output, ContainsSubstring("equal, bit for bit"));
  const auto ideal =
      run("push --device '" + test::deviceFile("cartesian-6.toml") + "' --renderer impedance --plant imperfect");
  CHECK(ideal.status == 1);
  CHECK_THAT(ideal.output, ContainsSubstring("has no [imperfections], which the plant imperfect requires"));
}

TEST_CASE("push: metrics under one name each as a table and as JSON, all renderers beside each other",
          "[push_command]") {
  const test::TemporaryFolder folder;
  const std::string all = "--renderer position-control,hold,impedance --device-damping 4 --noise 0 ";
  const auto table = run(push(all + "--output '" + (folder / "run.csv") + "'"));
  REQUIRE(table.status == 0);
  CHECK_THAT(table.output,
             ContainsSubstring("lowest 17.2") && ContainsSubstring("highest 3.11") && ContainsSubstring("(paper*)"));
  CHECK(std::filesystem::exists(folder / "run-position-control.csv"));
  CHECK(std::filesystem::exists(folder / "run-hold.csv"));
  CHECK(std::filesystem::exists(folder / "run-impedance.csv"));
  const auto json = run(push(all + "--json"));
  REQUIRE(json.status == 0);
  const auto metrics = test::parseJson(json.output);
  REQUIRE(metrics.size() == 3);
  for (const char* renderer : {"position-control", "hold", "impedance"}) {
    const auto& of = metrics.at(renderer);
    CHECK(of.size() == allMetrics().size() + 2);
    CHECK(of.at("first impact") == "measured");
    CHECK(of.at("faults") == 0);
    for (const Metric& metric : allMetrics()) {
      INFO(renderer << ": " << metric.symbol);
      REQUIRE(of.at(keyOf(metric)).is_number());
      // The table's row: symbol, unit and both values as printed.
      std::istringstream lines(table.output);
      std::string line, found;
      while (std::getline(lines, line))
        if (line.rfind(metric.symbol, 0) == 0) found = line;
      CHECK_THAT(found, ContainsSubstring(std::string("[") + metric.displayUnit + "]"));
      char value[32];
      std::snprintf(value, sizeof value, " %.4g", of.at(keyOf(metric)).get<double>() * metric.displayScale);
      CHECK_THAT(found, ContainsSubstring(value));
    }
  }
  // The paper's values are shown only beside the paper's renderers.
  const std::string row = table.output.substr(table.output.find("\nK_z1"), 170);
  CHECK(row.find("lowest 17.2") > 56 + 34 + 18);
  CHECK(metrics.at("hold").at("K_z1 [N/m]").get<double>() == Approx(27e3).epsilon(0.05));
  CHECK(metrics.at("position-control").at("K_z1 [N/m]") > 100e3);
  const auto ratio = [&](const char* renderer) {
    return metrics.at(renderer).at("K_z1 [N/m]").get<double>() /
           metrics.at(renderer).at("share of limit").get<double>();
  };
  CHECK(ratio("position-control") == Approx(ratio("hold")).epsilon(1e-9));  // one push, one limit
  CHECK(metrics.at("impedance").at("K_z1 [N/m]").get<double>() == Approx(3.06e3).epsilon(0.01));
}

TEST_CASE("push: a missing stiffness has its reason", "[push_command]") {
  for (const auto& [options, reason] : std::vector<std::pair<std::string, std::string>>{
           {"--scenario 2", "no step of force"},
           {"--renderer impedance --device-damping 4 --duration 1.004", "never returned"},
           {"--renderer impedance --noise 0 --duration 2 --guard off", "unstable"},
           {"--renderer impedance --noise 0 --duration 2", "unstable"},
           {"--renderer hold --release off --delay constant:1 --encoders --guard off", "unstable"}}) {
    INFO(options);
    const auto json = test::parseJson(printed(options + " --json").output).front();
    CHECK(json.at("first impact") == reason);
    CHECK(json.at("K_z1 [N/m]").is_null());
    CHECK(json.at("D_z1 [m]").is_null());
    const std::string table = run(push(options)).output;
    CHECK_THAT(table.substr(table.find("\nK_z1"), 120), ContainsSubstring(reason));
  }
}

TEST_CASE("push: one plant for linked renderers and plugins, with the damping of file and option", "[push_command]") {
  const test::TemporaryFolder folder;
  const auto ticks = [&](const std::string& renderer, const std::string& options) {
    const auto result = run(push("--renderer " + renderer + " --duration 1.1 --overwrite --output '" +
                                 (folder / "run.csv") + "' " + options));
    INFO(result.output);
    REQUIRE(result.status == 0);
    return test::readFile(folder / "run.csv");
  };
  const std::string plugins = ENAMEL_PLUGINS "/enamel_";
  for (const auto& [linked, plugin] : {std::pair<std::string, std::string>{"impedance", plugins + "impedance.so"},
                                       {"position-control", plugins + "position_control.so"},
                                       {"hold", plugins + "position_control.so' --set 'mode=hold"}}) {
    INFO(linked);
    const std::string undamped = ticks(linked, "--guard off"), damped = ticks(linked, "--device-damping 4");
    CHECK(undamped != damped);
    CHECK(ticks("'" + plugin + "'", "--guard off") == undamped);
    CHECK(ticks("'" + plugin + "'", "--device-damping 4") == damped);
  }

  std::string text = test::readFile(test::deviceFile("tau-nominal.toml"));
  text.insert(text.find('\n', text.find("[platform]")) + 1, "damping = [0.0, 0.0, 3.5, 0.0, 0.0, 0.0]\n");
  test::writeFile(folder / "damped.toml", text);
  const std::string spring = "push --renderer impedance --duration 1.1 --device '" + (folder / "damped.toml") + "' ";
  const auto file = run(spring), more = run(spring + "--device-damping 0.5"), hard = run(spring + "--stiffness 7000");
  CHECK_THAT(file.output, ContainsSubstring("mechanical damping 3.5 N s/m") && !ContainsSubstring("eq. 16"));
  CHECK_THAT(more.output, ContainsSubstring("mechanical damping 4 N s/m"));
  CHECK_THAT(hard.output,
             ContainsSubstring("need more than 3.5 N s/m") && ContainsSubstring("(eq. 16), the device has 3.5"));
}

TEST_CASE("push: hold with a servo of enamel design --output, linked and as a plugin", "[push_command]") {
  const test::TemporaryFolder folder;
  const auto design = [&](const std::string& name, const std::string& options) {
    const auto result = run("design --device '" + test::deviceFile("tau-nominal.toml") + "' --output '" +
                            (folder / name) + "' " + options);
    INFO(result.output);
    REQUIRE(result.status == 0);
    return folder / name;
  };
  const auto ticks = [&](const std::string& options) {
    const auto result = run(push("--duration 1.1 --overwrite --output '" + (folder / "run.csv") + "' " + options));
    INFO(result.output);
    REQUIRE(result.status == 0);
    return test::readFile(folder / "run.csv");
  };
  const std::string same = design("same.json", ""), soft = design("soft.json", "--q-integral 1e6");
  const std::string plugin = "--renderer '" ENAMEL_PLUGINS "/enamel_position_control.so' --set mode=hold ";
  const std::string hold = "--renderer hold ";
  const std::string inPlace = ticks(hold), softly = ticks(hold + "--gain '" + soft + "'");
  CHECK(ticks(hold + "--gain '" + same + "'") == inPlace);
  CHECK(softly != inPlace);
  CHECK(ticks(plugin + "--set 'gain=" + same + "'") == inPlace);
  CHECK(ticks(plugin + "--set 'gain=" + soft + "'") == softly);

  const std::string fast = design("fast.json", "--rate 2000");
  test::writeFile(folder / "three.json", R"({"model": "m", "period": 0.001, "K": [[1,2,3,4,5,6,7,8,9],
                                             [1,2,3,4,5,6,7,8,9], [1,2,3,4,5,6,7,8,9]]})");
  refuses({{hold + "--gain '" + fast + "'", "ticks of 0.0005 s, the period here is 0.001 s"},
           {hold + "--gain '" + (folder / "three.json") + "'", "for 3 joints, the device has 6"},
           {"--gain /no/such/servo.json", "/no/such/servo.json"},
           {"--gain '" + same + "'", "same.json: is an LQR design for hold, but --renderer does not name hold"},
           {"--renderer impedance --gain '" + same + "'", "for hold, but --renderer does not name hold"},
           {plugin + "--gain '" + same + "'", "for hold, but --renderer does not name hold"}});
}

TEST_CASE("push: position control, linked and as a plugin, is told of the plant's drives", "[push_command]") {
  const test::TemporaryFolder folder;
  const auto ticks = [&](const std::string& device, const std::string& options) {
    const auto result = run("push --device '" + test::deviceFile(device) +
                            "' --encoders --duration 1.1 --delay constant:1 --overwrite --output '" +
                            (folder / "run.csv") + "' " + options);
    INFO(result.output);
    REQUIRE(result.status == 0);
    return test::readFile(folder / "run.csv");
  };
  const std::string plugin = "--renderer '" ENAMEL_PLUGINS "/enamel_position_control.so' --set delay=1 ";
  CHECK((ticks("tau-nominal.toml", plugin) == ticks("tau-nominal.toml", "")));
  const std::string detailed = "tau-detailed.toml", ideal = plugin + "--set drive=ideal ",
                    rigid = plugin + "--set drive=rigid ";
  CHECK((ticks(detailed, ideal) == ticks(detailed, "")));
  // Configured for cables that the plant does not have, it gives energy.
  CHECK((ticks(detailed, "--guard off " + plugin) != ticks(detailed, "--guard off")));
  CHECK((ticks(detailed, "--plant imperfect-stiff " + rigid) == ticks(detailed, "--plant imperfect-stiff")));
  CHECK((ticks(detailed, "--plant imperfect " + plugin) == ticks(detailed, "--plant imperfect")));
  // A recording is made again with the same drives.
  for (const std::string plant : {"closed-form", "imperfect-stiff", "imperfect"}) {
    INFO(plant);
    const std::string recording = folder / (plant + ".rec");
    (void)ticks(detailed, "--plant " + plant + " --record '" + recording + "'");
    CHECK_THAT(run("replay '" + recording + "'").output, ContainsSubstring("equal, bit for bit"));
  }

  test::writeFile(folder / "old.json", R"({"kind": "surface", "model": "a", "period": 0.001})");
  refuses({{"--gain '" + (folder / "old.json") + "'",
            "old.json: kind: is \"surface\": position control does not need a file"},
           {plugin + "--set 'gain=" + (folder / "old.json") + "'",
            "gain: is only for mode hold: mode surface does not need a file"},
           {plugin + "--set drive=loose", "drive: is \"loose\", must be device, rigid or ideal"},
           {"--delay constant:9", "delay is 9 to 9 ticks, must be within 0 to 8"}});
}

TEST_CASE("push: the device as a renderer is told of it", "[push_command]") {
  for (const char* file : {"tau-detailed.toml", "delta.toml"}) {
    INFO(file);
    const DeviceParameters device = loadDevice(test::deviceFile(file));
    const Imperfections& real = imperfectionsOf(device);
    const auto driveFor = [&](const char* plant) { return makeMechanism(modelFor(plant, device))->limits().drive; };
    for (const char* plant : {kClosedForm, kMultibody, "any.fmu"}) {
      const Drive drive = driveFor(plant);
      CHECK(drivesOf(plant) == std::string("ideal"));
      CHECK(drive.bandwidth + drive.rotorInertia + drive.stiffness + drive.damping + drive.disturbance == 0.0);
    }
    const Drive drive = driveFor(kImperfect), stiff = driveFor(kImperfectStiff);
    CHECK(drivesOf(kImperfect) == std::string("device"));
    CHECK(drive.bandwidth == real.currentBandwidth);
    CHECK(drive.stiffness == real.cableStiffness);
    CHECK((drive.bandwidth > 0.0 && drive.rotorInertia > 0.0 && drive.disturbance > 0.0));
    CHECK(drivesOf(kImperfectStiff) == std::string("rigid"));
    CHECK((stiff.bandwidth == drive.bandwidth && stiff.disturbance == drive.disturbance));
    CHECK((stiff.rotorInertia == 0.0 && stiff.stiffness == 0.0 && stiff.damping == 0.0));
  }
  CHECK_THROWS_WITH(modelFor("wish", nominalDevice()),
                    ContainsSubstring("unknown plant \"wish\": must be closed-form"));
}

TEST_CASE("push: a preload, and a step inside its tick", "[push_command]") {
  const test::TemporaryFolder folder;
  const auto forces = [&](const std::string& options) {
    const auto result = run(push("--renderer impedance --device-damping 4 --duration 1.3 --overwrite --output '" +
                                 (folder / "run.csv") + "' " + options));
    INFO(result.output);
    REQUIRE(result.status == 0);
    std::vector<double> list;
    for (const std::string& force : column(test::readFile(folder / "run.csv"), "person fz [N]"))
      list.push_back(-std::stod(force));
    return list;
  };
  const auto plain = forces(""), inside = forces("--inside-tick"), pressed = forces("--preload 3 --inside-tick");
  REQUIRE(plain.size() == 1300);
  CHECK(plain[999] == 0.0);
  CHECK(inside[999] == 0.0);
  // At the beginning of its tick the step has not come yet; every other value of the person is unchanged.
  CHECK(inside[1000] == Approx(plain[1000] - 12.0).margin(1e-12));
  for (std::size_t i = 1001; i < plain.size(); ++i) REQUIRE(inside[i] == plain[i]);
  double sum = 0.0;
  for (std::size_t i = 0; i < 1000; ++i) sum += pressed[i] / 1000.0;
  CHECK(sum == Approx(3.0).margin(5.0 * 0.5 / std::sqrt(1000.0)));
  for (std::size_t i = 1001; i < plain.size(); ++i) REQUIRE(pressed[i] == plain[i]);
}

TEST_CASE("push and design on other mechanisms: as many columns as joints, in their units", "[push_command]") {
  const test::TemporaryFolder folder;
  for (const auto& [file, columns] : std::vector<std::pair<std::string, std::string>>{
           {"delta.toml", "q1 [rad],q2 [rad],q3 [rad],tau1 [N m],tau2 [N m],tau3 [N m],mode"},
           {"cartesian-3.toml", "q1 [m],q2 [m],q3 [m],tau1 [N],tau2 [N],tau3 [N],mode"}}) {
    INFO(file);
    const std::string device = "--device '" + test::deviceFile(file) + "' --force 2 ";
    // With the built-in weights these devices have walls of about 100 N/m: the guard counts returned energy as
    // generated.
    const auto ticks = [&](const std::string& options) {
      const auto result = run("push " + device + "--guard off --duration 1.1 --overwrite --output '" +
                              (folder / "run.csv") + "' " + options);
      INFO(result.output);
      REQUIRE(result.status == 0);
      return test::readFile(folder / "run.csv");
    };
    const auto designed = run("design " + device + "--overwrite --output '" + (folder / "servo.json") + "'");
    INFO(designed.output);
    REQUIRE(designed.status == 0);
    CHECK_THAT(designed.output, ContainsSubstring("q3 ") && !ContainsSubstring("q4 ") && ContainsSubstring("Table II"));
    const auto K = test::parseJson(test::readFile(folder / "servo.json")).at("K");
    CHECK(K.size() == 3);
    const std::string inPlace = ticks("--renderer hold");
    CHECK_THAT(inPlace.substr(0, inPlace.find('\n')), ContainsSubstring(",wall force [N]," + columns + ","));
    CHECK(ticks("--renderer hold --gain '" + (folder / "servo.json") + "'") == inPlace);
    CHECK(ticks("") != inPlace);
    CHECK(ticks("--renderer impedance --stiffness 1000") != inPlace);
    const auto wrong = run(push("--renderer hold --gain '" + (folder / "servo.json") + "'"));
    CHECK(wrong.status == 1);
    CHECK_THAT(wrong.output, ContainsSubstring("for 3 joints, the device has 6"));
  }
}

TEST_CASE("push: what one renderer reached outlives the failure of another", "[push_command]") {
  const test::TemporaryFolder folder;
  for (const char* renderers : {"impedance,hold", "hold,impedance"}) {
    const std::string both = std::string("--renderer ") + renderers + " --stiffness -5 --duration 1.1 ";
    const std::string output = "--overwrite --output '" + (folder / "run.csv") + "' ";
    const auto table = printed(both + output, folder / "errors");
    CHECK(table.status == 1);
    CHECK_THAT(table.output, ContainsSubstring("K_z1") && ContainsSubstring("hold") &&
                                 ContainsSubstring("run-hold.csv") && !ContainsSubstring("impedance"));
    const std::string errors = test::readFile(folder / "errors");
    CHECK(errors.rfind("enamel: impedance: ", 0) == 0);
    CHECK(std::count(errors.begin(), errors.end(), '\n') == 1);
    const auto json = printed(both + "--json");
    CHECK(json.status == 1);
    const auto metrics = test::parseJson(json.output);
    CHECK(metrics.size() == 1);
    CHECK(metrics.contains("hold"));
  }
  // A run that ends early is a failure too, with its time.
  const auto lost = run(push("--renderer impedance,position-control --stiffness 40000 --guard off"));
  INFO(lost.output);
  CHECK(lost.status == 1);
  CHECK_THAT(lost.output,
             ContainsSubstring("impedance: the device left its workspace at ") && ContainsSubstring("K_z1"));
  CHECK_THAT(lost.output, !ContainsSubstring("cannot hold the push"));
  const auto weak =
      run("push --encoders --force 8 --preload 1 --device '" + test::deviceFile("cartesian-3.toml") + "'");
  CHECK(weak.status == 1);
  CHECK_THAT(weak.output, ContainsSubstring("the motors cannot hold the push of 8 N, their largest force is 3.3 N: "
                                            "reduce --force"));
  // It slips off a tooth's slope, which a spring does not hold.
  const auto slid = run(push("--renderer impedance --scene '" ENAMEL_SOURCE_DIR "/data/scenes/molar.toml'"));
  CHECK(slid.status == 1);
  CHECK_THAT(slid.output, ContainsSubstring(" mm from the start at ") &&
                              ContainsSubstring(" m/s, off molar since 1.") &&
                              ContainsSubstring(" mm from gum): its pose is unreachable"));
  const auto stopped = run(push("--renderer impedance,position-control --stiffness 40000"));
  CHECK(stopped.status == 1);
  CHECK_THAT(stopped.output, ContainsSubstring("impedance: stopped by the guard at ") &&
                                 ContainsSubstring("gave energy") && ContainsSubstring("K_z1") &&
                                 ContainsSubstring("unstable"));
}

TEST_CASE("push and check-plugin: --set takes one KEY=VALUE and may be repeated", "[push_command]") {
  const std::string spring = "'" ENAMEL_PLUGINS "/enamel_impedance.so'";
  const auto stray = run(push("--renderer " + spring + " --set stiffness=5000 stray"));
  CHECK(stray.status == 2);
  CHECK_THAT(stray.output, ContainsSubstring("not expected: stray"));
  const auto twice = run(push("--renderer " + spring + " --duration 1.1 --set stiffness=5000 --set damping=1"));
  INFO(twice.output);
  CHECK(twice.status == 0);
  CHECK(twice.output != run(push("--renderer " + spring + " --duration 1.1 --set stiffness=5000")).output);
  CHECK(run("check-plugin --set stiffness=5000 " + spring).status == 0);
}

TEST_CASE("push: the same seed gives the same file, eq. 16 is warned about", "[push_command]") {
  const test::TemporaryFolder folder;
  const std::string options = "--duration 1.5 --delay random:0..1 --encoders --rates low-pass --output '";
  REQUIRE(run(push(options + (folder / "a.csv") + "' --seed 3")).status == 0);
  REQUIRE(run(push(options + (folder / "b.csv") + "' --seed 3")).status == 0);
  REQUIRE(run(push(options + (folder / "c.csv") + "' --seed 4")).status == 0);
  CHECK(test::readFile(folder / "a.csv") == test::readFile(folder / "b.csv"));
  CHECK(test::readFile(folder / "a.csv") != test::readFile(folder / "c.csv"));
  const auto warned = [&](const std::string& more) {
    const auto result = run(push("--renderer impedance --guard off --duration 1.1 " + more));
    CHECK(result.status == 0);
    return result.output.find("enamel: warning: ") != std::string::npos;
  };
  CHECK(warned(""));
  CHECK(warned("--device-damping 3"));  // equality is not enough
  CHECK_FALSE(warned("--device-damping 4"));
  CHECK(warned("--device-damping 4 --stiffness 9000"));
  CHECK(warned("--device-damping 4 --damping 2"));
}

TEST_CASE("push: errors are one line and the status is not 0", "[push_command]") {
  for (const char* arguments : {"--renderer rubber",
                                "--scenario 3",
                                "--force -1",
                                "--noise nan",
                                "--duration -1",
                                "--delay constant:99",
                                "--delay random:2..1",
                                "--delay often",
                                "--substeps 0",
                                "--x 500",
                                "--release maybe",
                                "--renderer impedance --stiffness -5",
                                "--output /no/such/folder/run.csv",
                                "--mode surface",
                                "--preload -1",
                                "--preload nan",
                                "--low-pass 0",
                                "--device-damping -1",
                                "--device-damping nan",
                                "--force 0x10",
                                "--force 12N",
                                "--low-pass inf",
                                "--seed 010",
                                "--seed -1",
                                "--seed 1e3",
                                "--substeps 1.5",
                                "--delay 'constant: 1'",
                                "--delay constant:+1",
                                "--delay constant:1x",
                                "--delay constant:99999999999",
                                "--delay random:0..",
                                "--set stiffness=1"}) {
    const auto result = run(push(arguments));
    INFO(arguments << "\n" << result.output);
    CHECK(result.status != 0);
    CHECK(std::count(result.output.begin(), result.output.end(), '\n') == 1);
    CHECK(result.output.rfind("enamel: ", 0) == 0);
  }
  CHECK_THAT(run("push --device none.toml").output, ContainsSubstring("enamel: none.toml"));
}

// Random delays and coarse encoders make the tool hop by 0.1 mm: the hops must not carry it away.
TEST_CASE("a tool that hops stays on the tooth", "[push_command]") {
  const std::string molar = " --scene '" ENAMEL_SOURCE_DIR "/data/scenes/molar.toml' --encoders --preload 1";
  const std::string delta =
      "push --device '" + test::deviceFile("delta.toml") + "' --force 5 --delay constant:1" + molar;
  for (const std::string& command : {push("--force 3 --delay random:0..3" + molar), delta})
    for (const char* seed : {"1", "2", "3"}) {
      const auto result = run(command + " --seed " + seed);
      INFO(result.output);
      REQUIRE(result.status == 0);
      const std::string name = "drift, across the normal [mm]";
      const std::size_t at = result.output.find(name);
      REQUIRE(at != std::string::npos);
      // 0.1 to 0.2 mm; with a grip that is reset by every hop 31 to 47.
      CHECK(std::stod(result.output.substr(at + name.size())) < 1.0);
    }
}

}  // namespace enamel::test_push_command
