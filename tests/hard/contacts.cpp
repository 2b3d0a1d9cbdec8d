// Contacts of tools with meshes: equal to the local minima found by brute force, and with the same bits whatever is
// kept from earlier ticks.
#include "support/contacts.hpp"

#include <Eigen/Geometry>

#include "enamel/collision/contacts.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_contacts {

namespace {

// Return the nearest point of a triangle: the foot in its plane if it is inside by signs of areas, else on an edge.
Vec3 nearestOf(const Vec3& p, const std::array<Vec3, 3>& corner) {
  const Vec3 n = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  bool isInside = n.squaredNorm() > 0.0;
  Vec3 best = corner[0];
  for (int i = 0; i < 3; ++i) {
    const Vec3 &a = corner[i], edge = corner[(i + 1) % 3] - a;
    isInside = isInside && edge.cross(p - a).dot(n) > 0.0;
    const Vec3 on = a + std::clamp(edge.dot(p - a) / edge.squaredNorm(), 0.0, 1.0) * edge;
    if ((on - p).norm() < (best - p).norm()) best = on;
  }
  return isInside ? Vec3(p - n * (n.dot(p - corner[0]) / n.squaredNorm())) : best;
}

// Return the squared distance for the innermost loop: at -O1, Eigen's expressions take several times as long.
double squared(const Vec3& a, const Vec3& b) {
  const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

// Return sound meshes, and one with gaps between its parts, which has many near features.
std::vector<test::NamedMesh> contactMeshes() {
  std::vector<test::NamedMesh> all = test::soundMeshes();
  TriangleMesh balls;
  for (int i = 0; i < 8; ++i)
    balls = test::joined(
        balls, test::transformed(test::ball(3, 0.1), 0.9, Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  all.push_back({"eight balls", std::move(balls), true});
  return all;
}

// A triangle's nearest point; one corner, and 1.1 times the squared extent of the triangle from it.
struct Nearest {
  Vec3 point;
  double distance;
  Vec3 corner;
  double extent;
};

std::vector<Nearest> nearestOfAll(const TriangleMesh& mesh, const Vec3& p) {
  std::vector<Nearest> all;
  all.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vec3 x = nearestOf(p, {a, b, c});
    all.push_back({x, (x - p).norm(), a, 1.1 * std::max(squared(b, a), squared(c, a))});
  }
  return all;
}

// Return whether no triangle through the nearest point of triangle i is nearer by more than a fraction `part`.
bool isMinimum(const TriangleMesh& mesh, const std::vector<Nearest>& all, std::size_t i, double size, double part) {
  const Vec3& x = all[i].point;
  const double nearer = (1.0 - part) * all[i].distance;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (!(all[k].distance < nearer) || squared(x, all[k].corner) > all[k].extent) continue;
    const auto& t = mesh.triangles[k];
    if ((nearestOf(x, {mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]}) - x).norm() < 1e-12 * size)
      return false;
  }
  return true;
}

// Return whether p is over a face, even barely: then no neighbour matters.
bool isOverFace(const TriangleMesh& mesh, std::size_t triangle, const Vec3& p, const Nearest& nearest) {
  const auto& t = mesh.triangles[triangle];
  const Vec3& a = mesh.vertices[t[0]];
  const Vec3 normal = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a).normalized();
  return std::abs(normal.dot(p - nearest.point)) > nearest.distance * (1.0 - 1e-13);
}

}  // namespace

