// Moving tools: all touches are found, none is invented, and the first touch is the first.
#include "enamel/collision/sweep.hpp"

#include <Eigen/QR>
#include <cstdio>

#include "collision/mesh_data.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_sweep {

namespace {

std::vector<test::NamedMesh> sweepMeshes() {
  std::vector<test::NamedMesh> all = test::soundMeshes();
  for (auto& mesh : test::brokenMeshes())
    if (mesh.name != "one point") all.push_back(std::move(mesh));
  return all;
}

// Brute force in extended precision by another method: least squares of segment and triangle in (t, u, v), free and
// with every combination of sides of the domain fixed. Places outside are moved into the domain, which never gives too
// small a distance.
long double distanceToTriangle(const Segment& segment, const std::array<Vec3, 3>& corner) {
  using Vec = Eigen::Matrix<long double, 3, 1>;
  const Vec a = segment.a.cast<long double>(), way = segment.b.cast<long double>() - a;
  const Vec c = corner[0].cast<long double>(), e1 = corner[1].cast<long double>() - c,
            e2 = corner[2].cast<long double>() - c;
  const auto clamp01 = [](long double x) { return x > 0.0L ? std::min(x, 1.0L) : 0.0L; };  // also for NaN
  long double least = 1e300L;
  for (int side = 0; side < 7; ++side) {    // face, three edges, three corners
    for (int time = 0; time < 3; ++time) {  // free, the start, the end
      Vec origin = a - c;
      Eigen::Matrix<long double, 3, Eigen::Dynamic, 0, 3, 3> free(3, 0);
      const auto add = [&free](const Vec& column) {
        free.conservativeResize(3, free.cols() + 1);
        free.col(free.cols() - 1) = column;
      };
      if (time == 0) add(way);
      if (time == 2) origin += way;
      if (side == 0 || side == 1) add(-e1);
      if (side == 0 || side == 2) add(-e2);
      if (side == 3) origin -= e1, add(e1 - e2);
      if (side == 5) origin -= e1;
      if (side == 6) origin -= e2;
      Eigen::Matrix<long double, Eigen::Dynamic, 1, 0, 3, 1> at(free.cols());
      if (free.cols() > 0) at = free.colPivHouseholderQr().solve(-origin);
      for (int i = 0; i < at.size(); ++i) at(i) = clamp01(at(i));
      if (side == 0 && at(at.size() - 2) + at(at.size() - 1) > 1.0L)
        at.tail(2) /= at(at.size() - 2) + at(at.size() - 1);
      least = std::min(least, (origin + free * at).norm());
    }
  }
  return least;
}

}  // namespace

TEST_CASE("random sphere sweeps touch when the distance says so", "[hard]") {
  const auto meshes = sweepMeshes();
  const int each = test::count(60, 100000 / static_cast<int>(meshes.size()) + 1);
  int hits = 0, free = 0, touching = 0;
  for (const auto& [name, mesh, closed] : meshes) {
    const MeshModel model(mesh);
    const test::ReferenceDistance distance(mesh);
    const double size = test::sizeOf(mesh);
    test::Random random(31);
    ProximityCache cache;
    for (int i = 0; i < each; ++i) {
      Vec3 from = test::queryPoint(mesh, size, random);
      if ((from - mesh.vertices[mesh.triangles[0][0]]).norm() > 5.0 * size) continue;
      const double way = size * random.power(-3.0, 0.5);
      const Vec3 to = from + way * random.direction();
      double radius = random.uniform(0.0, 1.0) < 0.2 ? 0.0 : size * std::pow(10.0, random.uniform(-4.0, -0.5));
      if (i % 7 == 0) radius = distance(0.5 * (from + to));  // often grazing
      INFO(name << " sweep " << i << " from " << from.transpose() << " to " << to.transpose() << " radius " << radius);
      const SweepHit hit = sweepSphere(model, from, to, radius);
      const SweepHit cached = sweepSphere(model, from, to, radius, &cache);
      REQUIRE(hit.hit == cached.hit);
      REQUIRE(hit.time == cached.time);
      REQUIRE(hit.point == cached.point);
      REQUIRE(hit.triangle == cached.triangle);
      // Rounding of the positions changes distances by 1e-16 of their size.
      const double rounding = 1e-12 * (size + (to - from).norm());
      const auto gapAt = [&](double t) { return distance(from + t * (to - from)) - radius; };
      if (hit.hit && hit.time > 0.0) {
        ++hits;
        REQUIRE(std::abs(gapAt(hit.time)) <= rounding);
        CHECK(std::abs((from + hit.time * (to - from) - hit.point).norm() - radius) <= rounding);
      } else if (hit.hit) {
        ++touching;
        REQUIRE(gapAt(0.0) <= rounding);
      } else {
        ++free;
      }
      for (int k = 0; k < 12 && (!hit.hit || hit.time > 0.0); ++k) {
        const double t = (hit.hit ? hit.time : 1.0) * (k < 8 ? random.uniform(0.0, 1.0) : 1.0 - std::pow(10.0, -k + 6));
        REQUIRE(gapAt(t) >= -rounding);
      }
    }
  }
  // All three kinds are common: 6 sweeps of each mesh (a sanitizer's run) show them.
  CHECK(hits + free + touching > 50);
  CHECK(free > 10);
  CHECK(hits + touching > 10);
  if (each >= 60) {
    CHECK(hits > 50);
    CHECK(touching > 10);
  }
}

