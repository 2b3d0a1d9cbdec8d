// Contacts of tools with scenes: analytic cases, meshes compared with the analytic shapes that they approximate, order,
// velocities, identity, caches.
#include "enamel/collision/contacts.hpp"

#include "enamel/collision/mesh_update.hpp"
#include "enamel/collision/sweep.hpp"
#include "support/catch.hpp"
#include "support/contacts.hpp"
#include "support/meshes.hpp"

namespace enamel::test_contacts {
using test::at;
using test::contactsOf;
using test::sphereTool;

namespace {

std::shared_ptr<const MeshModel> model(const TriangleMesh& mesh) { return std::make_shared<const MeshModel>(mesh); }

}  // namespace

TEST_CASE("a flat wall has its normal to the bit and the gap to one rounding", "[unit]") {
  test::Random random(503);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 point = random.vector(0.02), normal = random.direction(), x = random.vector(0.03);
    const Contact contact = nearestContact(flatWall(point, normal), Tool(), at(x), nullptr);
    REQUIRE(contact.normal == normal);
    REQUIRE((contact.point - x).norm() <= 1e-16);  // to the wall's frame and back
    REQUIRE(std::abs(contact.gap - normal.dot(x - point)) <= 1e-17);
  }
}

TEST_CASE("on the surface the normal is the face's, and a tool far away knows how far", "[unit]") {
  const auto box = model(test::boxMesh(Vec3(1.0 / 256, 1.0 / 128, 1.0 / 512)));
  for (int k = 0; k < 3; ++k)
    for (const double side : {-1.0, 1.0}) {
      Vec3 x = Vec3(1.0, 1.5, 0.5) / 2048;  // without rounding
      x[k] = side * box->mesh().vertices[0].cwiseAbs()[k];
      const SurfacePoint on = signedDistance(*box, x);
      REQUIRE(std::abs(on.distance) < 1e-17);
      REQUIRE(on.normal.isApprox(Vec3(side * Vec3::Unit(k)), 1e-15));
    }
  TriangleMesh sheet;
  sheet.vertices = {{-0.01, -0.01, 0.002}, {0.01, -0.01, 0.002}, {0.0, 0.01, 0.002}};
  sheet.triangles = {{0, 1, 2}};
  Tool tool;
  tool.parts[0] = {{0, -0.002, 0}, {0.001, 0.002, 0.001}, 0.001};
  for (const auto& [shape, top] : {std::pair(box, 1.0 / 512), {model(sheet), 0.002}}) {
    Scene scene;
    scene.add({"shape", shape, Pose{}, Vec6::Zero(), {}});
    for (const double height : {0.1, 1.0, 10.0, 1000.0}) {
      REQUIRE(nearestContact(scene, tool, at({0, 0, height}), nullptr).gap ==
              Approx(height - top - 0.001).epsilon(1e-12));
      const SegmentPoint near = closestToSegment(*shape, {{-0.001, 0, height}, {0.001, 0, height}}, kNoLimit);
      REQUIRE(near.triangle >= 0);
      REQUIRE(near.distance == Approx(height - top).epsilon(1e-12));
    }
  }
}

