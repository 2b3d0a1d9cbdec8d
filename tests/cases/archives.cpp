// Co-simulation units from other systems.
#include <sys/stat.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "enamel/core/error.hpp"
#include "plugins/fmi/archive.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"

namespace enamel::test_archives {

using test::run;

namespace {

std::size_t number(const std::string& bytes, std::size_t at, std::size_t size) {
  std::size_t value = 0;
  for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<std::uint8_t>(bytes.at(at + i));
  return value;
}

// Call change(entry in the table at the end, header in front of the data) for each file (APPNOTE 6.3, sections 4.3.7,
// 4.3.12, 4.3.16). No checksum covers these headers.
template <typename Change>
std::string changed(std::string zip, const Change& change) {
  const std::size_t end = zip.rfind("PK\5\6");
  if (end == std::string::npos) throw std::runtime_error("not a zip archive");
  const std::size_t entries = number(zip, end + 10, 2);
  std::size_t entry = number(zip, end + 16, 4);
  for (std::size_t i = 0; i < entries; ++i) {
    change(zip, entry, number(zip, entry + 42, 4));
    entry += 46 + number(zip, entry + 28, 2) + number(zip, entry + 30, 2) + number(zip, entry + 32, 2);
  }
  return zip;
}

// Replace / by \ in all names.
std::string withBackslashes(const std::string& zip) {
  return changed(zip, [](std::string& bytes, std::size_t entry, std::size_t file) {
    const auto change = [&bytes](std::size_t at, std::size_t length) {
      const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at);
      std::replace(begin, begin + static_cast<std::ptrdiff_t>(length), '/', '\\');
    };
    change(entry + 46, number(bytes, entry + 28, 2));
    change(file + 30, number(bytes, file + 26, 2));
  });
}

void put(std::string& bytes, std::size_t at, std::uint32_t value, std::size_t size = 4) {
  for (std::size_t i = 0; i < size; ++i) bytes[at + i] = static_cast<char>(value >> 8 * i & 0xffu);
}

// Replace a number of `size` bytes in both headers of each file.
std::string with(const std::string& zip, std::uint32_t value, std::size_t inTable, std::size_t inFile,
                 std::size_t size) {
  return changed(zip, [&](std::string& bytes, std::size_t entry, std::size_t file) {
    put(bytes, entry + inTable, value, size);
    put(bytes, file + inFile, value, size);
  });
}

// Set a file type in the Unix attributes.
std::string withKind(const std::string& zip, std::uint32_t kind) {
  return changed(zip, [kind](std::string& bytes, std::size_t entry, std::size_t) {
    bytes[entry + 5] = 3;  // made on Unix
    put(bytes, entry + 38, (kind | 0644u) << 16);
  });
}

// Let the headers state `size` bytes for each file.
std::string withSize(const std::string& zip, std::uint32_t size) { return with(zip, size, 24, 22, 4); }

std::string withNames(const std::string& zip, const std::string& name) {
  return changed(zip, [&name](std::string& bytes, std::size_t entry, std::size_t file) {
    bytes.replace(entry + 46, name.size(), name);
    bytes.replace(file + 30, name.size(), name);
  });
}

using Names = std::vector<std::string>;

// Return an archive of files with these names and 100 bytes each.
std::string zipOf(const Names& names, const std::string& bytes = std::string(100, 'x')) {
  const test::TemporaryFolder folder;
  std::vector<fmi::ArchiveFile> files;
  for (const std::string& name : names) files.push_back({name, bytes});
  fmi::writeArchive(folder / "a.zip", files);
  return test::readFile(folder / "a.zip");
}

// Return why an archive is refused; "" if it is unpacked.
std::string refusal(const std::string& zip, std::size_t most = 1000) {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "a.zip", zip);
  try {
    const fmi::UnpackedArchive unpacked(folder / "a.zip", most);
    return "";
  } catch (const Error& error) {
    const std::string text = error.what();
    return text.substr(text.find(": ") + 2);
  }
}

struct Archives {
  test::TemporaryFolder folder;
  test::CommandResult made = run("fmu --device '" + device() + "' --output '" + (folder / "unit.fmu") + "'");
  Archives() { test::writeFile(folder / "other.fmu", withBackslashes(test::readFile(folder / "unit.fmu"))); }
  test::CommandResult push(const std::string& unit) const {
    return run("push --device '" + device() + "' --plant '" + (folder / unit) + "' --duration 1.2 --json");
  }
  static std::string device() { return test::deviceFile("cartesian-6.toml"); }
};

}  // namespace

TEST_CASE("case 13: a unit is a plant, and its copy differs by backslashes alone", "[cases]") {
  const Archives archives;
  CHECK(archives.made.status == 0);
  const test::CommandResult result = archives.push("unit.fmu");
  INFO(result.output);
  CHECK(result.status == 0);
  std::string copy = test::readFile(archives.folder / "other.fmu");
  CHECK(copy.find("binaries/") == std::string::npos);
  CHECK(copy.find("binaries\\") != std::string::npos);
}

TEST_CASE("case 13: a unit with backslashes in its names is read", "[cases]") {
  const Archives archives;
  const test::CommandResult result = archives.push("other.fmu");
  INFO(result.output);
  CHECK(result.status == 0);
  CHECK(result.output == archives.push("unit.fmu").output);
}

