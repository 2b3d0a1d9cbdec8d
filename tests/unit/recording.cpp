// Recordings: every field survives, replay is exact from any chunk. Disks that are full or slow, files that were cut or
// changed. ENAMEL_LONG=1: 1e5 changed files.
#include "enamel/runtime/recording.hpp"

#include <chrono>
#include <cstring>
#include <thread>

#include "enamel/collision/scene_file.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/runtime/recorder.hpp"
#include "enamel/runtime/replay.hpp"
#include "enamel/sim/simulated_device.hpp"
#include "support/catch.hpp"
#include "support/disk.hpp"
#include "support/eventually.hpp"
#include "support/garbage.hpp"
#include "support/pushes.hpp"
#include "support/recording_rig.hpp"
#include "support/run_length.hpp"
#include "support/skip.hpp"

namespace enamel::test_recording {

using namespace test::recording_rig;

namespace {

void setWord(std::string& bytes, std::size_t at, std::uint32_t word) {
  std::memcpy(bytes.data() + at, &word, sizeof(word));
}

bool same(const JointVector& a, const JointVector& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

}  // namespace

TEST_CASE("recording: every field there and back", "[recording]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "a.rec";
  Rig rig;
  RecordingHeader header;
  header.deviceFile = "a \"device\"";
  header.deviceText = "kind = 1\n\tx";
  header.sceneFile = "b";
  header.sceneText = "c";
  header.files = 0xfedcba98;
  header.renderer = "spring";
  header.plugin = "d.so";
  header.parameters = {{"a", "1"}, {"b", ""}};
  header.start.position = {0.1, 1e-17, -0.3};
  header.start.rotation = test::rotationAbout(Vec3(1, 2, 3).normalized(), 0.1);
  struct Kept {
    Measurement m;
    JointVector requested, command;
    double force;
    Status status;
    GuardReason reason;
    RenderMode mode;
    bool saturated, reset;
  };
  std::vector<Kept> kept;
  {
    Recorder recorder(file, header, rig.tick);
    for (std::uint64_t i = 0; i < 300; ++i) {
      const bool reset = i == 100;
      if (reset) rig.tick.reset();
      Status status = rig.step();
      if (i == 40 || i == 200) {  // values that no device should report
        Measurement& m = rig.measurement;
        m.time += 1e-4;
        m.q = JointVector::Constant(7, -0.0);
        m.rates[1] = std::nan("7");
        m.applied = JointVector::Constant(3, 1e300);
        m.enabled = false;
        m.gripper = -0.25;
        m.heat = 0.5;
        m.buttons = 0x80000001;
        m.conditions = kForcesCut;
        status = rig.tick(m, rig.command);
      }
      recorder.add(7 * i, rig.measurement, rig.tick, rig.command, status, reset);
      ++rig.number;
      const TickOutput& out = rig.tick.frame().output;
      kept.push_back({rig.measurement, out.torque, rig.command.effort, out.normalForce, status, rig.tick.frame().reason,
                      out.mode, out.saturated, reset});
    }
    const RecordingResult result = recorder.close();
    CHECK(result.ticks == 300);
    CHECK(result.lost == 0);
    CHECK(result.problem.empty());
    CHECK(recorder.close().ticks == 300);
  }
  RecordingReader reader(file);
  const RecordingHeader& h = reader.header();
  CHECK(h.deviceFile == header.deviceFile);
  CHECK(h.deviceText == header.deviceText);
  CHECK(h.sceneFile == header.sceneFile);
  CHECK(h.sceneText == header.sceneText);
  CHECK(h.files == header.files);
  CHECK(h.renderer == header.renderer);
  CHECK(h.plugin == header.plugin);
  CHECK(h.parameters == header.parameters);
  CHECK(h.start.position == header.start.position);
  CHECK(h.start.rotation == header.start.rotation);
  CHECK(h.joints == 6);
  CHECK(h.stateSize == rig.tick.stateSize());
  CHECK(h.rendererState == rig.spring.stateSize());
  const GuardOptions &a = h.guard, &b = rig.tick.guard().options();
  CHECK(std::tie(a.on, a.period, a.force, a.moment, a.margin, a.speed, a.stopSpeed, a.turn, a.stopTurn, a.brake) ==
        std::tie(b.on, b.period, b.force, b.moment, b.margin, b.speed, b.stopSpeed, b.turn, b.stopTurn, b.brake));
  CHECK(std::tie(a.brakeTurn, a.longestGap, a.mostMissed, a.energy, a.power, a.softest, a.oscillation, a.engage) ==
        std::tie(b.brakeTurn, b.longestGap, b.mostMissed, b.energy, b.power, b.softest, b.oscillation, b.engage));
  CHECK(std::tie(a.rampIn, a.rampOut, a.workspace, a.damping, a.torque, a.slew, a.rate, a.encoderStep) ==
        std::tie(b.rampIn, b.rampOut, b.workspace, b.damping, b.torque, b.slew, b.rate, b.encoderStep));
  REQUIRE(reader.chunks() == 3);
  RecordedChunk chunk;
  std::size_t seen = 0;
  for (std::uint64_t i = 0; i < 3; ++i) {
    REQUIRE(reader.read(i, chunk) == "");
    CHECK(chunk.sequence == i);
    CHECK(chunk.lost == 0);
    CHECK(chunk.fresh == (i == 0));
    CHECK(chunk.last == (i == 2));
    CHECK(chunk.state.size() == h.stateSize);
    for (const RecordedTick& t : chunk.ticks) {
      const Kept& k = kept[seen];
      INFO("tick " << seen);
      CHECK(t.number == 7 * seen++);
      CHECK(t.measurement.time == k.m.time);
      CHECK(same(t.measurement.q, k.m.q));
      CHECK(same(t.measurement.rates, k.m.rates));
      REQUIRE(t.measurement.applied.has_value() == k.m.applied.has_value());
      if (k.m.applied) CHECK(same(*t.measurement.applied, *k.m.applied));
      CHECK(t.measurement.enabled == k.m.enabled);
      CHECK(t.measurement.gripper == k.m.gripper);
      CHECK(t.measurement.heat == k.m.heat);
      CHECK(t.measurement.buttons == k.m.buttons);
      CHECK(t.measurement.conditions == k.m.conditions);
      CHECK(same(t.requested, k.requested));
      CHECK(same(t.command, k.command));
      CHECK(t.normalForce == k.force);
      CHECK(t.status == k.status);
      CHECK(t.reason == k.reason);
      CHECK(t.mode == k.mode);
      CHECK(t.saturated == k.saturated);
      CHECK(t.reset == k.reset);
    }
  }
  CHECK(seen == kept.size());
  CHECK_THROWS_AS(reader.read(3, chunk), Error);
  // The header is ASCII; invalid UTF-8 in a path is replaced. No recording is overwritten.
  CHECK_THROWS_WITH(Recorder(file, header, rig.tick),
                    test::ContainsSubstring("a.rec") && test::ContainsSubstring("exists"));
}

TEST_CASE("recording: a push replays bit for bit, from every chunk, and another one does not", "[recording]") {
  const test::TemporaryFolder folder;
  const TauMechanism device(test::nominal());
  const SceneFile molar = loadScene(ENAMEL_SOURCE_DIR "/data/scenes/molar.toml");
  PushSetup setup;
  setup.scene = molar.scene;
  setup.tool = molar.tool;
  setup.start.position = molar.start;
  setup.delay = {0, 2};
  setup.encoders = {true, RateSource::lowPass, 100.0};
  setup.duration = 1.2;
  PositionControlRenderer servo = test::positionControl(device, 0, 2);
  const std::string file = folder / "push.rec";
  std::optional<Recorder> recorder;
  (void)runPush(std::make_unique<ClosedFormPlant>(device), device, servo, setup,
                [&](const TickRecord& tick, const VirtualLoop& loop) {
                  RecordingHeader header;
                  header.start = setup.start;
                  if (!recorder) recorder.emplace(file, header, loop.hapticTick());
                  recorder->makeRoom();
                  recorder->add(tick.tick, loop.measurement(), loop.hapticTick(), loop.command(), tick.status);
                });
  const std::uint64_t ticks = recorder->close().ticks;
  CHECK(ticks >= 1000);

  const auto run = [&](Renderer& renderer, std::uint64_t from) {
    RecordingReader reader(file);
    HapticTick tick(device, setup.scene, setup.tool, renderer, reader.header().guard, reader.header().start);
    return replay(reader, tick, from);
  };
  const std::uint64_t chunks = RecordingReader(file).chunks();
  for (std::uint64_t from = 0; from + 1 < chunks; from += std::max<std::uint64_t>(1, chunks / 20)) {
    const ReplayResult result = run(servo, from);
    INFO("from " << from << ": " << (result.first ? result.first->what : ""));
    CHECK(result.different == 0);
    CHECK(result.ticks + result.restored == ticks - from * kChunkTicks);
    CHECK(result.restored == (from > 0 ? 1 : 0));
    CHECK(result.states);
    CHECK(result.closed);
  }
  ImpedanceRenderer spring({});
  const ReplayResult other = run(spring, 0);
  CHECK(other.ticks == ticks);
  CHECK(other.different > 0);
  CHECK_FALSE(other.states);
  REQUIRE(other.first);
  CHECK(other.first->recorded != other.first->replayed);
  CHECK(run(spring, 1).different > 0);
  CHECK_THROWS_AS(run(servo, chunks), Error);

  // One bit of one measurement: reported at its tick.
  std::string bytes = test::readFile(file);
  const std::size_t size = chunkSize(RecordingReader(file).header().stateSize), header = wordAt(bytes, 12);
  const std::size_t chunk = kHead + header + 2 * size;
  bytes[chunk + size - kChunkTicks * kTick + 5 * kTick + 16] ^= 1;
  test::writeFile(file, bytes);
  RecordedChunk read;
  CHECK_THAT(RecordingReader(file).read(2, read),
             test::ContainsSubstring("chunk 2") && test::ContainsSubstring("is damaged"));
  const ReplayResult skipped = run(servo, 0);
  CHECK(skipped.damaged == 1);
  CHECK(skipped.restored == 1);
  CHECK(skipped.different == 0);
  setWord(bytes, chunk + 4, crc32(std::string_view(bytes).substr(chunk + 8, size - 8)));
  test::writeFile(file, bytes);
  const ReplayResult changed = run(servo, 0);
  CHECK(changed.damaged == 0);
  REQUIRE(changed.first);
  CHECK(changed.first->tick == 2 * kChunkTicks + 5);
}

TEST_CASE("recording: a file of version 1 is read, without what a device reports about itself", "[recording]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "a.rec";
  Rig rig;
  rig.measurement.buttons = 3;
  {
    Recorder recorder(file, {}, rig.tick);
    rig.run(recorder, 300);
    CHECK(recorder.close().ticks == 300);
  }
  constexpr std::size_t kOldTick = 320;
  std::string bytes = test::readFile(file), old = bytes.substr(0, kHead + wordAt(bytes, 12));
  setWord(old, 8, 1);
  const std::size_t states = chunkSize(RecordingReader(file).header().stateSize) - kChunkTicks * kTick;
  for (std::size_t at = old.size(); at < bytes.size();) {
    const std::size_t ticks = wordAt(bytes, at + 24);
    std::string chunk = bytes.substr(at, states);
    for (std::size_t i = 0; i < ticks; ++i) chunk += bytes.substr(at + states + i * kTick, kOldTick);
    setWord(chunk, 4, crc32(std::string_view(chunk).substr(8)));
    old += chunk;
    at += states + ticks * kTick;
  }
  test::writeFile(file, old);
  const ReplayResult result = replayed(file);
  CHECK(result.ticks == 300);
  CHECK(result.different == 0);
  CHECK(result.damaged == 0);
  RecordedChunk chunk;
  REQUIRE(RecordingReader(file).read(1, chunk) == "");
  CHECK(chunk.ticks[5].measurement.buttons == 0);
  CHECK_FALSE(chunk.ticks[5].measurement.gripper);
}

TEST_CASE("recording: a full disk loses ticks, says so, and the rest replays", "[recording]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "full.rec";
  test::Disk disk(100000);
  Rig rig;
  Recorder recorder([&](const char* bytes, std::size_t size) { return disk.write(bytes, size); }, "a disk", {},
                    rig.tick);
  rig.run(recorder, 10000);  // the ring has room for 3968
  const std::uint64_t first = recorder.lost();
  CHECK(first > 5000);
  disk.setRoom(std::size_t{1} << 30);
  REQUIRE(test::eventually([&] {  // until a tick finds room again
    rig.run(recorder, 1);
    return recorder.lost() < first + (rig.number - 10000);
  }));
  for (int i = 0; i < 20; ++i) {
    recorder.makeRoom();
    rig.run(recorder, 64);
  }
  const RecordingResult result = recorder.close();
  CHECK(result.problem.empty());
  CHECK(result.lost == recorder.lost());
  CHECK(result.ticks + result.lost == rig.number);
  test::writeFile(file, disk.content());
  const ReplayResult after = replayed(file);
  CHECK(after.lost == result.lost);
  CHECK(after.damaged == 0);
  CHECK(after.ticks + after.restored == result.ticks);
  CHECK(after.restored >= 1);
  CHECK(after.different == 0);
  CHECK(after.closed);

  // Full until the end: it is complete up to there, and missing ticks are reported.
  Rig other;
  test::Disk small(110000);
  Recorder full([&](const char* bytes, std::size_t size) { return small.write(bytes, size); }, "a disk", {},
                other.tick);
  other.run(full, 10000);
  const RecordingResult lost = full.close();
  CHECK(lost.problem == "a disk: cannot write the recording: No space left on device");
  CHECK(lost.ticks == 2 * kChunkTicks);
  CHECK(lost.ticks + lost.lost == 10000);
  test::writeFile(file, small.content());
  const ReplayResult part = replayed(file);
  CHECK(part.ticks == lost.ticks);
  CHECK(part.different == 0);
  CHECK(part.damaged == 1);  // the incomplete chunk
  CHECK_FALSE(part.closed);

  CHECK_THROWS_WITH(Recorder([](const char*, std::size_t) { return std::size_t{0}; }, "a disk", {}, other.tick),
                    test::ContainsSubstring("a disk: cannot write the recording"));
  CHECK_THROWS_AS(Recorder("/dev/full", {}, other.tick), Error);
  CHECK_THROWS_AS(Recorder(folder / "no/such/folder", {}, other.tick), Error);
}

TEST_CASE("recording: a loop on a device, with a fault and a reset, replays", "[recording]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "loop.rec";
  // Every 300th measurement is missing for six ticks: a fault, late.
  class Missing final : public HapticDevice {
   public:
    explicit Missing(HapticDevice& device) : device_(device) {}
    Status measure(Measurement& m) noexcept override {
      const Status status = device_.measure(m);
      return ++number_ % 300 >= 294 ? Status::stale : status;
    }
    Status actuate(const Command& command) noexcept override { return device_.actuate(command); }

   private:
    HapticDevice& device_;
    int number_ = 0;
  };
  const TauMechanism device(test::nominal());
  PositionControlRenderer servo = test::positionControl(device);
  const Scene wall = flatWall();
  SimulatedDevice simulated(device, {}, test::handAt(-1e-3, 1000.0, 5.0));
  Missing missing(simulated);
  HapticTick tick(device, wall, Tool(), servo, 1e-3);
  Recorder recorder(file, {}, tick);
  HapticLoopOptions options;
  options.sink = &recorder;
  std::uint64_t resets = 0;
  {
    LoopBody loop(missing, tick, options);
    for (int i = 0; i < 2000; ++i) {
      (void)loop.step();
      if (i % 300 != 50 || tick.guard().fault() == GuardReason::none) continue;
      loop.reset();
      ++resets;
    }
  }
  const RecordingResult result = recorder.close();
  CHECK(result.ticks > 1900);
  CHECK(resets >= 3);
  for (const std::uint64_t from : {0u, 4u}) {
    RecordingReader reader(file);
    HapticTick again(device, wall, Tool(), servo, reader.header().guard);
    const ReplayResult replay = enamel::replay(reader, again, from);
    INFO((replay.first ? replay.first->what : ""));
    CHECK(replay.different == 0);
    CHECK(replay.ticks + replay.restored == result.ticks - from * kChunkTicks);
  }
}

TEST_CASE("recording: a disk that takes nothing for a while holds up no tick", "[recording]") {
  Rig rig;
  std::atomic<bool> waits{false};
  Recorder recorder(
      [&](const char*, std::size_t size) {
        while (waits) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return std::min<std::size_t>(size, 20000);
      },
      "slow", {}, rig.tick);
  waits = true;
  rig.run(recorder, 20000);                            // the recording ends, but the disk still blocks
  CHECK(recorder.lost() == 20000 - 31 * kChunkTicks);  // capacity of the ring
  waits = false;
  const RecordingResult result = recorder.close();
  CHECK(result.problem.empty());
  CHECK(result.ticks + result.lost == 20000);
}

TEST_CASE("recording: read while it is written, and to the last whole chunk once it was cut", "[recording]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "a.rec", cut = folder / "cut.rec";
  Rig rig;
  Recorder recorder(file, {}, rig.tick);
  std::atomic<bool> done{false};
  std::uint64_t ticks = 0, wrong = 0;
  std::thread reads([&] {
    while (!done) {
      RecordingReader reader(file);
      RecordedChunk chunk;
      std::uint64_t now = 0;
      for (std::uint64_t i = 0; i < reader.chunks(); ++i) {
        const std::string problem = reader.read(i, chunk);
        if (problem.empty())
          now += chunk.ticks.size();
        else
          wrong += i + 1 < reader.chunks() || problem.find("cut off") == problem.npos;
      }
      wrong += now < ticks;
      ticks = now;
    }
  });
  for (int i = 0; i < 60; ++i) {
    rig.run(recorder, 32);
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  CHECK(recorder.close().ticks == 60 * 32);
  done = true;
  reads.join();
  CHECK(wrong == 0);

  const std::string bytes = test::readFile(file);
  const std::size_t size = chunkSize(rig.tick.stateSize()), begin = kHead + wordAt(bytes, 12);
  test::Random random(5);
  const int cuts = test::count(200, 5000);
  for (int i = 0; i < cuts; ++i) {
    const std::size_t length = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(bytes.size())));
    test::writeFile(cut, bytes.substr(0, length));
    if (length < begin) {
      CHECK_THROWS_AS(RecordingReader(cut), ConfigurationError);
      continue;
    }
    RecordingReader reader(cut);
    RecordedChunk chunk;
    std::size_t whole = 0;
    for (std::uint64_t k = 0; k < reader.chunks(); ++k) whole += reader.read(k, chunk).empty();
    CHECK(whole == (length - begin) / size);
  }
}

TEST_CASE("recording: a changed file is refused or read, within memory and time", "[recording]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "changed.rec", good = recorded(folder, 300);
  const std::size_t size = chunkSize(Rig().tick.stateSize()), begin = kHead + wordAt(good, 12);
  test::Random random(11);
  const auto pick = [&random](std::size_t n) {
    return std::min(static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(n))), n - 1);
  };
  const std::vector<std::string> words = {"-1", "1e999", "null", "\"", "[", "{", "4294967295", "0", "1048576", "true"};
  int refused = 0, readable = 0, changed = 0;
  std::uint64_t most = 0;
  const int files = test::longRun() ? 100000 : 1000;
  for (int i = 0; i < files; ++i) {
    std::string bytes = good;
    const bool inHeader = pick(3) == 0;
    for (std::size_t changes = 1 + pick(4); changes > 0; --changes) {
      const std::size_t at = inHeader ? pick(begin) : begin + pick(std::max<std::size_t>(1, bytes.size() - begin));
      if (at >= bytes.size()) break;
      switch (pick(6)) {
        case 0: bytes[at] = static_cast<char>(pick(256)); break;
        case 1: bytes.erase(at, 1 + pick(400)); break;
        case 2: bytes.insert(at, words[pick(words.size())]); break;
        case 3: bytes.insert(at, bytes.substr(pick(bytes.size()), pick(400))); break;
        case 4: {
          const double number = test::garbage(random);
          std::memcpy(bytes.data() + (bytes.size() - at >= 8 ? at : bytes.size() - 8), &number, 8);
          break;
        }
        default: bytes.resize(at); break;
      }
      if (bytes.size() < 8) break;
    }
    // Half of them with valid checksums, to find errors that a checksum would hide.
    if (pick(2) == 0 && bytes.size() > kHead) {
      if (inHeader) setWord(bytes, 12, static_cast<std::uint32_t>(wordAt(good, 12) + bytes.size() - good.size()));
      const std::size_t text = std::min<std::size_t>(wordAt(bytes, 12), bytes.size() - kHead);
      setWord(bytes, 16, crc32(std::string_view(bytes).substr(kHead, text)));
      for (std::size_t at = kHead + text; at + kChunkHead <= bytes.size(); at += size) {
        const std::size_t ticks = wordAt(bytes, at + 24);
        const std::size_t length = size - (kChunkTicks - std::min(ticks, kChunkTicks)) * kTick;
        if (at + length > bytes.size()) break;
        setWord(bytes, at + 4, crc32(std::string_view(bytes).substr(at + 8, length - 8)));
      }
    }
    test::writeFile(file, bytes);
    try {
      const ReplayResult result = replayed(file);
      ++readable;
      changed += result.different > 0;
      most = std::max(most, result.ticks);
    } catch (const Error&) {
      ++refused;
    }
  }
  CHECK(most <= 400);
  CHECK(refused > files / 20);
  CHECK(readable > files / 20);
  CHECK(changed > files / 100);
}

