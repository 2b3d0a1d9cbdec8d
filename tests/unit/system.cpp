// Differences between operating systems: files with names in UTF-8, locks, sockets, sleep, libraries. The same tests
// run on Linux and on Windows.
#include <cerrno>
#include <cstring>
#include <thread>

#include "core/system_file.hpp"
#include "core/system_process.hpp"
#include "enamel/core/file.hpp"
#include "enamel/plugin/host.hpp"
#include "plugin/system_library.hpp"
#include "runtime/system_socket.hpp"
#include "runtime/system_thread.hpp"
#include "support/catch.hpp"
#include "support/eventually.hpp"
#include "support/temporary_folder.hpp"

namespace enamel::test_system {

using test::ContainsSubstring;

namespace {

constexpr const char* kName =
    "zahn-\xc3\xa4-\xe6\xad\xaf-\xf0\x9f\xa6\xb7.txt";  // umlaut, kanji, a character of more than 16 bits

std::size_t filesIn(const std::string& folder) {
  const std::filesystem::directory_iterator all(std::filesystem::u8path(folder));
  return static_cast<std::size_t>(std::distance(all, {}));
}

}  // namespace

TEST_CASE("files have names in UTF-8", "[system]") {
  const test::TemporaryFolder folder;
  writeFile(folder / kName, "old");
  CHECK(readFile(folder / kName) == "old");
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::u8path(folder / ".")))
    names.push_back(entry.path().filename().u8string());
  CHECK(names == std::vector<std::string>{kName});
  CHECK(system::statusOf(folder / kName).kind == system::FileKind::regular);
  CHECK(system::statusOf(folder / kName).size == 3);
  CHECK(system::statusOf(folder / ".").kind == system::FileKind::folder);
  CHECK(system::remove(folder / kName));
  errno = 0;
  CHECK(system::statusOf(folder / kName).kind == system::FileKind::missing);
  CHECK(errno == ENOENT);
  CHECK_THROWS_WITH(readFile(folder / kName), ContainsSubstring(kName) && ContainsSubstring("No such file"));
}

TEST_CASE("a file is replaced whole, also while somebody reads it", "[system]") {
  const test::TemporaryFolder folder;
  const std::string path = folder / kName;
  writeFile(path, std::string("old\r\n\0\x1a", 7));  // bytes that a text mode would change
  {
    FileWriter file(path);
    file.write("half");
    CHECK(readFile(path).size() == 7);
    CHECK(filesIn(folder / ".") == 2);
  }
  CHECK(filesIn(folder / ".") == 1);
  CHECK(readFile(path) == std::string("old\r\n\0\x1a", 7));
  for (const std::string text : {"first\n", "second\n"}) {
    writeFile(path, text);
    CHECK(readFile(path) == text);
  }
  CHECK(filesIn(folder / ".") == 1);
  CHECK_THROWS_WITH(writeFile(folder / "no/such/file", "x"), ContainsSubstring("No such file or directory"));
}

TEST_CASE("descriptors: new files, places, sizes, locks", "[system]") {
  const test::TemporaryFolder folder;
  const std::string path = folder / kName;
  const int made = system::openNew(path);
  REQUIRE(made >= 0);
  CHECK(system::openNew(path) == -1);
  CHECK(errno == EEXIST);
  CHECK(system::writeSome(made, "0123456789", 10) == 10);
  CHECK(system::setSize(made, 8));
  CHECK(system::close(made));

  const int reader = system::openToRead(path);
  REQUIRE(reader >= 0);
  CHECK(system::statusOf(reader).size == 8);
  char bytes[8] = {};
  CHECK(system::readAt(reader, 5, bytes, 8) == 3);
  CHECK(std::memcmp(bytes, "567", 3) == 0);
  CHECK(system::readAt(reader, 8, bytes, 8) == 0);
  CHECK(system::readAt(reader, 100, bytes, 8) == 0);

  const int first = system::openToAppend(path), second = system::openToAppend(path);
  CHECK(system::lock(first));
  CHECK_FALSE(system::lock(second));
  CHECK(readFile(path) == "01234567");  // a lock does not hinder readers
  CHECK(system::setSize(first, 4));
  CHECK(system::writeSome(first, "ab", 2) == 2);
  CHECK(system::close(first));
  CHECK(system::lock(second));
  CHECK(system::writeSome(second, "c", 1) == 1);
  CHECK(system::close(second));
  CHECK(readFile(path) == "0123abc");
  CHECK(system::close(reader));
  CHECK(system::openToRead(folder / "none") == -1);
  CHECK(errno == ENOENT);
}

