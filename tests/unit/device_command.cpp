// `enamel device` as a user runs it, the example of a vendor's SDK, and the driver of lib/docs/device.md.
#include <sstream>

#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"

namespace enamel::test_device_command {

using test::ContainsSubstring;
using test::run;

namespace {

// The number behind a word of what was printed.
long numberAfter(const std::string& text, const std::string& word) {
  const std::size_t at = text.find(word);
  return at == std::string::npos ? -1 : std::atol(text.c_str() + at + word.size());
}

// What connecting to a server prints; the server writes into `log` and is ended then.
std::string connectTo(const std::string& server, const std::string& log, const std::string& options) {
  return test::runCommand("{ " + server + " >'" + log + "' 2>&1 & sleep 0.3; '" ENAMEL_TOOL "' device " + options +
                          "; kill $!; wait; }")
      .output;
}

// Another one for every run of the tests, at home in none of the ranges that systems give away.
std::string port(int n) { return std::to_string(10000 + (4 * static_cast<int>(getpid()) + n) % 20000); }

const std::string kStylus = test::deviceFile("cartesian-3.toml");

}  // namespace

TEST_CASE("a device is served and felt from another process", "[device_command]") {
  const test::TemporaryFolder folder;
  const std::string log = folder / "log", key = folder / "key";
  test::writeFile(key, "00112233445566778899aabbccddeeff\n");
  const std::string server =
      "'" ENAMEL_TOOL "' device --serve --port " + port(0) + " --duration 30 --key '" + key + "'";
  const std::string output = connectTo(
      server, log, "--connect 127.0.0.1:" + port(0) + " --renderer impedance --duration 1 --key '" + key + "'");
  INFO(output << "\n" << test::readFile(log));
  CHECK(numberAfter(output, "accepted ") > 300);
  CHECK_THAT(output, ContainsSubstring("wake-up error") && ContainsSubstring("age of the command") &&
                         ContainsSubstring("reason of the guard"));
  CHECK_THAT(output, !ContainsSubstring("checksum") && !ContainsSubstring("not made with our key"));
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
  refuses("", "give --serve or --connect HOST:PORT");
  refuses("--serve --connect localhost", "give --serve or --connect HOST:PORT");
  refuses("--serve --bind 0.0.0.0 --duration 0.1",
          "0.0.0.0 is not of this machine alone (127.0.0.1): a key is required");
  refuses("--serve --key /nowhere", "/nowhere");
  refuses("--connect 127.0.0.1:0", "with a port in 1 to 65535");
  refuses("--connect 127.0.0.1:99999", "with a port in 1 to 65535");
  const test::TemporaryFolder folder;
  const std::string record = folder / "a.rec";
  refuses(
      "--connect 127.0.0.1:" + port(1) + " --device '" + kStylus + "' --renderer impedance --record '" + record + "'",
      "127.0.0.1:" + port(1) + ": no measurement within 1 s");
  CHECK_FALSE(std::filesystem::exists(record));
  refuses("--connect localhost --port 1", "--port");
  refuses("--serve --duration 0.1 --scene /nowhere", "--scene");
  refuses("--serve --rate 100", "--rate");
  refuses("--connect 127.0.0.1:" + port(1) + " --renderer nothing", "nothing");
}

TEST_CASE("the example of a vendor's SDK feels a table", "[device_command]") {
  // On a busy machine ticks come late: then the guard holds the force back and says so.
  auto result = test::runCommand("'" ENAMEL_VENDOR_SDK "' '" + kStylus + "' 1");
  const auto late = [&result] { return result.output.find("a tick came late") != std::string::npos; };
  for (int again = 0; again < 5 && result.status != 0 && late(); ++again)
    result = test::runCommand("'" ENAMEL_VENDOR_SDK "' '" + kStylus + "' 1");
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
  const std::string output =
      connectTo("timeout 30 python3 '" + script + "' " + port(2), log,
                "--connect 127.0.0.1:" + port(2) + " --renderer impedance --duration 1 --device '" + kStylus + "'");
  INFO(output << "\n" << test::readFile(log));
  CHECK(numberAfter(output, "accepted ") > 200);
  CHECK_THAT(output, !ContainsSubstring("checksum") && !ContainsSubstring("another"));
  CHECK(test::readFile(log).empty());
}

}  // namespace enamel::test_device_command