TEST_CASE("recording: a tick takes any state, and its command stays within the limits", "[recording]") {
  Rig rig;
  for (int i = 0; i < 50; ++i, ++rig.number) (void)rig.step();
  std::vector<char> good(rig.tick.stateSize()), state = good;
  rig.tick.saveState(good.data());
  test::Random random(3);
  int beyond = 0, stopped = 0;
  const int states = test::count(5000, 100000);
  for (int i = 0; i < states; ++i) {
    state = good;
    for (int change = 0; change < 1 + i % 5; ++change) {
      const double number = i % 2 == 0 ? test::garbage(random) : std::floor(random.uniform(-3.0, 30.0));
      const std::size_t at = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(state.size() / 8)));
      std::memcpy(state.data() + 8 * at, &number, 8);
    }
    rig.tick.loadState(state.data());
    for (int k = 0; k < 3; ++k, ++rig.number) {
      stopped += rig.step() != Status::ok;
      for (int j = 0; j < 6; ++j) beyond += !(std::abs(rig.command.effort[j]) <= rig.tick.guard().options().torque[j]);
    }
    if (i % 10 == 0) rig.number = 50;
  }
  CHECK(beyond == 0);
  CHECK(stopped > 0);
  rig.tick.loadState(good.data());
  rig.tick.saveState(state.data());
  CHECK(state == good);
}

}  // namespace enamel::test_recording
