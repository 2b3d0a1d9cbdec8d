// OpenMesh meshes as obstacles: handles are numbers, and edits reach the mesh, the model and the drawing thread alike.
#include "enamel/collision/openmesh.hpp"

#include <atomic>
#include <chrono>
#include <cstring>
#include <thread>

#include "collision/mesh_data.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"

namespace enamel::test_openmesh {

namespace {

struct DoubleTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using FloatMesh = OpenMesh::TriMesh_ArrayKernelT<>;
using DoubleMesh = OpenMesh::TriMesh_ArrayKernelT<DoubleTraits>;
using OpenMesh::FaceHandle;
using OpenMesh::VertexHandle;

// Return the molar; or a ball of its size for the short run under a sanitizer.
TriangleMesh molar() {
  if (test::kSlowdown > 1 && !test::longRun()) return test::transformed(test::ball(4, 0.1), 5e-3, Vec3::Zero());
  return loadMesh(ENAMEL_SOURCE_DIR "/data/meshes/molar.ply", 1e-3);
}

std::uint64_t mixed(std::uint64_t h, std::uint64_t value) {
  h = (h ^ value) * 0x9e3779b97f4a7c15u;
  return h ^ h >> 29;
}

// A reader's copy of a mesh, and a sum over all of it that is updated as items change.
struct Copy {
  std::vector<Vec3> vertices;
  std::vector<std::array<int, 3>> triangles;  // all -1: missing
  std::uint64_t sum = 0;

  explicit Copy(const TriangleMesh& mesh) {
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) setVertex(static_cast<int>(v), mesh.vertices[v]);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) setTriangle(static_cast<int>(t), mesh.triangles[t]);
  }

  void setVertex(int number, const Vec3& position) {
    const auto v = static_cast<std::size_t>(number);
    if (v >= vertices.size()) vertices.resize(v + 1, Vec3::Zero());
    sum -= hash(v, vertices[v]);
    vertices[v] = position;
    sum += hash(v, vertices[v]);
  }
  void setTriangle(int number, const std::array<int, 3>& corners) {
    const auto t = static_cast<std::size_t>(number);
    if (t >= triangles.size()) triangles.resize(t + 1, {-1, -1, -1});
    sum -= hash(t, triangles[t]);
    triangles[t] = corners;
    sum += hash(t, triangles[t]);
  }
  void apply(const MeshChange& change) {
    for (std::size_t i = 0; i < change.vertices.size(); ++i) setVertex(change.vertices[i], change.positions[i]);
    for (std::size_t i = 0; i < change.triangles.size(); ++i) setTriangle(change.triangles[i], change.corners[i]);
  }

  bool operator==(const MeshModel& model) const {
    if (vertices != model.mesh().vertices || triangles.size() != model.mesh().triangles.size()) return false;
    for (std::size_t t = 0; t < triangles.size(); ++t)
      if (triangles[t] != cornersIn(model, static_cast<int>(t))) return false;
    return true;
  }
  static std::array<int, 3> cornersIn(const MeshModel& model, int t) {
    return isPresent(model, t) ? model.mesh().triangles[static_cast<std::size_t>(t)] : std::array<int, 3>{-1, -1, -1};
  }

 private:
  // 0 for items that were never set.
  static std::uint64_t hash(std::size_t number, const Vec3& v) {
    std::uint64_t h = 2 * number + 1;
    for (int k = 0; k < 3; ++k) {
      std::uint64_t bits;
      std::memcpy(&bits, &v[k], sizeof bits);
      h = mixed(h, bits);
    }
    return v.isZero(0.0) ? 0 : h;
  }
  static std::uint64_t hash(std::size_t number, const std::array<int, 3>& t) {
    std::uint64_t h = 2 * number;
    for (const int v : t) h = mixed(h, static_cast<std::uint64_t>(v));
    return t[0] < 0 ? 0 : h;
  }
};

// Edits as of a drill and a finger, anywhere on a mesh. An edit that fails ends the test.
template <typename Mesh>
class Editor {
 public:
  Editor(EditableMesh<Mesh>& mesh, std::uint64_t seed) : mesh_(mesh), random_(seed), known_(mesh.model()->mesh()) {}

  // Edit, and return the sum over the model, updated by what the model reports of the touched items.
  std::uint64_t edit() {
    touchedVertices_.clear();
    touchedFaces_.clear();
    doEdit();
    const MeshModel& model = *mesh_.model();
    for (const VertexHandle v : touchedVertices_)
      known_.setVertex(v.idx(), model.mesh().vertices[static_cast<std::size_t>(v.idx())]);
    for (const FaceHandle f : touchedFaces_) known_.setTriangle(f.idx(), Copy::cornersIn(model, f.idx()));
    return known_.sum;
  }