TEST_CASE("the nearest contact is the first of the contacts, and is found beyond any margin", "[unit]") {
  test::Random random(505);
  Scene scene;
  scene.add({"box", Box{{0.01, 0.02, 0.005}}, at({0.03, 0, 0}), Vec6::Zero(), {}});
  scene.add(
      {"ball", model(test::transformed(test::ball(4, 0.0), 0.012, Vec3::Zero())), at({-0.03, 0, 0}), Vec6::Zero(), {}});
  scene.add({"rod", Capsule{0.004, 0.02}, at({0, 0.04, 0}), Vec6::Zero(), {}});
  scene.add(halfSpace("floor", {0, 0, -0.03}, Vec3(0.1, 0, 1).normalized()));
  Tool tool = sphereTool(0.001);
  tool.parts[1] = {{0, 0, 0.001}, {0, 0.003, 0.012}, 0.0005};
  tool.count = 2;
  ToolCache cache = makeToolCache(scene, tool);
  int within = 0;
  for (int i = 0; i < 5000; ++i) {
    const Pose pose{random.vector(0.06), random.rotation(3.0)};
    const Contact nearest = nearestContact(scene, tool, pose, &cache);
    const Contact plain = nearestContact(scene, tool, pose, nullptr);
    REQUIRE(nearest.gap == plain.gap);
    REQUIRE(nearest.point == plain.point);
    const ContactSnapshot all = contactsOf(scene, tool, pose, 0.005);
    if (nearest.gap > 0.005 + 1e-9) REQUIRE(all.count == 0);
    if (all.count == 0) continue;
    ++within;
    REQUIRE(nearest.gap == all.contacts[0].gap);
    REQUIRE(nearest.obstacle == all.contacts[0].obstacle);
    // One comes from the pseudonormal, the other from the direction to the point; both are known to 1e-17 m.
    REQUIRE((nearest.normal - all.contacts[0].normal).norm() < 1e-9);
  }
  CHECK(within > 500);
  Scene deep;  // both ends of the part at one depth, its middle deeper
  deep.add({"ball", Sphere{1.0}, Pose(), Vec6::Zero(), {}});
  tool.parts[0] = {{-0.1, 0.05, 0}, {0.1, 0.05, 0}, 0.01};
  tool.count = 1;
  CHECK(std::abs(contactsOf(deep, tool, Pose(), 0.0).contacts[0].gap + 0.96) < 1e-15);
  CHECK(std::abs(nearestContact(deep, tool, Pose(), nullptr).gap + 0.96) < 1e-15);
  auto drilled = std::make_shared<MeshModel>(test::ball(1));
  for (int t = 0; t < static_cast<int>(drilled->mesh().triangles.size()); ++t)
    REQUIRE(removeTriangles(*drilled, &t, 1) == Status::ok);
  Scene gone;
  gone.add({"ball", std::shared_ptr<const MeshModel>(drilled), Pose(), Vec6::Zero(), {}});
  CHECK(nearestContact(gone, tool, Pose(), nullptr).gap == kNoLimit);
  CHECK(nearestContact(Scene(), tool, Pose(), nullptr).gap == kNoLimit);
  CHECK(nearestContact(scene, tool, at({0, std::nan(""), 0}), nullptr).gap == kNoLimit);
}

TEST_CASE("a box of triangles touches like a box", "[unit]") {
  test::Random random(42);
  const Vec3 half(0.03, 0.02, 0.01);
  Scene analytic, mesh;
  Pose pose;
  pose.position = {0.1, 0.2, 0.3};
  pose.rotation = test::rotationAbout(Vec3(1, 2, 3).normalized(), 0.7);
  const Material rubber{3000.0, 0.8, 0.6, 0.1};
  analytic.add({"box", Box{half}, pose, Vec6::Zero(), rubber});
  mesh.add({"box", model(test::boxMesh(half)), pose, Vec6::Zero(), rubber});
  int seen = 0;
  for (int i = 0; i < 3000; ++i) {
    const Tool tool = sphereTool(0.005, random.vector(0.01));
    const Pose platform{pose.position + random.vector(0.05), test::rotationAbout(random.direction(), 1.0)};
    const ContactSnapshot a = contactsOf(analytic, tool, platform, 0.01), b = contactsOf(mesh, tool, platform, 0.01);
    const Vec3 centre = platform.rotation * tool.parts[0].a + platform.position;
    REQUIRE(a.count == b.count);
    if (a.count == 0) continue;
    ++seen;
    CHECK(std::abs(a.contacts[0].gap - b.contacts[0].gap) < 1e-14);
    CHECK((a.contacts[0].normal - b.contacts[0].normal).norm() < 1e-6);
    CHECK((centre - 0.005 * b.contacts[0].normal - b.contacts[0].point).norm() < 1e-14);
    CHECK(b.contacts[0].material.stiffness == rubber.stiffness);
    CHECK(b.contacts[0].material.friction == rubber.friction);
  }
  CHECK(seen > 200);
}

