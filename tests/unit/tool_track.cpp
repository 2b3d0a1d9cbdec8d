// A moving tool keeps the side from which it came, however thin the wall and however fast the tool.
#include <Eigen/Geometry>
#include <utility>

#include "enamel/collision/contacts.hpp"
#include "support/catch.hpp"
#include "support/contacts.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_tool_track {

namespace {

using test::at;
using test::sphereTool;

constexpr double kTick = 0.5e-3;  // m: 0.5 m/s at 1 kHz

Shape meshShape(TriangleMesh mesh) { return std::make_shared<const MeshModel>(std::move(mesh)); }

Scene sceneOf(Shape shape) {
  Scene scene;
  scene.add({"it", std::move(shape), Pose(), Vec6::Zero(), {}});
  return scene;
}

Tool capsuleTool(const Vec3& a, const Vec3& b, double radius) {
  Tool tool;
  tool.parts[0] = {a, b, radius};
  tool.count = 1;
  return tool;
}

ContactSnapshot follow(const Scene& scene, const Tool& tool, const Pose& pose, ToolTrack& track, double margin = 1e-3) {
  ContactSnapshot contacts;
  REQUIRE(followContacts(scene, tool, pose, margin, track, contacts) == Status::ok);
  return contacts;
}

// A square of 20 mm at z = 0, with `n` x `n` squares of two triangles, seen from above.
TriangleMesh sheet(int n) {
  TriangleMesh mesh;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) mesh.vertices.push_back({0.02 * i / n - 0.01, 0.02 * j / n - 0.01, 0.0});
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int a = i * (n + 1) + j, b = a + n + 1;
      mesh.triangles.push_back({a, b, a + 1});
      mesh.triangles.push_back({b, b + 1, a + 1});
    }
  return mesh;
}

}  // namespace

TEST_CASE("nothing goes through a plate of 0.1 mm at 0.5 m/s", "[unit]") {
  const Vec3 half(0.01, 0.01, 0.05e-3);
  const Tool tools[] = {sphereTool(0.0), sphereTool(0.15e-3), sphereTool(1e-3, {1e-3, 0, 0}),
                        capsuleTool({-4e-3, 0, 0}, {4e-3, 1e-3, 0}, 0.15e-3),
                        capsuleTool({0, 0, 0}, {0, 0, 8e-3}, 0.3e-3)};
  const Shape shapes[] = {Box{half}, meshShape(test::boxMesh(half)), meshShape(sheet(7)), meshShape(sheet(1))};
  int popped = 0;  // pops if only the position counted
  for (const Shape& shape : shapes)
    for (const Tool& tool : tools) {
      const Scene scene = sceneOf(shape);
      const bool isSheet = &shape >= shapes + 2;
      const double top = isSheet ? 0.0 : half.z(), radius = tool.parts[0].radius;
      test::Random random(71);
      ToolTrack track = makeToolTrack(scene, tool);
      Vec3 p(1e-4, 2e-4, 3e-3);
      int deep = 0;
      for (int i = 0; i < 300; ++i) {  // down, to and fro, and up again
        const double wanted = i < 100 ? -4e-3 : i < 200 ? -3e-3 + 2e-3 * std::sin(1.0 * i) : 4e-3;
        const Vec3 goal(1e-3 * std::sin(0.3 * i), 1e-3 * std::cos(0.4 * i), wanted);
        p += (goal - p) * std::min(1.0, kTick / (goal - p).norm());
        const ContactSnapshot contacts = follow(scene, tool, at(p), track);
        const double gap = p.z() - top - radius;  // of the lowest place
        if (gap > 1e-3) continue;
        REQUIRE(contacts.count >= 1);
        INFO("tick " << i << " at " << p.transpose() << ", gap " << contacts.contacts[0].gap << ", true " << gap);
        REQUIRE(std::abs(contacts.contacts[0].gap - gap) < 1e-9);
        REQUIRE(contacts.contacts[0].normal.z() > 1.0 - 1e-9);
        deep += gap < -1e-3;
        const ContactSnapshot alone = test::contactsOf(scene, tool, at(p), 1e-3);
        popped += alone.count == 0 || alone.contacts[0].normal.z() < 0.5;
      }
      CHECK(deep > 50);
      CHECK(follow(scene, tool, at({0, 0, 0.02}), track).count == 0);
    }
  CHECK(popped > 1000);
}