TEST_CASE("archives: good ones are unpacked, whoever packed them", "[cases]") {
  for (const char* name : {"a/b.txt", "a\\b.txt", "./a/b.txt", "a/./b.txt"}) {
    INFO(name);
    const test::TemporaryFolder folder;
    test::writeFile(folder / "a.zip", zipOf({name}, "content"));
    const fmi::UnpackedArchive unpacked(folder / "a.zip");
    CHECK(test::readFile(unpacked.folder() + "/a/b.txt") == "content");
  }
  CHECK(refusal(zipOf({"a..b", "..c/d", "e/f..g"})) == "");
  CHECK(refusal(withKind(zipOf({"a", "b"}), S_IFREG)) == "");
  CHECK(refusal(zipOf({"a", "b"}), 200) == "");
  CHECK(refusal(zipOf({"\xc3\x84", "\xc3\xa4"})) == "");  // only ASCII letters are compared without case
}

TEST_CASE("archives: names that lead out of it are refused", "[cases]") {
  for (const char* name : {"", "..", "../x", "a/../../x", "a/../x", "a/..", "/", "/etc/x", "//x", "..\\x",
                           "a\\..\\..\\x", "a\\../..\\x", "\\x", "\\\\server\\x", "C:\\x", "C:/x", "c:x", "C:"}) {
    INFO(name);
    CHECK(refusal(zipOf({"good", name})) == "holds \"" + std::string(name) + "\", a path outside of the archive");
  }
}

TEST_CASE("archives: links and devices are refused", "[cases]") {
  for (const std::uint32_t kind : {S_IFLNK, S_IFCHR, S_IFBLK, S_IFIFO, S_IFSOCK})
    CHECK(refusal(withKind(zipOf({"a"}), kind)) == "holds \"a\", which is a link or a device");
}

TEST_CASE("archives: bombs are refused, by the size that they say and by the real one", "[cases]") {
  const std::string zeros = zipOf({"a", "b"}, std::string(600, '\0'));
  CHECK(refusal(zeros, 1200) == "");
  CHECK(refusal(zeros, 1199) == "holds more than 1199 bytes");
  CHECK(refusal(withSize(zeros, 0x7fffffffu)) == "holds more than 1000 bytes");
  CHECK(refusal(withSize(zeros, 10)) == "a is damaged");
  CHECK(refusal(withSize(zeros, 0)) == "a is damaged");
  CHECK(refusal(withSize(zeros, 601), 2000) == "a is damaged");
  Names many(fmi::kMostEntries + 1);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = std::to_string(i);
  CHECK(refusal(zipOf(many, "")) == "holds 10001 files, at most 10000 are read");
}

TEST_CASE("archives: a folder with content of its own is refused", "[cases]") {
  CHECK(refusal(zipOf({"a/"})) == "holds \"a/\", a folder with data");
  CHECK(refusal(zipOf({"a/"}, "")) == "");
}

TEST_CASE("archives: names that are one file on some systems are refused", "[cases]") {
  CHECK(refusal(zipOf({"a/B.xml", "A/b.xml"})) ==
        "holds \"a/B.xml\" and \"A/b.xml\", which are the same file if case is ignored");
  for (const Names& names : {Names{"a", "A"}, {"a/b", "a\\b"}, {"a", "./a"}, {"a/", "A"}}) {
    INFO(names[0] << " " << names[1]);
    CHECK(refusal(zipOf(names, "")).find("which are the same file if case is ignored") != std::string::npos);
  }
  CHECK(refusal(withNames(zipOf({"a1", "a2"}), "a3")).find("which are the same file if case is ignored") !=
        std::string::npos);
  CHECK(refusal(zipOf({"a", "a/b"})) == "cannot unpack a/b: Not a directory");
  CHECK(refusal(zipOf({"a/b", "a"})) == "cannot unpack a: Is a directory");
}

TEST_CASE("archives: a NUL in a name is read as a space", "[cases]") {
  const auto unpacked = [](const std::string& name, const std::string& as) {
    const test::TemporaryFolder folder;
    test::writeFile(folder / "a.zip", withNames(zipOf({"name"}, "content"), name));
    const fmi::UnpackedArchive archive(folder / "a.zip");
    return test::readFile(archive.folder() + as) == "content";
  };
  CHECK(unpacked(std::string("a\0me", 4), "/a me"));
  CHECK(unpacked(std::string("..\0e", 4), "/.. e"));
  CHECK(refusal(withNames(zipOf({"name", "a me"}), std::string("a\0me", 4)))
            .find("which are the same file if case is ignored") != std::string::npos);
}

TEST_CASE("archives: what cannot be read or written has libzip's or the system's reason", "[cases]") {
  const std::string zip = zipOf({"a"});
  CHECK(refusal(with(zip, 1, 8, 6, 2)) == "a cannot be read: No password provided");
  CHECK(refusal(with(zip, 97, 10, 8, 2)) == "a cannot be read: Compression method not supported");
  CHECK(refusal(with(zip, 0x12345678u, 16, 14, 4)) == "a is damaged");
  CHECK(refusal(zip.substr(0, zip.size() / 2)).rfind("cannot open the archive: ", 0) == 0);
  const std::string longest(255, 'x');
  CHECK(refusal(zipOf({longest})) == "");
  CHECK(refusal(zipOf({longest + "x"})).find(": File name too long") != std::string::npos);
  CHECK(refusal(zipOf({longest + "x/y"})).find(": File name too long") != std::string::npos);
}

TEST_CASE("archives: of a refused one nothing is left", "[cases]") {
  const auto units = [] {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::temp_directory_path()))
      if (entry.path().filename().string().rfind("enamel-unit-", 0) == 0) names.push_back(entry.path().string());
    return names.size();
  };
  const test::TemporaryFolder folder;
  setenv("TMPDIR", (folder / "").c_str(), 1);
  const std::string reason = refusal(withSize(zipOf({"a"}), 10));
  const std::size_t left = units();
  unsetenv("TMPDIR");
  CHECK(reason == "a is damaged");
  CHECK(left == 0);
}

}  // namespace enamel::test_archives
