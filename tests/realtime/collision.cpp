// No query or update of the collision module allocates. Allocations are counted by interposition, with valid and
// invalid input.
#include <malloc.h>

#include <cstdio>
#include <map>
#include <string>

#include "enamel/collision/mesh_update.hpp"
#include "enamel/collision/solid_changes.hpp"
#include "enamel/collision/sweep.hpp"
#include "enamel/collision/tool_sweep.hpp"
#include "support/allocation_counter.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/processor_time.hpp"

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
    step.position = pose.position + 0.005 * (i % 2) * random.direction();  // continues, or jumps
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
  Solid copy = *solid;
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
    copy.set(i % copy.bricks(), solid->samples(i % copy.bricks()));
    changes.publish(*solid);
    for (int k = 0; k < 10; ++k) taken += changes.take(change);
  }
  CHECK(test::allocationCount() == before);
  CHECK(touched > 1000);
  CHECK(taken > 1000);
}

namespace {

// Times at the limits of the accepted input, relative to one pass over every triangle or brick. Such a ratio does not
// depend on the machine. The bounds are three to four times the measured values.
class Costs {
 public:
  explicit Costs(double unit) : unit_(unit) {}

  template <typename Query, typename Prepare>
  void add(const char* name, const Query& query, const Prepare& prepare) {
    double& most = most_[name];
    most = std::max(most, test::leastTime(2, query, prepare) / unit_);
  }
  template <typename Query>
  void add(const char* name, const Query& query) {
    add(name, query, [] {});
  }

  void check(const std::map<std::string, double>& bounds) const {
    CHECK(most_.size() == bounds.size());
    for (const auto& [name, cost] : most_) {
      std::printf("  %-20s %6.2f looks\n", name.c_str(), cost);
      INFO(name << ": " << cost << " looks");
      CHECK(cost < bounds.at(name));
    }
  }

 private:
  double unit_;  // s
  std::map<std::string, double> most_;
};

// Return places at the centre of a ball of radius 1, where all of it is equally near, on it, near it, and extremely far
// away.
std::vector<Vec3> places() {
  std::vector<Vec3> all = {Vec3::Zero(), Vec3(0.5, 0.1, -0.2), Vec3::UnitZ(), Vec3(1.1, 0.1, 0.1), Vec3(3, 1, 2)};
  for (const double far : {1e3, 1e6, 1e100, 1e300}) all.push_back(far * Vec3(0.6, -0.64, 0.48));
  return all;
}

constexpr double kRadii[] = {0.0, 0.1, 1.0, 1e9, 1e300}, kMargins[] = {0.0, 1.0, 1e300};

Pose poseAt(const Vec3& place) { return {place, Mat3::Identity()}; }

// Return a tool with the ball's radius and the length of its diameter, which touches all of it.
Tool largeTool() {
  Tool tool;
  tool.parts[0] = {{-1, 0, 0}, {1, 0, 0}, 1.0};
  return tool;
}

void addToolQueries(const Scene& scene, Costs& costs) {
  const Tool tool = largeTool();
  ToolTrack track = makeToolTrack(scene, tool);
  ToolCache cache = makeToolCache(scene, tool);
  ContactSnapshot contacts;
  for (const Vec3& p : places()) {
    for (const double margin : kMargins) {
      costs.add("findContacts", [&] { (void)findContacts(scene, tool, poseAt(p), margin, nullptr, contacts); });
      costs.add("findContacts", [&] { (void)findContacts(scene, tool, poseAt(p), margin, &cache, contacts); });
      costs.add("followContacts", [&] { (void)followContacts(scene, tool, poseAt(p), margin, track, contacts); });
    }
    costs.add("nearestContact", [&] { (void)nearestContact(scene, tool, poseAt(p), nullptr); });
    for (const Vec3& q : places())
      costs.add("sweepTool", [&] { (void)sweepTool(scene, tool, poseAt(p), poseAt(q), nullptr); });
  }
}

void addMeshQueries(const MeshModel& mesh, Costs& costs) {
  std::vector<int> found(mesh.mesh().triangles.size());
  const int room = static_cast<int>(found.size());
  for (const Vec3& p : places()) {
    costs.add("closestPoint", [&] { closestPoint(mesh, p); });
    costs.add("signedDistance", [&] { signedDistance(mesh, p); });
    for (const double radius : kRadii)
      costs.add("trianglesWithin", [&] { trianglesWithin(mesh, p, radius, found.data(), room); });
    for (const Vec3& q : places()) {
      costs.add("closestToSegment", [&] { closestToSegment(mesh, {p, q}); });
      costs.add("pick", [&] { pick(mesh, {p, q}); });
      const Segment from{p, p + Vec3::UnitX()}, to{q, q - Vec3::UnitX()};
      for (const double radius : kRadii) {
        costs.add("sweepSphere", [&] { sweepSphere(mesh, p, q, radius); });
        costs.add("sweepCapsule", [&] { sweepCapsule(mesh, from, to, radius); });
        costs.add("sweepCapsule", [&] { sweepCapsule(mesh, {p, q}, {q, p}, radius); });
      }
    }
  }
}

}  // namespace