TEST_CASE("a walk round an open border is a walk outside: its gap is the distance from the sheet", "[unit]") {
  TriangleMesh bowl = sheet(12);  // and concave or convex shapes, seen from above
  for (const double bend : {0.0, 30.0, -30.0}) {
    for (Vec3& v : bowl.vertices) v.z() = bend * (v.x() * v.x() + v.y() * v.y());
    const Scene scene = sceneOf(meshShape(bowl));
    const MeshModel& model = *std::get<std::shared_ptr<const MeshModel>>(scene.obstacles()[0].shape);
    const Tool tool = sphereTool(0.3e-3);
    test::Random random(72);
    for (int walk = 0; walk < test::count(10, 1000); ++walk) {
      ToolTrack track = makeToolTrack(scene, tool);
      const double away = random.uniform(0.4e-3, 3e-3), y = random.uniform(-8e-3, 8e-3);
      const Vec3 border(0.01, y, bend * (1e-4 + y * y));
      double before = 0.0;
      for (int i = 0; i <= 2000; ++i) {  // above, around the border, below, and back
        const double turn = M_PI * (1.0 - std::cos(2.0 * M_PI * i / 2000)) / 2.0;
        const Vec3 p = border + away * Vec3(std::cos(turn - 0.5 * M_PI), 0, -std::sin(turn - 0.5 * M_PI));
        const ContactSnapshot contacts = follow(scene, tool, at(p), track, 5e-3);
        const double distance = closestPoint(model, p).distance - 0.3e-3;
        REQUIRE(contacts.count >= 1);
        REQUIRE(std::abs(contacts.contacts[0].gap - distance) < 1e-12);
        if (i > 0) REQUIRE(std::abs(distance - before) < 2.0 * M_PI * M_PI * away / 2000);
        before = distance;
      }
    }
  }
}

TEST_CASE("a held part lets go at the border and on its way back, and nowhere else", "[unit]") {
  const Scene scene = sceneOf(meshShape(sheet(9)));
  const Tool tool = sphereTool(0.2e-3);
  ToolTrack track = makeToolTrack(scene, tool);
  double z = 1e-3, x = 0.0;
  for (; z > -1e-3; z -= kTick) (void)follow(scene, tool, at({x, 0, z}), track);
  for (; x < 0.0099; x += kTick / 10) {
    const ContactSnapshot held = follow(scene, tool, at({x, 0, z}), track);
    REQUIRE(held.count == 1);
    REQUIRE(held.contacts[0].normal.z() > 0.999);
    REQUIRE(std::abs(held.contacts[0].gap - z + 0.2e-3) < 1e-9);
  }
  ToolTrack copy = track;
  for (; x < 0.012; x += kTick / 10) (void)follow(scene, tool, at({x, 0, z}), track);
  const ContactSnapshot gone = follow(scene, tool, at({x, 0, z}), track, 0.02);
  REQUIRE(gone.count == 1);
  CHECK(gone.contacts[0].gap > 0.0);
  for (x = 0.0099; x > 0.0; x -= kTick / 10) (void)follow(scene, tool, at({x, 0, z}), track);
  CHECK(follow(scene, tool, at({x, 0, z}), track).contacts[0].normal.z() < -0.999);  // now it is below
  // A copy continues from its own state.
  CHECK(follow(scene, tool, at({0.0098, 0, z}), copy).contacts[0].normal.z() > 0.999);
  for (; z < 0.3e-3; z += kTick / 10) {
    const ContactSnapshot back = follow(scene, tool, at({0.0098, 0, z}), copy);
    REQUIRE(std::abs(back.contacts[0].gap - z + 0.2e-3) < 1e-9);
  }
}