TEST_CASE("a sphere touches at every local minimum of the distance and nowhere else", "[hard]") {
  const SimdLevel best = simdLevel();
  int several = 0;
  for (const auto& [name, mesh, closed] : contactMeshes()) {
    INFO(name);
    Scene scene;
    scene.add({"mesh", std::make_shared<const MeshModel>(mesh), Pose(), Vec6::Zero(), {}});
    const double size = test::sizeOf(mesh);
    test::Random random(51);
    const int count = mesh.triangles.size() > 5000 ? test::count(60, 600) : test::count(300, 4000);
    for (int i = 0; i < count; ++i) {
      const Vec3 p = i % 2 == 0 ? test::queryPoint(mesh, size, random) : Vec3(random.vector(0.5 * size));
      if (p.norm() > 3.0 * size || std::abs(test::windingNumber(mesh, p)) > 0.5) continue;
      const std::vector<Nearest> all = nearestOfAll(mesh, p);
      double nearest = 1e300;
      for (const Nearest& one : all) nearest = std::min(nearest, one.distance);
      if (!(nearest > 1e-6 * size)) continue;
      const double reach = nearest * std::pow(10.0, random.uniform(0.0, 1.0)),
                   radius = random.uniform(0.0, std::min(reach, kLargestTool));
      const Tool tool = test::sphereTool(radius);
      const ContactSnapshot contacts = test::contactsOf(scene, tool, test::at(p), reach - radius);
      for (const SimdLevel level : {SimdLevel::baseline, SimdLevel::avx2, SimdLevel::avx512})
        if (useSimdLevel(level) == level)
          REQUIRE(test::areEqual(contacts, test::contactsOf(scene, tool, test::at(p), reach - radius)));
      useSimdLevel(best);
      INFO("point " << i << " at " << p.transpose() << ", radius " << radius << ", reach " << reach);
      REQUIRE(contacts.count >= 1);
      CHECK(std::abs(contacts.contacts[0].gap + radius - nearest) <= 1e-12 * size);
      for (int k = 0; k < contacts.count; ++k) {
        const Contact& contact = contacts.contacts[k];
        const Vec3 x = p - (contact.gap + radius) * contact.normal;
        bool isMet = false;
        for (std::size_t t = 0; t < all.size() && !isMet; ++t)
          if (squared(all[t].point, x) < 1e-24 * size * size)  // 1e-9: the library allows for rounding, 1e-12
            isMet = isOverFace(mesh, t, p, all[t]) || isMinimum(mesh, all, t, size, 1e-9);
        CHECK(isMet);
      }
      std::vector<std::size_t> minima;
      for (std::size_t t = 0; t < all.size(); ++t)
        if (all[t].distance < reach * (1.0 - 1e-9) && isMinimum(mesh, all, t, size, 0.0)) minima.push_back(t);
      if (minima.size() > 60) continue;  // more than are kept
      several += contacts.count > 1;
      for (const std::size_t t : minima) {
        bool isMet = contacts.count == kMaxContacts;
        for (int k = 0; k < contacts.count; ++k)
          isMet = isMet || (contacts.contacts[k].gap + radius <= all[t].distance + 1e-12 * size &&
                            contacts.contacts[k].normal.dot((p - all[t].point) / all[t].distance) > 0.9659);
        CHECK(isMet);
      }
    }
  }
  CHECK(several > (test::kSlowdown == 1 ? 20 : 0));
}

TEST_CASE("where two tips meet in a vertex, each has its own contact there", "[hard]") {
  // Return the vertices of a tip at the origin: rings along `way`, each with its distance and width, and an end.
  const auto tip = [](const Vec3& way, int corners, const std::vector<std::pair<double, double>>& rings) {
    TriangleMesh mesh;
    mesh.vertices.push_back(Vec3::Zero());
    const Vec3 u = way.unitOrthogonal(), v = way.cross(u);
    for (const auto& [far, wide] : rings)
      for (int i = 0; i < corners; ++i) {
        const double angle = 2.0 * M_PI * i / corners;
        mesh.vertices.push_back(far * way + wide * (std::cos(angle) * u + std::sin(angle) * v));
      }
    mesh.vertices.push_back(1.2 * rings.back().first * way);
    const int last = static_cast<int>(rings.size()) - 1, end = static_cast<int>(mesh.vertices.size()) - 1;
    for (int i = 0; i < corners; ++i) {
      const auto at = [&](int ring, int k) { return 1 + ring * corners + k % corners; };
      mesh.triangles.push_back({0, at(0, i + 1), at(0, i)});
      for (int ring = 0; ring < last; ++ring) {
        mesh.triangles.push_back({at(ring, i), at(ring, i + 1), at(ring + 1, i)});
        mesh.triangles.push_back({at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)});
      }
      mesh.triangles.push_back({end, at(last, i), at(last, i + 1)});
    }
    return mesh;
  };
  // A corner of the blunt tip is nearest, but an edge of the other one, a spike that leans over the place, is nearer.
  const Vec3 place(-0.1, 0.0, 0.0);
  const TriangleMesh blunt = tip(Vec3::UnitX(), 8, {{0.2, 0.4}, {0.5, 1.0}, {0.8, 1.6}}),
                     spike = tip(Vec3(-0.8, 0.6, 0.0), 3, {{1.0, 0.05}});
  const auto gaps = [&place](const TriangleMesh& mesh) {
    CHECK(inspect(mesh).watertight);
    Scene scene;
    scene.add({"it", std::make_shared<const MeshModel>(mesh), Pose(), Vec6::Zero(), {}});
    Pose pose;
    pose.position = place;
    ContactSnapshot contacts;
    REQUIRE(findContacts(scene, Tool(), pose, 0.15, nullptr, contacts) == Status::ok);
    std::vector<double> found;
    for (int i = 0; i < contacts.count; ++i) found.push_back(contacts.contacts[i].gap);
    return found;
  };
  const std::vector<double> ofBlunt = gaps(blunt), ofSpike = gaps(spike), ofBoth = gaps(test::joined(blunt, spike));
  REQUIRE(ofBlunt == std::vector<double>{0.1});
  REQUIRE(ofSpike.size() == 1);
  REQUIRE(ofBoth.size() == 2);
  CHECK(ofBoth[0] == ofSpike[0]);
  CHECK(ofBoth[1] == ofBlunt[0]);
}