TEST_CASE("a thread does not wake before its deadline", "[system]") {
  std::thread([] {
    system::nameThread("a name of more than fifteen characters");
    (void)system::requestRealtime(1);
    for (const int ahead_us : {-100, 0, 50, 900, 3000, 20000}) {
      const std::int64_t deadline = system::clockNow() + 1000 * ahead_us;
      system::sleepUntil(deadline);
      CHECK(system::clockNow() >= deadline);
    }
  }).join();
  const auto begin = std::chrono::steady_clock::now();
  const std::int64_t before = system::clockNow();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const std::int64_t passed = system::clockNow() - before;
  CHECK(passed >= 20000000);
  CHECK(std::chrono::nanoseconds(passed) <= std::chrono::steady_clock::now() - begin);
}

TEST_CASE("a connected socket hears its peer only, and all again afterwards", "[system]") {
  const system::Endpoint any = system::findHost("127.0.0.1", 0);
  CHECK(any.isLoopback());
  CHECK(system::findHost("localhost", 7).text() == "127.0.0.1:7");
  CHECK_THROWS_WITH(system::findHost("no such host", 1), ContainsSubstring("device: cannot find no such host: "));
  system::UdpSocket server(any), peer(any), other(any);
  const auto at = [&any](const system::UdpSocket& s) { return system::Endpoint{any.address, s.port()}; };
  CHECK_THROWS_WITH(system::UdpSocket(at(server)), ContainsSubstring("cannot bind to " + at(server).text()));
  char bytes[8] = {};
  system::Endpoint from;
  CHECK(server.receive(bytes, sizeof bytes, from) == -1);

  const auto hears = [&](system::UdpSocket& sender, char letter) {
    REQUIRE(sender.send(&letter, 1, at(server)));
    const bool arrives = test::eventually([&] { return server.receive(bytes, sizeof bytes, from) == 1; });
    return arrives && bytes[0] == letter && from.port == sender.port();
  };
  CHECK(hears(peer, 'a'));
  CHECK(hears(other, 'b'));
  REQUIRE(server.connect(at(peer)));
  const char ignored = 'c';
  REQUIRE(other.send(&ignored, 1, at(server)));
  CHECK(hears(peer, 'd'));
  CHECK(server.send("e", 1));
  CHECK(test::eventually([&] { return peer.receive(bytes, sizeof bytes, from) == 1; }));
  CHECK(bytes[0] == 'e');
  REQUIRE(server.disconnect());
  CHECK(hears(other, 'f'));

  // A datagram that is too long is cut. One without a receiver does not hinder those that follow.
  REQUIRE(peer.send("0123456789", 10, at(server)));
  CHECK(test::eventually([&] { return server.receive(bytes, sizeof bytes, from) == 8; }));
  system::Endpoint gone;
  {
    const system::UdpSocket closed(any);
    gone = at(closed);
  }
  REQUIRE(server.send("x", 1, gone));
  CHECK(hears(peer, 'g'));
}

TEST_CASE("a library that cannot be loaded is refused with the reason", "[system]") {
  const test::TemporaryFolder folder;
  const std::string path = folder / ("plugin" + system::kLibraryEnding);
  CHECK_THROWS_WITH(system::checkLibrary(path), ContainsSubstring("no such file"));
  test::writeFile(path, "text");
  CHECK_THROWS_WITH(system::checkLibrary(path), ContainsSubstring("is not a shared library"));
  CHECK_THROWS_AS(system::loadLibrary(path), PluginError);
}

TEST_CASE("this process has a number and processors", "[system]") {
  CHECK(system::processId() > 0);
  CHECK(system::processors() >= 1);
}

}  // namespace enamel::test_system
