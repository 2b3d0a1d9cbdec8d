// Playing recordings without a window: the frames equal those of the run, however they are reached. Steps, ends, lost
// ticks, files that were cut or damaged.
#include "player.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <optional>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/runtime/recorder.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "support/disk.hpp"
#include "support/eventually.hpp"
#include "support/run_length.hpp"

namespace enamel::viewer::test_player {

namespace {

// A recording of a tool on springs that moves in and out of a wall, with the run's own values.
struct Run {
  explicit Run(const std::string& scene = "flat-wall.toml") {
    header.deviceFile = test::deviceFile("cartesian-6.toml");
    header.deviceText = readFile(header.deviceFile);
    header.sceneFile = ENAMEL_SOURCE_DIR "/data/scenes/" + scene;
    header.sceneText = readFile(header.sceneFile);
    header.renderer = "impedance";
    file = loadScene(header.sceneFile);
    header.start.position = file.start;
    header.files = meshChecksum(file.scene);
    device = makeMechanism(loadDevice(header.deviceFile));
    spring.emplace(ImpedanceOptions{2000.0, 5.0});
    tick.emplace(*device, file.scene, file.tool, *spring, 1e-3, header.start);
  }

  void run(Recorder& recorder, int ticks) {
    for (int i = 0; i < ticks; ++i, ++number) {
      const double t = 1e-3 * static_cast<double>(number);
      Pose pose = header.start;
      pose.position +=
          Vec3(0.002 * std::sin(3.0 * t), 0.0, -0.5 * (file.start.z() + 0.001) * (1.0 - std::cos(18.0 * t)));
      Kinematics k;
      REQUIRE(device->reach(pose, Vec6::Zero(), false, k) == Status::ok);
      Measurement measurement;
      measurement.time = t;
      measurement.q = number == broken ? JointVector(std::nan("") * k.q) : k.q;
      measurement.rates = k.rates;
      Command command;
      const Status status = (*tick)(measurement, command);
      recorder.add(number, measurement, *tick, command, status);
      poses.push_back(tick->frame().kinematics.pose);
      contacts.push_back(tick->frame().contacts.count);
      forces.push_back(tick->frame().output.normalForce);
      commands.push_back(command.effort);
      reasons.push_back(tick->frame().reason);
    }
  }

