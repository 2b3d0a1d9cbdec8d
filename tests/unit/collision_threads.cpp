// Several threads query one const scene, each with its own cache. The results are those of one thread without a cache,
// on every SIMD level. The tsan preset searches for races in the same test.
#include <array>
#include <thread>

#include "enamel/collision/contacts.hpp"
#include "enamel/collision/sweep.hpp"
#include "support/catch.hpp"
#include "support/contacts.hpp"
#include "support/meshes.hpp"

namespace enamel::test_collision_threads {

namespace {

struct Answers {
  SurfacePoint nearest;
  SweepHit sphere, capsule;
  SegmentPoint segment;
  ContactSnapshot contacts;
};

bool isSame(const Answers& a, const Answers& b) {
  return a.nearest.distance == b.nearest.distance && a.nearest.triangle == b.nearest.triangle &&
         a.nearest.normal == b.nearest.normal && a.sphere.time == b.sphere.time && a.capsule.time == b.capsule.time &&
         a.capsule.point == b.capsule.point && a.segment.distance == b.segment.distance &&
         a.segment.triangle == b.segment.triangle && test::areEqual(a.contacts, b.contacts);
}

class Work {
 public:
  Work() : mesh_(std::make_shared<const MeshModel>(test::transformed(test::ball(5, 0.1), 0.01, Vec3::Zero()))) {
    scene_.add({"wavy", mesh_, Pose(), Vec6::Zero(), {}});
    scene_.add({"floor", HalfSpace{}, {Vec3(0, 0, -0.012), Mat3::Identity()}, Vec6::Zero(), {}});
    tool_.parts[0].radius = 0.0005;
    tool_.parts[1] = {{0, 0, 0.001}, {0, 0, 0.005}, 0.0003};
    tool_.parts[2] = {{0, 0, 0.005}, {0, 0, 0.015}, 0.0008};
    tool_.count = 3;
    test::Random random(71);
    Pose pose{{0, 0, 0.0115}, Mat3::Identity()};
    Vec3 direction = Vec3::UnitX();
    for (int i = 0; i < kQueries; ++i) {  // along the surface, rotating, sometimes somewhere else
      direction = (direction + 0.1 * random.direction() - 40.0 * (pose.position.norm() - 0.0108) * pose.position / 0.01)
                      .normalized();
      pose.position += 5e-5 * direction;
      pose.rotation = test::rotationAbout(random.direction(), 0.02) * pose.rotation;
      if (i % 150 == 149) pose = {0.0105 * random.direction(), test::rotationAbout(random.direction(), 2.0)};
      poses_.push_back(pose);
    }
  }

  Answers ask(int i, ToolCache* cache, ProximityCache* point) const {
    const Pose &from = poses_[i], &to = poses_[(i + 1) % kQueries];
    const auto axis = [](const Pose& p) { return Segment{p.position, p.rotation * Vec3(0, 0, 0.005) + p.position}; };
    Answers a;
    a.nearest = signedDistance(*mesh_, from.position, point);
    a.sphere = sweepSphere(*mesh_, from.position, to.position, 0.0005, point);
    a.capsule = sweepCapsule(*mesh_, axis(from), axis(to), 0.0003);
    a.segment = closestToSegment(*mesh_, axis(from));
    if (findContacts(scene_, tool_, from, 1e-4, cache, a.contacts) != Status::ok) a.contacts.count = -1;
    return a;
  }

  ToolCache cache() const { return makeToolCache(scene_, tool_); }

  static constexpr int kQueries = 1200;

 private:
  std::shared_ptr<const MeshModel> mesh_;
  Scene scene_;
  Tool tool_;
  std::vector<Pose> poses_;
};

}  // namespace

TEST_CASE("several threads get the answers that one gets", "[unit]") {
  const Work work;
  std::vector<Answers> alone;
  int touching = 0;
  for (int i = 0; i < Work::kQueries; ++i) {
    alone.push_back(work.ask(i, nullptr, nullptr));
    touching += alone.back().contacts.count > 0;
  }
  CHECK(touching > Work::kQueries / 20);
  const SimdLevel best = simdLevel();
  for (const SimdLevel level : {SimdLevel::baseline, SimdLevel::avx2, SimdLevel::avx512}) {
    if (useSimdLevel(level) != level) continue;
    std::array<int, 4> wrong{};
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&work, &alone, &count = wrong[t], t] {
        ToolCache cache = work.cache();
        ProximityCache point;
        for (int k = 0; k < Work::kQueries; ++k) {
          const int i = (k + 300 * t) % Work::kQueries;
          count += !isSame(work.ask(i, &cache, &point), alone[i]);
        }
      });
    for (std::thread& thread : threads) thread.join();
    CHECK(wrong == std::array<int, 4>{});
  }
  useSimdLevel(best);
}

}  // namespace enamel::test_collision_threads