TEST_CASE("a plate of 1 um is not passed at 10 m/s", "[hard]") {
  test::Random random(32);
  const double half = 0.5e-6;
  const MeshModel plate(test::boxMesh({0.02, 0.02, half}));
  for (int i = 0; i < test::count(2000, 100000); ++i) {
    const double radius = i % 3 == 0 ? 0.0 : random.uniform(1e-6, 5e-4);
    const Vec3 from{random.uniform(-5e-3, 5e-3), random.uniform(-5e-3, 5e-3),
                    radius + half + random.uniform(1e-7, 9e-3)};
    const Vec3 to = from + 0.01 * Vec3{random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), -1.0};  // one tick
    const SweepHit hit = sweepSphere(plate, from, to, radius);
    REQUIRE(hit.hit);
    const double truth = (from.z() - radius - half) / 0.01;
    REQUIRE(std::abs(hit.time - truth) <= 1e-9);
    CHECK(hit.normal.z() == Approx(1.0).epsilon(1e-9));
    const Segment start{from, from + Vec3(1e-3, 0, 1e-3)}, end{to, to + Vec3(1e-3, 0, 1e-3)};
    const SweepHit capsule = sweepCapsule(plate, start, end, radius);
    REQUIRE(capsule.hit);
    CHECK(capsule.time <= truth + 1e-9);
    CHECK(capsule.time >= truth - 1e-9);
  }
  CHECK(sweepSphere(plate, Vec3::Zero(), Vec3::Zero(), -1.0).status == Status::outOfRange);
  CHECK(sweepSphere(plate, Vec3::Zero(), Vec3::Zero(), std::nan("")).status == Status::notFinite);
  CHECK(sweepCapsule(plate, {}, {}, -1.0).status == Status::outOfRange);
  CHECK(closestToSegment(plate, {}, -1.0).status == Status::outOfRange);
}