  RecordingHeader header;
  SceneFile file;
  std::shared_ptr<const Mechanism> device;
  std::optional<ImpedanceRenderer> spring;
  std::optional<HapticTick> tick;
  std::uint64_t number = 0, broken = UINT64_MAX;
  std::vector<Pose> poses;
  std::vector<int> contacts;
  std::vector<double> forces;
  std::vector<JointVector> commands;
  std::vector<GuardReason> reasons;
};

void record(Run& run, const std::string& file, int ticks) {
  Recorder recorder(file, run.header, *run.tick);
  for (int done = 0; done < ticks; done += 64) {  // half a chunk
    recorder.makeRoom();
    run.run(recorder, std::min(64, ticks - done));
  }
  REQUIRE(recorder.close().problem.empty());
}

bool sameFrame(const Frame& frame, const Run& run) {
  const std::uint64_t i = frame.record.tick;
  return frame.record.pose.position == run.poses[i].position && frame.record.pose.rotation == run.poses[i].rotation &&
         frame.contacts.count == run.contacts[i] && frame.record.command == run.commands[i] &&
         frame.record.guard == run.reasons[i] &&
         (run.reasons[i] != GuardReason::none || frame.record.normalForce == run.forces[i]);
}

long residentKilobytes() {
  long total = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> total >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

bool noted(const Player& player, const std::string& text) {
  for (const std::string& note : player.notes())
    if (note.find(text) != std::string::npos) return true;
  return false;
}

}  // namespace

TEST_CASE("player: the frames of a run, bit for bit, forwards, backwards and at random", "[player]") {
  for (const char* scene : {"flat-wall.toml", "molar.toml"}) {
    INFO(scene);
    const test::TemporaryFolder folder;
    Run run(scene);
    record(run, folder / "run.rec", 600);
    Player player(folder / "run.rec");
    CHECK(player.size() == 600);
    CHECK(player.notes().empty());
    CHECK(player.scene().name == run.file.name);
    CHECK(player.stretches().size() == 5);
    int same = 0, touching = 0;
    for (int i = 0; i < 600; ++i, player.step(1)) {
      REQUIRE(player.frame().record.tick == static_cast<std::uint64_t>(i));
      same += sameFrame(player.frame(), run);
      touching += player.frame().record.mode == RenderMode::contact;
    }
    CHECK(same == 600);
    CHECK(touching > 50);
    CHECK(player.position() == 599);  // the last step changed nothing
    same = 0;
    for (int i = 0; i < 100; ++i, player.step(-1)) same += sameFrame(player.frame(), run);
    CHECK(same == 100);
    CHECK(player.position() == 499);
    player.seek(1.0);
    for (int i = 0; i < 3; ++i) player.step(-1);
    CHECK(player.position() == 0);
    test::Random random(2101);
    same = 0;
    for (int i = 0; i < 50; ++i) {
      player.seek(random.uniform(0.0, 600.0));
      same += sameFrame(player.frame(), run);
    }
    CHECK(same == 50);
    // Every event on the way is a touch after a while without one, and the way back leads to the first.
    player.seek(0.0);
    std::size_t events = 0;
    for (; player.jump(true); ++events) {
      const std::uint64_t at = player.position();
      CHECK(player.frame().record.mode == RenderMode::contact);
      player.step(-1);
      CHECK(player.frame().record.mode == RenderMode::free);
      player.seek(static_cast<double>(at));
    }
    CHECK(events == player.events().size());
    CHECK(events > 0);
    while (player.jump(false)) --events;
    CHECK(events == 1);
    CHECK(player.position() == player.events()[0].position);

    // The charts' samples are those of the same ticks; before the first and after the last they are missing.
    const std::vector<Sample> samples = player.samples(-100, 800);
    REQUIRE(samples.size() == 800);
    CHECK(std::isnan(samples[99].gap));
    CHECK(std::isnan(samples[700].normalForce));
    same = 0;
    for (std::size_t i = 0; i < 600; ++i)
      same += samples[i + 100].position == run.poses[i].position && samples[i + 100].torque == run.commands[i];
    CHECK(same == 600);
  }
}

TEST_CASE("player: time, speed, steps and both ends", "[player]") {
  const test::TemporaryFolder folder;
  Run run;
  record(run, folder / "run.rec", 700);
  Player player(folder / "run.rec");
  CHECK_FALSE(player.playing());
  player.advance(1.0);
  CHECK(player.position() == 0);
  player.setPlaying(true);
  CHECK_FALSE(player.frame().paused);
  player.advance(0.1);
  CHECK(player.position() == 100);
  CHECK(player.seconds() == Approx(0.1));
  player.setSpeed(0.01);
  for (int i = 0; i < 60; ++i) player.advance(1.0 / 60.0);  // one second of pictures: 10 ticks, none of them skipped
  CHECK(std::abs(player.seconds() - 0.11) < 1e-9);
  player.setSpeed(1000.0);
  CHECK(player.speed() == Player::kFastest);
  player.setSpeed(0.0);
  CHECK(player.speed() == Player::kSlowest);
  player.setSpeed(10.0);
  player.advance(0.05);
  CHECK(player.position() >= 609);
  CHECK(player.position() <= 610);
  player.advance(1.0);
  CHECK(player.position() == 699);
  CHECK_FALSE(player.playing());
  player.setPlaying(true);  // at the end it starts again
  CHECK(player.position() == 0);
  player.step(100);
  CHECK(player.position() == 100);
  CHECK_FALSE(player.playing());
  player.step(-101);
  CHECK(player.position() == 0);
  player.step(100000);
  CHECK(player.position() == 699);
  player.seek(-5.0);
  CHECK(player.position() == 0);
  player.seek(1e300);
  CHECK(player.position() == 699);
}

TEST_CASE("player: ticks that were lost and chunks that are damaged are gaps", "[player]") {
  const test::TemporaryFolder folder;
  Run run;
  // The disk is full until the recorder has lost ticks.
  test::Disk disk(20000);
  Recorder recorder([&](const char* bytes, std::size_t size) { return disk.write(bytes, size); }, "a disk", run.header,
                    *run.tick);
  run.run(recorder, 5000);
  const std::uint64_t kept = 5000 - recorder.lost();
  REQUIRE(recorder.lost() > 500);
  disk.setRoom(std::size_t{1} << 30);
  REQUIRE(test::eventually([&] { return disk.content().size() > 200000; }));
  run.run(recorder, 500);
  const RecordingResult result = recorder.close();
  REQUIRE(result.problem.empty());
  test::writeFile(folder / "full.rec", disk.content());
  {
    Player player(folder / "full.rec");
    CHECK(player.size() == 5500);
    CHECK(noted(player, std::to_string(result.lost) + " ticks lost"));
    player.seek(static_cast<double>(kept) - 1.0);
    CHECK(player.gap() == 0);
    CHECK(player.frame().record.tick == kept - 1);
    player.seek(static_cast<double>(kept));
    CHECK(player.gap() == result.lost);
    CHECK(player.frame().record.tick == kept - 1);  // the last tick seen
    CHECK(std::isnan(player.samples(static_cast<std::int64_t>(kept), 1)[0].gap));
    player.step(-1);
    CHECK(player.frame().record.tick == kept - 1);
    player.step(1);  // over the gap
    CHECK(player.gap() == 0);
    CHECK(player.frame().record.tick == kept + result.lost);
    CHECK(sameFrame(player.frame(), run));
    player.step(-1);
    CHECK(player.frame().record.tick == kept - 1);
    player.setPlaying(true);  // through the gap, with its duration
    player.advance(1e-3 * static_cast<double>(result.lost));
    CHECK(player.gap() > 0);
    player.advance(2.5e-3);
    CHECK(player.gap() == 0);
  }

  // The third chunk is damaged, and the file is cut within its last one.
  Run other;
  record(other, folder / "cut.rec", 1000);
  std::string bytes = test::readFile(folder / "cut.rec");
  const std::size_t last = 32 + 344 * (1000 - 7 * kChunkTicks);
  const std::size_t chunk =
      32 + (RecordingReader(folder / "cut.rec").header().stateSize + 7) / 8 * 8 + 344 * kChunkTicks;
  std::uint32_t header;
  std::memcpy(&header, bytes.data() + 12, sizeof(header));
  bytes[24 + header + 2 * chunk + 5000] ^= 1;
  bytes.resize(bytes.size() - last / 2);
  test::writeFile(folder / "cut.rec", bytes);
  Player player(folder / "cut.rec");
  CHECK(player.size() == 7 * kChunkTicks);
  CHECK(player.stretches().size() == 6);
  CHECK(noted(player, "not closed"));
  CHECK(noted(player, "cut off"));
  CHECK(noted(player, "1 chunk cannot be read: chunk 2"));
  player.seek(3.0 * kChunkTicks - 1.0);
  CHECK(player.gap() == kChunkTicks);
  player.step(1);
  CHECK(player.frame().record.tick == 3 * kChunkTicks);
  CHECK(sameFrame(player.frame(), other));
  player.step(-1);
  CHECK(player.frame().record.tick == 2 * kChunkTicks - 1);
}

TEST_CASE("player: what is no recording, of another device, without ticks, not finite", "[player]") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_WITH(Player("/no/such/file"), test::ContainsSubstring("/no/such/file: cannot open the file"));
  test::writeFile(folder / "text.rec", "no recording at all, but long enough to have a head");
  CHECK_THROWS_WITH(Player(folder / "text.rec"), test::ContainsSubstring("is not a recording"));
  Run empty;
  record(empty, folder / "empty.rec", 0);
  CHECK_THROWS_WITH(Player(folder / "empty.rec"), test::ContainsSubstring("has no tick that can be read"));
  Run other;
  other.header.deviceText = readFile(test::deviceFile("delta.toml"));
  record(other, folder / "other.rec", 10);
  CHECK_THROWS_WITH(Player(folder / "other.rec"), test::ContainsSubstring("the device has 3 joints, its ticks have 6"));
  Run mixed;
  mixed.header.sceneText = readFile(ENAMEL_SOURCE_DIR "/data/scenes/corner.toml");
  record(mixed, folder / "mixed.rec", 10);
  CHECK_THROWS_WITH(Player(folder / "mixed.rec"),
                    test::ContainsSubstring("the size of its states does not match the scene"));
  Run changed;
  changed.header.files = 1;
  record(changed, folder / "changed.rec", 10);
  CHECK(noted(Player(folder / "changed.rec"), "has changed"));