TEST_CASE("a sphere in a groove touches both sides, on a flat or a ridge once", "[unit]") {
  TriangleMesh groove;  // two planes at right angles, with many triangles
  const int n = 20;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double x = 0.02 * (i - n / 2) / n, y = 0.02 * (j - n / 2) / n;
      groove.vertices.push_back({x, y, std::abs(x)});
    }
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int a = i * (n + 1) + j, b = a + n + 1;
      groove.triangles.push_back({a, b, a + 1});
      groove.triangles.push_back({b, b + 1, a + 1});
    }
  Scene scene;
  scene.add({"groove", model(groove), Pose(), Vec6::Zero(), {}});
  const double r = 0.002;
  for (double y = -0.004; y < 0.004; y += 0.00013) {
    const ContactSnapshot two = contactsOf(scene, sphereTool(r), at({0, y, r * std::sqrt(2.0)}), 1e-4);
    REQUIRE(two.count == 2);
    for (int i = 0; i < 2; ++i) {
      CHECK(std::abs(two.contacts[i].gap) < 1e-12);
      CHECK(std::abs(two.contacts[i].normal.z() - std::sqrt(0.5)) < 1e-9);
    }
    CHECK(two.contacts[0].normal.dot(two.contacts[1].normal) < 1e-9);
    const ContactSnapshot one = contactsOf(scene, sphereTool(r), at({0.006, y, 0.006 + 1.4 * r}), 5e-4);
    CHECK(one.count == 1);  // on one side only
  }
  for (Vec3& v : groove.vertices) v.z() = -v.z();
  Scene ridge;
  ridge.add({"ridge", model(groove), Pose(), Vec6::Zero(), {}});
  CHECK(contactsOf(ridge, sphereTool(r), at({0, 0.0001, 0.99 * r}), 1e-3).count == 1);
}

TEST_CASE("a capsule on a plane touches with both ends, across a ridge in between", "[unit]") {
  Scene plane;
  plane.add({"floor", HalfSpace{}, Pose(), Vec6::Zero(), {}});
  Tool tool;
  tool.parts[0] = {{-0.01, 0, 0}, {0.01, 0, 0}, 0.001};
  tool.count = 1;
  const ContactSnapshot flat = contactsOf(plane, tool, at({0, 0, 0.0005}), 1e-3);
  REQUIRE(flat.count == 2);
  CHECK(flat.contacts[0].gap == Approx(-0.0005).epsilon(1e-12));
  CHECK(flat.contacts[0].point.z() == Approx(-0.0005).epsilon(1e-12));
  for (const Shape& shape :
       {Shape(Box{{0.002, 0.05, 0.01}}), Shape(model(test::boxMesh({0.002, 0.05, 0.01}))), Shape(Sphere{0.01})}) {
    Scene post;
    post.add({"post", shape, Pose(), Vec6::Zero(), {}});
    const ContactSnapshot middle = contactsOf(post, tool, at({0.0004, 0, 0.0105}), 1e-3);
    REQUIRE(middle.count >= 1);
    CHECK(middle.contacts[0].gap == Approx(-0.0005).epsilon(1e-3));
    CHECK(middle.contacts[0].normal.z() == Approx(1.0).epsilon(1e-2));
  }
}

