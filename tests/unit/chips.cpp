// Chips of a bur: in proportion to the cut volume, from its rim, for a while, and the same ones every time.
#include "chips.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "support/catch.hpp"

namespace enamel::viewer::test_chips {

namespace {

constexpr double kRadius = 1e-3, kFrame = 1.0 / 60.0;
const Vec3 kMouth(0.01, -0.02, 0.005), kAxis = Vec3(1.0, 2.0, 2.0) / 3.0;

RemovedVolume cutOf(int chips, std::size_t layer) {
  RemovedVolume cut{};
  cut[layer] = chips * Chips::kVolume;
  return cut;
}

void advance(Chips& chips, double seconds, const RemovedVolume& cut = {}) {
  chips.advance(seconds, cut, kMouth, kAxis, kRadius);
}

int flying(const Chips& chips, int layer) {
  return static_cast<int>(std::count_if(chips.chips().begin(), chips.chips().end(), [layer](const Chips::Chip& chip) {
    return chip.age < Chips::kLife && chip.layer == layer;
  }));
}

}  // namespace

TEST_CASE("as many chips fly as was cut of each layer, until they are old", "[chips]") {
  Chips chips;
  advance(chips, kFrame);
  CHECK(flying(chips, 0) == 0);
  RemovedVolume cut = cutOf(20, 0);
  cut[1] = 7.4 * Chips::kVolume;
  advance(chips, kFrame, cut);
  CHECK(flying(chips, 0) == Approx(20).margin(1));
  CHECK(flying(chips, 1) == 7);
  cut = cutOf(0, 0);
  cut[1] = 0.7 * Chips::kVolume;  // the remainder of the last cut counts
  advance(chips, kFrame, cut);
  CHECK(flying(chips, 1) == 8);
  advance(chips, Chips::kLife - 2.5 * kFrame);
  CHECK(flying(chips, 1) > 0);
  advance(chips, 2.5 * kFrame);
  CHECK(flying(chips, 0) + flying(chips, 1) == 0);
  advance(chips, 0.5 * Chips::kLife, cutOf(100000, 2));
  CHECK(flying(chips, 2) == static_cast<int>(Chips::kPool));
}

TEST_CASE("chips leave the rim of the bur, out of the hole, and fall", "[chips]") {
  Chips chips;
  advance(chips, 0.0, cutOf(200, 0));
  const Chips at = chips;
  for (std::size_t i = 0; i < 199; ++i) {
    const Chips::Chip& chip = at.chips()[i];
    CHECK((chip.position - kMouth).norm() == Approx(kRadius));
    CHECK(std::abs(kAxis.dot(chip.position - kMouth)) < 1e-12);
    CHECK(kAxis.dot(chip.velocity) >= 0.0);
    CHECK(kAxis.cross(chip.position - kMouth).dot(chip.velocity) > 0.0);  // in the direction of rotation
    CHECK(chip.age == 0.0);
  }
  // A parabola, for any number of steps.
  Chips other = at;
  advance(chips, 0.2);
  for (int i = 0; i < 4; ++i) advance(other, 0.05);
  for (std::size_t i = 0; i < 199; ++i) {
    const Vec3 fall(0.0, -0.5 * Chips::kGravity * 0.04, 0.0);
    const Vec3 expected = at.chips()[i].position + 0.2 * at.chips()[i].velocity + fall;
    CHECK((chips.chips()[i].position - expected).norm() < 1e-12);
    CHECK((other.chips()[i].position - expected).norm() < 1e-12);
  }
}

TEST_CASE("the same cuts throw the same chips; while time stands still, nothing moves", "[chips]") {
  Chips a, b;
  const auto same = [&] {
    return std::equal(a.chips().begin(), a.chips().end(), b.chips().begin(),
                      [](const Chips::Chip& x, const Chips::Chip& y) {
                        return x.position == y.position && x.velocity == y.velocity && x.age == y.age;
                      });
  };
  for (int i = 0; i < 30; ++i)
    for (Chips* chips : {&a, &b}) advance(*chips, kFrame, cutOf(i, static_cast<std::size_t>(i % 3)));
  CHECK(same());
  for (int i = 0; i < 5; ++i) advance(a, 0.0);
  CHECK(same());
  advance(a, kFrame);
  CHECK_FALSE(same());
}

}  // namespace enamel::viewer::test_chips
