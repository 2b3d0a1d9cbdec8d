// Mistakes in calls of the library: they are refused with a reason, and no invalid memory is read or written. Also run
// with the address sanitizer (preset asan).
#include <fcntl.h>
#include <sys/stat.h>
#include <time.h>

#include <algorithm>
#include <filesystem>

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/collision/tool_sweep.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/plugin/author.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/render/tick.hpp"
#include "enamel/runtime/periodic_thread.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/meshes.hpp"

namespace enamel::test_slips {

using test::ContainsSubstring;

namespace {

const double kNan = std::nan(""), kInfinity = HUGE_VAL;

double secondsOf(clockid_t clock, const std::function<void()>& work) {
  const auto now = [clock] {
    timespec t;
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  };
  const double begin = now();
  work();
  return now() - begin;
}

Tool toolOf(const ToolPart& part) {
  Tool tool;
  tool.parts[0] = part;
  return tool;
}

std::string repeat(const std::string& text, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += text;
  return all;
}

}  // namespace

TEST_CASE("a tool that is none touches nothing, and says so", "[slips]") {
  Scene scene = flatWall();
  scene.add({"ball", std::make_shared<const MeshModel>(test::ball(3)), {}, Vec6::Zero(), {}, 0.0});
  const Pose inside{{0.0, 0.0, -0.01}, Mat3::Identity()};
  std::vector<std::pair<Tool, Status>> tools;
  for (const int count : {-1, 9, 1 << 30, -(1 << 30)}) {
    tools.emplace_back(Tool{}, Status::outOfRange);
    tools.back().first.count = count;
  }
  for (const double radius : {kNan, kInfinity, -kInfinity})
    tools.emplace_back(toolOf({Vec3::Zero(), Vec3::Zero(), radius}), Status::notFinite);
  for (const double radius : {-1e-9, -0.01, 5.0, 1e308})
    tools.emplace_back(toolOf({Vec3::Zero(), Vec3::Zero(), radius}), Status::outOfRange);
  tools.emplace_back(toolOf({{0.0, kNan, 0.0}, Vec3::Zero(), 0.01}), Status::notFinite);
  tools.emplace_back(toolOf({Vec3::Zero(), {kInfinity, 0.0, 0.0}, 0.01}), Status::notFinite);
  tools.emplace_back(toolOf({Vec3::Zero(), {0.0, 0.0, 22.0}, 0.0}), Status::outOfRange);  // in millimetres by mistake
  tools.emplace_back(toolOf({{-1e308, 0.0, 0.0}, Vec3::Zero(), 0.0}), Status::outOfRange);
  for (const auto& [tool, status] : tools) {
    INFO(tool.count << ", radius " << tool.parts[0].radius);
    CHECK(checkTool(tool) == status);
    CHECK_THROWS_WITH(makeToolCache(scene, tool), ContainsSubstring("0 to 8 parts") && ContainsSubstring("0 to 1 m"));
    CHECK_THROWS_AS(makeToolTrack(scene, tool), Error);
    ContactSnapshot contacts;
    contacts.count = 3;
    CHECK(findContacts(scene, tool, inside, 1.0, nullptr, contacts) == status);
    CHECK(contacts.count == 0);
    ToolTrack track = makeToolTrack(scene, Tool{});
    CHECK(followContacts(scene, tool, inside, 1.0, track, contacts) == status);
    CHECK(contacts.count == 0);
    CHECK(nearestContact(scene, tool, inside, nullptr).gap == kNoLimit);
    CHECK(sweepTool(scene, tool, Pose{}, inside, nullptr).status == status);
  }
  Tool none;
  none.count = 0;  // a tool without parts touches nothing
  ContactSnapshot contacts;
  CHECK(findContacts(scene, none, inside, 1.0, nullptr, contacts) == Status::ok);
  CHECK(contacts.count == 0);
}

TEST_CASE("the largest tool has a bounded tick", "[slips]") {
  Scene scene;
  TriangleMesh mesh = test::ball(6, 0.05);
  for (Vec3& v : mesh.vertices) v *= 0.5;
  scene.add({"ball", std::make_shared<const MeshModel>(mesh), {}, Vec6::Zero(), {}, 0.0});
  // Compared with a ball of 1 mm at the same poses, in processor time, with the best of five for each tick.
  const auto timesOf = [&](const Tool& tool) {
    std::vector<double> times(100, HUGE_VAL);
    for (int round = 0; round < 5; ++round) {
      ToolTrack track = makeToolTrack(scene, tool);
      ContactSnapshot contacts;
      for (std::size_t i = 0; i < times.size(); ++i) {
        const Pose pose{{0.0, 0.0, 0.6 - 0.002 * static_cast<double>(i)}, Mat3::Identity()};
        const double time = secondsOf(CLOCK_THREAD_CPUTIME_ID, [&] {
          CHECK(followContacts(scene, tool, pose, 1e-3, track, contacts) == Status::ok);
        });
        times[i] = std::min(times[i], time);
      }
    }
    std::sort(times.begin(), times.end());
    return times;
  };
  const double small = timesOf(toolOf({Vec3::Zero(), Vec3::Zero(), 1e-3}))[50];
  const double large = timesOf(toolOf({{-kLargestTool, 0.0, 0.0}, {kLargestTool, 0.0, 0.0}, 0.01})).back();
  INFO("its longest tick takes " << large << " s, a usual one of the ball " << small << " s");
  CHECK(large < 300.0 * small);  // the ratio is about 20
}

TEST_CASE("an obstacle goes only where an obstacle can be", "[slips]") {
  Scene scene = flatWall();
  const Pose before = scene.obstacles()[0].pose;
  Pose bad;
  CHECK(scene.move(-1, Pose{}, Vec6::Zero()) == Status::outOfRange);
  CHECK(scene.move(1, Pose{}, Vec6::Zero()) == Status::outOfRange);
  CHECK(scene.move(1 << 30, Pose{}, Vec6::Zero()) == Status::outOfRange);
  bad.position.x() = kNan;
  CHECK(scene.move(0, bad, Vec6::Zero()) == Status::notFinite);
  CHECK(scene.move(0, Pose{}, Vec6::Constant(kInfinity)) == Status::notFinite);
  for (const Mat3& matrix : {Mat3(Mat3::Zero()), Mat3(-Mat3::Identity()), Mat3(1.001 * Mat3::Identity())}) {
    CHECK_FALSE(isRotation(matrix));
    CHECK(scene.move(0, Pose{Vec3::Zero(), matrix}, Vec6::Zero()) == Status::outOfRange);
  }
  CHECK_FALSE(isRotation(Mat3::Constant(kNan)));
  CHECK(scene.obstacles()[0].pose.position == before.position);
  CHECK(scene.obstacles()[0].pose.rotation == before.rotation);
  CHECK(scene.move(0, Pose{}, Vec6::Unit(2)) == Status::ok);
  CHECK(scene.obstacles()[0].twist == Vec6::Unit(2));
}

TEST_CASE("a renderer without activate() has no state, and none after one that failed", "[slips]") {
  const auto device = makeMechanism(loadDevice(test::deviceFile("tau-nominal.toml")));
  PositionControlRenderer renderer(positionControlFor(*device, 1e-3, 0, 0));
  std::vector<unsigned char> state(1 << 16, 0x5a);
  const auto before = state;
  const auto hasNone = [&] {
    CHECK(renderer.stateSize() == 0);
    renderer.saveState(state.data());
    CHECK(state == before);
    renderer.loadState(state.data());
    renderer.reset();
    TickOutput output;
    TickFrame input;
    CHECK(renderer.step(input, output) == Status::inactive);
  };
  hasNone();
  renderer.activate(1e-3);
  CHECK(renderer.stateSize() > 0);
  CHECK_THROWS_WITH(renderer.activate(2e-3), ContainsSubstring("is for ticks of 0.001 s, the period here is 0.002 s"));
  hasNone();
  renderer.activate(1e-3);
  renderer.deactivate();
  CHECK(renderer.stateSize() > 0);
  for (const double period : {0.0, -1e-3, 1e-300, 1e-6, 0.2, 1e308, kNan, kInfinity})
    CHECK_THROWS_WITH(renderer.activate(period), ContainsSubstring("must be in 1e-05 to 0.1 s"));
  hasNone();

  // An invalid start pose is replaced by home.
  renderer.activate(1e-3);
  const Scene scene = flatWall();
  for (const Mat3& matrix : {Mat3(Mat3::Zero()), Mat3(-Mat3::Identity()), Mat3(Mat3::Constant(kNan))}) {
    HapticTick tick(*device, scene, Tool{}, renderer, 1e-3, Pose{{0.01, 0.0, 0.0}, matrix});
    CHECK(tick.frame().kinematics.q == device->home().q);
  }
  CHECK_THROWS_AS(HapticTick(*device, scene, toolOf({Vec3::Zero(), Vec3::Zero(), -1.0}), renderer, 1e-3), Error);
}

TEST_CASE("plugin parameters that are not there", "[slips]") {
  const EnamelParameter known[] = {{"stiffness", "1000", "N/m"}};
  const EnamelDescription description{"wall", "1", "a wall", known, 1};
  const auto refuse = [&](const EnamelParameter* parameters, std::size_t count, const std::string& reason) {
    const EnamelConfiguration given{nullptr, nullptr, nullptr, nullptr, parameters, count};
    CHECK_THROWS_WITH(PluginConfiguration(description, given), ContainsSubstring(reason));
  };
  const EnamelParameter noKey[] = {{nullptr, "1", nullptr}}, noValue[] = {{"stiffness", nullptr, nullptr}};
  refuse(nullptr, 1, "is NULL, must have 1 entries");
  refuse(nullptr, static_cast<std::size_t>(-1), "is NULL, must have");
  refuse(noKey, 1, "number 0: has no key or no value");
  refuse(noValue, 1, "number 0: has no key or no value");
  for (const char* value : {"nan", "inf", "-inf", "1e999", "12x", " "}) {
    const EnamelParameter one[] = {{"stiffness", value, nullptr}};
    const EnamelConfiguration given{nullptr, nullptr, nullptr, nullptr, one, 1};
    CHECK_THROWS_AS(PluginConfiguration(description, given).number("stiffness", -kInfinity, kInfinity, "N/m"), Error);
  }
}

TEST_CASE("a thread of a long period ends soon", "[slips]") {
  CHECK(secondsOf(CLOCK_MONOTONIC, [] { PeriodicThread thread(10.0, [] {}); }) < 10.0);  // it takes 50 ms
}

TEST_CASE("messages are one line that a terminal can show", "[slips]") {
  CHECK(printable("plain \xc3\xa9") == "plain \xc3\xa9");
  CHECK(printable(std::string("a\x1b[2J\r\x07\x7f\0b", 10)) == "a\\x1b[2J\\x0d\\x07\\x7f\\x00b");
  CHECK(printable("a\nb\tc") == "a b c");
  CHECK(printable("\xc2\x9b") == "\xc2\\x9b");
  const std::string cut = printable("file: " + std::string(5000000, 'x') + " must be a number");
  CHECK(cut.size() < 2100);
  CHECK_THAT(cut,
             ContainsSubstring("file: xxx") && ContainsSubstring(" ... ") && ContainsSubstring("must be a number"));
  CHECK_THAT(Error("\x1b[31m").what(), ContainsSubstring("\\x1b[31m"));
  CHECK_THAT(ConfigurationError("f\n\x1b", 1, "k", "p").what(), ContainsSubstring("f \\x1b:1: k: p"));
}

TEST_CASE("files that are none are not waited for", "[slips]") {
  const test::TemporaryFolder folder;
  REQUIRE(mkfifo((folder / "pipe.toml").c_str(), 0600) == 0);
  std::filesystem::create_symlink("/dev/zero", folder / "zero.ply");
  test::writeFile(folder / "long.toml", std::string(100, 'x'));
  CHECK_THROWS_WITH(readFile(folder / "pipe.toml"),
                    ContainsSubstring("pipe.toml: is a pipe or a device, must be a regular file"));
  CHECK_THROWS_WITH(readFile("/dev/zero"), ContainsSubstring("is a pipe or a device, must be a regular file"));
  CHECK_THROWS_WITH(readFile("/proc/self/status"), ContainsSubstring("changed its size while it was read"));
  CHECK_THROWS_WITH(readFile(folder / ""), ContainsSubstring("is a folder"));
  CHECK_THROWS_WITH(readFile(""), ContainsSubstring("No such file"));
  CHECK_THROWS_WITH(readFile(folder / "none"), ContainsSubstring("cannot open the file: No such file"));
  CHECK_THROWS_WITH(readFile(folder / "long.toml", 99), ContainsSubstring("is 100 bytes, at most 99 are read"));
  CHECK(readFile(folder / "long.toml", 100).size() == 100);
  CHECK_THROWS_WITH(loadDevice(folder / "pipe.toml"),
                    ContainsSubstring("is a pipe or a device, must be a regular file"));
  CHECK_THROWS_WITH(loadScene(folder / "pipe.toml"),
                    ContainsSubstring("is a pipe or a device, must be a regular file"));
  CHECK_THROWS_WITH(loadMesh(folder / "zero.ply"), ContainsSubstring("is a pipe or a device, must be a regular file"));
}

TEST_CASE("a file is written whole or not at all", "[slips]") {
  const test::TemporaryFolder folder;
  const std::string path = folder / "out.json";
  const auto files = [&] { return std::distance(std::filesystem::directory_iterator(folder / ""), {}); };
  writeFile(path, "old");
  {
    FileWriter file(path);
    file.write("half of the ne");
  }
  CHECK(test::readFile(path) == "old");
  CHECK(files() == 1);
  std::filesystem::create_symlink("out.json", folder / "link");
  std::filesystem::permissions(path, std::filesystem::perms(0640));
  writeFile(folder / "link", std::string("new\0", 4));
  CHECK(test::readFile(path) == std::string("new\0", 4));
  CHECK(std::filesystem::is_symlink(folder / "link"));
  CHECK(std::filesystem::status(path).permissions() == std::filesystem::perms(0640));
  CHECK(files() == 2);
  // Links to a file that does not exist yet, and links that lead nowhere.
  std::filesystem::create_symlink("middle", folder / "first");
  std::filesystem::create_symlink("later.json", folder / "middle");
  writeFile(folder / "first", "later");
  CHECK(test::readFile(folder / "later.json") == "later");
  CHECK(std::filesystem::is_symlink(folder / "first"));
  CHECK(std::filesystem::is_symlink(folder / "middle"));
  std::filesystem::create_symlink("b", folder / "a");
  std::filesystem::create_symlink("a", folder / "b");
  CHECK_THROWS_WITH(writeFile(folder / "a", "ring"), ContainsSubstring("/a: cannot write the file: Too many levels"));
  CHECK(std::filesystem::is_symlink(folder / "a"));
  CHECK_THROWS_WITH(writeFile("/dev/full", "x"), ContainsSubstring("/dev/full: cannot write the file: No space left"));
  CHECK_THROWS_WITH(writeFile(folder / "", "x"), ContainsSubstring("Is a directory"));
  CHECK_THROWS_WITH(writeFile(folder / "no/such/file", "x"), ContainsSubstring("No such file or directory"));
}

TEST_CASE("configurations that are too deep or too long", "[slips]") {
  const auto refuse = [](const std::string& text, const std::string& reason) {
    CHECK_THROWS_WITH(parseDevice(text, "d.toml"), ContainsSubstring("d.toml") && ContainsSubstring(reason));
    CHECK_THROWS_AS(parseScene(text, "d.toml"), ConfigurationError);
  };
  const std::string dots = "a" + repeat(".a", 40), quoted = "\"a\"" + repeat(" . 'a.b'", 40);
  refuse("\n" + dots + " = 1\n", "d.toml:2: has a dotted key with more parts than 32");
  refuse(quoted + " = 1\n", "dotted key");
  refuse("[" + dots + "]\n", "dotted key");
  refuse("[[" + dots + "]]\n", "dotted key");
  refuse("x = {" + dots + " = 1}\n", "dotted key");
  refuse("x = {y = 1, " + dots + " = 1}\n", "dotted key");
  refuse("\"\"\"\n\"\"\" = 1\n" + dots + " = 1\n", "dotted key");
  refuse("# '''\n" + dots + " = 1\n", "dotted key");
  refuse("a = \"\\\"\"\n" + dots + " = 1\n", "dotted key");
  refuse("x = " + repeat("[", 40) + repeat("]", 40) + "\n", "nested deeper than 32");
  refuse("x = " + repeat("{x = ", 40) + "1" + repeat("}", 40) + "\n", "nested deeper than 32");
  refuse(std::string(300000, '#'), "is 300000 bytes, at most 262144 are read");
  refuse("name = \"a\\u001b[2J\"\n", "must be one line");
  refuse("name = \"" + std::string(3000, 'x') + "\"\n", "of at most 2000 bytes");
  for (const char* text : {"[,a]\n", "[[,a]]\n", "a = [\xe2\x80\xa8-1]\n"}) refuse(text, "not valid TOML");
  for (const char* text : {"\xcd\x9f = 1\n", "a = 1\xc3\xa9\n", "a = [\xcd\x9f]\n", "a = 0'\xcd\x9f\n",
                           "a = \"\"\"\\\xc5\x9e\"\"\"\n", "a = \"\"\"\\\n  \xc5\x9e\"\"\"\n]\n"})
    refuse(text, "not valid TOML");
  // Dots in numbers, texts and remarks do not nest keys.
  CHECK_NOTHROW(checkNesting("a = [" + repeat("0.1, ", 100) + "]\nb = \"" + dots + "\"\n# " + dots + "\n", ""));
  CHECK_NOTHROW(checkNesting("c = '''\n" + dots + "\n'''\nd.e = 1\n", ""));
  CHECK_THROWS_WITH(checkNesting(repeat("[", 200000), "j.json"), ContainsSubstring("j.json:1: has brackets"));
  CHECK_NOTHROW(checkNesting(repeat("[", 32) + "\"" + repeat("[", 99) + "\"" + repeat("]", 32), ""));
}

TEST_CASE("a plugin file that ends before its head says", "[slips]") {
  const test::TemporaryFolder folder;
  const auto refuse = [&](const std::string& bytes, const std::string& reason) {
    test::writeFile(folder / "cut.so", bytes);
    CHECK_THROWS_WITH(PluginLibrary::load(folder / "cut.so"),
                      ContainsSubstring("cut.so: ") && ContainsSubstring(reason));
  };
  std::string library(4096, 0);
  REQUIRE(std::ifstream("/proc/self/exe", std::ios::binary).read(library.data(), 4096));
  library[16] = 3;  // ET_DYN, whatever type the test program has
  refuse("", "is not a shared library (its ELF header is missing)");
  refuse(library.substr(0, 20), "is not a shared library (its ELF header is missing)");
  refuse(library.substr(0, 64), "is truncated: it has 64 bytes, its header declares more");
  refuse(library.substr(0, 200), "is truncated");
  refuse(library, "is truncated: it has 4096 bytes");
  std::string far = library;
  far.replace(32, 8, 8, '\xff');  // e_phoff
  refuse(far, "is truncated");
  std::string narrow = library;
  narrow[4] = 1;  // 32 bits
  refuse(narrow, "is not a shared library");
  REQUIRE(mkfifo((folder / "pipe.so").c_str(), 0600) == 0);
  CHECK_THROWS_WITH(PluginLibrary::load(folder / "pipe.so"), ContainsSubstring("no such file"));
}

}  // namespace enamel::test_slips