TEST_CASE("the cost of a query is bounded by the triangles of a mesh, whatever the input", "[realtime]") {
  TriangleMesh holed = test::ball(4);
  for (std::size_t t = 0; t < holed.triangles.size(); t += 7)
    holed.triangles.erase(holed.triangles.begin() + static_cast<long>(t));
  for (const TriangleMesh& triangles : {test::ball(4), holed}) {
    const auto mesh = std::make_shared<const MeshModel>(triangles);
    int one = -1;
    Costs costs(test::leastTime(9, [&] { trianglesWithin(*mesh, Vec3::Zero(), 1e3, &one, 1); }));
    CHECK(one == 0);
    addMeshQueries(*mesh, costs);
    Scene scene;
    scene.add({"mesh", mesh, Pose(), Vec6::Zero(), {}});
    addToolQueries(scene, costs);
    costs.check({{"closestPoint", 4.0},
                 {"closestToSegment", 25.0},
                 {"findContacts", 50.0},
                 {"followContacts", 50.0},
                 {"nearestContact", 10.0},
                 {"pick", 4.0},
                 {"signedDistance", 4.0},
                 {"sweepCapsule", 250.0},
                 {"sweepSphere", 20.0},
                 {"sweepTool", 120.0},
                 {"trianglesWithin", 15.0}});
  }
}

TEST_CASE("the cost of a query of analytic shapes is that of a few hundred distances, whatever the input",
          "[realtime]") {
  Scene scene;
  scene.add({"floor", HalfSpace{}, Pose(), Vec6::Zero(), {}});
  scene.add({"box", Box{{1.0, 0.5, 0.1}}, Pose(), Vec6::Zero(), {}});
  scene.add({"ball", Sphere{1.0}, Pose(), Vec6::Zero(), {}});
  scene.add({"rod", Capsule{0.1, 1.0}, Pose(), Vec6::Zero(), {}});
  double sum = 0.0;
  Costs costs(test::leastTime(9, [&] {
    for (int i = 0; i < 100; ++i) {
      const Vec3 p(0.3, 0.01 * i, 0.2);
      sum += signedDistance(HalfSpace{}, p).distance + signedDistance(Box{}, p).distance +
             signedDistance(Sphere{}, p).distance + signedDistance(Capsule{}, p).distance;
    }
  }));
  CHECK(std::isfinite(sum));
  addToolQueries(scene, costs);
  costs.check({{"findContacts", 25.0}, {"followContacts", 25.0}, {"nearestContact", 25.0}, {"sweepTool", 100.0}});
}

TEST_CASE("the cost of a query, an undo and a restoration is bounded by the bricks of a solid, whatever the input",
          "[realtime]") {
  const std::vector<SolidLayer> layers = {{"all", {}, 1e9, 0.0, nullptr}};
  const auto solid = std::make_shared<Solid>(MeshModel(test::ball(4)), layers, SolidOptions{0.03, 64});
  double sum = 0.0;
  const auto look = [&sum](const Solid& of) {
    for (int i = 0; i < of.bricks(); ++i)
      for (const float sample : of.samples(i)) sum += static_cast<double>(sample);
  };
  Costs costs(test::leastTime(9, [&] { look(*solid); }));
  for (const Vec3& p : places()) {
    costs.add("signedDistance", [&] { signedDistance(*solid, p); });
    costs.add("isInside", [&] { isInside(*solid, p); });
    for (const Vec3& q : places()) costs.add("closestToSegment", [&] { closestToSegment(*solid, {p, q}); });
  }
  Scene scene;
  scene.add({"solid", std::shared_ptr<const Solid>(solid), Pose(), Vec6::Zero(), {}});
  addToolQueries(scene, costs);
  costs.check({{"closestToSegment", 15.0},
               {"findContacts", 10.0},
               {"followContacts", 10.0},
               {"isInside", 0.1},
               {"nearestContact", 10.0},
               {"signedDistance", 10.0},
               {"sweepTool", 20.0}});

  // Cut all of a block, restore it, and send it.
  Solid block(MeshModel(test::boxMesh({5e-3, 5e-3, 3e-3})), layers, {1e-4, 4096});
  Costs ofBlock(test::leastTime(9, [&] { look(block); }));
  const auto cutAll = [&] {
    block.mark();
    const Segment across{{-5e-3, 0, 0}, {5e-3, 0, 0}};
    block.cut(across, across, Solid::kLargestBur);
  };
  ofBlock.add("restore", [&] { block.restore(); });
  ofBlock.add(
      "restore", [&] { block.restore(); }, cutAll);
  ofBlock.add(
      "undo", [&] { CHECK(block.undo()); }, cutAll);
  SolidChanges changes;
  BrickChange sent;
  const auto change = [&] {
    cutAll();
    block.restore();
    while (changes.take(sent)) {
    }
  };
  ofBlock.add(
      "publish", [&] { changes.publish(block, block.bricks()); }, change);
  ofBlock.check({{"restore", 5.0}, {"undo", 5.0}, {"publish", 5.0}});
  CHECK(std::isfinite(sum));
}

}  // namespace enamel::test_collision
