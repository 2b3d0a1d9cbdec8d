// Memory and work per byte to read a file: for ordinary files, mutated ones, and the worst ones that are accepted. The
// unit of work is the checksum of a byte, measured in the same run, so that the result does not depend on the machine.
// ENAMEL_LONG=1: 1e5 mutated files per format, and a table.
#include <malloc.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <new>

#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/control/servo_file.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/runtime/recorder.hpp"
#include "enamel/study/run_file.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/meshes.hpp"
#include "support/processor_time.hpp"
#include "support/pushes.hpp"
#include "support/run_length.hpp"

namespace {

std::atomic<std::ptrdiff_t> used{0}, most{0};  // bytes of the heap

void* taken(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  const std::ptrdiff_t now = used += static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  if (now > most) most = now;
  return memory;
}

void given(void* memory) noexcept {
  used -= static_cast<std::ptrdiff_t>(malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace

void* operator new(std::size_t size) { return taken(std::malloc(size)); }
void* operator new(std::size_t size, std::align_val_t at) {
  return taken(memalign(static_cast<std::size_t>(at), size));
}
void operator delete(void* memory) noexcept { given(memory); }
void operator delete(void* memory, std::size_t) noexcept { given(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { given(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { given(memory); }

namespace enamel::test_readers {

namespace {

// Limits for a file: its share per byte, and a base for a model and the reader's tables.
constexpr double kMemoryShare = 20.0, kMemoryBase = 1 << 20;         // bytes per byte; bytes
constexpr double kWorkShare = 500.0, kWorkBase = 1e6;                // in checksums of a byte: per byte; total
constexpr std::size_t kLong = 1 << 20, kLongToml = (1 << 18) - 100;  // bytes

struct Format {
  std::string name;
  std::function<void(const std::string& bytesOrPath)> read;
  std::string good;
  std::vector<std::string> worst;
  std::string path = {};  // file to read; empty: read the bytes
};

std::string repeat(const std::string& text, std::size_t bytes) {
  std::string all;
  while (all.size() < bytes) all += text;
  return all;
}

// Return as many values as are always accepted, or up to `bytes` of them.
std::string many(const std::string& value, std::size_t bytes) {
  return repeat(value, std::min(bytes, 990 / (value.size() == 2 ? 1 : 2) * value.size()));
}

// Return the processor time for the checksum of a byte, s.
double checksumSeconds() {
  const std::string bytes(1 << 20, 'x');
  const double begin = test::processorTime();
  const std::uint32_t sum = crc32(bytes);
  const double passed = test::processorTime() - begin;
  REQUIRE(sum != 0);
  return passed / static_cast<double>(bytes.size());
}

struct Cost {
  double memory, time;  // bytes, s
  bool refused;
};

Cost costOf(const Format& format, const std::string& bytes) {
  Cost cost{0.0, 0.0, false};
  if (!format.path.empty()) writeFile(format.path, bytes);
  const std::ptrdiff_t before = used;
  most = before;
  const double begin = test::processorTime();
  try {
    format.read(format.path.empty() ? bytes : format.path);
  } catch (const Error&) {
    cost.refused = true;
  }
  cost.time = test::processorTime() - begin;
  cost.memory = static_cast<double>(most - before);
  return cost;
}

std::vector<Format> allFormats(const test::TemporaryFolder& folder) {
  const auto mesh = [](const std::string& path) {
    return [path](const std::string& bytes) { (void)parseMesh(bytes, path); };
  };
  const std::string plyHead =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face ";
  const std::string tenTriangles = [] {
    std::string face = "\x0c";
    for (int i = 0; i < 12; ++i) face += static_cast<char>(i % 3);
    return face;
  }();
  const auto fans = [&](const std::string& type, const std::string& face, std::size_t count) {
    return plyHead + std::to_string(count) + "\nproperty list uchar " + type + " vertex_indices\nend_header\n" +
           std::string(36, '\0') + repeat(face, count * face.size());
  };
  const std::size_t vertices = kLong / 6, faces = kLong / 2 / 14;
  std::vector<Format> formats;
  formats.push_back(
      {"off",
       mesh("a.off"),
       "OFF 4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n",
       {"OFF " + std::to_string(vertices) + " 1 0\n" + repeat("0 0 0\n", 6 * vertices) + "3 0 1 2\n",
        "OFF 3 " + std::to_string(faces) + " 0\n0 0 0\n1 0 0\n0 1 0\n" + repeat("4 0 1 2 0\n    ", 14 * faces),
        "OFF 3 1 0\n0 0 0 " + repeat("#", kLong) + "\n1 0 0\n0 1 0\n3 0 1 2\n"}});
  formats.push_back({"obj",
                     mesh("a.obj"),
                     "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
                     {repeat("v 0 0 0\n", kLong) + "f 1 2 3\n", "v 0 0 0\n" + repeat("f 1 1 1 1\n  ", kLong),
                      "v 0 0 0\nf" + repeat(" 1", kLong) + "\n", repeat("\n", kLong)}});
  std::string stl(80, ' ');
  const std::uint32_t triangles = kLong / 50;
  stl.append(reinterpret_cast<const char*>(&triangles), 4);
  formats.push_back(
      {"stl",
       mesh("a.stl"),
       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
       "0\nendloop\nendfacet\nendsolid\n",
       {stl + std::string(50 * triangles, '\0'),
        "solid\n" + repeat("outer\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nendloop\n", kLong) + "endsolid\n"}});
  formats.push_back(
      {"ply",
       mesh("a.ply"),
       fans("uchar", std::string("\x03\x00\x01\x02", 4), 8) + std::string(60, '\0'),
       {fans("uchar", std::string("\x03\x00\x01\x02  ", 4), kLong / 4), fans("uchar", tenTriangles, kLong / 13),
        fans("uchar", "\xff" + std::string(255, '\0'), kLong / 256),
        "ply\n" + repeat("element a 0\n", kLong) + "end_header\n\n",
        "ply\nelement a 0\n" + repeat("property char a\n", kLong) + "end_header\n\n",
        "ply\nformat ascii 1.0\nelement vertex " + std::to_string(vertices) +
            "\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar "
            "int vertex_indices\nend_header\n" +
            repeat("0 0 0\n", 6 * vertices) + "3 0 1 2\n"}});
  std::string keys;
  for (int i = 0; keys.size() < kLongToml; ++i) keys += "k" + std::to_string(i) + "=1\n";
  const std::vector<std::string> worstToml = {"a=[" + many("1,", kLongToml) + "1]\n",
                                              "a=[" + many("[],", kLongToml) + "1]\n",
                                              "a=[" + many("{},", kLongToml) + "1]\n",
                                              repeat("[[a]]\n", kLongToml),
                                              keys.substr(0, keys.rfind('\n', kLongToml) + 1),
                                              "a=\"" + repeat("x", kLongToml) + "\"\n",
                                              repeat("#\n", kLongToml)};
  for (const char* device : {"tau-detailed.toml", "delta.toml", "cartesian-6.toml"})
    formats.push_back({device, [](const std::string& bytes) { (void)parseDevice(bytes, "a.toml"); },
                       test::readFile(test::deviceFile(device)), worstToml});
  formats.push_back({"scene",
                     [](const std::string& bytes) { (void)parseScene(bytes, ENAMEL_SOURCE_DIR "/data/a.toml"); },
                     test::readFile(ENAMEL_SOURCE_DIR "/data/scenes/corner.toml"), worstToml});
  const std::vector<std::string> worstJson = {
      "[" + many("1,", kLong) + "1]",    "[" + many("[],", kLong) + "1]",           "[" + many("{},", kLong) + "1]",
      "[" + many("\"\",", kLong) + "1]", "{" + many("\"\":1,", kLong) + "\"a\":1}", "\"" + repeat("x", kLong) + "\""};
  formats.push_back({"servo.json", [](const std::string& path) { (void)loadServo(path); },
                     R"({"model": "a", "period": 0.001, "K": [[1, 2, 3, 4, 5, 6], [1, 2, 3, 4, 5, 6]]})", worstJson,
                     folder / "servo.json"});
  const auto recording = [](const std::string& header, const std::string& chunks) {
    const std::uint32_t words[4] = {1, static_cast<std::uint32_t>(header.size()), crc32(header), 0};
    return "ENAMELR\n" + std::string(reinterpret_cast<const char*>(words), sizeof(words)) + header + chunks;
  };
  const auto readRecording = [](const std::string& path) {
    RecordingReader reader(path);
    RecordedChunk chunk;
    for (std::uint64_t i = 0; i < reader.chunks(); ++i) (void)reader.read(i, chunk);
  };
  const TauMechanism device(test::nominal());
  const Scene wall = flatWall();
  ImpedanceRenderer spring({6000.0, 0.0});
  HapticTick tick(device, wall, Tool(), spring, 1e-3);
  std::string recorded;
  {
    Recorder recorder([&recorded](const char* bytes, std::size_t size) { return recorded.append(bytes, size), size; },
                      "recording", {}, tick);
    Measurement m;
    Command command;
    m.q = device.home().q;
    m.rates = device.home().rates;
    for (std::uint64_t i = 0; i < 150; ++i) {
      m.time = 1e-3 * static_cast<double>(i);
      recorder.add(i, m, tick, command, tick(m, command));
    }
  }
  std::vector<std::string> worstRecordings = {recorded + repeat("CHNK", kLong), recorded + std::string(kLong, '\0')};
  for (const std::string& json : worstJson) worstRecordings.push_back(recording(json, ""));
  std::string manyKeys = "{\"a\":1";
  for (int i = 0; i < 50000; ++i) manyKeys += ",\"" + std::to_string(i) + "\":1";
  worstRecordings.push_back(recording(manyKeys + "}", ""));
  formats.push_back({"recording", readRecording, recorded, worstRecordings, folder / "a.rec"});
  StudyPlan plan;
  plan.grid = 3;
  plan.runs = 300;
  plan.scenarios = {1};
  plan.columns.push_back({"a", nullptr, {}});
  std::string runs = runHeader() + '\n', lost = runs;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    StudyResult result;
    result.run = runAt(plan, i);
    runs += runLine(plan, result) + '\n';
    result.status = Status::stopped;
    lost += runLine(plan, result) + '\n';
  }
  formats.push_back({"runs.csv",
                     [plan](const std::string& path) { (void)readRuns(plan, path); },
                     runs.substr(0, runs.size() / 20),
                     {runs, lost, repeat("\n", kLong), repeat(",", kLong)},
                     folder / "runs.csv"});
  return formats;
}

}  // namespace

TEST_CASE("a file costs memory and time as it is long, or it is refused", "[readers]") {
  const test::TemporaryFolder folder;
  const std::vector<std::string> words = {"nan",
                                          "-1",
                                          "1e999",
                                          "99999999999999999999",
                                          "\n",
                                          " ",
                                          "[",
                                          "{",
                                          "\"",
                                          "'''",
                                          "a.b",
                                          "=",
                                          "#",
                                          ",",
                                          "inf",
                                          "0",
                                          std::string(1, '\0'),
                                          "\xff\xff\xff\xff"};
  test::Random random(77);
  const auto pick = [&random](std::size_t n) {
    return std::min(static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(n))), n - 1);
  };
  double checksum = checksumSeconds();
  for (const Format& format : allFormats(folder)) {
    INFO(format.name);
    CHECK_FALSE(costOf(format, format.good).refused);
    double memory = 0.0, time = 0.0;
    const auto check = [&](const std::string& bytes) {
      Cost cost = costOf(format, bytes);
      const double size = static_cast<double>(bytes.size()), most = kWorkShare * size + kWorkBase;
      for (int again = 0; again < 10 && cost.time > most * checksum; ++again) {  // a machine has hiccups
        cost = costOf(format, bytes);
        checksum = checksumSeconds();
      }
      INFO(size << " bytes: " << cost.memory / size << " of memory a byte, " << 1e6 * cost.time / size
                << " us a byte: " << bytes.substr(0, 80));
      CHECK(cost.memory <= kMemoryShare * size + kMemoryBase);
      CHECK(cost.time <= most * checksum);
      if (size > 1e5) memory = std::max(memory, cost.memory / size);
      if (size > 1e5) time = std::max(time, cost.time / size);
      return cost;
    };
    for (const std::string& bytes : format.worst) check(bytes);
    int loaded = 0;
    const int files = test::count(500, 100000);
    for (int i = 0; i < files; ++i) {
      std::string bytes = format.good;
      for (std::size_t changes = 1 + pick(4); changes > 0 && !bytes.empty(); --changes) {
        const std::size_t at = pick(bytes.size());
        switch (pick(5)) {
          case 0: bytes[at] = static_cast<char>(pick(256)); break;
          case 1: bytes.erase(at, 1 + pick(20)); break;
          case 2: bytes.insert(at, words[pick(words.size())]); break;
          case 3: bytes.insert(at, bytes.substr(pick(bytes.size()), pick(200))); break;
          default: bytes.resize(at); break;
        }
      }
      loaded += !check(bytes).refused;
    }
    CHECK(loaded < files);
    if (test::longRun())
      std::printf("%-20s %8zu bytes: %5.1f bytes of memory and %6.3f us a byte at most; %d of %d mutated files load\n",
                  format.name.c_str(), format.worst.front().size(), memory, 1e6 * time, loaded, files);
  }
}

}  // namespace enamel::test_readers
