// Expected performance of position control on a device.
#include "enamel/study/expectation.hpp"

#include <algorithm>

#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test_expectation {

namespace {

const std::vector<WallExpectation>& light() {
  static const auto once = expectWall(loadDevice(test::deviceFile("cartesian-3.toml")), 1e-3, 2, 2);
  return once;
}

double gainOf(const WallExpectation& e, const std::string& name) {
  const auto found = std::find_if(e.changes.begin(), e.changes.end(), [&](const auto& c) { return c.name == name; });
  REQUIRE(found != e.changes.end());
  return found->gain;
}

}  // namespace

TEST_CASE("a wall is expected to be softer and less safe with a delay, and nothing is lost", "[expectation]") {
  REQUIRE(light().size() == 3);
  const double largest = makeMechanism(loadDevice(test::deviceFile("cartesian-3.toml")))->limits().effort.maxCoeff();
  for (const WallExpectation& e : light()) {
    CHECK(e.lost == 0);
    CHECK(e.stiffness.mean > 1e3);
    CHECK(e.chatter > 0.0);
    CHECK(e.safePush > 0.3 * largest);
    CHECK(e.safePush < largest);
    CHECK(std::is_sorted(e.changes.begin(), e.changes.end(),
                         [](const auto& a, const auto& b) { return a.gain > b.gain; }));
  }
  for (std::size_t d = 1; d < light().size(); ++d) {
    CHECK(light()[d].delay == static_cast<int>(d));
    CHECK(light()[d].stiffness.mean < light()[d - 1].stiffness.mean);
    CHECK(light()[d].safePush <= light()[d - 1].safePush);  // its search has steps
  }
  CHECK(light().back().safePush < light().front().safePush);
}

TEST_CASE("a better device does what was said of it", "[expectation]") {
  DeviceParameters device = loadDevice(test::deviceFile("cartesian-3.toml"));
  std::get<CartesianParameters>(device).positionStep *= 0.5;
  const double gain = gainOf(light()[0], "half the encoder step");
  CHECK(gain > 0.2);
  CHECK(expectWall(device, 1e-3, 0, 1)[0].stiffness.mean ==
        Approx((1.0 + gain) * light()[0].stiffness.mean).epsilon(0.05));  // the gain excludes runs lost after 0.15 s
  CHECK(gainOf(light()[1], "a tick less of delay") ==
        Approx(light()[0].stiffness.mean / light()[1].stiffness.mean - 1.0).margin(0.05));
}

TEST_CASE("an expectation does not depend on the threads", "[expectation]") {
  const auto alone = expectWall(loadDevice(test::deviceFile("cartesian-3.toml")), 1e-3, 1, 1);
  for (std::size_t i = 0; i < alone.size(); ++i) {
    CHECK(alone[i].stiffness.mean == light()[i].stiffness.mean);
    CHECK(alone[i].safePush == light()[i].safePush);
    CHECK(alone[i].changes.size() == light()[i].changes.size());
    for (std::size_t c = 0; c < alone[i].changes.size(); ++c)
      CHECK(alone[i].changes[c].gain == light()[i].changes[c].gain);
  }
}

TEST_CASE("cables limit a device that has them", "[expectation]") {
  const auto soft = expectWall(loadDevice(test::deviceFile("delta.toml")), 1e-3, 0, 1);
  CHECK(gainOf(soft[0], "cables twice as stiff") > 0.2);
}

}  // namespace enamel::test_expectation