TEST_CASE("segments are as near as brute force finds them, with any hint and on any machine", "[hard]") {
  const SimdLevel best = simdLevel();
  for (const auto& [name, mesh, closed] : sweepMeshes()) {
    if (mesh.triangles.size() > 700) continue;
    INFO(name);
    const MeshModel model(mesh);
    const double size = test::sizeOf(mesh), count = static_cast<double>(mesh.triangles.size());
    test::Random random(33);
    for (int i = 0; i < test::count(60, 2000); ++i) {
      const auto& t = mesh.triangles[static_cast<std::size_t>(random.uniform(0.0, count))];
      const Vec3 a = test::queryPoint(mesh, size, random);
      if ((a - mesh.vertices[t[0]]).norm() > 5.0 * size) continue;
      const double length = size * random.power(-3.0, 0.5);
      Segment segment{a, a + length * random.direction()};
      const Vec3 edge = mesh.vertices[t[1]] - mesh.vertices[t[0]];
      if (i % 5 == 0) segment.b = segment.a;
      if (i % 5 == 1) segment.b = segment.a + random.uniform(-2.0, 2.0) * edge;  // parallel
      if (i % 5 == 2) {
        const double aside = edge.norm() * random.power(-16.0, -1.0);
        segment.b = segment.a + 2.0 * edge + aside * random.direction();
      }
      if (i % 5 == 3) segment.a = mesh.vertices[t[2]] - (segment.b - mesh.vertices[t[2]]);  // through a corner
      long double truth = 1e300L;
      for (const auto& triangle : mesh.triangles)
        truth = std::min(truth, distanceToTriangle(segment, {mesh.vertices[triangle[0]], mesh.vertices[triangle[1]],
                                                             mesh.vertices[triangle[2]]}));
      const SegmentPoint found = closestToSegment(model, segment);
      INFO("segment " << i << " from " << segment.a.transpose() << " to " << segment.b.transpose());
      const double rounding = 1e-12 * (size + segment.a.lpNorm<1>() + segment.b.lpNorm<1>());
      REQUIRE(found.triangle >= 0);
      CHECK(std::abs(found.distance - static_cast<double>(truth)) <= rounding);
      if (found.distance > 1e-6 * size) {  // a free segment is free, with at least the requested distance
        const double limit = found.distance * (i % 2 == 0 ? 0.9999 : random.uniform(0.5, 1.0));
        const SegmentPoint clear =
            closestToSegment(model, segment, limit, i % 3 == 0 ? -1 : found.triangle, random.uniform(0.0, 3.0) * limit);
        REQUIRE(clear.triangle < 0);
        CHECK(clear.distance >= limit * (1.0 - 1e-12));
        CHECK(clear.distance <= found.distance);
      }
      const Vec3 x = segment.a + found.parameter * (segment.b - segment.a);
      CHECK(std::abs((x - found.point).norm() - found.distance) <= rounding);
      CHECK(closestPoint(model, found.point).distance <= rounding);
      for (const SimdLevel level : {SimdLevel::baseline, SimdLevel::avx2, SimdLevel::avx512}) {
        if (useSimdLevel(level) != level) continue;
        const int hint = i % 3 == 0 ? -1 : static_cast<int>(random.uniform(0.0, count));
        const double limit = i % 2 == 0 ? kNoLimit : found.distance > 0.0 ? 1.001 * found.distance + rounding : 0.0;
        const SegmentPoint again = closestToSegment(model, segment, limit, hint);
        REQUIRE(again.distance == found.distance);
        REQUIRE(again.triangle == found.triangle);
        REQUIRE(again.parameter == found.parameter);
        REQUIRE(again.point == found.point);
      }
      useSimdLevel(best);
    }
  }
}

TEST_CASE("capsule sweeps stop at the surface and never pass it", "[hard]") {
  const MeshModel model(test::ball(4, 0.1));
  test::Random random(34);
  int met = 0, grazed = 0;
  double worst = 0.0, worstGrazed = 0.0;
  for (int i = 0; i < test::count(600, 100000); ++i) {
    const Vec3 a = 2.5 * random.direction();
    const Segment from{a, a + random.vector(0.4)};
    const bool turns = i % 2 == 0;
    const Vec3 way = 2.0 * random.vector(1.0);
    const Segment to{a + way, from.b + (turns ? Vec3(2.0 * random.vector(1.0)) : way)};
    const auto at = [&](double t) { return Segment{from.a + t * (to.a - from.a), from.b + t * (to.b - from.b)}; };
    double radius = random.uniform(0.01, 0.3);
    if (i % 3 == 0) {  // the smallest distance of the path, within rounding: grazing
      double least = 1e300, best = 0.0;
      for (double width = 0.5; width > 1e-9; width *= 0.25)
        for (int k = -8; k <= 8; ++k) {
          const double t = std::min(1.0, std::max(0.0, (width == 0.5 ? 0.5 : best) + width * k / 8.0));
          const double d = closestToSegment(model, at(t)).distance;
          if (d < least) least = d, best = t;
        }
      radius = least * (i % 2 == 0 ? 1.0 : 1.0 + 1e-12);
    }
    const SweepHit hit = sweepCapsule(model, from, to, radius);
    const auto gapAt = [&](double t) { return closestToSegment(model, at(t)).distance - radius; };
    INFO("sweep " << i << " radius " << radius << " hit " << hit.hit << " time " << hit.time);
    if (hit.hit && hit.time > 0.0) {
      const double gap = gapAt(hit.time);
      REQUIRE(std::abs(gap) < 1e-13);  // rounding of coordinates of about 3
      // The error of the time is the gap / closing speed, in paths; it is unlimited at a root of higher order.
      const double h = 1e-6, closing = (gapAt(hit.time - h) - gap) / h;
      if (closing > 1e-3) {
        ++met;
        worst = std::max(worst, std::abs(gap) / closing);
      } else {
        ++grazed;
        worstGrazed = std::max(worstGrazed, std::abs(gap));
      }
    }
    // No touch before the hit.
    for (int k = 0; k < 10 && !(hit.hit && hit.time == 0.0); ++k) {
      const double t = random.uniform(0.0, hit.hit ? hit.time : 1.0), gap = gapAt(t);
      INFO("gap " << gap << " at " << t);
      REQUIRE(gap >= -1e-13);
    }
    if (hit.hit && hit.time > 0.0)
      for (int k = 3; k < 9; ++k) REQUIRE(gapAt(hit.time * (1.0 - std::pow(10.0, -k))) >= -1e-13);
  }
  std::printf("capsules: %d met at an angle, time within %.1e of the path; %d grazed, gap %.1e\n", met, worst, grazed,
              worstGrazed);
  CHECK(worst < 1e-9);
  CHECK(met > test::count(600, 100000) / 30);
}

