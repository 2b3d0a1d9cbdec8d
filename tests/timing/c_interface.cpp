// Cost of a session, and of its C interface, over the haptic tick alone: medians of alternating blocks of ticks.
#include <algorithm>
#include <array>
#include <chrono>
#include <vector>

#include "enamel/c/enamel.h"
#include "enamel/device/device_file.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "enamel/session/session.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test_c_interface {

namespace {

constexpr int kBlocks = 40, kTicks = 500;
using Clock = std::chrono::steady_clock;

double medianOf(std::vector<double>& times) {
  std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
  return times[times.size() / 2];
}

}  // namespace

TEST_CASE("a session costs little more than its tick, and the C interface little more than a session", "[timing]") {
  const auto mechanism = makeMechanism(DeviceParameters(test::nominal()));
  const Scene wall = flatWall();
  const auto renderer = makeLinked(kPositionControl, {}, mechanism, 1e-3);
  HapticTick tick(*mechanism, wall, Tool{}, *renderer, 1e-3);

  SessionObstacle obstacle;
  static_cast<Obstacle&>(obstacle) = wall.obstacles()[0];
  Session session{SessionDef{}};
  (void)session.add(obstacle);

  EnamelSessionDef def;
  REQUIRE(enamel_session_defaults(&def) == ENAMEL_OK);
  EnamelSession* handle = nullptr;
  REQUIRE(enamel_session_create(&def, &handle, {nullptr, 0}) == ENAMEL_OK);
  EnamelObstacleDef plate;
  REQUIRE(enamel_obstacle_defaults(&plate) == ENAMEL_OK);
  plate.name = "wall";
  EnamelObstacle id;
  REQUIRE(enamel_add(handle, &plate, &id) == ENAMEL_OK);

  const Kinematics& home = mechanism->home();
  Measurement measurement;
  measurement.q = home.q;
  measurement.rates = home.rates;
  EnamelMeasurement plain{};
  plain.size = sizeof plain;
  plain.enabled = 1;
  std::copy_n(home.q.data(), 6, plain.q);

  Command command;
  double effort[ENAMEL_MAX_JOINTS];
  std::array<std::vector<double>, 3> times;
  int failures = 0;
  for (int block = 0; block < kBlocks; ++block)
    for (std::size_t way = 0; way < times.size(); ++way)
      for (int i = 0; i < kTicks; ++i) {
        measurement.time = plain.time = 1e-3 * (block * kTicks + i);
        const auto begin = Clock::now();
        if (way == 0) failures += tick(measurement, command) != Status::ok ? 1 : 0;
        if (way == 1) failures += session.tick(measurement, command) != Status::ok ? 1 : 0;
        if (way == 2) failures += enamel_tick(handle, &plain, effort) != ENAMEL_OK ? 1 : 0;
        times[way].push_back(std::chrono::duration<double>(Clock::now() - begin).count());
      }
  CHECK(failures == 0);
  CHECK(session.snapshot().contacts.count == 1);
  const double alone = medianOf(times[0]), cpp = medianOf(times[1]), c = medianOf(times[2]);
  CAPTURE(1e6 * alone, 1e6 * cpp, 1e6 * c);
  WARN("whole tick " << 1e6 * alone << " us, session " << 1e6 * cpp << " us, C interface " << 1e6 * c << " us");
  CHECK(cpp < 1.5 * alone);
  CHECK(c < 1.15 * cpp);  // 0.3 us where a tick takes 2 us
  enamel_session_destroy(handle);
}

}  // namespace enamel::test_c_interface