TEST_CASE("a tool of parts that meet has the same contacts with and without a cache", "[hard]") {
  int touching = 0, deep = 0, free = 0;
  for (const auto& [name, mesh, closed] : contactMeshes()) {
    INFO(name);
    Scene scene;
    scene.add({"mesh", std::make_shared<const MeshModel>(mesh), Pose(), Vec6::Zero(), {}});
    scene.add({"turned",
               std::make_shared<const MeshModel>(mesh),
               {Vec3(0.3, 0.2, 0.1), Eigen::AngleAxisd(1.0, Vec3::UnitY()).toRotationMatrix()},
               Vec6::Zero(),
               {}});
    const double size = test::sizeOf(mesh);
    test::Random random(52);
    for (int walk = 0; walk < test::count(12, 400); ++walk) {
      const double scale = std::min(size * std::pow(10.0, random.uniform(-2.0, -0.7)), kLargestTool / 3.0);
      const double margin = random.uniform(0.0, 0.3) * scale;
      Tool tool;  // sphere, neck and shaft: thick after thin, or thin after thick
      tool.parts[0] = {Vec3::Zero(), Vec3::Zero(), 0.3 * scale};
      tool.parts[1] = {{0, 0, 0.2 * scale}, {0, 0, scale}, random.uniform(0.05, 0.5) * scale};
      tool.parts[2] = {{0, 0, scale}, {0, 0, 3.0 * scale}, random.uniform(0.05, 0.5) * scale};
      tool.count = 3;
      ToolCache cache = makeToolCache(scene, tool);
      Vec3 p = test::queryPoint(mesh, size, random);
      if (p.norm() > 2.0 * size) p *= size / p.norm();
      Eigen::Quaterniond turned(random.rotation(M_PI));
      Vec3 way = random.direction();
      const double step = scale * std::pow(10.0, random.uniform(-3.0, 0.0));
      for (int i = 0; i < 60; ++i) {
        way = (way + 0.3 * random.direction()).normalized();
        if (p.norm() > size) way = -p.normalized();
        p += (i % 25 == 24 ? 0.3 * size : step) * way;
        turned = Eigen::AngleAxisd(0.3 * step / scale, random.direction()) * turned;
        const Pose pose{p, turned.toRotationMatrix()};
        const ContactSnapshot plain = test::contactsOf(scene, tool, pose, margin);
        const ContactSnapshot cached = test::contactsOf(scene, tool, pose, margin, &cache);
        INFO("walk " << walk << " step " << i << " of " << step << ", at " << p.transpose());
        REQUIRE(test::areEqual(plain, cached));
        for (int k = 0; k < plain.count; ++k)
          REQUIRE(test::identityError(scene, tool, pose, plain.contacts[k]) <= 1e-12 * size);
        ++(plain.count == 0 ? free : plain.contacts[0].gap < -0.5 * scale ? deep : touching);
      }
    }
  }
  if (test::kSlowdown == 1) {
    CHECK(touching > 300);
    CHECK(deep > 100);
    CHECK(free > 300);
  }
}

}  // namespace enamel::test_contacts
