// `enamel device` as a user runs it, the example of a vendor's SDK, and the driver of lib/docs/device.md.
#include <arpa/inet.h>
#include <sys/socket.h>

#include <algorithm>
#include <fstream>

#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/process.hpp"

namespace enamel::test_device_command {

using test::ContainsSubstring;
using test::run;

namespace {

// Return the number after a word in the output.
long numberAfter(const std::string& text, const std::string& word) {
  const std::size_t at = text.find(word);
  return at == std::string::npos ? -1 : std::atol(text.c_str() + at + word.size());
}

// Return the output of a client of a served device that has accepted enough measurements. One second is enough, except
// on a loaded machine, where the server may not be ready yet.
std::string connectTo(const std::string& url, long measurements) {
  std::string output;
  int seconds = 1;
  const bool connected = test::eventually([&] {
    output = run("device --connect '" + url + "' --renderer impedance --duration " + std::to_string(seconds)).output;
    const long accepted = numberAfter(output, "accepted ");
    if (accepted >= 0) seconds = std::min(4 * seconds, 64);
    return accepted > measurements;
  });
  INFO(output);
  CHECK(connected);
  return output;
}

// Return a port that was free just now.
std::string freePort() {
  const int s = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  REQUIRE((bind(s, any, length) == 0 && getsockname(s, any, &length) == 0));
  close(s);
  return std::to_string(ntohs(address.sin_port));
}

const std::string kStylus = test::deviceFile("cartesian-3.toml");

}  // namespace

TEST_CASE("a device is served and felt from another process", "[device_command]") {
  const test::TemporaryFolder folder;
  const std::string log = folder / "log", key = folder / "key";
  test::writeFile(key, "00112233445566778899aabbccddeeff\n");
  test::Process server("exec '" ENAMEL_TOOL "' device --serve virtual: --port 0 --key '" + key + "' > '" + log +
                       "' 2>&1");
  REQUIRE(test::eventually([&] { return numberAfter(test::readFile(log), " at 127.0.0.1:") > 0; }));
  const std::string port = std::to_string(numberAfter(test::readFile(log), " at 127.0.0.1:"));
  const std::string output = connectTo("udp://127.0.0.1:" + port + "?key=" + key, 300);
  server.signal(SIGTERM);
  CHECK(server.wait() == 0);
  INFO(output << "\n" << test::readFile(log));
  CHECK(numberAfter(output, "accepted ") > 300);
  CHECK_THAT(output, ContainsSubstring("wake-up error") && ContainsSubstring("age of the command") &&
                         ContainsSubstring("reason of the guard"));
  CHECK_THAT(output, !ContainsSubstring("checksum") && !ContainsSubstring("wrong key"));
  CHECK(numberAfter(test::readFile(log), "accepted ") > 300);
  CHECK_THAT(test::readFile(log), ContainsSubstring("with a key") && ContainsSubstring("measurement to command"));
}

TEST_CASE("slips in a command line of device are told", "[device_command]") {
  const auto refuses = [](const std::string& options, const std::string& message) {
    const auto result = run("device " + options);
    INFO(options);
    CHECK(result.status != 0);
    CHECK_THAT(result.output, ContainsSubstring(message));
  };
  refuses("", "give one of --serve URL, --connect URL and --first-touch URL");
  refuses("--serve virtual: --connect udp://localhost", "give one of --serve URL, --connect URL and --first-touch URL");
  refuses("--serve virtual: --bind 0.0.0.0 --duration 0.1",
          "0.0.0.0 can be reached from other machines: give a key, or use 127.0.0.1");
  refuses("--serve virtual: --key /nowhere", "/nowhere");
  refuses("--connect localhost",
          "device URL \"localhost\": it must begin with a scheme in small letters and ':'; possible are virtual:FILE");
  const test::TemporaryFolder folder;
  const std::string record = folder / "a.rec", url = "udp://127.0.0.1:" + freePort() + "?device=" + kStylus;
  refuses("--connect '" + url + "' --renderer impedance --record '" + record + "'",
          '"' + url + "\": no measurement within 1 s");
  CHECK_FALSE(std::filesystem::exists(record));
  refuses("--connect udp://localhost --port 1", "--port");
  refuses("--serve virtual: --duration 0.1 --scene /nowhere", "--scene");
  refuses("--serve virtual: --rate 100", "--rate");
  refuses("--connect virtual: --renderer nothing", "nothing");
  const std::string learnt = folder / "learnt.toml";
  refuses("--connect virtual: --renderer impedance --duration 0.1 --learnt '" + learnt + "'",
          "--learnt: nothing is learnt");
  CHECK_FALSE(std::filesystem::exists(learnt));
}

TEST_CASE("a virtual device runs in one process, and the forms of URLs are listed", "[device_command]") {
  const test::TemporaryFolder folder;
  const std::string record = folder / "a.rec", learnt = folder / "learnt.toml";
  test::CommandResult result;
  for (const char* seconds : {"1", "4", "16"}) {  // on a busy machine ticks are late
    result = run("device --connect 'virtual:" + kStylus + "' --overwrite --record '" + record + "' --learnt '" +
                 learnt + "' --duration " + seconds);
    if (result.status == 0) break;
  }
  INFO(result.output);
  CHECK((result.status == 0 || result.output.find("stopped by the guard: ") != std::string::npos));
  CHECK(numberAfter(result.output, "ticks in contact ") > 0);
  CHECK(numberAfter(result.output, record + ", ") > 0);
  CHECK_THAT(test::readFile(learnt), ContainsSubstring("masses: ") && ContainsSubstring("name = "));
  std::ifstream isolated("/sys/devices/system/cpu/isolated"), kernel("/sys/kernel/realtime");
  std::string cores, realtime;
  std::getline(isolated, cores);
  std::getline(kernel, realtime);
  const auto says = [&](const char* setting) { return result.output.find(setting) != std::string::npos; };
  CHECK(says("a core without other work") == cores.empty());
  CHECK(says("bounded waits in the kernel") == (realtime != "1"));
  CHECK_THAT(run("devices").output, ContainsSubstring("virtual:FILE") && ContainsSubstring("udp://HOST:PORT"));
}

TEST_CASE("a bur cuts on a virtual device", "[device_command]") {
  const test::TemporaryFolder folder;
  const std::string scene = folder / "cube.toml";
  test::writeFile(folder / "cube.off",
                  "OFF 8 12 0\n-9 -9 -9\n9 -9 -9\n9 9 -9\n-9 9 -9\n-9 -9 0\n9 -9 0\n9 9 0\n-9 9 0\n3 0 2 1\n3 0 3 2\n"
                  "3 4 5 6\n3 4 6 7\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n");
  const std::string cube =
      "name = \"cube\"\nstart = [0, 0, 0.0015]\n[[tool]]\nfrom = [0, 0, 0.001]\nradius = 0.001\n[[obstacle]]\n"
      "name = \"cube\"\nshape = \"solid\"\nfile = \"cube.off\"\nunit = \"mm\"\ncell = 0.0004\n[[obstacle.layer]]\n"
      "name = \"dentine\"\nhardness = 6e8\n";
  test::writeFile(scene, cube);
  const std::string command = "device --connect virtual: --scene '" + scene + "' --spin --duration ";
  CHECK_THAT(run(command + "1").output, ContainsSubstring("cube.toml: --spin needs a table [bur]"));
  test::writeFile(scene, cube + "[bur]\npart = 0\nwear = 5.0\nturns = 2000.0\n");
  std::string output;
  for (const char* seconds : {"1", "4", "16"}) {  // on a busy machine ticks are late
    output = run(command + seconds).output;
    if (numberAfter(output, "removed ") > 0) break;
  }
  INFO(output);
  CHECK(numberAfter(output, "removed ") > 0);
}

TEST_CASE("a first trial writes its report, and stops at a surprise or at the person's word", "[device_command]") {
  const test::TemporaryFolder folder;
  const std::string touch =
      "'" ENAMEL_TOOL "' device --first-touch 'virtual:" + kStylus + "' --output '" + (folder / "out") + "'";
  // The simulated hand does not do as it is told.
  const auto surprised = test::runCommand("yes '' | " + touch);
  INFO(surprised.output);
  CHECK(surprised.status != 0);
  CHECK_THAT(surprised.output, ContainsSubstring("stopped at the first surprise: "));
  CHECK_THAT(test::readFile(folder / "out/report.txt"),
             ContainsSubstring("Cartesian, 3 axes at virtual:") && ContainsSubstring("SURPRISE: "));
  CHECK_THAT(test::runCommand(touch + " < /dev/null").output, ContainsSubstring("--overwrite"));
  const auto ended = test::runCommand("echo no | " + touch + " --overwrite");
  CHECK(ended.status != 0);
  CHECK_THAT(ended.output, ContainsSubstring("ended by the person before: Lay the handle down") &&
                               ContainsSubstring("the trial is not complete"));
}

TEST_CASE("the example of a vendor's SDK feels a table", "[device_command]") {
  // On a busy machine ticks are late. Then the guard reduces the force and reports it.
  test::CommandResult result;
  const auto late = [&result] { return result.output.find("a tick came late") != std::string::npos; };
  for (const char* seconds : {"1", "4", "16"}) {
    result = test::runCommand("'" ENAMEL_VENDOR_SDK "' '" + kStylus + "' " + seconds);
    if (result.status == 0) break;
  }
  INFO(result.output);
  if (result.status != 0 && late()) WARN("this machine is too busy for a loop at 1 kHz");
  CHECK((result.status == 0 || late()));
  CHECK(numberAfter(result.output, "largest force on a line: ") >= 0);
  CHECK(test::runCommand("'" ENAMEL_VENDOR_SDK "' /nowhere.toml").status == 1);
}

TEST_CASE("the driver in Python of the page is a device", "[device_command]") {
  if (test::runCommand("python3 -c 'import zlib'").status != 0) {
    WARN("python3 is not installed");
    return;
  }
  const std::string page = test::readFile(ENAMEL_SOURCE_DIR "/lib/docs/device.md");
  const std::size_t begin = page.find("```python\n"), end = page.find("```", begin + 10);
  REQUIRE(end != std::string::npos);
  const test::TemporaryFolder folder;
  const std::string script = folder / "driver.py", log = folder / "log";
  test::writeFile(script, page.substr(begin + 10, end - begin - 10));
  const std::string port = freePort();
  const test::Process driver("exec python3 '" + script + "' " + port + " > '" + log + "' 2>&1");
  const std::string output = connectTo("udp://127.0.0.1:" + port + "?device=" + kStylus, 200);
  INFO(output << "\n" << test::readFile(log));
  CHECK(numberAfter(output, "accepted ") > 200);
  CHECK_THAT(output, !ContainsSubstring("checksum") && !ContainsSubstring("another"));
  CHECK(test::readFile(log).empty());
}

}  // namespace enamel::test_device_command
