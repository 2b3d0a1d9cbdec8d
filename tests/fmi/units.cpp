// FMI 3.0 units. A master in this test gets from plant and renderer units the bits of the native loop. Units are
// accepted as plants, or refused with a reason. For FMPy as the master see tests/fmi/fmpy.sh.
#include <dlfcn.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <type_traits>

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/sim/push.hpp"
#include "plugins/fmi/archive.hpp"
#include "plugins/fmi/export.hpp"
#include "plugins/fmi/fmi3.hpp"
#include "plugins/fmi/import.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"

namespace enamel::test_units {

namespace {

const std::string kDevices = ENAMEL_SOURCE_DIR "/data/devices/";
const std::string kUnits = ENAMEL_PLUGINS "/../fmi";

/// Write a unit into a folder and return its path.
std::string unitOf(const test::TemporaryFolder& folder, const std::string& device, const std::string& renderer,
                   const std::map<std::string, std::string>& parameters = {}) {
  fmi::ExportSetup setup;
  setup.unit.renderer = renderer;
  setup.unit.parameters = parameters;
  setup.unit.plant = renderer.empty() ? "closed-form" : "";
  setup.deviceFile = kDevices + device;
  setup.binary = kUnits + "/enamel_fmi_unit.so";
  const std::string path = folder / ((renderer.empty() ? "plant" : renderer) + ".fmu");
  fmi::writeUnit(path, setup);
  return path;
}

/// A unit that the test drives by hand.
class Slave {
 public:
  Slave(const std::string& path, const std::string& device, const std::string& renderer,
        const std::map<std::string, std::string>& parameters = {})
      : archive_(path) {
    const auto mechanism = makeMechanism(loadDevice(kDevices + device));
    fmi::UnitConfiguration configuration;
    configuration.renderer = renderer;
    configuration.parameters = parameters;
    configuration.plant = renderer.empty() ? "closed-form" : "";
    table_ = fmi::variablesOf(configuration, *mechanism);
    handle_ = dlopen((archive_.folder() + "/binaries/" + fmi::platformTuple() + "/" + fmi::kIdentifier + ".so").c_str(),
                     RTLD_NOW | RTLD_LOCAL);
    REQUIRE(handle_ != nullptr);
    const std::string description = readFile(archive_.folder() + "/modelDescription.xml");
    const std::size_t at = description.find("instantiationToken=\"") + 20;
    token_ = description.substr(at, description.find('"', at) - at);
    instance_ = instantiate(token_);
    REQUIRE(instance_ != nullptr);
  }
  ~Slave() {
    call<fmi::FreeInstance>("fmi3FreeInstance")(instance_);
    dlclose(handle_);
  }
  Slave(const Slave&) = delete;
  Slave& operator=(const Slave&) = delete;

  fmi::Instance instantiate(const std::string& token) {
    return call<fmi::InstantiateCoSimulation>("fmi3InstantiateCoSimulation")(
        "slave", token.c_str(), (archive_.folder() + "/resources/").c_str(), false, false, false, false, nullptr, 0,
        &problem_,
        [](void* problem, fmi::Status, const char*, const char* text) { *static_cast<std::string*>(problem) = text; },
        nullptr);
  }
  void begin() {
    CHECK(call<fmi::EnterInitializationMode>("fmi3EnterInitializationMode")(instance_, false, 0, 0, false, 0) ==
          fmi::ok);
    CHECK(call<fmi::Transition>("fmi3ExitInitializationMode")(instance_) == fmi::ok);
  }
  fmi::Status set(const std::string& name, const double* values) {
    const fmi::Reference r = reference(name);
    return call<fmi::Set<double>>("fmi3SetFloat64")(instance_, &r, 1, values, table_[r].start.size());
  }
  fmi::Status setFlag(const std::string& name, bool value) {
    const fmi::Reference r = reference(name);
    return call<fmi::Set<bool>>("fmi3SetBoolean")(instance_, &r, 1, &value, 1);
  }
  Eigen::VectorXd get(const std::string& name) {
    const fmi::Reference r = reference(name);
    Eigen::VectorXd values(static_cast<Eigen::Index>(table_[r].start.size()));
    REQUIRE(call<fmi::Get<double>>("fmi3GetFloat64")(instance_, &r, 1, values.data(), table_[r].start.size()) ==
            fmi::ok);
    return values;
  }
  fmi::Status step(double time, double step) {
    bool event = true, terminate = true, early = true;
    double last = -1.0;
    const fmi::Status status =
        call<fmi::DoStep>("fmi3DoStep")(instance_, time, step, true, &event, &terminate, &early, &last);
    CHECK(!(event || terminate || early));
    return status;
  }
  template <typename Function>
  Function* call(const char* name) {
    auto* const function = reinterpret_cast<Function*>(dlsym(handle_, name));
    REQUIRE(function != nullptr);
    return function;
  }
  fmi::Reference reference(const std::string& name) const {
    for (std::size_t i = 0; i < table_.size(); ++i)
      if (table_[i].name == name) return static_cast<fmi::Reference>(i);
    FAIL("no variable " << name);
    return 0;
  }
  fmi::Instance instance() const { return instance_; }
  const std::string& token() const { return token_; }
  const std::string& problem() const { return problem_; }