  Run broken;
  broken.broken = 300;
  record(broken, folder / "broken.rec", 500);
  Player player(folder / "broken.rec");
  CHECK(noted(player, "1 tick with values that are not finite"));
  player.seek(300.0);
  const Frame& frame = player.frame();
  CHECK(frame.record.status == Status::notFinite);
  CHECK(frame.record.pose.position == broken.poses[299].position);  // the last known position of the tool
  CHECK(std::isfinite(frame.record.normalForce));
  player.seek(0.0);
  while (player.jump(true) && player.position() < 300) continue;
  CHECK(player.frame().record.guard == GuardReason::measurement);
  CHECK(std::isnan(player.samples(300, 1)[0].gap));
  CHECK(std::isfinite(player.samples(301, 1)[0].gap));
  std::filesystem::resize_file(folder / "broken.rec", 20000);  // by another program
  player.seek(450.0);
  CHECK_THROWS_WITH(player.frame(), test::ContainsSubstring("broken.rec: the file changed while it was played"));
}

// ENAMEL_LONG=1: ten minutes. Times and memory are only reported.
TEST_CASE("player: any place of a long recording", "[player]") {
  const test::TemporaryFolder folder;
  const int ticks = test::count(2000, 600000);
  Run run;
  record(run, folder / "long.rec", ticks);
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto ms = [](auto from, auto to) { return std::chrono::duration<double, std::milli>(to - from).count(); };
  const long before = residentKilobytes();
  const auto begin = now();
  Player player(folder / "long.rec");
  const double opening = ms(begin, now());
  REQUIRE(player.size() == static_cast<std::uint64_t>(ticks));
  test::Random random(2102);
  std::vector<double> frame, all;
  int same = 0;
  for (int i = 0; i < 50; ++i) {
    player.seek(random.uniform(0.0, static_cast<double>(ticks)));
    const auto from = now();
    same += sameFrame(player.frame(), run);
    frame.push_back(ms(from, now()));
    (void)player.samples(static_cast<std::int64_t>(player.position()) - 1500, 3000);
    all.push_back(ms(from, now()));
  }
  CHECK(same == 50);
  std::sort(frame.begin(), frame.end());
  std::sort(all.begin(), all.end());
  player.seek(0.0);
  player.setSpeed(10.0);
  player.setPlaying(true);
  const auto played = now();
  int pictures = 0;
  for (; player.playing() && pictures < 600; ++pictures) {
    player.advance(1.0 / 60.0);
    (void)player.frame();
    (void)player.samples(static_cast<std::int64_t>(player.position()) - 1500, 3000);
  }
  std::printf(
      "player, %d ticks: opened in %.0f ms, %ld kB more; a place at random: frame %.2f ms, with charts %.1f ms "
      "(median), %.1f ms (largest); played at 10x: %.2f ms a picture\n",
      ticks, opening, residentKilobytes() - before, frame[25], all[25], all.back(), ms(played, now()) / pictures);
}

}  // namespace enamel::viewer::test_player
