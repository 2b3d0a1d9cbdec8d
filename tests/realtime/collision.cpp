// No query or update of the collision module allocates: counted by interposition, with good and with bad input.
#include <malloc.h>

#include "enamel/collision/mesh_update.hpp"
#include "enamel/collision/solid_changes.hpp"
#include "enamel/collision/sweep.hpp"
#include "enamel/collision/tool_sweep.hpp"
#include "support/allocation_counter.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"

namespace enamel::test_collision {

TEST_CASE("a scene of planes and boxes pays for no mesh", "[realtime]") {
  const auto mesh = std::make_shared<const MeshModel>(test::ball(3, 0.1));
  Scene walls, meshes;
  for (const char* name : {"a", "b", "c", "d"}) {
    walls.add({name, HalfSpace{}, Pose(), Vec6::Zero(), {}});
    meshes.add({name, mesh, Pose(), Vec6::Zero(), {}});
  }
  walls.add({"box", Box{}, Pose(), Vec6::Zero(), {}});
  const auto bytesOf = [](const Scene& scene) {
    const std::size_t before = mallinfo2().uordblks;
    const ToolTrack track = makeToolTrack(scene, Tool());
    return mallinfo2().uordblks - before;
  };
  CHECK(bytesOf(walls) < 2000);
  CHECK(bytesOf(meshes) > 4 * 10000);  // the lists of near triangles
}

TEST_CASE("the collision module allocates nothing in a tick", "[realtime]") {
  const auto mesh = std::make_shared<MeshModel>(test::ball(5, 0.1), SpareCapacity{1000, 1000});
  const TriangleMesh closedWithFlats = [] {
    for (auto& [name, broken, closed] : test::brokenMeshes())
      if (name == "closed with zero areas") return broken;
    return TriangleMesh();
  }();
  const MeshModel flats(closedWithFlats);
  TriangleMesh holed = test::ball(4, 0.1);
  for (std::size_t t = 0; t < holed.triangles.size(); t += 7)
    holed.triangles.erase(holed.triangles.begin() + static_cast<long>(t));
  const auto open = std::make_shared<const MeshModel>(holed);
  Scene scene;
  scene.add({"mesh", std::shared_ptr<const MeshModel>(mesh), Pose(), Vec6::Zero(), {}});
  scene.add({"floor", HalfSpace{}, Pose(), Vec6::Zero(), {}});
  scene.add({"box", Box{{0.5, 0.5, 0.5}}, Pose(), Vec6::Zero(), {}});
  scene.add({"ball", Sphere{0.5}, Pose(), Vec6::Zero(), {}});
  scene.add({"rod", Capsule{0.1, 1.0}, Pose(), Vec6::Zero(), {}});
  scene.add({"open", open, Pose(), Vec6::Zero(), {}});
  Obstacle sheet{"sheet", open, Pose(), Vec6::Zero(), {}};
  sheet.thickness = 0.01;
  scene.add(sheet);
  Tool tool;
  tool.parts[0].radius = 0.2;
  tool.parts[1] = {{0, 0, 0}, {0.3, 0.2, 0.1}, 0.05};
  tool.count = 2;
  ToolCache cache = makeToolCache(scene, tool);
  ToolCache copy = cache;
  ToolTrack track = makeToolTrack(scene, tool), copyOfTrack = track;
  std::array<int, 64> near;
  ProximityCache one, other, copyOfOne;
  ContactSnapshot contacts;
  test::Random random(61);
  int undefined = 0;
  const auto use = [&undefined](double answer) { undefined += !std::isfinite(answer); };
  long allocated = 0;
  Vec3 p = Vec3::UnitX();
  for (int i = 0; i < 2000; ++i) {
    p = i % 20 == 0 ? test::queryPoint(mesh->mesh(), test::sizeOf(mesh->mesh()), random)
                    : Vec3(p + 0.003 * random.direction());
    const Vec3 q = i % 50 == 49 ? Vec3(std::nan(""), 0, 0) : Vec3(p + 0.1 * random.direction());
    const Vec3 onFlats = test::queryPoint(flats.mesh(), test::sizeOf(flats.mesh()), random);
    Pose pose, next, step;
    pose.position = p;
    next.position = q;
    next.rotation = test::rotationAbout(random.direction(), 0.3);
    const int vertex = i, triangle = 3 * i;
    const Vec3 moved = 0.99 * mesh->mesh().vertices[static_cast<std::size_t>(i)];
    const auto corners = mesh->mesh().triangles[static_cast<std::size_t>(triangle)];
    const long before = test::allocationCount();
    use(closestPoint(*mesh, p, &one).distance);
    use(signedDistance(*mesh, q).distance);
    use(signedDistance(flats, onFlats, &other).distance);
    use(sweepSphere(*mesh, p, q, 0.1, &one).time);
    use(sweepCapsule(*mesh, {p, q}, {q, p}, 0.01).time);
    use(closestToSegment(*mesh, {p, q}).parameter);
    use(pick(*mesh, {p, Vec3::Zero()}).time);
    use(findContacts(scene, tool, pose, 0.1, &cache, contacts) == Status::ok ? contacts.contacts[0].gap : 0.0);
    use(findContacts(scene, tool, next, 0.1, nullptr, contacts) == Status::ok ? contacts.contacts[0].gap : 0.0);
    use(nearestContact(scene, tool, pose, &cache).gap);
    use(signedDistance(*open, p, &one).distance);
    use(trianglesWithin(*open, p, 0.1, near.data(), 64).found);
    step.position = pose.position + 0.005 * (i % 2) * random.direction();  // goes on, or is put elsewhere
    use(followContacts(scene, tool, step, 0.1, track, contacts) == Status::ok ? contacts.contacts[0].gap : 0.0);
    copyOfTrack = track;
    copy = cache;
    copyOfOne = one;
    if (i % 10 == 0) use(sweepTool(scene, tool, pose, next, &cache).time);
    scene.move(2, pose, Vec6::Ones());
    use(moveVertices(*mesh, &vertex, &moved, 1) == Status::ok);
    use(removeTriangles(*mesh, &triangle, 1) == Status::ok);
    use(addVertices(*mesh, &moved, 1) == Status::ok);
    use(addTriangles(*mesh, &corners, 1) == Status::ok);
    if (i % 2 == 0) use(replaceTriangles(*mesh, &triangle, &corners, 1) == Status::ok);
    allocated += test::allocationCount() - before;
  }
  CHECK(undefined == 0);
  CHECK(allocated == 0);
}

TEST_CASE("a solid that is cut, asked, sent and restored allocates nothing", "[realtime]") {
  const auto solid =
      std::make_shared<Solid>(MeshModel(test::boxMesh({2e-3, 2e-3, 1e-3})),
                              std::vector<SolidLayer>{{"all", {}, 1e9, 0.0, nullptr}}, SolidOptions{1e-4, 10});
  Scene scene;
  scene.add({"solid", std::shared_ptr<const Solid>(solid), Pose(), Vec6::Zero(), {}});
  Tool tool;
  tool.parts[0].radius = 5e-4;
  tool.parts[1] = {{0, 0, 1e-3}, {0, 0, 5e-3}, 3e-4};
  tool.count = 2;
  ToolTrack track = makeToolTrack(scene, tool);
  ContactSnapshot contacts;
  SolidChanges changes;
  BrickChange change;
  test::Random random(62);
  int touched = 0, taken = 0;
  const long before = test::allocationCount();
  for (int i = 0; i < 1000; ++i) {
    Vec3 p = random.vector(2.5e-3);
    if (i % 50 == 49) p.x() = std::nan("");
    const Vec3 q = p + 2e-4 * random.direction();
    if (i % 10 == 0) solid->mark();
    solid->cut({p, p}, {q, q}, random.uniform(1e-4, 5e-4));
    Pose pose;
    pose.position = q;
    touched += signedDistance(*solid, p).found;
    touched += closestToSegment(*solid, {p, q}, 1e-3).found;
    touched += followContacts(scene, tool, pose, 1e-3, track, contacts) == Status::ok ? contacts.count : 0;
    if (i % 70 == 69) (void)solid->undo();
    if (i % 200 == 199) solid->restore();
    changes.publish(*solid);
    for (int k = 0; k < 10; ++k) taken += changes.take(change);
  }
  CHECK(test::allocationCount() == before);
  CHECK(touched > 1000);
  CHECK(taken > 1000);
}

}  // namespace enamel::test_collision