 private:
  fmi::UnpackedArchive archive_;
  std::vector<fmi::Variable> table_;
  void* handle_;
  std::string token_, problem_;
  fmi::Instance instance_;
};

const std::set<std::string> kUsed = {"fmi3GetVersion",
                                     "fmi3SetDebugLogging",
                                     "fmi3InstantiateCoSimulation",
                                     "fmi3FreeInstance",
                                     "fmi3EnterInitializationMode",
                                     "fmi3ExitInitializationMode",
                                     "fmi3Terminate",
                                     "fmi3Reset",
                                     "fmi3GetFloat64",
                                     "fmi3SetFloat64",
                                     "fmi3GetInt32",
                                     "fmi3SetInt32",
                                     "fmi3GetBoolean",
                                     "fmi3SetBoolean",
                                     "fmi3GetFMUState",
                                     "fmi3SetFMUState",
                                     "fmi3FreeFMUState",
                                     "fmi3SerializedFMUStateSize",
                                     "fmi3SerializeFMUState",
                                     "fmi3DeserializeFMUState",
                                     "fmi3DoStep"};

/// Calls each function that a unit refuses, with the standard's parameters, all zero.
struct Refusals {
  Slave& unit;
  int count = 0;

  template <typename... Parameters>
  void operator()(const std::string& name, fmi::Status (*function)(fmi::Instance, Parameters...)) {
    if (kUsed.count(name) > 0) return;
    INFO(name);
    CHECK(function(unit.instance(), Parameters{}...) == fmi::error);
    CHECK(unit.problem() == name + ": not supported by this unit");
    ++count;
  }
  template <typename Result, typename... Parameters>
  void operator()(const std::string& name, Result (*function)(Parameters...)) {
    if (kUsed.count(name) > 0) return;
    INFO(name);
    if constexpr (std::is_same_v<Result, fmi::Instance>) CHECK(function(Parameters{}...) == nullptr);
    ++count;
  }
};

/// A run as seen by a master.
struct Seen {
  Eigen::VectorXd position, q, torque;
  bool operator==(const Seen& o) const { return position == o.position && q == o.q && torque == o.torque; }
};

/// Run ticks `from` to `to` of a push of 12 N from tick 1000 on.
std::vector<Seen> drive(Slave& plant, Slave& renderer, int from, int to) {
  std::vector<Seen> seen;
  for (int i = from; i < to; ++i) {
    const double time = i * 1e-3;
    const Eigen::VectorXd q = plant.get("q");
    for (const char* name : {"q", "rates", "applied"}) CHECK(renderer.set(name, plant.get(name).data()) == fmi::ok);
    const Eigen::VectorXd torque = renderer.get("torque");
    seen.push_back({plant.get("position"), q, torque});
    const Vec3 force(-0.0, -0.0, i >= 1000 ? -12.0 : -0.0);
    CHECK(plant.set("torque", torque.data()) == fmi::ok);
    CHECK(plant.set("force", force.data()) == fmi::ok);
    REQUIRE(renderer.step(time, 1e-3) == fmi::ok);
    REQUIRE(plant.step(time, 1e-3) == fmi::ok);
  }
  return seen;
}

std::string reasonOf(const std::string& path, const DeviceParameters& device) {
  try {
    const auto make = fmi::plantsOf(path, device);
    const auto plant = make(0);
    (void)plant->start(Pose{});
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// Return the files of a unit, in order to change them.
std::map<std::string, std::string> filesOf(const std::string& path) {
  const fmi::UnpackedArchive archive(path);
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(archive.folder()))
    if (entry.is_regular_file())
      files[std::filesystem::relative(entry.path(), archive.folder()).string()] =
          readFile(entry.path().string(), fmi::kLargestUnit);
  return files;
}

void write(const std::string& path, const std::map<std::string, std::string>& files) {
  std::vector<fmi::ArchiveFile> list;
  for (const auto& [name, bytes] : files) list.push_back({name, bytes});
  fmi::writeArchive(path, list);
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  REQUIRE(at != std::string::npos);
  return text.replace(at, what.size(), by);
}

}  // namespace

TEST_CASE("fmi: units of plant and renderer make the native loop's bits", "[fmi]") {
  const std::string file = "tau-nominal.toml";
  const auto device = makeMechanism(loadDevice(kDevices + file));
  for (const std::string name : {"hold", "position-control"}) {
    INFO(name);
    std::unique_ptr<Renderer> native;
    std::map<std::string, std::string> parameters;
    if (name == "hold") {
      HoldOptions options;
      options.release = false;
      parameters["release"] = "off";
      native = std::make_unique<HoldRenderer>(designServo(device, Pose{}, 1e-3).K, 1e-3, options);
    } else {
      native = std::make_unique<PositionControlRenderer>(positionControlFor(*device, 1e-3, 0, 0));
    }
    PushSetup setup;
    setup.hand.noise = 0.0;
    setup.duration = 1.2;
    std::vector<Seen> expected;
    const PushResult result = runPush(*device, *native, setup, [&](const TickRecord& tick) {
      expected.push_back({tick.pose.position, tick.q, tick.command});
    });
    REQUIRE(result.status == Status::ok);

    const test::TemporaryFolder folder;
    Slave plant(unitOf(folder, file, ""), file, "");
    Slave renderer(unitOf(folder, file, name, parameters), file, name, parameters);
    CHECK(plant.setFlag("guide", true) == fmi::ok);
    plant.begin();
    renderer.begin();
    std::vector<Seen> seen = drive(plant, renderer, 0, 1050);

    // Save both during the first impact, continue, and restore them; the renderer's state as bytes.
    fmi::State plantState = nullptr, state = nullptr, again = nullptr;
    REQUIRE(plant.call<fmi::GetState>("fmi3GetFMUState")(plant.instance(), &plantState) == fmi::ok);
    REQUIRE(renderer.call<fmi::GetState>("fmi3GetFMUState")(renderer.instance(), &state) == fmi::ok);
    std::size_t size = 0;
    REQUIRE(renderer.call<fmi::StateSize>("fmi3SerializedFMUStateSize")(renderer.instance(), state, &size) == fmi::ok);
    std::vector<std::uint8_t> bytes(size);
    REQUIRE(renderer.call<fmi::Serialize>("fmi3SerializeFMUState")(renderer.instance(), state, bytes.data(), size) ==
            fmi::ok);
    const std::vector<Seen> rest = drive(plant, renderer, 1050, 1200);
    seen.insert(seen.end(), rest.begin(), rest.end());
    REQUIRE(seen.size() == expected.size());
    CHECK(seen == expected);  // every tick, bit for bit
    double moved = 0.0;
    for (const Seen& tick : expected) moved = std::max(moved, (tick.position - expected.front().position).norm());
    CHECK(moved > 1e-6);

    CHECK(plant.call<fmi::SetState>("fmi3SetFMUState")(plant.instance(), plantState) == fmi::ok);
    REQUIRE(renderer.call<fmi::Deserialize>("fmi3DeserializeFMUState")(renderer.instance(), bytes.data(), size,
                                                                       &again) == fmi::ok);
    CHECK(renderer.call<fmi::SetState>("fmi3SetFMUState")(renderer.instance(), again) == fmi::ok);
    CHECK(drive(plant, renderer, 1050, 1200) == rest);
    for (auto& [slave, kept] : {std::pair<Slave&, fmi::State&>(plant, plantState), {renderer, again}}) {  // also after
      CHECK(slave.call<fmi::Transition>("fmi3Reset")(slave.instance()) == fmi::ok);
      CHECK(slave.call<fmi::SetState>("fmi3SetFMUState")(slave.instance(), kept) == fmi::ok);
    }
    CHECK(drive(plant, renderer, 1050, 1200) == rest);
    CHECK(renderer.call<fmi::Deserialize>("fmi3DeserializeFMUState")(renderer.instance(), bytes.data(), size / 2,
                                                                     &again) == fmi::error);
    for (auto& [slave, kept] :
         {std::pair<Slave&, fmi::State&>(plant, plantState), {renderer, state}, {renderer, again}}) {
      CHECK(slave.call<fmi::FreeState>("fmi3FreeFMUState")(slave.instance(), &kept) == fmi::ok);
      CHECK(kept == nullptr);
    }
  }
}

TEST_CASE("fmi: outputs follow from inputs without a step, and what is wrong is said", "[fmi]") {
  const std::string file = "cartesian-3.toml";
  const test::TemporaryFolder folder;
  Slave renderer(unitOf(folder, file, "impedance", {{"stiffness", "500"}}), file, "impedance", {{"stiffness", "500"}});
  CHECK(renderer.step(0.0, 1e-3) == fmi::error);
  CHECK(renderer.problem() == "fmi3DoStep is not allowed in this state of the unit");
  renderer.begin();
  Vec3 q(0.0, 0.0, 1e-4);
  CHECK(renderer.set("q", q.data()) == fmi::ok);
  const Eigen::VectorXd outside = renderer.get("torque");
  for (int i = 0; i < 300; ++i) REQUIRE(renderer.step(i * 1e-3, 1e-3) == fmi::ok);
  q.z() = -1e-3;  // move in small steps, because the guard limits the speed
  for (int i = 300; i < 400; ++i) {
    const Vec3 inside(0.0, 0.0, 1e-4 - 1.1e-3 * (i - 299) / 100.0);
    CHECK(renderer.set("q", inside.data()) == fmi::ok);
    REQUIRE(renderer.step(i * 1e-3, 1e-3) == fmi::ok);
  }
  const Eigen::VectorXd first = renderer.get("requested");
  CHECK(first[2] - outside[2] == Approx(0.5).epsilon(1e-6));
  q.z() = -0.98e-3;
  CHECK(renderer.set("q", q.data()) == fmi::ok);
  CHECK(renderer.get("requested")[2] - outside[2] == Approx(0.49).epsilon(1e-6));
  q.z() = -1e-3;
  CHECK(renderer.set("q", q.data()) == fmi::ok);
  CHECK(renderer.get("requested") == first);

  CHECK(renderer.step(0.4, 2e-3) == fmi::error);
  CHECK(renderer.problem().find("the step is 0.002") == 0);
  CHECK(renderer.set("torque", q.data()) == fmi::error);
  CHECK(renderer.problem() == "torque cannot be set now");
  q.x() = std::nan("");
  CHECK(renderer.set("q", q.data()) == fmi::error);
  CHECK(renderer.problem() == "q is not finite");
  const fmi::Reference wrong = 1000, mode = renderer.reference("mode");
  double value = 0.0;
  const auto get = renderer.call<fmi::Get<double>>("fmi3GetFloat64");
  CHECK(get(renderer.instance(), &wrong, 1, &value, 1) == fmi::error);
  CHECK(get(renderer.instance(), &mode, 1, &value, 1) == fmi::error);
  CHECK(renderer.problem() == "mode has another type");
  CHECK(renderer.instantiate("{another}") == nullptr);
  CHECK(renderer.problem().find("do not match modelDescription.xml") != std::string::npos);
}

TEST_CASE("fmi: a unit exports every function of the standard, and refuses those that it has no use for", "[fmi]") {
  const std::string file = "cartesian-3.toml";
  const test::TemporaryFolder folder;
  Slave plant(unitOf(folder, file, ""), file, "");
  plant.begin();
  Refusals refusals{plant};
#define CALL(name, type) refusals(#name, plant.call<type>(#name));
  using namespace fmi;  // for the types in the table
  ENAMEL_FMI3_FUNCTIONS(CALL)
#undef CALL
  CHECK(refusals.count == 54);
  CHECK(plant.step(0.0, 1e-3) == fmi::ok);  // none of the calls had an effect
}

TEST_CASE("fmi: every plant comes back to a saved state bit for bit", "[fmi]") {
  const std::string file = "tau-detailed.toml", multibody = kUnits + "/enamel_fmi_unit_multibody.so";
  for (const std::string plantName : {"closed-form", "real", "multibody"}) {
    if (plantName == "multibody" && !std::filesystem::exists(multibody)) continue;
    INFO(plantName);
    const test::TemporaryFolder folder;
    fmi::ExportSetup setup;
    setup.unit.plant = plantName;
    setup.deviceFile = kDevices + file;
    setup.binary = plantName == "multibody" ? multibody : kUnits + "/enamel_fmi_unit.so";
    fmi::writeUnit(folder / "plant.fmu", setup);
    CHECK(filesOf(folder / "plant.fmu")["modelDescription.xml"].find("canGetAndSetFMUState=\"true\"") !=
          std::string::npos);
    Slave plant(folder / "plant.fmu", file, "");
    const auto drive = [&](int first, int last) {
      std::vector<Eigen::VectorXd> seen;
      for (int i = first; i < last; ++i) {
        const Vec3 force(0.2 * std::sin(0.1 * i), 0.1, -0.3);
        CHECK(plant.set("force", force.data()) == fmi::ok);
        REQUIRE(plant.step(i * 1e-3, 1e-3) == fmi::ok);
        for (const char* name : {"position", "velocity", "q", "rates"}) seen.push_back(plant.get(name));
      }
      return seen;
    };
    plant.begin();
    (void)drive(0, 20);
    fmi::State state = nullptr;
    REQUIRE(plant.call<fmi::GetState>("fmi3GetFMUState")(plant.instance(), &state) == fmi::ok);
    const auto first = drive(20, 40);
    CHECK(first.back() != first[3]);
    for (int time = 0; time < 2; ++time) {  // a state can be used more than once
      CHECK(plant.call<fmi::SetState>("fmi3SetFMUState")(plant.instance(), state) == fmi::ok);
      CHECK(drive(20, 40) == first);
    }
    CHECK(plant.call<fmi::FreeState>("fmi3FreeFMUState")(plant.instance(), &state) == fmi::ok);
    CHECK(plant.call<fmi::SetState>("fmi3SetFMUState")(plant.instance(), state) == fmi::error);
    CHECK(plant.problem() == "the state is missing (NULL)");
  }
}

TEST_CASE("fmi: a unit as a plant is the plant that it was written from", "[fmi]") {
  for (const char* file : {"tau-nominal.toml", "delta.toml", "cartesian-6.toml"}) {
    INFO(file);
    const DeviceParameters parameters = loadDevice(kDevices + file);
    const auto mechanism = makeMechanism(parameters);
    const test::TemporaryFolder folder;
    const std::string path = unitOf(folder, file, "");
    const auto make = fmi::plantsOf(path, parameters);
    CHECK_THROWS_WITH(make(0)->clone(), path + ": a plant in another unit cannot be copied");
    ClosedFormPlant native(*mechanism);
    const auto unit = make(0), other = make(1);
    Pose start;
    start.position = {1e-3, -2e-3, 3e-3};
    REQUIRE(native.start(start) == Status::ok);
    REQUIRE(unit->start(start) == Status::ok);
    REQUIRE(other->start(Pose{}) == Status::ok);
    Kinematics k;
    for (int i = 0; i < 100; ++i) {
      JointVector torque = mechanism->home().gravity;
      for (Eigen::Index j = 0; j < torque.size(); ++j)
        torque[j] += 0.02 * mechanism->limits().effort[j] * std::sin(0.1 * i + static_cast<double>(j));
      Vec6 wrench = Vec6::Zero();
      wrench[i % 3] = 0.3;
      const auto held = [&](double, const Pose&, const Vec6&) { return wrench; };
      REQUIRE(native.advance(i * 1e-3, 1e-3, torque, held) == Status::ok);
      REQUIRE(unit->advance(i * 1e-3, 1e-3, torque, held) == Status::ok);
      REQUIRE(unit->state().position == native.state().position);
      REQUIRE(unit->state().orientation.coeffs() == native.state().orientation.coeffs());
      REQUIRE(unit->state().twist == native.state().twist);
      JointVector q, rates;
      REQUIRE(mechanism->reach(native.state().pose(), native.state().twist, false, k) == Status::ok);
      unit->read(k, q, rates);
      REQUIRE(q == k.q);
      REQUIRE(rates == k.rates);
    }
    CHECK(other->state().position == Vec3(Vec3::Zero()));  // instances share nothing
    REQUIRE(unit->start(start) == Status::ok);             // a second start
    CHECK(unit->state().twist == Vec6(Vec6::Zero()));
  }
}

TEST_CASE("fmi: a unit by another hand runs as a plant", "[fmi]") {
  // A description as from another author: scalars, and units with their own names.
  std::string text = R"(<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="mass" instantiationToken="{mass}">
  <CoSimulation modelIdentifier="mass" canHandleVariableCommunicationStepSize="true"/>
  <UnitDefinitions><Unit name="newton"><BaseUnit kg="1" m="1" s="-2"/></Unit></UnitDefinitions>
  <ModelVariables>
    <Float64 name="time" valueReference="12" causality="independent" variability="continuous"/>
)";
  const auto scalars = [&](const char* name, int first, const char* rest) {
    for (int i = 1; i <= 3; ++i)
      text += "    <Float64 name=\"" + std::string(name) + "[" + std::to_string(i) + "]\" valueReference=\"" +
              std::to_string(first + i - 1) + "\" " + rest + "/>\n";
  };
  scalars("velocity", 6, "causality=\"output\" unit=\"m/s\"");
  scalars("torque", 0, "causality=\"input\" start=\"0\" unit=\"newton\"");
  scalars("position", 9, "causality=\"output\"");
  scalars("force", 3, "causality=\"input\" start=\"0\" unit=\"newton\"");
  text += "  </ModelVariables>\n  <ModelStructure/>\n</fmiModelDescription>\n";
  const test::TemporaryFolder folder;
  const std::string path = folder / "mass.fmu";
  const std::string binary = "binaries/" + fmi::platformTuple() + "/mass.so";
  write(path, {{"modelDescription.xml", text}, {binary, readFile(kUnits + "/mass.so", fmi::kLargestUnit)}});

