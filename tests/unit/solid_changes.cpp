// A drawing thread receives every brick as it was at some time, and in the end as it is.
#include "enamel/collision/solid_changes.hpp"

#include <atomic>
#include <chrono>
#include <cstring>
#include <thread>

#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_solid_changes {

namespace {

std::uint64_t hashOf(const BrickSamples& samples) {
  std::uint64_t h = 0;
  for (const float sample : samples) {
    std::uint32_t bits;
    std::memcpy(&bits, &sample, sizeof bits);
    h = (h ^ bits) * 0x9e3779b97f4a7c15u;
    h ^= h >> 29;
  }
  return h;
}

Solid block() {
  return Solid(MeshModel(test::boxMesh(Vec3(2e-3, 2e-3, 1e-3))), {{"enamel", {}, 3.4e9, 0.0, nullptr}}, {1e-4});
}

void cutAnyhow(Solid& solid, test::Random& random) {
  const Vec3 a = random.vector(2e-3), b = a + random.vector(3e-4);
  solid.cut({a, a}, {b, b}, random.uniform(1e-4, 5e-4));
}

}  // namespace

TEST_CASE("solid changes: every brick that another thread takes was there, and none is lost", "[unit]") {
  Solid solid = block();
  const auto bricks = static_cast<std::size_t>(solid.bricks());
  const int ticks = test::count(400, 20000);
  std::vector<std::uint64_t> hashes(bricks * static_cast<std::size_t>(ticks + 1));  // by publish() and brick
  for (std::size_t b = 0; b < bricks; ++b) hashes[b] = hashOf(solid.samples(static_cast<int>(b)));
  std::vector<std::uint64_t> drawn(hashes.begin(), hashes.begin() + static_cast<long>(bricks));
  SolidChanges changes;
  std::atomic<bool> isOver{false};
  int wrong = 0;
  std::atomic<int> takes{0};
  std::uint64_t last = 0;
  std::thread reader([&] {
    BrickChange change;
    for (;;) {
      const bool over = isOver.load();
      if (!changes.take(change)) {
        if (over) return;
        std::this_thread::yield();
        continue;
      }
      const auto brick = static_cast<std::size_t>(change.brick);
      drawn[brick] = hashOf(change.samples);
      wrong += drawn[brick] !=
                   hashes[bricks * std::min<std::size_t>(change.revision, static_cast<std::size_t>(ticks)) + brick] ||
               change.revision < last;
      last = change.revision;
      ++takes;
    }
  });
  test::Random random(2230);
  for (int tick = 1; tick <= ticks; ++tick) {
    if (tick % 10 == 0) solid.mark();
    if (tick % 35 == 0) (void)solid.undo();
    cutAnyhow(solid, random);
    for (std::size_t b = 0; b < bricks; ++b)
      hashes[bricks * static_cast<std::size_t>(tick) + b] = hashOf(solid.samples(static_cast<int>(b)));
    CHECK(changes.publish(solid) == static_cast<std::uint64_t>(tick));
    while (tick == 100 && takes == 0)
      std::this_thread::sleep_for(std::chrono::microseconds(20));  // the reader takes part, however late it is
  }
  for (std::size_t i = 0; i < bricks; ++i) changes.publish(solid), std::this_thread::yield();
  isOver = true;
  reader.join();
  for (BrickChange change; changes.publish(solid), changes.take(change);)
    drawn[static_cast<std::size_t>(change.brick)] = hashOf(change.samples);
  CHECK(wrong == 0);
  CHECK(takes > 100);
  CHECK(std::equal(drawn.begin(), drawn.end(), hashes.end() - static_cast<long>(bricks)));
}

TEST_CASE("solid changes: what finds no room waits", "[unit]") {
  Solid solid = block();
  SolidChanges changes;
  BrickChange change;
  changes.publish(solid);
  CHECK_FALSE(changes.take(change));
  test::Random random(2231);
  std::vector<BrickSamples> drawn;
  for (int brick = 0; brick < solid.bricks(); ++brick) drawn.push_back(solid.samples(brick));
  for (int i = 0; i < 200; ++i) {
    cutAnyhow(solid, random);
    changes.publish(solid, 5);
  }
  int taken = 0, takenAfter = 0;
  for (; changes.take(change); ++taken) drawn[static_cast<std::size_t>(change.brick)] = change.samples;
  CHECK(taken == 256);
  for (; changes.publish(solid, 3), changes.take(change); ++takenAfter)
    drawn[static_cast<std::size_t>(change.brick)] = change.samples;
  CHECK(takenAfter > 10);
  for (int brick = 0; brick < solid.bricks(); ++brick)
    CHECK(drawn[static_cast<std::size_t>(brick)] == solid.samples(brick));
}

}  // namespace enamel::test_solid_changes