TEST_CASE("contacts tell the obstacle, the tool's part, the triangle and its feature", "[unit]") {
  test::Random random(506);
  Scene scene;
  scene.add({"wavy", model(test::transformed(test::ball(3, 0.1), 0.01, Vec3::Zero())), Pose(), Vec6::Zero(), {}});
  scene.add({"box",
             Box{{0.006, 0.004, 0.008}},
             {Vec3(0.02, 0, 0), test::rotationAbout(Vec3(1, 2, 3).normalized(), 0.5)},
             Vec6::Zero(),
             {2}});
  scene.add({"triangles", model(test::boxMesh({0.005, 0.006, 0.007})), at({0, 0.02, 0}), Vec6::Zero(), {}});
  Tool tool = sphereTool(0.001);
  tool.parts[1] = {{0, 0, 0.002}, {0, 0.001, 0.012}, 0.0005};
  tool.parts[2] = {{0.004, 0, 0}, {0.004, 0, 0}, 0.0};
  tool.count = 3;
  const double rounding = 1e-15;  // of coordinates of 0.03 m, rotated and back
  ToolCache cache = makeToolCache(scene, tool);
  int met[3][3] = {}, parts[3] = {}, compared = 0;
  Pose pose;
  for (int i = 0; i < 8000; ++i) {
    pose = i % 4 == 0
               ? Pose{{random.uniform(-0.014, 0.03), random.uniform(-0.014, 0.03), random.uniform(-0.014, 0.014)},
                      random.rotation(3.0)}
               : at(pose.position + 1e-4 * random.direction());
    const ContactSnapshot all = contactsOf(scene, tool, pose, 0.002);
    REQUIRE(test::areEqual(all, contactsOf(scene, tool, pose, 0.002, &cache)));
    for (int k = 0; k < all.count; ++k) {
      const Contact& contact = all.contacts[k];
      REQUIRE(test::identityError(scene, tool, pose, contact) < rounding);
      ++met[contact.obstacle][static_cast<int>(contact.feature)];
      ++parts[contact.part];
    }
    const Contact nearest = nearestContact(scene, tool, pose, nullptr);
    REQUIRE(test::identityError(scene, tool, pose, nearest) < rounding);
    REQUIRE(test::areEqual(nearest, nearestContact(scene, tool, pose, &cache)));
    // Brute force over the spheres and the wavy mesh, unless another triangle is about as near.
    if (nearest.obstacle != 0 || nearest.part == 1 || nearest.gap < 0.0 || nearest.feature != Feature::face) continue;
    const TriangleMesh& mesh = std::get<std::shared_ptr<const MeshModel>>(scene.obstacles()[0].shape)->mesh();
    double least = kNoLimit;
    int triangle = -1, part = -1;
    for (const int k : {0, 2})
      for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
        const auto& v = mesh.triangles[static_cast<std::size_t>(t)];
        const double gap = test::referenceDistance(pose.rotation * tool.parts[k].a + pose.position, mesh.vertices[v[0]],
                                                   mesh.vertices[v[1]], mesh.vertices[v[2]]) -
                           tool.parts[k].radius;
        if (!(gap < least)) continue;
        least = gap;
        triangle = t;
        part = k;
      }
    REQUIRE(std::abs(least - nearest.gap) < rounding);
    REQUIRE(triangle == nearest.triangle);
    REQUIRE(part == nearest.part);
    ++compared;
  }
  CHECK(compared > 100);
  for (const auto& obstacle : met)
    for (const int feature : obstacle) CHECK(feature > 20);
  for (const int part : parts) CHECK(part > 50);
  // Only a mesh has triangles; round shapes have no edges. Without a contact the feature is missing.
  Scene round;
  round.add({"ball", Sphere{0.01}, Pose(), Vec6::Zero(), {}});
  const Contact onBall = nearestContact(round, tool, at({0, 0, 0.02}), nullptr);
  CHECK((onBall.part == 0 && onBall.triangle == -1 && onBall.feature == Feature::face && onBall.featureIndex == -1));
  const Contact none = nearestContact(Scene(), tool, Pose(), nullptr);
  CHECK((none.part == -1 && none.triangle == -1 && none.featureIndex == -1));
}