TEST_CASE("fast walks into blades, wedges, teeth of a comb and soups never change sides", "[unit]") {
  TriangleMesh comb;
  for (int i = -4; i <= 4; ++i)
    comb = test::joined(comb, test::transformed(test::boxMesh({0.02e-3, 4e-3, 3e-3}), 1.0, {1e-3 * i, 0, 0}));
  TriangleMesh soup;
  test::Random random(73);
  for (int i = 0; i < 60; ++i) {
    const int first = 3 * i;
    for (int k = 0; k < 3; ++k) soup.vertices.push_back(random.vector(6e-3));
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  const TriangleMesh wedge = test::transformed(test::wedge(0.02), 5e-3, Vec3::Zero());
  int held = 0, cornered = 0;
  for (const TriangleMesh* mesh : {&std::as_const(comb), &wedge, &std::as_const(soup)}) {
    const Scene scene = sceneOf(meshShape(*mesh));
    const MeshModel& model = *std::get<std::shared_ptr<const MeshModel>>(scene.obstacles()[0].shape);
    for (const Tool& tool : {sphereTool(0.15e-3), sphereTool(0.0), capsuleTool({0, 0, 0}, {0, 1e-3, 4e-3}, 0.2e-3)})
      for (int walk = 0; walk < test::count(20, 2000); ++walk) {
        ToolTrack track = makeToolTrack(scene, tool);
        const double radius = tool.parts[0].radius;
        const Vec3 goal = random.vector(5e-3);
        Vec3 p = 0.014 * random.direction();
        for (int i = 0; i < 60; ++i) {
          const Vec3 way = i < 40 ? Vec3(goal - p) : Vec3(0.014 * p.normalized() - p);
          p += std::min(1.0, kTick / (way.norm() + 1e-12)) * way + 0.1 * kTick * random.direction();
          const ContactSnapshot contacts = follow(scene, tool, at(p), track, 0.0);
          for (int k = 0; k < contacts.count; ++k) {
            REQUIRE(contacts.contacts[k].gap <= 0.0);
            REQUIRE(std::abs(contacts.contacts[k].normal.norm() - 1.0) < 1e-5);  // over the skin or less, 1e-7 m
          }
          if (contacts.count != 1 || !(contacts.contacts[0].gap < -radius) || tool.parts[0].a != tool.parts[0].b)
            continue;
          // If the tool is held, the held place is at the surface, outside. In a soup, sheets cross each other: held by
          // two in the corner between them, the single contact is on neither.
          const Contact& contact = contacts.contacts[0];
          const Vec3 place = p - (contact.gap + radius - 2e-6) * contact.normal;
          const bool isOnIt = closestPoint(model, place).distance < 3e-6;
          if (mesh != &soup) REQUIRE((isOnIt && test::windingNumber(*mesh, place) < 0.5));
          ++(isOnIt ? held : cornered);
        }
        (void)follow(scene, tool, at({0, 0, 0.05}), track);
        REQUIRE(follow(scene, tool, at({0, 0, 0.05}), track, 1e-3).count == 0);
      }
  }
  CHECK(held > 100 / test::kSlowdown);
  CHECK(20 * cornered <= held);
}

TEST_CASE("a sheet has two sides, a thickness and no inside", "[unit]") {
  const double thick = 0.4e-3;
  for (const bool isBall : {false, true}) {
    Scene scene;
    Obstacle obstacle{"sheet",
                      meshShape(isBall ? test::transformed(test::ball(4), 0.01, Vec3::Zero()) : sheet(5)),
                      Pose(),
                      Vec6::Zero(),
                      {}};
    obstacle.thickness = thick;
    scene.add(obstacle);
    const MeshModel& model = *std::get<std::shared_ptr<const MeshModel>>(scene.obstacles()[0].shape);
    test::Random random(74);
    for (int i = 0; i < 500; ++i) {
      const Vec3 p = random.vector(0.01);
      const Tool tool = sphereTool(i % 2 == 0 ? 0.0 : 0.5e-3);
      const SurfacePoint near = closestPoint(model, p);
      const double gap = near.distance - 0.5 * thick - tool.parts[0].radius;
      const ContactSnapshot contacts = test::contactsOf(scene, tool, at(p), 0.02);
      REQUIRE(contacts.count >= 1);
      REQUIRE(std::abs(contacts.contacts[0].gap - gap) < 1e-12);
      REQUIRE((contacts.contacts[0].normal - (p - near.point) / near.distance).norm() < 1e-6);
      REQUIRE((p - tool.parts[0].radius * contacts.contacts[0].normal - contacts.contacts[0].point).norm() < 1e-12);
      REQUIRE(std::abs(nearestContact(scene, tool, at(p), nullptr).gap - gap) < 1e-12);
      ToolTrack track = makeToolTrack(scene, tool);
      REQUIRE(std::abs(follow(scene, tool, at(p), track, 0.02).contacts[0].gap - gap) < 1e-12);
    }
    ToolTrack track = makeToolTrack(scene, Tool());  // from inside, or from below
    const double side = isBall ? 0.01 : 0.0;
    for (double z = side - 3e-3; z < side + 3e-3; z += kTick) {
      const ContactSnapshot contacts = follow(scene, Tool(), at({0, 0, z}), track, 5e-3);
      REQUIRE(contacts.count >= 1);
      REQUIRE(contacts.contacts[0].normal.z() < -0.99);
      REQUIRE(std::abs(contacts.contacts[0].gap - (side - z - 0.5 * thick)) < 1e-5);  // the ball has flat faces
    }
  }
  Scene scene;
  Obstacle box{"box", Box{}, Pose(), Vec6::Zero(), {}};
  box.thickness = 1e-3;
  CHECK_THROWS_WITH(scene.add(box), test::ContainsSubstring("thickness"));
}

TEST_CASE("all triangles about a point, as many as there is room for", "[unit]") {
  const MeshModel model(test::ball(4, 0.1));
  test::Random random(75);
  int cut = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 p = random.vector(1.2);
    const double radius = random.uniform(0.0, 0.6);
    std::vector<int> all;
    for (std::size_t t = 0; t < model.mesh().triangles.size(); ++t) {
      const auto& v = model.mesh().triangles[t];
      if (test::referenceDistance(p, model.mesh().vertices[v[0]], model.mesh().vertices[v[1]],
                                  model.mesh().vertices[v[2]]) <= radius)
        all.push_back(static_cast<int>(t));
    }
    std::array<int, 100> found;
    const int capacity = i % 3 == 0 ? 0 : i % 3 == 1 ? 10 : 100;
    const TriangleCount answer = trianglesWithin(model, p, radius, found.data(), capacity);
    REQUIRE(answer.status == Status::ok);
    REQUIRE(answer.found == static_cast<int>(all.size()));
    const std::size_t written = std::min(all.size(), static_cast<std::size_t>(capacity));
    REQUIRE(std::equal(all.begin(), all.begin() + static_cast<long>(written), found.begin()));
    cut += written < all.size();
  }
  CHECK(cut > 50);
  CHECK(trianglesWithin(model, Vec3(std::nan(""), 0, 0), 1.0, nullptr, 0).status == Status::notFinite);
  CHECK(trianglesWithin(model, Vec3::Zero(), -1.0, nullptr, 0).status == Status::outOfRange);
}

