// The C interface: the same bits from every language, and safety against NULL, wrong sizes, stale ids and bad input.
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <thread>
#include <vector>

#include "enamel/c/enamel.h"
#include "enamel/core/unity_frame.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/session/session.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/eventually.hpp"
#include "support/meshes.hpp"

namespace enamel::test_c_interface {

using test::ContainsSubstring;

namespace {

// The push of tests/c/push.c in C++: the bits of the torques.
std::string pushInCpp() {
  SessionDef def;
  def.start.emplace();
  def.start->position.z() = 0.5e-3;
  Session session(def);
  TriangleMesh box;
  for (const double z : {-0.01, 0.0})
    for (const auto& [x, y] : {std::pair{-0.02, -0.02}, {0.02, -0.02}, {0.02, 0.02}, {-0.02, 0.02}})
      box.vertices.emplace_back(x, y, z);
  box.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                   {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  SessionObstacle plate;
  plate.name = "plate";
  plate.mesh = std::make_shared<MeshModel>(std::move(box));
  (void)session.add(plate);
  VirtualDeviceSetup setup;
  setup.start = *def.start;
  VirtualDevice device(session.mechanism(), setup);
  std::string bits;
  for (int i = 0; i < 300; ++i) {
    Measurement measurement;
    Command command;
    REQUIRE(device.measure(measurement) == Status::ok);
    REQUIRE(session.tick(measurement, command) == Status::ok);
    Vec6 wrench;
    wrench << -5.0 * device.state().twist.head<3>(), -0.02 * device.state().twist.tail<3>();
    wrench[2] -= 2.0;
    REQUIRE(device.actuate(command) == Status::ok);
    REQUIRE(device.advance([&](double, const Pose&, const Vec6&) { return wrench; }) == Status::ok);
    for (int j = 0; j < 6; ++j) {
      std::uint64_t number = 0;
      std::memcpy(&number, &command.effort[j], sizeof number);
      char text[20];
      std::snprintf(text, sizeof text, "%016llx%c", static_cast<unsigned long long>(number), j < 5 ? ' ' : '\n');
      bits += text;
    }
  }
  return bits;
}

std::string outputOf(const std::string& command) {
  const test::TemporaryFolder folder;
  const int code = std::system(("LC_ALL=C " + command + " >" + (folder / "out") + " 2>&1").c_str());
  std::string text = test::readFile(folder / "out");
  INFO(text);
  REQUIRE(code == 0);
  return text;
}

const std::string kClients = ENAMEL_SOURCE_DIR "/tests/c/";

class Handle {
 public:
  explicit Handle(const EnamelSessionDef& def) {
    char text[256] = "";
    const std::int32_t result = enamel_session_create(&def, &session_, {text, sizeof text});
    INFO(text);
    REQUIRE(result == ENAMEL_OK);
  }
  ~Handle() { enamel_session_destroy(session_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator EnamelSession*() const { return session_; }  // NOLINT: reads like the C program
  std::string message() const {
    char text[512] = "";
    enamel_message(session_, {text, sizeof text});
    return text;
  }

 private:
  EnamelSession* session_ = nullptr;
};

EnamelSessionDef defaults() {
  EnamelSessionDef def;
  REQUIRE(enamel_session_defaults(&def) == ENAMEL_OK);
  return def;
}

EnamelObstacleDef obstacle(const char* name, EnamelShape shape, double size) {
  EnamelObstacleDef def;
  REQUIRE(enamel_obstacle_defaults(&def) == ENAMEL_OK);
  def.name = name;
  def.shape = shape;
  def.dimensions[0] = def.dimensions[1] = def.dimensions[2] = size;
  return def;
}

EnamelSnapshot snapshotOf(EnamelSession* session) {
  EnamelSnapshot now{};
  now.size = sizeof now;
  REQUIRE(enamel_snapshot(session, &now) == ENAMEL_OK);
  return now;
}

// A Cartesian device of 0.2 kg with three axes, as a host would write it.
std::int32_t fill(const double* q, const double* rates, EnamelKinematics* state) {
  *state = EnamelKinematics{};
  for (int i = 0; i < 3; ++i) {
    state->q[i] = state->position[i] = q[i];
    state->rates[i] = state->twist[i] = rates[i];
    state->rotation[4 * i] = 1.0;
    state->jacobian[i][i] = state->inverse[i][i] = 1.0;
    state->inertia[i][i] = 0.2;
  }
  return ENAMEL_OK;
}
std::int32_t trackOf(void*, const double* q, const double* rates, EnamelKinematics* state) {
  return fill(q, rates, state);
}
std::int32_t reachOf(void*, const EnamelPose* pose, const double* twist, EnamelKinematics* state) {
  return fill(pose->position, twist, state);
}
EnamelMechanism cartesian() {
  EnamelMechanism mechanism{};
  mechanism.size = sizeof mechanism;
  mechanism.joints = 3;
  mechanism.name = "my axes";
  for (int i = 0; i < 3; ++i) {
    mechanism.max_torque[i] = 10.0;
    mechanism.encoder_step[i] = 1e-5;
  }
  mechanism.track = trackOf;
  mechanism.reach = reachOf;
  return mechanism;
}

// A driver: a mass of 0.2 kg that falls onto the wall under 1 N, with some damping.
struct OwnAxis {
  double z = 0.5e-3, speed = 0.0, time = 0.0, force = 0.0;
  bool isOpen = false;
  std::atomic<bool> refuses{false};
};
std::int32_t openAxis(void* user, EnamelMessage) {
  static_cast<OwnAxis*>(user)->isOpen = true;
  return ENAMEL_OK;
}
void closeAxis(void* user) { static_cast<OwnAxis*>(user)->isOpen = false; }
std::int32_t measureAxis(void* user, EnamelMeasurement* measurement) {
  auto& axis = *static_cast<OwnAxis*>(user);
  measurement->time = axis.time;
  measurement->q[2] = 1e-5 * std::round(1e5 * axis.z);
  measurement->rates[2] = axis.speed;
  return ENAMEL_OK;
}
std::int32_t actuateAxis(void* user, const double* effort, std::int32_t) {
  auto& axis = *static_cast<OwnAxis*>(user);
  axis.time += 1e-3;
  axis.speed += 1e-3 * (effort[2] - 1.0 - 3.0 * axis.speed) / 0.2;
  axis.z += 1e-3 * axis.speed;
  axis.force = effort[2];
  return axis.refuses ? ENAMEL_INACTIVE : ENAMEL_OK;
}

}  // namespace

TEST_CASE("a push has the same bits in C++, C, Python and C#", "[c]") {
  const std::string expected = pushInCpp();
  CHECK(outputOf(ENAMEL_C_CLIENT) == expected);
  const std::string library = "ENAMEL_LIBRARY=" ENAMEL_C_LIBRARY " ";
  CHECK(outputOf(library + "PYTHONDONTWRITEBYTECODE=1 python3 " + kClients + "push.py") == expected);
  if (std::system("command -v mcs >/dev/null && command -v mono >/dev/null") != 0) {
    WARN("mono is not installed: the C# client is not run");
    return;
  }
  const test::TemporaryFolder folder;
  const std::string program = folder / "push.exe";
  outputOf("mcs -out:" + program + " " + kClients + "Push.cs " ENAMEL_SOURCE_DIR "/plugins/csharp/Enamel.cs");
  const std::string run = "LD_LIBRARY_PATH=$(dirname " ENAMEL_C_LIBRARY ") mono " + program;
  CHECK(outputOf(run) == expected);
  // Every struct of the C# binding has the layout of the header.
  std::istringstream layout(outputOf(run + " --layout"));
  const std::string description = test::readFile(ENAMEL_SOURCE_DIR "/lib/src/c/enamel.abi");
  int lines = 0;
  for (std::string line; std::getline(layout, line); ++lines) {
    CAPTURE(line);
    CHECK(description.find(line) != std::string::npos);
  }
  CHECK(lines > 100);
}

TEST_CASE("an own tooth in Python and C#, by the commands of the page", "[c]") {
  const std::string page = test::readFile(ENAMEL_SOURCE_DIR "/plugins/LANGUAGES.md");
  // The page is for a release build in the project's folder.
  const auto run = [&](std::string command, const std::string& folder) {
    INFO(command);
    CHECK(page.find(command) != std::string::npos);
    const std::string library = ENAMEL_C_LIBRARY;
    for (const auto& [from, to] : {std::pair<std::string, std::string>{"build/release/lib/libenamel.so", library},
                                   {"build/release/lib", library.substr(0, library.rfind('/'))},
                                   {"own_tooth.exe", folder + "/own_tooth.exe"}})
      if (const std::size_t at = command.find(from); at != std::string::npos) command.replace(at, from.size(), to);
    return outputOf("cd " ENAMEL_SOURCE_DIR " && PYTHONDONTWRITEBYTECODE=1 " + command);
  };
  const test::TemporaryFolder folder;
  CHECK_THAT(
      run("ENAMEL_LIBRARY=build/release/lib/libenamel.so python3 plugins/ctypes/own_tooth.py data/meshes/molar.ply",
          ""),
      ContainsSubstring("contact begins"));
  if (std::system("command -v mcs >/dev/null && command -v mono >/dev/null") != 0) return;
  run("mcs -out:own_tooth.exe plugins/csharp/OwnTooth.cs plugins/csharp/Enamel.cs", folder / "");
  CHECK_THAT(run("LD_LIBRARY_PATH=build/release/lib mono own_tooth.exe data/meshes/molar.ply", folder / ""),
             ContainsSubstring("contact begins"));
}

TEST_CASE("guides of C reach the ticks", "[c]") {
  EnamelSessionDef def = defaults();
  const EnamelMechanism mechanism = cartesian();
  def.mechanism = &mechanism;
  Handle session(def);
  const double points[] = {-0.1, 0.0, 0.02, 0.1, 0.0, 0.02};
  EnamelGuide guides[2] = {};
  for (EnamelGuide& guide : guides) {
    guide.pose.rotation[0] = guide.pose.rotation[4] = guide.pose.rotation[8] = 1.0;
    guide.stiffness = 100.0;
    guide.max_force = 1.0;
  }
  EnamelMeasurement measurement{};
  measurement.size = sizeof measurement;
  measurement.enabled = 1;
  const auto force = [&](EnamelGuideShape shape) {
    guides[0].shape = shape;
    REQUIRE(enamel_set_guides(session, guides, 1) == ENAMEL_OK);
    double effort[ENAMEL_MAX_JOINTS] = {};
    for (int i = 0; i < 200; ++i) {
      measurement.time += 1e-3;
      REQUIRE(enamel_tick(session, &measurement, effort) == ENAMEL_OK);
    }
    return Vec3(effort[0], effort[1], effort[2]);
  };
  guides[0].points = points;
  guides[0].point_count = 2;
  CHECK((force(ENAMEL_GUIDE_LINE) - Vec3(0.0, 0.0, 1.0)).norm() < 1e-9);  // 2 N by the spring
  guides[0].dimensions[0] = 0.015;
  CHECK((force(ENAMEL_GUIDE_LINE) - Vec3(0.0, 0.0, 0.5)).norm() < 1e-9);
  guides[0].pose.position[2] = 5e-3;
  CHECK((force(ENAMEL_GUIDE_PLANE) - Vec3(0.0, 0.0, 0.5)).norm() < 1e-9);
  CHECK((force(ENAMEL_GUIDE_HALF_SPACE) - Vec3(0.0, 0.0, 0.5)).norm() < 1e-9);
  for (double& half : guides[0].dimensions) half = 2e-3;
  CHECK((force(ENAMEL_GUIDE_BOX) - Vec3(0.0, 0.0, 0.3)).norm() < 1e-9);
  guides[1].shape = 7;
  CHECK(enamel_set_guides(session, guides, 2) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("EnamelGuide.shape is 7, must be an EnamelGuideShape, 0 to 3"));
  guides[1].shape = ENAMEL_GUIDE_LINE;
  CHECK(enamel_set_guides(session, guides, 2) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("guide 1: the line has 0 points"));
  guides[1].points = points;
  guides[1].point_count = 65;
  CHECK(enamel_set_guides(session, guides, 2) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("guide 1: the line has 65 points"));
  CHECK(enamel_set_guides(session, guides, 9) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("there are 9 guides, must be at most 8"));
  CHECK(enamel_set_guides(session, nullptr, 1) == ENAMEL_NULL);
  CHECK(enamel_set_guides(session, nullptr, 0) == ENAMEL_OK);
}

TEST_CASE("the stored binary interface is that of the header", "[c]") {
  CHECK(outputOf("python3 " + kClients + "layout.py --check").empty());
  CHECK(enamel_version() == ENAMEL_VERSION_MAJOR * 65536 + ENAMEL_VERSION_MINOR * 256 + ENAMEL_VERSION_PATCH);
}

TEST_CASE("NULL and wrong sizes are errors of every function", "[c]") {
  EnamelPose pose{};
  EnamelObstacle id{0, 1};
  EnamelEvent event{};
  EnamelSnapshot snapshot{};
  EnamelMeasurement measurement{};
  EnamelObstacleDef def{};
  double numbers[9] = {};
  std::int32_t flag = 0;
  for (const std::int32_t result : {enamel_session_defaults(nullptr),
                                    enamel_obstacle_defaults(nullptr),
                                    enamel_session_create(nullptr, nullptr, {nullptr, 0}),
                                    enamel_message(nullptr, {nullptr, 0}),
                                    enamel_start(nullptr),
                                    enamel_start_device(nullptr, nullptr),
                                    enamel_start_virtual(nullptr, nullptr, nullptr),
                                    enamel_stop(nullptr),
                                    enamel_is_running(nullptr, &flag),
                                    enamel_tick(nullptr, &measurement, numbers),
                                    enamel_snapshot(nullptr, &snapshot),
                                    enamel_next_event(nullptr, &event),
                                    enamel_add(nullptr, &def, &id),
                                    enamel_replace(nullptr, id, &def),
                                    enamel_remove(nullptr, id),
                                    enamel_find(nullptr, "a", &id),
                                    enamel_move(nullptr, id, &pose, nullptr),
                                    enamel_set_material(nullptr, id, nullptr),
                                    enamel_set_suspension(nullptr, id, nullptr),
                                    enamel_set_tap(nullptr, id, 300.0, 90.0),
                                    enamel_activate(nullptr, id, 1),
                                    enamel_move_vertices(nullptr, id, &flag, numbers, 1),
                                    enamel_restore(nullptr, id),
                                    enamel_mark(nullptr, id),
                                    enamel_undo(nullptr, id),
                                    enamel_solid_load(nullptr, nullptr, {nullptr, 0}),
                                    enamel_labels_defaults(nullptr),
                                    enamel_solid_from_labels(nullptr, nullptr, {nullptr, 0}),
                                    enamel_solid_copy(nullptr, id, nullptr),
                                    enamel_solid_save(nullptr, "x", {nullptr, 0}),
                                    enamel_solid_compare(nullptr, &def, nullptr, nullptr, {nullptr, 0}),
                                    enamel_set_guides(nullptr, nullptr, 0),
                                    enamel_named_tool("round-010", nullptr, {nullptr, 0}),
                                    enamel_set_tool(nullptr, nullptr, nullptr),
                                    enamel_set_renderer(nullptr, "hold", nullptr, 0),
                                    enamel_set_own_renderer(nullptr, nullptr, nullptr, 0),
                                    enamel_set_effect(nullptr, numbers),
                                    enamel_spin(nullptr, 1),
                                    enamel_clutch(nullptr, 1),
                                    enamel_enable(nullptr, 1),
                                    enamel_reset(nullptr),
                                    enamel_record(nullptr, "x"),
                                    enamel_stop_recording(nullptr, nullptr, nullptr),
                                    enamel_tick_measurement(nullptr, &measurement),
                                    enamel_tick_move(nullptr, id, &pose, nullptr),
                                    enamel_tick_activate(nullptr, id, 1),
                                    enamel_tick_spin(nullptr, 1),
                                    enamel_tick_effect(nullptr, numbers),
                                    enamel_virtual_create(nullptr, nullptr),
                                    enamel_virtual_measure(nullptr, &measurement),
                                    enamel_virtual_actuate(nullptr, numbers),
                                    enamel_virtual_advance(nullptr, numbers),
                                    enamel_virtual_state(nullptr, &pose, numbers)})
    CHECK(result == ENAMEL_NULL);
  enamel_session_destroy(nullptr);
  enamel_virtual_destroy(nullptr);
  enamel_solid_destroy(nullptr);
  enamel_vector_from_unity(nullptr);
  enamel_rotation_to_unity(nullptr, nullptr);

  EnamelSessionDef wrong = defaults();
  wrong.size -= 8;
  EnamelSession* none = nullptr;
  CHECK(enamel_session_create(&wrong, &none, {nullptr, 0}) == ENAMEL_SIZE);
  CHECK(none == nullptr);

  const Handle session(defaults());
  CHECK(enamel_snapshot(session, &snapshot) == ENAMEL_SIZE);
  CHECK(enamel_next_event(session, &event) == ENAMEL_SIZE);
  CHECK(enamel_tick(session, &measurement, numbers) == ENAMEL_SIZE);
  CHECK(enamel_add(session, nullptr, &id) == ENAMEL_NULL);
  CHECK_THAT(session.message(), ContainsSubstring("a required pointer is NULL"));
  CHECK(enamel_add(session, &def, &id) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("EnamelObstacleDef.size is 0"));
  char tiny[4];
  CHECK(enamel_message(session, {tiny, sizeof tiny}) == ENAMEL_OK);
  CHECK(std::string(tiny) == "Ena");
  event.size = sizeof event;
  CHECK(enamel_next_event(session, &event) == ENAMEL_NOTHING);
  CHECK(std::string(enamel_result_text(12345)) == "unknown result");
  CHECK(std::string(enamel_reason_text(-1)) == "unknown reason");
}

TEST_CASE("errors have the reason of the library, and change nothing", "[c]") {
  EnamelSessionDef def = defaults();
  def.scene = "no such file.toml";
  char text[200] = "";
  EnamelSession* none = nullptr;
  CHECK(enamel_session_create(&def, &none, {text, sizeof text}) == ENAMEL_FAILED);
  CHECK_THAT(text, ContainsSubstring("no such file.toml"));

  const Handle session(defaults());
  EnamelObstacle first{}, second{};
  EnamelObstacleDef ball = obstacle("ball", ENAMEL_SPHERE, 1e-3);
  REQUIRE(enamel_add(session, &ball, &first) == ENAMEL_OK);
  CHECK(enamel_add(session, &ball, &second) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("occurs twice"));
  ball.name = "other";
  ball.dimensions[0] = -1.0;
  CHECK(enamel_add(session, &ball, &second) == ENAMEL_FAILED);
  ball.shape = 17;
  CHECK(enamel_add(session, &ball, &second) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("EnamelObstacleDef.shape is 17"));
  ball.shape = ENAMEL_MESH;
  CHECK(enamel_add(session, &ball, &second) == ENAMEL_FAILED);
  const double vertices[] = {0, 0, 0, 1e-2, 0, 0, 0, 1e-2, 0};
  const std::int32_t corners[] = {0, 1, 7};
  ball.vertices = vertices;
  ball.vertex_count = 3;
  ball.triangles = corners;
  ball.triangle_count = 1;
  CHECK(enamel_add(session, &ball, &second) == ENAMEL_FAILED);
  EnamelMaterial gum{1500.0, 0.1, 0.1, 0.0, 1.5, 2e-3, 1.0, 3.0, 0.01, 5e-6, 3e-4};
  CHECK(enamel_set_material(session, first, &gum) == ENAMEL_OK);
  gum.exponent = 11.0;
  CHECK(enamel_set_material(session, first, &gum) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("an exponent in 1 to 10"));
  gum.exponent = gum.thickness = 0.0;  // linear, without ground
  CHECK(enamel_set_material(session, first, &gum) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("a puncture force needs a thickness"));
  gum.puncture = 0.0;  // never
  CHECK(enamel_set_material(session, first, &gum) == ENAMEL_OK);
  gum.hysteresis = -1.0;
  CHECK(enamel_set_material(session, first, &gum) == ENAMEL_FAILED);
  gum.hysteresis = 0.0;
  gum.roughness = 1e-5;
  CHECK(enamel_set_material(session, first, &gum) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("a roughness of 1e-05 m"));
  gum.roughness = 0.0;
  gum.stribeck = -1.0;
  CHECK(enamel_set_material(session, first, &gum) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("a Stribeck speed of -1 m/s"));
  EnamelPose away{{std::numeric_limits<double>::quiet_NaN(), 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  CHECK(enamel_move(session, first, &away, nullptr) == ENAMEL_FAILED);
  REQUIRE(enamel_remove(session, first) == ENAMEL_OK);
  CHECK(enamel_remove(session, first) == ENAMEL_FAILED);
  CHECK(enamel_activate(session, {999, 3}, 1) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("it was removed"));
  CHECK(enamel_find(session, "ball", &second) == ENAMEL_NOTHING);
  CHECK(second.generation == 0);
  CHECK(enamel_clutch(session, 1) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("a clutch needs a workspace map"));
}

namespace {

// A cube of 8 mm that a bur can cut.
struct Cube {
  std::vector<double> vertices;
  std::vector<std::int32_t> triangles;
  EnamelLayer layer{
      {std::numeric_limits<double>::infinity(), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}, 0.2e9, 0.0};
  EnamelObstacleDef def = obstacle("cube", ENAMEL_SOLID, 0.0);

  Cube() {
    const TriangleMesh box = test::boxMesh(Vec3::Constant(4e-3));
    for (const Vec3& v : box.vertices) vertices.insert(vertices.end(), v.data(), v.data() + 3);
    for (const auto& t : box.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
    def.vertices = vertices.data();
    def.vertex_count = box.vertices.size();
    def.triangles = triangles.data();
    def.triangle_count = box.triangles.size();
    def.layers = &layer;
    def.layer_count = 1;
    def.cell = 2e-4;
  }
  Cube(const Cube&) = delete;
  Cube& operator=(const Cube&) = delete;
};

// A session with a bur above the cube.
EnamelSessionDef drilling() {
  static const EnamelPose start{{0, 0, 5e-3}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  static const EnamelBur bur{sizeof(EnamelBur), 0, 0.5, 2000.0, 1e-3, 0.0, 0.3, 5e-6, 6, 1e-5, 1000.0, 0.05};
  static EnamelTool tool{};
  tool.size = sizeof tool;
  tool.count = 1;
  tool.parts[0].radius = 1e-3;
  EnamelSessionDef def = defaults();
  def.start = &start;
  def.tool = &tool;
  def.bur = &bur;
  return def;
}

// Press on what is below the tool.
void pressFor(EnamelSession* session, EnamelVirtualDevice* device, int ticks) {
  for (int i = 0; i < ticks; ++i) {
    EnamelMeasurement measurement{};
    measurement.size = sizeof measurement;
    EnamelPose pose{};
    double effort[ENAMEL_MAX_JOINTS], twist[6], wrench[6];
    REQUIRE(enamel_virtual_measure(device, &measurement) == ENAMEL_OK);
    REQUIRE(enamel_tick(session, &measurement, effort) == ENAMEL_OK);
    REQUIRE(enamel_virtual_state(device, &pose, twist) == ENAMEL_OK);
    for (int j = 0; j < 6; ++j) wrench[j] = (j < 3 ? -20.0 : -0.05) * twist[j];
    wrench[2] -= 2.0;
    REQUIRE(enamel_virtual_actuate(device, effort) == ENAMEL_OK);
    REQUIRE(enamel_virtual_advance(device, wrench) == ENAMEL_OK);
  }
}

// The solid of a session with all of its cuts.
EnamelSolid* cutOf(EnamelSession* session, EnamelObstacle id) {
  EnamelSolid* solid = nullptr;
  REQUIRE(enamel_stop(session) == ENAMEL_OK);
  REQUIRE(enamel_solid_copy(session, id, &solid) == ENAMEL_OK);
  return solid;
}

EnamelCutComparison compared(EnamelSolid* solid, const EnamelObstacleDef& target) {
  EnamelCutComparison comparison{};
  comparison.size = sizeof comparison;
  REQUIRE(enamel_solid_compare(solid, &target, nullptr, &comparison, {nullptr, 0}) == ENAMEL_OK);
  return comparison;
}

}  // namespace

TEST_CASE("a solid is cut, and its changed bricks come as triangles", "[c]") {
  const Handle session(drilling());
  const Cube cube;
  EnamelObstacle id{};
  REQUIRE(enamel_add(session, &cube.def, &id) == ENAMEL_OK);

  std::vector<double> points(3 * ENAMEL_SURFACE_VERTICES), normals(3 * ENAMEL_SURFACE_VERTICES);
  std::vector<std::int32_t> layers(ENAMEL_SURFACE_VERTICES), corners(3 * ENAMEL_SURFACE_TRIANGLES);
  EnamelSurface surface{sizeof(EnamelSurface),
                        -1,
                        points.data(),
                        normals.data(),
                        layers.data(),
                        corners.data(),
                        ENAMEL_SURFACE_VERTICES,
                        ENAMEL_SURFACE_TRIANGLES,
                        0,
                        0};
  CHECK(enamel_take_surface(session, id, &surface) == ENAMEL_NOTHING);
  std::int32_t bricks = 0;
  REQUIRE(enamel_solid_bricks(session, id, &bricks) == ENAMEL_OK);
  double area = 0.0;
  for (std::int32_t brick = 0; brick < bricks; ++brick) {
    surface.brick = brick;
    REQUIRE(enamel_take_surface(session, id, &surface) == ENAMEL_OK);
    for (std::size_t i = 0; i < surface.triangle_count; ++i) {
      const auto at = [&](std::size_t k) {
        return Vec3(Eigen::Map<const Vec3>(points.data() + 3 * corners[3 * i + k]));
      };
      area += 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
    }
  }
  CHECK(area == Approx(6.0 * 64e-6).epsilon(0.02));

  EnamelVirtualDevice* device = nullptr;
  REQUIRE(enamel_virtual_create(session, &device) == ENAMEL_OK);
  REQUIRE(enamel_spin(session, 1) == ENAMEL_OK);
  double chatter = 0.0;
  for (int i = 0; i < 400; ++i) {
    pressFor(session, device, 1);
    chatter = std::max(chatter, snapshotOf(session).bur_chatter);
  }
  CHECK(chatter > 0.0);
  enamel_virtual_destroy(device);
  CHECK(snapshotOf(session).removed[0] > 0.0);
  double lowest = 1.0;
  int changed = 0;
  for (surface.brick = -1; enamel_take_surface(session, id, &surface) == ENAMEL_OK; surface.brick = -1, ++changed)
    for (std::size_t i = 0; i < surface.vertex_count; ++i)
      if (std::abs(points[3 * i]) < 1e-3 && std::abs(points[3 * i + 1]) < 1e-3)
        lowest = std::min(lowest, points[3 * i + 2]);
  CHECK(changed > 0);
  CHECK(lowest < 4e-3 - 50e-6);  // the bottom of the cut
  surface.brick = bricks;
  CHECK(enamel_take_surface(session, id, &surface) == ENAMEL_FAILED);
  surface.brick = 0;
  surface.vertex_capacity = 10;
  CHECK(enamel_take_surface(session, id, &surface) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("room for 10 vertices"));

  EnamelObstacleDef molar = obstacle("molar", ENAMEL_MESH, 0.0);
  molar.file = ENAMEL_SOURCE_DIR "/data/meshes/molar.ply";
  molar.unit = 1e-3;
  CHECK(enamel_add(session, &molar, &id) == ENAMEL_OK);
  molar.name = "missing";
  molar.file = "no such mesh.ply";
  CHECK(enamel_add(session, &molar, &id) == ENAMEL_FAILED);
  CHECK_THAT(session.message(), ContainsSubstring("no such mesh.ply"));
}

TEST_CASE("a stroke is undone; a cut solid is copied, saved, loaded, compared, and added again", "[c]") {
  const Handle session(drilling());
  const Cube cube;
  EnamelObstacle id{};
  REQUIRE(enamel_add(session, &cube.def, &id) == ENAMEL_OK);
  EnamelObstacleDef whole = cube.def;  // the target: nothing should be cut
  whole.shape = ENAMEL_MESH;
  EnamelVirtualDevice* device = nullptr;
  REQUIRE(enamel_virtual_create(session, &device) == ENAMEL_OK);
  REQUIRE(enamel_spin(session, 1) == ENAMEL_OK);
  REQUIRE(enamel_mark(session, id) == ENAMEL_OK);
  pressFor(session, device, 400);

  EnamelSolid* const cut = cutOf(session, id);
  const EnamelCutComparison found = compared(cut, whole);
  CHECK(found.removed[0] > 1e-10);
  CHECK(found.removed[0] == Approx(snapshotOf(session).removed[0]).epsilon(0.1));  // the sum of many cuts
  CHECK(found.planned[0] == Approx(0.0).margin(1e-15));
  CHECK(found.whole.over_cut[0] == Approx(found.removed[0]).epsilon(1e-6));
  CHECK(found.whole.deepest > 1e-4);
  REQUIRE(found.vertex_count > 0);
  double deepest = 0.0;
  int prepared = 0;
  for (std::size_t i = 0; i < found.vertex_count; ++i) {
    deepest = std::max(deepest, -found.distance[i]);
    prepared += found.prepared[i];
    CHECK(std::abs(found.vertices[3 * i]) < 4.1e-3);
  }
  CHECK(deepest == Approx(found.whole.deepest));
  CHECK(prepared > 0);
  for (std::size_t i = 0; i < 3 * found.triangle_count; ++i)
    CHECK(found.triangles[i] < static_cast<std::int32_t>(found.vertex_count));

  const test::TemporaryFolder folder;
  const std::string file = folder / "cut.solid";
  REQUIRE(enamel_solid_save(cut, file.c_str(), {nullptr, 0}) == ENAMEL_OK);
  EnamelSolid* loaded = nullptr;
  REQUIRE(enamel_solid_load(file.c_str(), &loaded, {nullptr, 0}) == ENAMEL_OK);
  CHECK(compared(loaded, whole).removed[0] == found.removed[0]);
  EnamelObstacleDef again = obstacle("again", ENAMEL_SOLID, 0.0);
  again.solid = loaded;
  CHECK(compared(cut, again).whole.over_cut[0] < 0.01 * found.removed[0]);
  EnamelObstacle other{};
  REQUIRE(enamel_add(session, &again, &other) == ENAMEL_OK);
  enamel_solid_destroy(loaded);  // the session keeps its own
  loaded = cutOf(session, other);
  CHECK(compared(loaded, whole).removed[0] == found.removed[0]);
  enamel_solid_destroy(loaded);
  REQUIRE(enamel_remove(session, other) == ENAMEL_OK);

  REQUIRE(enamel_spin(session, 0) == ENAMEL_OK);
  REQUIRE(enamel_undo(session, id) == ENAMEL_OK);
  REQUIRE(enamel_undo(session, id) == ENAMEL_OK);  // without a stroke
  pressFor(session, device, 1);
  EnamelSolid* const undone = cutOf(session, id);
  CHECK(compared(undone, whole).removed[0] == 0.0);
  enamel_solid_destroy(undone);
  enamel_virtual_destroy(device);

  char text[200];
  EnamelTool named{};
  CHECK(enamel_named_tool("flame-01", &named, {text, sizeof text}) == ENAMEL_FAILED);
  CHECK_THAT(text, ContainsSubstring("\"flame-01\" is not a tool"));
  REQUIRE(enamel_named_tool("flame-012-030", &named, {text, sizeof text}) == ENAMEL_OK);
  CHECK(named.count == 8);
  CHECK(named.head == 6);
  CHECK(named.parts[5].b[2] + named.parts[5].radius == Approx(3e-3));
  CHECK(enamel_solid_load("no such tooth.solid", &loaded, {text, sizeof text}) == ENAMEL_FAILED);
  CHECK_THAT(text, ContainsSubstring("no such tooth.solid"));
  CHECK(loaded == nullptr);
  EnamelCutComparison wrong{};
  CHECK(enamel_solid_compare(cut, &whole, nullptr, &wrong, {text, sizeof text}) == ENAMEL_SIZE);
  wrong.size = sizeof wrong;
  whole.shape = ENAMEL_BOX;
  CHECK(enamel_solid_compare(cut, &whole, nullptr, &wrong, {text, sizeof text}) == ENAMEL_FAILED);
  CHECK_THAT(text, ContainsSubstring("ENAMEL_MESH"));
  enamel_solid_destroy(cut);
  EnamelObstacleDef wall = obstacle("wall", ENAMEL_HALF_SPACE, -0.05);
  REQUIRE(enamel_add(session, &wall, &other) == ENAMEL_OK);
  EnamelSolid* none = nullptr;
  for (const std::int32_t result :
       {enamel_mark(session, other), enamel_undo(session, other), enamel_solid_copy(session, other, &none)}) {
    CHECK(result == ENAMEL_FAILED);
    CHECK_THAT(session.message(), ContainsSubstring("it is not a solid"));
  }
}

TEST_CASE("labels of voxels become a solid", "[c]") {
  constexpr int kSize = 24;
  constexpr double kSpacing = 1e-4, kRadius = 9e-4;
  std::vector<std::uint16_t> voxels;
  for (int i = 0; i < kSize * kSize * kSize; ++i) {
    const Vec3 place(i % kSize, i / kSize % kSize, i / kSize / kSize);
    const double distance = (kSpacing * (place - Vec3::Constant(0.5 * (kSize - 1)))).norm();
    voxels.push_back(distance < 0.5 * kRadius ? 7 : distance < kRadius ? 3 : 0);
  }
  EnamelLabels labels{};
  REQUIRE(enamel_labels_defaults(&labels) == ENAMEL_OK);
  const std::int32_t outer = 3, inner = 7;
  EnamelMaterial rigid{};
  rigid.stiffness = std::numeric_limits<double>::infinity();
  const EnamelLabelLayer layers[] = {{rigid, 3.4e9, &outer, 1}, {rigid, 0.6e9, &inner, 1}};
  for (std::int32_t& count : labels.voxels) count = kSize;
  labels.labels = voxels.data();
  labels.layers = layers;
  labels.layer_count = 2;
  for (double& start : labels.origin) start = -0.5 * (kSize - 1) * kSpacing;
  EnamelSolid* ball = nullptr;
  REQUIRE(enamel_solid_from_labels(&labels, &ball, {nullptr, 0}) == ENAMEL_OK);
  EnamelObstacleDef itself = obstacle("ball", ENAMEL_SOLID, 0.0);
  itself.solid = ball;
  const EnamelCutComparison found = compared(ball, itself);
  CHECK(found.removed[0] + found.removed[1] == 0.0);
  REQUIRE(found.vertex_count > 0);
  for (std::size_t i = 0; i < found.vertex_count; ++i)  // half a voxel
    CHECK(Vec3(Eigen::Map<const Vec3>(found.vertices + 3 * i)).norm() == Approx(kRadius).margin(0.5 * kSpacing));
  enamel_solid_destroy(ball);

  char text[200];
  labels.voxels[2] = 1 << 28;
  CHECK(enamel_solid_from_labels(&labels, &ball, {text, sizeof text}) == ENAMEL_FAILED);
  CHECK_THAT(text, ContainsSubstring("1 to 2^28 voxels"));
  labels.size = 0;
  CHECK(enamel_solid_from_labels(&labels, &ball, {text, sizeof text}) == ENAMEL_SIZE);
  CHECK(ball == nullptr);
}

TEST_CASE("an own mechanism and an own device, in a loop of their own", "[c][threads]") {
  const EnamelMechanism axes = cartesian();
  EnamelSessionDef def = defaults();
  def.mechanism = &axes;
  def.lock_memory = 0;
  const EnamelPose start{{0, 0, 0.5e-3}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  def.start = &start;
  const Handle session(def);
  const EnamelObstacleDef wall = obstacle("wall", ENAMEL_HALF_SPACE, 0.0);
  EnamelObstacle id{};
  REQUIRE(enamel_add(session, &wall, &id) == ENAMEL_OK);
  OwnAxis axis;
  EnamelDevice device{};
  device.size = sizeof device;
  device.user = &axis;
  device.open = openAxis;
  device.close = closeAxis;
  device.measure = measureAxis;
  device.actuate = actuateAxis;
  REQUIRE(enamel_start_device(session, &device) == ENAMEL_OK);
  CHECK(enamel_start_device(session, &device) == ENAMEL_FAILED);
  std::int32_t running = 0;
  REQUIRE(enamel_is_running(session, &running) == ENAMEL_OK);
  CHECK(running == 1);
  EnamelSnapshot now = snapshotOf(session);
  for (int i = 0; i < 20000 && now.tick < 500; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    now = snapshotOf(session);
  }
  CHECK(now.joints == 3);
  CHECK(now.contact_count == 1);
  CHECK(std::abs(now.position[2]) < 50e-6);
  axis.refuses = true;
  REQUIRE(test::eventually([&] { return snapshotOf(session).unsent > 3; }));
  CHECK(snapshotOf(session).since_tick > 0.0);
  REQUIRE(enamel_stop(session) == ENAMEL_OK);
  CHECK(snapshotOf(session).since_tick == 0.0);
  CHECK_FALSE(axis.isOpen);
  EnamelEvent event{};
  event.size = sizeof event;
  REQUIRE(enamel_next_event(session, &event) == ENAMEL_OK);
  CHECK(event.kind == ENAMEL_CONTACT_BEGIN);
  CHECK(event.obstacle.slot == id.slot);
  CHECK(event.obstacle.generation == id.generation);
  CHECK(std::string(enamel_event_text(event.kind)) == "contact begins");

  EnamelMechanism bad = cartesian();
  bad.encoder_step[1] = 0.0;
  def.mechanism = &bad;
  char text[200] = "";
  EnamelSession* none = nullptr;
  CHECK(enamel_session_create(&def, &none, {text, sizeof text}) == ENAMEL_FAILED);
  CHECK_THAT(text, ContainsSubstring("joint 1 has an encoder step of 0"));

  bad = cartesian();
  bad.reach = [](void* user, const EnamelPose* pose, const double* twist, EnamelKinematics* state) {
    reachOf(user, pose, twist, state);
    for (int i = 0; i < 3; ++i) state->jacobian[i][i] = 0.0;
    return std::int32_t{ENAMEL_OK};
  };
  CHECK(enamel_session_create(&def, &none, {text, sizeof text}) == ENAMEL_FAILED);
  CHECK_THAT(text, ContainsSubstring("device \"my axes\": reach() at the start pose: the Jacobian is zero"));
  bad.reach = [](void* user, const EnamelPose* pose, const double* twist, EnamelKinematics* state) {
    reachOf(user, pose, twist, state);
    state->gravity[1] = std::nan("");
    return std::int32_t{ENAMEL_OK};
  };
  CHECK(enamel_session_create(&def, &none, {text, sizeof text}) == ENAMEL_FAILED);
  CHECK_THAT(text, ContainsSubstring("reach() of the home pose gives a number that is not finite"));
  bad.reach = reachOf;
  bad.track = [](void* user, const double* q, const double* rates, EnamelKinematics* state) {
    trackOf(user, q, rates, state);
    state->jacobian[0][0] = std::nan("");
    return std::int32_t{ENAMEL_OK};
  };
  CHECK(enamel_session_create(&def, &none, {text, sizeof text}) == ENAMEL_FAILED);
  CHECK_THAT(text, ContainsSubstring("track() at the start pose: the status is \"not finite\", must be ok; a number"));
}

TEST_CASE("before_tick moves, activates and adds effects; a virtual device runs in real time", "[c][threads]") {
  struct Host {
    EnamelObstacle wall{};
    std::atomic<int> calls{0}, failures{0};
  } host;
  EnamelSessionDef def = defaults();
  def.lock_memory = 0;
  def.user = &host;
  def.before_tick = [](void* user, EnamelTickAccess* access) {
    auto& self = *static_cast<Host*>(user);
    EnamelMeasurement measurement{};
    measurement.size = sizeof measurement;
    EnamelPose pose{{0, 0, -1e-3}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    const double wrench[6] = {0, 0, 0, 0, 0, 0};
    if (enamel_tick_measurement(access, &measurement) != ENAMEL_OK || measurement.size != sizeof measurement ||
        enamel_tick_move(access, self.wall, &pose, nullptr) != ENAMEL_OK ||
        enamel_tick_activate(access, self.wall, 1) != ENAMEL_OK || enamel_tick_spin(access, 0) != ENAMEL_OK ||
        enamel_tick_effect(access, wrench) != ENAMEL_OK)
      ++self.failures;
    ++self.calls;
  };
  const Handle session(def);
  EnamelObstacleDef wall = obstacle("wall", ENAMEL_HALF_SPACE, 0.0);
  wall.active = 0;
  REQUIRE(enamel_add(session, &wall, &host.wall) == ENAMEL_OK);
  REQUIRE(enamel_start_virtual(session, nullptr, nullptr) == ENAMEL_OK);
  EnamelSnapshot now = snapshotOf(session);
  for (int i = 0; i < 20000 && now.contact_count == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    now = snapshotOf(session);
  }
  REQUIRE(enamel_stop(session) == ENAMEL_OK);
  CHECK(now.contact_count == 1);
  CHECK(host.calls > 0);
  CHECK(host.failures == 0);
}

TEST_CASE("a URL in the definition is the device of enamel_start", "[c]") {
  EnamelSessionDef def = defaults();
  def.device = "virtual:" ENAMEL_SOURCE_DIR "/data/devices/cartesian-3.toml";
  const Handle session(def);
  REQUIRE(enamel_start(session) == ENAMEL_OK);
  CHECK(enamel_start(session) == ENAMEL_FAILED);
  EnamelSnapshot now = snapshotOf(session);
  for (int i = 0; i < 20000 && now.tick < 10; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    now = snapshotOf(session);
  }
  CHECK(now.tick >= 10);
  CHECK(now.joints == 3);
  REQUIRE(enamel_stop(session) == ENAMEL_OK);

  const Handle own(defaults());
  CHECK(enamel_start(own) == ENAMEL_FAILED);
  std::array<char, 256> text{};
  CHECK(enamel_message(own, {text.data(), text.size()}) == ENAMEL_OK);
  CHECK_THAT(text.data(), test::ContainsSubstring("needs a URL"));
  def.device = "mouse://0";
  EnamelSession* none = nullptr;
  CHECK(enamel_session_create(&def, &none, {text.data(), text.size()}) == ENAMEL_FAILED);
  CHECK_THAT(text.data(), test::ContainsSubstring("device URL \"mouse://0\""));
}

TEST_CASE("frames of Unity: z is mirrored, and rotations keep their effect", "[c]") {
  test::Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Mat3 rotation = random.rotation(3.0);
    const Vec3 point = random.vector(1.0);
    double quaternion[4], back[9], vector[3] = {point.x(), point.y(), point.z()};
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = rotation;
    enamel_rotation_to_unity(rows.data(), quaternion);
    enamel_rotation_from_unity(quaternion, back);
    CHECK((Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(back) - rows).norm() < 1e-14);
    // Unity's rotation of a mirrored point is the mirrored rotation of the point.
    enamel_vector_to_unity(vector);
    const Eigen::Quaterniond q(quaternion[3], quaternion[0], quaternion[1], quaternion[2]);
    Vec3 turned = q * Vec3(vector[0], vector[1], vector[2]);
    enamel_vector_from_unity(turned.data());
    CHECK((turned - rotation * point).norm() < 1e-14);
    // A moment is a product of two vectors, whose sign changes with the handedness.
    const Vec3 force = random.vector(1.0);
    CHECK((mirrorUnityTurn(mirrorUnity(point).cross(mirrorUnity(force))) - point.cross(force)).norm() < 1e-14);
  }
}

}  // namespace enamel::test_c_interface