TEST_CASE("a tool's cache can be copied and moved from", "[unit]") {
  test::Random random(507);
  Scene scene;
  scene.add({"wavy", model(test::transformed(test::ball(4, 0.1), 0.01, Vec3::Zero())), Pose(), Vec6::Zero(), {}});
  const Tool tool = sphereTool(0.001);
  ToolCache cache = makeToolCache(scene, tool), other, copy = cache;
  for (int i = 0; i < 600; ++i) {
    const Pose pose = at((0.0105 + 1e-3 * (i % 5)) * Vec3(std::sin(0.01 * i), 0, std::cos(0.01 * i)));
    const ContactSnapshot plain = contactsOf(scene, tool, pose, 1e-3);
    if (i % 50 == 10) copy = cache;
    if (i % 50 == 20) other = std::move(cache);
    REQUIRE(test::areEqual(plain, contactsOf(scene, tool, pose, 1e-3, &cache)));
    REQUIRE(test::areEqual(plain, contactsOf(scene, tool, pose, 1e-3, &copy)));
    REQUIRE(test::areEqual(plain, contactsOf(scene, tool, pose, 1e-3, &other)));
    if (i % 50 == 30) cache = std::move(other);
  }
}

TEST_CASE("contacts are ordered, carry the obstacle's velocity and stay within the capacity", "[unit]") {
  Scene scene;
  Vec6 twist;
  twist << 0.1, 0.0, 0.0, 0.0, 0.0, 2.0;
  for (int i = 0; i < 12; ++i)
    scene.add({"wall " + std::to_string(i), HalfSpace{}, at({0, 0, -0.001 * ((5 * i) % 12)}), twist, {}});
  const ContactSnapshot contacts = contactsOf(scene, sphereTool(0.02, {0.03, 0, 0}), at({0, 0, 0}), 0.01);
  REQUIRE(contacts.count == kMaxContacts);
  for (int i = 1; i < contacts.count; ++i) CHECK(contacts.contacts[i - 1].gap <= contacts.contacts[i].gap);
  CHECK(contacts.contacts[0].gap == Approx(-0.02));
  CHECK(contacts.contacts[0].obstacle == 0);
  CHECK((contacts.contacts[0].obstacleVelocity - Vec3(0.1, 0.06, 0.0)).norm() < 1e-15);  // v + w x r
}

TEST_CASE("contacts are the same with a cache and move little when the tool moves little", "[unit]") {
  test::Random random(43);
  Scene scene;
  scene.add({"wavy", model(test::transformed(test::ball(5, 0.1), 0.01, Vec3::Zero())), Pose(), Vec6::Zero(), {}});
  scene.add({"floor", HalfSpace{}, at({0, 0, -0.012}), Vec6::Zero(), {}});
  Tool tool = sphereTool(0.001, {0, 0.001, 0});
  tool.parts[1] = {{0, 0, 0}, {0, 0, 0.01}, 0.0005};
  tool.count = 2;
  ToolCache cache = makeToolCache(scene, tool);
  Pose pose = at({0, 0, 0.0115});
  Vec3 direction = Vec3::UnitX();
  double gap = 0.0;
  int seen = 0;
  for (int i = 0; i < 2000; ++i) {
    direction = (direction + 0.1 * random.direction()).normalized();
    pose.position += 2e-5 * direction;
    if (pose.position.norm() > 0.013 || pose.position.norm() < 0.01)
      direction = (direction - pose.position.normalized() * (pose.position.norm() - 0.0115) * 500.0).normalized();
    const ContactSnapshot plain = contactsOf(scene, tool, pose, 5e-4),
                          cached = contactsOf(scene, tool, pose, 5e-4, &cache);
    REQUIRE(test::areEqual(plain, cached));
    const double now = plain.count > 0 ? plain.contacts[0].gap : 5e-4;
    if (i > 0) CHECK(std::abs(now - gap) <= 2e-5 * (1.0 + 1e-9));  // gaps are Lipschitz continuous
    gap = now;
    seen += plain.count > 0;
  }
  CHECK(seen > 100);
}

}  // namespace enamel::test_contacts
