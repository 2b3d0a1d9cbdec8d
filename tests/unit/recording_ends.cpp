// Recordings that end without close(): processes that were killed, pipes whose reader has gone.
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "support/eventually.hpp"
#include "support/recording_rig.hpp"

namespace enamel::test_recording_ends {

using namespace test::recording_rig;

TEST_CASE("recording: of a process that was killed all whole chunks are read", "[recording_ends]") {
  const test::TemporaryFolder folder;
  const std::string file = folder / "killed.rec";
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    Rig rig;
    Recorder recorder(file, {}, rig.tick);
    while (true) {
      recorder.makeRoom();
      rig.run(recorder, 16);
      usleep(1000);
    }
  }
  const auto size = [&] { return std::filesystem::exists(file) ? std::filesystem::file_size(file) : 0; };
  CHECK(test::eventually([&] { return size() >= 200000; }));
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  RecordingReader reader(file);
  const std::uint64_t whole = (std::filesystem::file_size(file) - kHead - wordAt(test::readFile(file), 12)) /
                              chunkSize(reader.header().stateSize);
  CHECK(whole >= 3);
  const ReplayResult result = replayed(file);
  CHECK(result.ticks == whole * kChunkTicks);
  CHECK(result.different == 0);
  CHECK_FALSE(result.closed);
}

TEST_CASE("recording: a pipe whose reader has gone ends the recording, not the process", "[recording_ends]") {
  const test::TemporaryFolder folder;
  const std::string pipe = folder / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  Rig rig;
  Recorder recorder(pipe, {}, rig.tick);
  ::close(reader);
  rig.run(recorder, 300);
  const RecordingResult result = recorder.close();
  CHECK(result.lost == 300);
  CHECK_THAT(result.problem, test::ContainsSubstring("pipe: cannot write the recording: Broken pipe"));
}

}  // namespace enamel::test_recording_ends