TEST_CASE("a contact keeps its key while it slides", "[unit]") {
  const Scene scene = sceneOf(meshShape(test::transformed(test::ball(4, 0.05), 0.01, Vec3::Zero())));
  const Tool tool = sphereTool(0.5e-3);
  ToolTrack track = makeToolTrack(scene, tool);
  std::uint32_t key = 0;
  int triangles = 0, triangle = -1;
  for (int i = 0; i < 400; ++i) {
    const Vec3 direction(std::sin(0.005 * i), 0.1, std::cos(0.005 * i));
    const SurfacePoint near = signedDistance(*std::get<std::shared_ptr<const MeshModel>>(scene.obstacles()[0].shape),
                                             0.0112 * direction.normalized());
    const ContactSnapshot contacts = follow(scene, tool, at(near.point + 0.4e-3 * near.normal), track, 2e-4);
    REQUIRE(contacts.count >= 1);
    REQUIRE(contacts.contacts[0].key != 0);
    if (i > 0) REQUIRE(contacts.contacts[0].key == key);
    key = contacts.contacts[0].key;
    triangles += contacts.contacts[0].triangle != triangle;
    triangle = contacts.contacts[0].triangle;
  }
  CHECK(triangles > 10);
  CHECK(follow(scene, tool, at({0, 0, 0.013}), track, 2e-4).count == 0);
  const ContactSnapshot again = follow(scene, tool, at({0, 0, 0.0108}), track, 1e-3);
  REQUIRE(again.count >= 1);
  CHECK(again.contacts[0].key != key);
}

}  // namespace enamel::test_tool_track