 private:
  void doEdit() {
    const double kind = random_.uniform(0.0, 1.0);
    if (kind < 0.5) {
      push();
    } else if (kind < 0.75) {
      splitFace();
    } else if (kind < 0.9) {
      makeHole();
    } else {
      closeHole();
    }
  }

  int pick(std::size_t count) {
    return static_cast<int>(
        std::min(static_cast<std::size_t>(random_.uniform(0.0, static_cast<double>(count))), count - 1));
  }
  FaceHandle pickFace() {
    for (;;) {
      const FaceHandle face(pick(mesh_.mesh().n_faces()));
      if (!mesh_.mesh().status(face).deleted()) return face;
    }
  }
  std::array<VertexHandle, 3> cornersOf(FaceHandle face) const {
    auto v = mesh_.mesh().cfv_begin(face);
    std::array<VertexHandle, 3> corners;
    for (VertexHandle& corner : corners) corner = *v++;
    return corners;
  }
  typename Mesh::Point moved(const typename Mesh::Point& p) {
    const Vec3 d = 2e-5 * random_.direction();
    using Scalar = typename Mesh::Scalar;
    return p + typename Mesh::Point(static_cast<Scalar>(d.x()), static_cast<Scalar>(d.y()), static_cast<Scalar>(d.z()));
  }
  void add(const std::array<VertexHandle, 3>& v) {
    touchedFaces_.push_back(mesh_.addFace(v[0], v[1], v[2]));
    REQUIRE(touchedFaces_.back().is_valid());
  }
  void remove(const std::vector<FaceHandle>& faces) {
    REQUIRE(mesh_.deleteFaces(faces.data(), static_cast<int>(faces.size())) == Status::ok);
    touchedFaces_ = faces;
  }

  void push() {  // a vertex and its ring
    const VertexHandle centre = cornersOf(pickFace())[0];
    std::vector<VertexHandle> vertices{centre};
    for (const VertexHandle v : mesh_.mesh().vv_range(centre)) vertices.push_back(v);
    std::vector<typename Mesh::Point> points;
    for (const VertexHandle v : vertices) points.push_back(moved(mesh_.mesh().point(v)));
    REQUIRE(mesh_.moveVertices(vertices.data(), points.data(), static_cast<int>(vertices.size())) == Status::ok);
    touchedVertices_ = vertices;
  }
  void splitFace() {
    const FaceHandle face = pickFace();
    const std::array<VertexHandle, 3> v = cornersOf(face);
    const Mesh& mesh = mesh_.mesh();
    const auto middle = (mesh.point(v[0]) + mesh.point(v[1]) + mesh.point(v[2])) / typename Mesh::Scalar(3);
    remove({face});
    const VertexHandle tip = mesh_.addVertex(moved(middle));
    REQUIRE(tip.is_valid());
    touchedVertices_.push_back(tip);
    for (std::size_t i = 0; i < 3; ++i) add({v[i], v[(i + 1) % 3], tip});
  }
  void makeHole() {
    const FaceHandle face = pickFace();
    std::vector<FaceHandle> faces{face};
    for (const FaceHandle f : mesh_.mesh().ff_range(face)) faces.push_back(f);
    for (const FaceHandle f : faces) holes_.push_back(cornersOf(f));
    remove(faces);
  }
  void closeHole() {  // a face in a wrong place among others is refused
    if (holes_.empty()) return;
    const std::array<VertexHandle, 3> v = holes_.back();
    holes_.pop_back();
    const std::size_t before = mesh_.mesh().n_faces();
    const FaceHandle face = mesh_.addFace(v[0], v[1], v[2]);
    REQUIRE(mesh_.mesh().n_faces() == before + (face.is_valid() ? 1 : 0));
    REQUIRE(mesh_.model()->mesh().triangles.size() == mesh_.mesh().n_faces());
    if (face.is_valid()) touchedFaces_.push_back(face);
  }

  EditableMesh<Mesh>& mesh_;
  test::Random random_;
  std::vector<std::array<VertexHandle, 3>> holes_;
  Copy known_;
  std::vector<VertexHandle> touchedVertices_;
  std::vector<FaceHandle> touchedFaces_;
};

