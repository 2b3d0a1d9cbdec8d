// Sound through OpenAL without a sound card: with its devices that play to nowhere, into a file, and into a full disk.
#include "sound_output.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/eventually.hpp"
#include "support/skip.hpp"

namespace enamel::viewer::test_sound_output {

namespace {

constexpr BurLoad kFree{2000.0, 0.0, 0.0};

void wait(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

std::string troubleOf(const SoundOutput& output) {
  return test::eventually([&] { return output.trouble() != nullptr; }) ? output.trouble() : "";
}

// For a frequency that is a multiple of 50 Hz, in the window of 20 ms that begins there.
constexpr std::size_t kWindow = BurSound::kRate / 50;
double powerOf(const std::int16_t* samples, double frequency) {
  double c = 0.0, d = 0.0;
  for (std::size_t i = 0; i < kWindow; ++i) {
    const double angle = 2.0 * M_PI * frequency * static_cast<double>(i) / BurSound::kRate;
    c += samples[i] * std::cos(angle);
    d += samples[i] * std::sin(angle);
  }
  return c * c + d * d;
}

// OpenAL selects its driver once per process.
template <typename Function>
bool inChild(const std::string& configuration, const Function& passes) {
  const test::TemporaryFolder folder;
  test::writeFile(folder / "openal.conf", configuration);
  const pid_t child = fork();
  if (child == 0) {
    unsetenv("ALSOFT_DRIVERS");
    setenv("ALSOFT_CONF", (folder / "openal.conf").c_str(), 1);
    _exit(passes() ? 0 : 1);
  }
  int status = -1;
  return waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

TEST_CASE("a bur is heard where there is a device; without one, or when it goes away, there is only silence",
          "[sound]") {
  const auto troubleIs = [](const char* expected) {
    return [expected] {
      SoundOutput output;
      output.set(kFree);
      return troubleOf(output) == expected;
    };
  };
  if (inChild("drivers = none\n", troubleIs("built without OpenAL"))) return test::skipTest("OpenAL is missing");
  CHECK(inChild("drivers = none\n", troubleIs("no audio device")));
  CHECK(inChild("drivers = wave\n[wave]\nfile = /dev/full\n", troubleIs("the audio device was disconnected")));

  const test::TemporaryFolder folder;
  const std::string file = folder / "bur.wav";
  CHECK(
      inChild("drivers = wave\nsample-type = int16\nchannels = mono\nfrequency = 44100\n[wave]\nfile = " + file + "\n",
              [&file] {
                SoundOutput output;
                output.set(kFree);
                return test::eventually([&] {
                         return std::filesystem::exists(file) && std::filesystem::file_size(file) > 3 * BurSound::kRate;
                       }) &&
                       output.trouble() == nullptr;
              }));
  const std::string wave = test::readFile(file);
  const std::size_t data = wave.find("data");
  REQUIRE(data != std::string::npos);
  std::vector<std::int16_t> samples((wave.size() - data - 8) / 2);
  std::memcpy(samples.data(), wave.data() + data + 8, 2 * samples.size());
  REQUIRE(samples.size() > BurSound::kRate);
  // Only the tone of the rotation, except for gaps when a loaded machine was late.
  int pure = 0;
  for (std::size_t at = 0; at + kWindow <= samples.size(); at += kWindow) {
    const std::int16_t* const window = samples.data() + at;
    pure += powerOf(window, 2000.0) > 100.0 * std::max(powerOf(window, 1900.0), powerOf(window, 2100.0));
  }
  CHECK(pure >= 5);

  setenv("ALSOFT_DRIVERS", "null", 1);
  for (int i = 0; i < 3; ++i) {
    SoundOutput output;
    output.set(kFree);
    wait(0.05);
    CHECK(output.trouble() == nullptr);
  }
}

}  // namespace enamel::viewer::test_sound_output