TEST_CASE("an axis whose far ends hold its sweep up is there a few steps after the sixteenth", "[hard]") {
  const MeshModel model(TriangleMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
  test::Random random(36);
  const double radius = 1e-3;
  int held = 0;
  double left = 0.0;  // of the path
  for (int i = 0; i < 2000; ++i) {
    // Near a place close to the triangle; the axis sinks towards it.
    const double length = random.power(0.0, 2.0), share = random.uniform(0.0, 1.0);
    const Vec3 place(random.uniform(0.0, 0.5), random.uniform(0.0, 0.5), radius + random.power(-3.0, -1.0));
    const Vec3 first = random.direction(), last = (first + random.uniform(0.0, 0.5) * random.direction()).normalized();
    const auto axis = [&](const Vec3& p, const Vec3& way) {
      return Segment{p - share * length * way, p + (1.0 - share) * length * way};
    };
    const Segment from = axis(place, first), to = axis(place - Vec3(0.0, 0.0, random.uniform(0.0, 0.02)), last);
    const auto within = [&](int steps) { return kernel::sweepCapsule(model, from, to, radius, steps); };
    const SweepHit hit = within(kernel::kMostAdvances);
    if (!hit.hit) continue;
    held += hit.time - within(16).time > 1e-6;
    left = std::max(left, hit.time - within(19).time);
  }
  CHECK(held > 20);
  CHECK(left < 1e-6);  // 1.5e-8; one step less leaves 4e-5
}

TEST_CASE("a pick hits what the segment crosses first", "[hard]") {
  const TriangleMesh mesh = test::ball(4, 0.1);
  const MeshModel model(mesh);
  test::Random random(35);
  for (int i = 0; i < test::count(500, 20000); ++i) {
    const Vec3 inside = 0.2 * random.vector(1.0), outside = 3.0 * random.direction();
    const SweepHit hit = pick(model, {outside, inside});
    REQUIRE(hit.hit);  // the surface is in between
    CHECK(closestPoint(model, hit.point).distance < 1e-12);
    CHECK(hit.normal.dot(inside - outside) <= 0.0);
    // No touch before the hit: just before it, the whole path is outside.
    for (int k = 1; k <= 4; ++k)
      CHECK(signedDistance(model, outside + 0.25 * k * (hit.time - 1e-6) * (inside - outside)).distance > 0.0);
  }
  // Exactly through vertices and edges.
  for (std::size_t v = 0; v < mesh.vertices.size(); v += 5)
    CHECK(pick(model, {3.0 * mesh.vertices[v], 0.5 * mesh.vertices[v]}).hit);
  CHECK_FALSE(pick(model, {Vec3(3, 3, 3), Vec3(3, -3, 3)}).hit);
  // A large triangle is beside the whole segment; a small one is crossed earlier.
  TriangleMesh two;
  two.vertices = {{-1, -1, -0.03}, {2, -1, 0.03}, {0.5, 2, 0}, {0.3, -0.1, -0.1}, {0.3, 0.1, -0.1}, {0.3, 0, 0.1}};
  two.triangles = {{0, 1, 2}, {3, 4, 5}};
  const SweepHit first = pick(MeshModel(two), {Vec3::Zero(), Vec3::UnitX()});
  CHECK(first.triangle == 1);
  CHECK(std::abs(first.time - 0.3) < 1e-15);
}

}  // namespace enamel::test_sweep