// Compare the model with OpenMesh's half-edges, and with a new model.
template <typename Mesh>
void compareWithNew(const EditableMesh<Mesh>& edited, test::Random& random, int queries) {
  const MeshModel& model = *edited.model();
  const kernel::MeshData& data = kernel::Inside::of(model);
  std::vector<int> numbers, numberOf(model.mesh().triangles.size(), -1);
  const Mesh& mesh = edited.mesh();
  for (const FaceHandle f : mesh.faces()) {  // all faces that are not deleted
    REQUIRE(isPresent(model, f.idx()));
    numberOf[static_cast<std::size_t>(f.idx())] = static_cast<int>(numbers.size());
    numbers.push_back(f.idx());
    for (const OpenMesh::HalfedgeHandle h : mesh.fh_range(f)) {
      const auto& t = model.mesh().triangles[static_cast<std::size_t>(f.idx())];
      const auto edge = std::find(t.begin(), t.end(), mesh.from_vertex_handle(h).idx()) - t.begin();
      REQUIRE(edge < 3);
      REQUIRE(data.neighbour[f.idx()][static_cast<std::size_t>(edge)] == mesh.opposite_face_handle(h).idx());
    }
  }
  const MeshModel fresh(presentMesh(model));
  REQUIRE(fresh.mesh().triangles.size() == numbers.size());
  const kernel::MeshData& built = kernel::Inside::of(fresh);
  CHECK(data.openEdges == built.openEdges);
  CHECK(data.crowdedEdges == built.crowdedEdges);
  CHECK(data.closed == built.closed);
  for (std::size_t t = 0; t < numbers.size(); ++t)
    for (std::size_t i = 0; i < 3; ++i) {
      const int other = data.neighbour[numbers[t]][i];
      REQUIRE(built.neighbour[t][i] == (other < 0 ? -1 : numberOf[static_cast<std::size_t>(other)]));
    }
  const double size = test::sizeOf(fresh.mesh());
  ProximityCache cache;
  Vec3 p = Vec3::Zero();
  for (int i = 0; i < queries; ++i) {
    p = i % 4 == 0 ? test::queryPoint(fresh.mesh(), size, random) : Vec3(p + 1e-4 * random.direction());
    const SurfacePoint a = closestPoint(model, p, &cache), b = closestPoint(fresh, p);
    REQUIRE(a.triangle == numbers[static_cast<std::size_t>(b.triangle)]);
    REQUIRE(a.distance == b.distance);
    REQUIRE(a.point == b.point);
    if (!isSound(model) || !isSound(fresh) || a.distance < 1e-7 * size) continue;
    REQUIRE(signedDistance(model, p, &cache).distance == signedDistance(fresh, p).distance);
  }
}

template <typename Mesh>
void checkEdits(const TriangleMesh& start, int edits, int rebuilds) {
  EditableMesh<Mesh> mesh(toOpenMesh<Mesh>(start), {edits, 3 * edits});
  Copy drawn(mesh.model()->mesh());
  Editor<Mesh> editor(mesh, 81);
  test::Random random(82);
  std::uint64_t taken = 0;
  for (int i = 1; i <= edits; ++i) {
    const std::uint64_t sum = editor.edit(), revision = mesh.publish();
    if (i % 7 != 3) {  // a reader that is sometimes late
      while (const MeshChange* change = mesh.takeChanges()) {
        drawn.apply(*change);
        taken = change->revision;
        mesh.publish();
      }
      REQUIRE(taken == revision);
      REQUIRE(drawn.sum == sum);
    }
    if (i % (edits / rebuilds) != 0) continue;
    compareWithNew(mesh, random, 300);
    if (taken == revision) REQUIRE(drawn == *mesh.model());
  }
  CHECK(taken > static_cast<std::uint64_t>(edits) * 8 / 10);  // the other edits found no hole to close
}

}  // namespace

TEMPLATE_TEST_CASE("handles are numbers, there and back", "[unit]", FloatMesh, DoubleMesh) {
  TriangleMesh mesh = test::ball(2, 0.1);
  mesh.vertices.push_back(Vec3(3, 0, 0));  // a loose vertex
  for (Vec3& v : mesh.vertices) v = v.cast<float>().template cast<double>();
  TestType there = toOpenMesh<TestType>(mesh);
  const TriangleMesh back = fromOpenMesh(there);
  CHECK(back.vertices == mesh.vertices);
  REQUIRE(back.triangles.size() == mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<int, 3> turned = back.triangles[t];
    std::rotate(turned.begin(), std::find(turned.begin(), turned.end(), mesh.triangles[t][0]), turned.end());
    REQUIRE(turned == mesh.triangles[t]);
  }
  there.request_face_status();
  there.request_edge_status();
  there.request_vertex_status();
  there.delete_face(FaceHandle(7), false);
  CHECK_THROWS_WITH(fromOpenMesh(there), "face 7 is marked as deleted: call garbage_collection() before");
  mesh.triangles.push_back(mesh.triangles[5]);
  CHECK_THROWS_WITH(toOpenMesh<TestType>(mesh), test::ContainsSubstring("triangle 128 does not fit"));
  mesh.triangles.back() = {3, 3, 5};
  CHECK_THROWS_WITH(toOpenMesh<TestType>(mesh), test::ContainsSubstring("triangle 128 does not fit"));
  mesh.triangles.pop_back();
  mesh.vertices.back() = Vec3(100, 0, 0);
  CHECK_THROWS_WITH(EditableMesh<TestType>(toOpenMesh<TestType>(mesh)), test::ContainsSubstring("vertex 66"));
}

