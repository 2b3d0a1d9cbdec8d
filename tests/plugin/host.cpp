// Renderers in plugins: the same bits as the linked ones, the same contract, and their own errors.
#include "enamel/plugin/host.hpp"

#include "enamel/control/device_plant.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/render/tick.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/pushes.hpp"

namespace enamel::test_host {

using test::ContainsSubstring;

namespace {

const std::string kDevice = ENAMEL_SOURCE_DIR "/data/devices/tau-nominal.toml";

std::shared_ptr<const PluginLibrary> library(const std::string& name) {
  return PluginLibrary::load(ENAMEL_PLUGINS "/enamel_" + name + ".so");
}

PluginSetup nominalSetup(std::map<std::string, std::string> parameters = {}) {
  PluginSetup setup;
  setup.devicePath = kDevice;
  setup.parameters = std::move(parameters);
  return setup;
}

void requireSame(const TickOutput& a, const TickOutput& b) {
  REQUIRE(a.torque == b.torque);
  REQUIRE(a.normalForce == b.normalForce);
  REQUIRE(a.mode == b.mode);
  REQUIRE(a.saturated == b.saturated);
}

}  // namespace

TEST_CASE("a plugin gives the bits of the linked renderer, tick by tick, good input and bad", "[plugin]") {
  const auto device = std::make_shared<TauMechanism>(test::nominal());
  HoldRenderer hold(designServo(device, Pose{}, 1e-3).K, 1e-3, {});
  ImpedanceRenderer spring({6000.0, 0.0});
  PositionControlRenderer servo = test::positionControl(*device), late = test::positionControl(*device, 0, 3);
  using Parameters = std::map<std::string, std::string>;
  for (const auto& [name, parameters, linked] :
       {std::tuple<std::string, Parameters, Renderer*>{"position_control", {}, &servo},
        {"position_control", {{"delay", "0"}, {"delay-high", "3"}}, &late},
        {"position_control", {{"mode", "hold"}}, &hold},
        {"impedance", {}, &spring}}) {
    INFO(name << " " << parameters.size());
    const auto plugin = makeRenderer(library(name), nominalSetup(parameters));
    plugin->activate(1e-3);
    linked->activate(1e-3);
    REQUIRE(plugin->stateSize() >= linked->stateSize());
    test::Random random(91);
    std::vector<unsigned char> state(plugin->stateSize()), linkedState(linked->stateSize());
    int contact = 0, refused = 0;
    for (int i = 0; i < 3000; ++i) {
      Vec6 twist = Vec6::Zero();
      twist.head<3>() = random.vector(0.1);
      TickFrame input = test::frameAt(*device, test::poseAtDepth(2e-4 * std::sin(0.01 * i)), 1e-3 * (i + 1), twist);
      if (i % 50 == 7) input.kinematics.q[2] = std::nan("");
      if (i % 50 == 8) input.contacts.contacts[0].gap = 1e9;
      if (i % 50 == 9) input.contacts.count = 99;
      if (i % 50 == 10) input.time = 0.0;
      if (i % 5 == 2) input.age = 1;                      // a lost sample
      if (i % 3 == 0) input.maxTorque.setConstant(0.05);  // often cut
      TickOutput a, b;
      const Status wanted = linked->step(input, a), got = plugin->step(input, b);
      REQUIRE(got == wanted);
      requireSame(a, b);
      contact += a.mode == RenderMode::contact;
      refused += wanted != Status::ok;
      if (i == 1500) {
        plugin->saveState(state.data());
        linked->saveState(linkedState.data());
      }
      if (i % 700 == 699) {
        plugin->reset();
        linked->reset();
      }
      if (i == 2500) {
        plugin->loadState(state.data());
        linked->loadState(linkedState.data());
      }
    }
    CHECK(contact > 500);
    CHECK(refused > 200);
  }
}

TEST_CASE("the reference runs through plugins have the bits of the linked renderers", "[plugin]") {
  const auto device = std::make_shared<TauMechanism>(test::nominal());
  for (const test::ReferenceRun& run : test::referenceRuns()) {
    INFO((run.servo ? "position_control" : "impedance"));
    const TauMechanism plant(run.servo ? test::nominal() : test::dampedNominal());
    HoldRenderer hold(designServo(device, Pose{}, 1e-3).K, 1e-3, test::asInThePaper());
    ImpedanceRenderer spring({6000.0, 0.0});
    PluginSetup given = nominalSetup();
    if (run.servo) given.parameters = {{"mode", "hold"}, {"release", "off"}};
    const auto plugin = makeRenderer(library(run.servo ? "position_control" : "impedance"), given);
    const PushSetup setup = test::referenceSetup(run);
    const auto linked = test::recordPush(plant, run.servo ? static_cast<Renderer&>(hold) : spring, setup);
    const auto through = test::recordPush(plant, *plugin, setup);
    REQUIRE(linked.size() == run.z.size());
    REQUIRE(through.size() == linked.size());
    double worst = 0.0;
    for (std::size_t i = 0; i < linked.size(); ++i) {
      const TickRecord &a = linked[i], &b = through[i];
      REQUIRE(a.pose.position == b.pose.position);
      REQUIRE(a.pose.rotation == b.pose.rotation);
      REQUIRE(a.twist == b.twist);
      REQUIRE(a.command == b.command);
      REQUIRE(a.normalForce == b.normalForce);
      REQUIRE(a.mode == b.mode);
      REQUIRE(a.saturated == b.saturated);
      worst = std::max(worst, std::abs(b.pose.position.z() - run.z[i]));
    }
    CHECK(worst < 1e-9);  // as for the linked renderers in unit.push
  }
}

TEST_CASE("a push through a plugin writes the same file as the linked renderer", "[plugin]") {
  const test::TemporaryFolder folder;
  for (const auto& [name, file] : {std::pair<std::string, std::string>{"position-control", "position_control.so'"},
                                   {"hold", "position_control.so' --set mode=hold"},
                                   {"impedance", "impedance.so'"}}) {
    INFO(name);
    const std::string common =
        "push --device '" + kDevice + "' --device-damping 4 --encoders --rates low-pass --seed 5 --duration 1.3 ";
    REQUIRE(
        test::run(common + "--renderer " + name + " --overwrite --output '" + (folder / "linked.csv") + "'").status ==
        0);
    REQUIRE(test::run(common + "--renderer '" ENAMEL_PLUGINS "/enamel_" + file + " --overwrite --output '" +
                      (folder / "plugin.csv") + "'")
                .status == 0);
    const std::string linked = test::readFile(folder / "linked.csv");
    CHECK(linked.size() > 100000);
    CHECK(linked == test::readFile(folder / "plugin.csv"));
  }
  CHECK(test::run("push --device '" + kDevice + "' --renderer template --set stiffness=1000 --duration 1.1").status ==
        0);
  const auto unknown = test::run("push --device '" + kDevice + "' --renderer template --set brains=5");
  CHECK(unknown.status == 1);
  CHECK_THAT(unknown.output, ContainsSubstring("unknown parameter: brains"));
}

TEST_CASE("a small study through plugins writes the same runs as the linked renderers", "[plugin]") {
  const test::TemporaryFolder folder;
  const std::string common =
      "study --no-convergence --grid 2 --runs 2 --scenario 1,2 --delay random:0..1 --seed 3 --output '";
  REQUIRE(test::run(common + (folder / "linked") + "' --renderers position-control,impedance").status == 0);
  REQUIRE(test::run(common + (folder / "plugins") + "' --renderers " ENAMEL_PLUGINS "/enamel_position_control.so," +
                    ENAMEL_PLUGINS "/enamel_impedance.so --set delay-high=1")
              .status == 0);
  CHECK_THAT(test::run(common + (folder / "typo") + "' --renderers template --set relase=off").output,
             ContainsSubstring("relase, which is not a parameter of any plugin"));
  const std::string linked = test::readFile(folder / "linked/runs.csv");
  CHECK(std::count(linked.begin(), linked.end(), '\n') == 2 * 2 * 4 * 2 + 1);
  std::string plugins = test::readFile(folder / "plugins/runs.csv");
  const std::string mark = " (plugin)";  // in the columns' names, the only difference
  int marks = 0;
  for (std::size_t at = 0; (at = plugins.find(mark)) != std::string::npos; ++marks) plugins.erase(at, mark.size());
  CHECK(marks == 2 * 2 * 4 * 2);
  CHECK(linked == plugins);
}

TEST_CASE("the template's wrench becomes the torque of gravity and wall on any mechanism", "[plugin]") {
  PluginSetup setup;  // this plugin needs no device
  setup.parameters = {{"stiffness", "3000"}, {"damping", "5"}};
  const auto renderer = makeRenderer(library("template"), setup);
  renderer->activate(1e-3);
  ImpedanceRenderer spring({3000.0, 5.0});
  spring.activate(1e-3);
  const TauMechanism device(test::nominal());
  test::Random random(17);
  int contact = 0;
  for (int i = 0; i < 500; ++i) {
    const Pose pose = random.workspacePose(0.2);
    TickFrame input = test::frameAt(device, pose, 1e-3 * (i + 1), random.vector6(0.1, 1.0));
    // Several contacts whose obstacles move, deepest first.
    input.contacts.count = i % 4;
    double gap = -2e-3;
    for (int k = 0; k < input.contacts.count; ++k) {
      Contact& c = input.contacts.contacts[k];
      c.point = input.kinematics.pose.position + random.vector(0.05);
      c.normal = random.direction();
      c.gap = gap += 1e-3 * random.uniform(0.0, 2.0);
      c.obstacleVelocity = random.vector(0.05);
    }
    TickOutput a, b;
    REQUIRE(renderer->step(input, a) == Status::ok);
    REQUIRE(spring.step(input, b) == Status::ok);
    CHECK((a.torque - b.torque).cwiseAbs().maxCoeff() <= 1e-14);  // sums in another order
    CHECK(a.normalForce == Approx(b.normalForce).epsilon(1e-13));
    CHECK(a.mode == b.mode);
    contact += a.mode == RenderMode::contact;
  }
  CHECK(contact > 200);
}

TEST_CASE("a plugin that is not active has no state", "[plugin]") {
  for (const char* name : {"position_control", "impedance", "template"}) {
    INFO(name);
    const auto plugin = makeRenderer(library(name), nominalSetup());
    std::vector<unsigned char> state(1 << 16, 0x5a);
    const auto before = state;
    const auto hasNone = [&] {
      CHECK(plugin->stateSize() == 0);
      plugin->saveState(state.data());
      plugin->loadState(state.data());
      plugin->reset();
      CHECK(state == before);
      TickOutput output;
      CHECK(plugin->step(TickFrame{}, output) == Status::inactive);
    };
    hasNone();
    plugin->activate(1e-3);
    CHECK(plugin->stateSize() > 0);
    CHECK_THROWS_AS(plugin->activate(-1.0), Error);
    hasNone();
    plugin->activate(1e-3);
    CHECK(plugin->stateSize() > 0);
  }
}

TEST_CASE("a plugin's gain comes from a file", "[plugin]") {
  const test::TemporaryFolder folder;
  const auto device = std::make_shared<TauMechanism>(test::nominal());
  const Eigen::MatrixXd K = 0.5 * designServo(device, Pose{}, 1e-3).K;
  std::ostringstream json;
  json.precision(17);
  json << R"({"model": "tau-nominal.toml", "period": 1e-3, "K": [)";
  for (int i = 0; i < K.rows(); ++i)
    for (int j = 0; j < K.cols(); ++j)
      json << (j > 0 ? ", " : i > 0 ? ", [" : "[") << K(i, j) << (j + 1 < K.cols() ? "" : "]");
  json << "]}";
  test::writeFile(folder / "servo.json", json.str());
  PluginSetup setup = nominalSetup();
  setup.parameters = {{"mode", "hold"}, {"gain", folder / "servo.json"}};
  const auto plugin = makeRenderer(library("position_control"), setup);
  plugin->activate(1e-3);
  HoldRenderer linked(K, 1e-3, {});
  linked.activate(1e-3);
  for (int i = 1; i < 100; ++i) {
    const TickFrame input = test::frameAt(*device, test::poseAtDepth(1e-4 * std::sin(0.1 * i)), 1e-3 * i);
    TickOutput a, b;
    REQUIRE(plugin->step(input, a) == Status::ok);
    REQUIRE(linked.step(input, b) == Status::ok);
    requireSame(a, b);
  }
  CHECK_THROWS_WITH(plugin->activate(2e-3), ContainsSubstring("designed for 0.001 s"));
  const auto refuse = [&](const std::string& text, const std::string& reason) {
    test::writeFile(folder / "bad.json", text);
    setup.parameters = {{"mode", "hold"}, {"gain", folder / "bad.json"}};
    CHECK_THROWS_WITH(makeRenderer(library("position_control"), setup),
                      ContainsSubstring("bad.json") && ContainsSubstring(reason));
  };
  refuse("nonsense", "must be the JSON file of a servo design");
  refuse(R"({"model": "a", "period": 0.001})", "K: is missing");
  refuse(R"({"model": "a", "period": 0, "K": [[1, 2, 3]]})", "period: is 0, must be in 1e-05 to 0.1 s");
  refuse(R"({"model": "a", "period": 0.001, "K": [[1, 2]]})", "K[0]: must be a list of 3 numbers");
  refuse(R"({"model": "a", "period": 0.001, "K": [[1, 2, "x"]]})", "K[0][2]: must be a number");
  refuse(R"({"model": "a", "period": 0.001, "K": []})", "K: has 0 rows, must have 1 to 7");

  // The other mode needs no file.
  const auto surface = makeRenderer(library("position_control"), nominalSetup({{"delay", "1"}, {"delay-high", "2"}}));
  PositionControlRenderer linkedSurface(positionControlFor(*device, 1e-3, 1, 2));
  surface->activate(1e-3);
  linkedSurface.activate(1e-3);
  for (int i = 1; i < 100; ++i) {
    const TickFrame input = test::frameAt(*device, test::poseAtDepth(1e-4 * std::sin(0.1 * i)), 1e-3 * i);
    TickOutput a, b;
    REQUIRE(surface->step(input, a) == Status::ok);
    REQUIRE(linkedSurface.step(input, b) == Status::ok);
    requireSame(a, b);
  }
  setup.parameters = {{"gain", folder / "servo.json"}};
  CHECK_THROWS_WITH(makeRenderer(library("position_control"), setup),
                    ContainsSubstring("gain: is only for mode hold: mode surface does not need a file"));
  for (const auto& [key, value, reason] : {std::tuple{"mode", "rubber", "is \"rubber\", must be surface or hold"},
                                           {"delay", "0.5", "delay: is 0.5, must be a whole number of ticks"},
                                           {"delay", "9", "delay: is 9, must be in 0 to 8 ticks"},
                                           {"delay-high", "many", "delay-high: is \"many\", must be a number"},
                                           {"drive", "loose", "is \"loose\", must be device, rigid or ideal"}}) {
    setup.parameters = {{key, value}};
    CHECK_THROWS_WITH(makeRenderer(library("position_control"), setup), ContainsSubstring(reason));
  }
  setup.parameters = {{"delay", "3"}, {"delay-high", "2"}};
  CHECK_THROWS_WITH(makeRenderer(library("position_control"), setup), ContainsSubstring("delay is 3 to 2 ticks"));
}

TEST_CASE("a plugin's errors arrive with file and reason", "[plugin]") {
  const auto impedance = library("impedance");
  CHECK_THROWS_WITH(makeRenderer(library("position_control"), {}),
                    ContainsSubstring("configure() failed") && ContainsSubstring("device: is missing"));
  PluginSetup setup = nominalSetup();
  setup.parameters = {{"stiffness", "-1"}};
  CHECK_THROWS_WITH(makeRenderer(impedance, setup), ContainsSubstring("stiffness: is -1, must be in 0 to"));
  setup.parameters = {{"stiffness", "soft"}};
  CHECK_THROWS_WITH(makeRenderer(impedance, setup), ContainsSubstring("is \"soft\", must be a number"));
  setup.parameters = {{"brains", "5"}};
  CHECK_THROWS_WITH(makeRenderer(impedance, setup), ContainsSubstring("brains: is not a parameter of impedance"));
  setup = nominalSetup();
  setup.deviceText = "nonsense";
  CHECK_THROWS_WITH(makeRenderer(impedance, setup), ContainsSubstring("tau-nominal.toml"));
  setup = nominalSetup();
  setup.scenePath = "/no/such/scene.toml";
  CHECK_THROWS_WITH(makeRenderer(impedance, setup), ContainsSubstring("/no/such/scene.toml"));
  const auto renderer = makeRenderer(impedance, nominalSetup());
  CHECK_THROWS_AS(renderer->activate(0.5), Error);
  TickOutput output;
  CHECK(renderer->step({}, output) == Status::inactive);
  CHECK_THROWS_AS(PluginLibrary::load(ENAMEL_BAD_PLUGINS "/bad_version.so"), PluginError);
}

TEST_CASE("what a bad plugin does in a tick becomes a fault", "[plugin]") {
  const TauMechanism device(test::nominal());
  TickOutput output;
  for (const auto& [name, status] : {std::pair{"nan", Status::notFinite}, {"limit", Status::ok}}) {
    INFO(name);
    const auto renderer = makeRenderer(PluginLibrary::load(ENAMEL_BAD_PLUGINS "/bad_" + std::string(name) + ".so"), {});
    renderer->activate(1e-3);
    CHECK(renderer->step(test::frameAt(device, test::poseAtDepth(1e-4), 1.0), output) == status);
    CHECK(output.torque.allFinite());
    CHECK((output.torque.array().abs() <= device.limits().effort.array()).all());
  }
}

}  // namespace enamel::test_host