  const DeviceParameters device = loadDevice(kDevices + "cartesian-3.toml");
  const auto plant = fmi::plantsOf(path, device)(0);
  REQUIRE(plant->start(Pose{}) == Status::ok);
  // Under a constant force along x: v = F/b (1 - exp(-t b/m)).
  const JointVector torque = (JointVector(3) << 0.6, 0.0, 0.0).finished();
  const auto person = [](double, const Pose&, const Vec6&) { return (Vec6() << 0.4, 0, 0, 0, 0, 0).finished(); };
  for (int i = 0; i < 50; ++i) REQUIRE(plant->advance(i * 1e-3, 1e-3, torque, person) == Status::ok);
  CHECK(plant->state().twist[0] == Approx(0.5 * (1.0 - std::exp(-0.05 * 20.0))).epsilon(1e-12));
  CHECK(plant->state().position[0] == Approx(0.5 * (0.05 - (1.0 - std::exp(-1.0)) / 20.0)).epsilon(1e-12));

  const test::CommandResult pushed = test::run("push --device " + kDevices + "cartesian-3.toml --plant " + path +
                                               " --renderer impedance --stiffness 500 --noise 0 --force 3 --guard off");
  INFO(pushed.output);
  CHECK(pushed.status == 0);
  CHECK(pushed.output.find("K_z1") != std::string::npos);
  // The unit starts at its own pose, and reports it if the push starts elsewhere.
  const test::CommandResult away =
      test::run("push --device " + kDevices + "cartesian-3.toml --plant " + path + " --renderer impedance --x 5");
  CHECK(away.status == 1);
  CHECK(away.output.find("begins 0.005000 m") != std::string::npos);
}

TEST_CASE("fmi: broken units are refused with their reason", "[fmi]") {
  const std::string file = "tau-nominal.toml";
  const DeviceParameters device = loadDevice(kDevices + file);
  const test::TemporaryFolder folder;
  const auto good = filesOf(unitOf(folder, file, ""));
  const std::string path = folder / "broken.fmu", binary = "binaries/" + fmi::platformTuple() + "/enamel_unit.so",
                    xml = "modelDescription.xml";
  const auto refusal = [&](const std::map<std::string, std::string>& files) {
    write(path, files);
    const std::string reason = reasonOf(path, device);
    CHECK(reason.find(path + ": ") == 0);
    return reason.substr(path.size() + 2);
  };
  const auto described = [&](const std::string& what, const std::string& by) {
    auto files = good;
    files[xml] = replaced(files[xml], what, by);
    files[binary].clear();  // not checked here
    return refusal(files);
  };
  write(path, good);
  CHECK(reasonOf(path, device).empty());
  CHECK(described("fmiVersion=\"3.0\"", "fmiVersion=\"2.0\"") == "has the FMI version \"2.0\", must be 3.0");
  CHECK(described("<CoSimulation ", "<ModelExchange ") == "does not support co-simulation");
  CHECK(described("name=\"torque\"", "name=\"tau\"") == "has no input torque of 6 numbers");
  CHECK(described("name=\"position\"", "name=\"place\"") == "has no output position of 3 numbers");
  CHECK(described("name=\"orientation\"", "name=\"attitude\"") ==
        "needs an output orientation, because the device turns");
  CHECK(described("name=\"rates\"", "name=\"speeds\"") ==
        "has one of the outputs q and rates, must have both or neither");
  CHECK(described("name=\"velocity\" valueReference=\"6\" description=\"Velocity of the TCP, W\" causality=\"output\"",
                  "name=\"velocity\" valueReference=\"6\" causality=\"local\"") ==
        "variable velocity has the causality \"local\", must be output");
  CHECK(described("<Dimension start=\"6\"", "<Dimension start=\"5\"") == "variable torque has 5 numbers, must have 6");
  CHECK(described("<BaseUnit m=\"1\"", "<BaseUnit factor=\"0.001\" m=\"1\"") ==
        "variable position is in m, must be in SI: kg^0 m^1 s^0");
  CHECK(described("<ModelVariables>", "<ModelVariable>").find("modelDescription.xml: ") == 0);
  auto files = good;
  files[xml] = replaced(files[xml], "instantiationToken=\"{", "instantiationToken=\"{no");
  CHECK(refusal(files).find("cannot be instantiated: ") == 0);
  files = good;
  files.erase(binary);
  CHECK(refusal(files) == "has no " + binary + ", a binary for this machine");
  files[binary] = "no library";
  CHECK(refusal(files).find(binary + " cannot be loaded: ") == 0);
  files[binary] = readFile(ENAMEL_PLUGINS "/enamel_impedance.so", fmi::kLargestUnit);
  CHECK(refusal(files) == "its binary has no fmi3GetVersion()");
  files = good;
  files.erase(xml);
  CHECK(refusal(files).find("modelDescription.xml: ") == 0);
  files = good;
  files.erase("resources/device.toml");
  CHECK(refusal(files).find("cannot be instantiated: ") == 0);
  files = good;
  files["../outside"] = "";
  CHECK(refusal(files) == "holds \"../outside\", a path outside of the archive");
  test::writeFile(path, "no archive");
  CHECK(reasonOf(path, device).find(path + ": cannot open the archive: ") == 0);
  CHECK(reasonOf(folder / "absent.fmu", device).find("cannot open the archive: ") != std::string::npos);
  CHECK(reasonOf(unitOf(folder, "delta.toml", ""), device) ==
        folder / "plant.fmu" + ": variable torque has 3 numbers, must have 6");

  const test::CommandResult pushed = test::run("push --device " + kDevices + file + " --plant " + path);
  CHECK(pushed.status == 1);
  CHECK(pushed.output.find("cannot open the archive") != std::string::npos);
}

TEST_CASE("fmi: the command writes units and says what it cannot", "[fmi]") {
  const test::TemporaryFolder folder;
  const std::string tau = "fmu --device " + kDevices + "tau-nominal.toml --output " + folder / "unit.fmu";
  const test::CommandResult molar =
      test::run(tau + " --renderer position-control --scene " ENAMEL_SOURCE_DIR "/data/scenes/molar.toml");
  CHECK(molar.status == 0);
  {
    const fmi::UnpackedArchive unit(folder / "unit.fmu");  // it contains the mesh
    const SceneFile packed = loadScene(unit.folder() + "/resources/scene.toml");
    const SceneFile scene = loadScene(ENAMEL_SOURCE_DIR "/data/scenes/molar.toml");
    Pose pose;
    pose.position = scene.start;
    CHECK(nearestContact(packed.scene, packed.tool, pose, nullptr).gap ==
          nearestContact(scene.scene, scene.tool, pose, nullptr).gap);
  }
  for (const auto& [options, reason] :
       std::map<std::string, std::string>{{" --scene x.toml", "--scene and --set need --renderer"},
                                          {" --renderer wood", "unknown plugin \"wood\""},
                                          {" --renderer impedance --period 1", "0.1"},
                                          {" --plant wood", "wood"},
                                          {" --substeps 0", "--substeps is 0"}}) {
    const test::CommandResult result = test::run(tau + options + " --overwrite");
    INFO(options << ": " << result.output);
    CHECK(result.status != 0);
    CHECK(result.output.find(reason) != std::string::npos);
  }
}

}  // namespace enamel::test_units