TEST_CASE("edits that are refused change nothing", "[unit]") {
  EditableMesh<DoubleMesh> mesh(toOpenMesh<DoubleMesh>(test::boxMesh({1, 1, 1})), {1, 1});
  const VertexHandle bad(8), good(0);
  const OpenMesh::Vec3d point(0.5, 0.5, 0.5), far(100, 0, 0), none(std::nan(""), 0, 0);
  const FaceHandle faces[2] = {FaceHandle(0), FaceHandle(12)};
  CHECK(mesh.moveVertices(&bad, &point, 1) == Status::outOfRange);
  CHECK(mesh.moveVertices(&good, &far, 1) == Status::outOfRange);
  CHECK(mesh.moveVertices(&good, &none, 1) == Status::notFinite);
  CHECK(mesh.deleteFaces(faces, 2) == Status::outOfRange);
  CHECK_FALSE(mesh.addVertex(far).is_valid());
  CHECK_FALSE(mesh.addFace(VertexHandle(0), VertexHandle(1), VertexHandle(2)).is_valid());
  CHECK_FALSE(mesh.addFace(VertexHandle(0), VertexHandle(0), VertexHandle(2)).is_valid());
  CHECK_FALSE(mesh.addFace(VertexHandle(0), VertexHandle(1), VertexHandle(8)).is_valid());
  CHECK(mesh.publish() == 0);
  CHECK(mesh.takeChanges() == nullptr);
  CHECK(mesh.mesh().n_faces() == 12);
  CHECK(mesh.addVertex(point).idx() == 8);
  CHECK_FALSE(mesh.addVertex(point).is_valid());  // no room
  CHECK(mesh.deleteFaces(faces, 1) == Status::ok);
  const auto& t = mesh.model()->mesh().triangles[0];
  const VertexHandle a(t[0]), b(t[1]), c(t[2]);
  CHECK(mesh.addFace(a, b, c).idx() == 12);
  CHECK_FALSE(mesh.addFace(a, b, VertexHandle(8)).is_valid());
  CHECK(mesh.publish() == 1);
  const MeshChange* change = mesh.takeChanges();
  REQUIRE(change != nullptr);
  CHECK(change->revision == 1);
  CHECK(change->vertices == std::vector<int>{8});
  CHECK(change->triangles == std::vector<int>{0, 12});
  CHECK(change->corners[0] == std::array<int, 3>{-1, -1, -1});
  CHECK(mesh.takeChanges() == nullptr);
}

TEST_CASE("after many edits the model is as one built anew, and so is what is drawn", "[unit]") {
  checkEdits<FloatMesh>(molar(), test::count(1500, 100000), test::longRun() ? 20 : 2);
  checkEdits<DoubleMesh>(test::ball(2, 0.1), test::count(500, 10000), 5);
}

TEST_CASE("a thread that draws has the mesh of every revision that it takes", "[unit]") {
  const int edits = test::count(1000, 100000);
  EditableMesh<FloatMesh> mesh(toOpenMesh<FloatMesh>(molar()), {edits, 3 * edits});
  Copy drawn(mesh.model()->mesh());
  std::vector<std::uint64_t> sums(static_cast<std::size_t>(edits) + 1);  // by revision
  std::atomic<bool> isOver{false};
  std::atomic<std::uint64_t> last{0};
  int takes = 0, wrong = 0;
  std::thread reader([&] {
    for (;;) {
      const bool over = isOver.load();
      const MeshChange* change = mesh.takeChanges();
      if (change == nullptr && over) return;
      if (change == nullptr) {
        std::this_thread::yield();
        continue;
      }
      drawn.apply(*change);
      wrong += sums[change->revision] != drawn.sum || change->revision <= last.load();
      last = change->revision;
      ++takes;
    }
  });
  Editor<FloatMesh> editor(mesh, 83);
  std::uint64_t revision = 0;
  for (int i = 0; i < edits; ++i) {
    sums[revision + 1] = editor.edit();
    revision = mesh.publish();
    if (i == edits / 2)  // during the edits, at least one change has been taken
      for (; last == 0; mesh.publish()) std::this_thread::sleep_for(std::chrono::microseconds(20));
  }
  for (; last < revision; mesh.publish()) std::this_thread::yield();
  isOver = true;
  reader.join();
  CHECK(wrong == 0);
  CHECK(last.load() == revision);
  CHECK(takes > 1);
  CHECK(drawn == *mesh.model());
}

}  // namespace enamel::test_openmesh
