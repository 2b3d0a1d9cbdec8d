// Friction of a surface from slides: numbers that only the test knows, from noisy samples.
#include "enamel/identify/surface_friction.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "enamel/collision/material.hpp"
#include "enamel/core/error.hpp"
#include "enamel/sim/push.hpp"
#include "support/catch.hpp"
#include "support/temporary_folder.hpp"

namespace enamel::test_surface_friction {

namespace {

double between(double low, double high, std::uint64_t seed, std::uint32_t run) {
  return low + (high - low) * randomInstant(seed, run);
}

Material surface(std::uint32_t run) {
  Material material;
  material.friction = between(0.2, 0.6, 1, run);
  material.slidingFriction = material.friction * between(0.4, 0.8, 2, run);
  material.stribeck = between(2e-3, 2e-2, 3, run);
  material.viscosity = between(0.1, 2.0, 4, run);
  return material;
}

// Slides from 0.5 to 100 mm/s, to and fro, under 0.5 to 3 N. The noise of the force has a part that lasts.
std::vector<SlideSample> slides(const Material& m, std::uint32_t run, double noise, int count = 4000) {
  std::vector<SlideSample> samples;
  double lasting = 0.0;
  for (int i = 0; i < count; ++i) {
    const auto number = run * 100000 + static_cast<std::uint32_t>(i);
    const double sweep = 0.5 - 0.5 * std::cos(2.0 * M_PI * i / 157.3);
    const double speed = 5e-4 * std::pow(200.0, sweep);
    const double normal = 1.75 + 1.25 * std::sin(2.0 * M_PI * i / 211.7);
    const auto bell = [&](std::uint64_t seed) {  // of unit variance: sum of twelve uniform numbers
      double sum = -6.0;
      for (std::uint64_t k = 0; k < 12; ++k) sum += randomInstant(100 * seed + k, number);
      return sum;
    };
    lasting = 0.9 * lasting + 0.3 * bell(1);
    samples.push_back({speed, normal,
                       normal * m.slidingRatio(speed) + m.viscosity * speed + noise * (0.7 * bell(2) + 0.3 * lasting)});
  }
  return samples;
}

}  // namespace

TEST_CASE("slides without noise give the numbers of the surface", "[surface_friction]") {
  for (std::uint32_t run = 0; run < 20; ++run) {
    const Material truth = surface(run);
    const SurfaceFriction found = fitFriction(slides(truth, run, 0.0));
    CHECK(found.rest.value == Approx(truth.friction).epsilon(1e-3));
    CHECK(found.sliding.value == Approx(truth.slidingFriction).epsilon(1e-3));
    CHECK(found.stribeck.value == Approx(truth.stribeck).epsilon(1e-3));
    CHECK(found.viscosity.value == Approx(truth.viscosity).epsilon(1e-2));
    CHECK(found.error < 1e-4);
    CHECK(found.hidden.empty());
  }
}

TEST_CASE("the intervals of a surface's friction contain the truth", "[surface_friction]") {
  // 95 % of 100 are 95. Fewer than 89 have a probability of 1 %.
  int rest = 0, sliding = 0, stribeck = 0, viscosity = 0;
  constexpr int kRuns = 100;
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    const Material truth = surface(1000 + run);
    const SurfaceFriction found = fitFriction(slides(truth, run, 0.05, 2000));
    const auto contains = [](const Estimate& e, double value) { return e.low <= value && value <= e.high ? 1 : 0; };
    rest += contains(found.rest, truth.friction);
    sliding += contains(found.sliding, truth.slidingFriction);
    viscosity += contains(found.viscosity, truth.viscosity);
    stribeck += found.stribeck.isSeen ? contains(found.stribeck, truth.stribeck) : 0;
  }
  INFO("rest " << rest << ", sliding " << sliding << ", Stribeck " << stribeck << ", viscosity " << viscosity);
  CHECK(std::min(std::min(rest, sliding), std::min(stribeck, viscosity)) >= 89);
}

TEST_CASE("slides without a visible dependence on the speed say so", "[surface_friction]") {
  Material coulomb;
  coulomb.friction = coulomb.slidingFriction = 0.3;
  int seen = 0;
  for (std::uint32_t run = 0; run < 50; ++run) {
    const SurfaceFriction found = fitFriction(slides(coulomb, run, 0.05, 2000));
    if (found.stribeck.isSeen) {
      ++seen;
      continue;
    }
    CHECK(found.rest.value == found.sliding.value);
    CHECK(found.sliding.value == Approx(0.3).margin(0.01));
    CHECK_THAT(found.hidden, test::ContainsSubstring("slower slides would show"));
  }
  CHECK(seen <= 10);
}

TEST_CASE("wrong slides are refused", "[surface_friction]") {
  std::vector<SlideSample> samples = slides(surface(1), 1, 0.0, 200);
  samples[7].normal = 0.0;
  CHECK_THROWS_WITH(fitFriction(samples), test::ContainsSubstring("sample 8 of the slides"));
  samples[7].normal = std::nan("");
  CHECK_THROWS_WITH(fitFriction(samples), test::ContainsSubstring("must be above 0, and all finite"));
  samples.resize(50);
  CHECK_THROWS_WITH(fitFriction(samples), test::ContainsSubstring("there are 50 samples of slides, must be at least"));

  const test::TemporaryFolder folder;
  const std::string file = folder / "slides.csv";
  test::writeFile(file, "speed, normal, friction\n# a remark\n0.01, 2.0, 0.5\n\n0.02 1.5\t0.25\n");
  const std::vector<SlideSample> read = loadSlides(file);
  REQUIRE(read.size() == 2);
  CHECK((read[1].speed == 0.02 && read[1].normal == 1.5 && read[1].tangential == 0.25));
  test::writeFile(file, "0.01, 2.0, 0.5\n0.01, 2.0\n");
  CHECK_THROWS_WITH(loadSlides(file), test::ContainsSubstring("slides.csv:2: must have three numbers"));
  test::writeFile(file, "0.01, 2.0, 0.5\n0.01, 2.0, 0.5, 1\n");
  CHECK_THROWS_WITH(loadSlides(file), test::ContainsSubstring("slides.csv:2: has more than three numbers"));
  test::writeFile(file, "0.01, 2.0, 0.5\nnan, 2.0, 0.5\n");
  CHECK(std::isnan(loadSlides(file)[1].speed));  // fitFriction() refuses it
}

}  // namespace enamel::test_surface_friction
