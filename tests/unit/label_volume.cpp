// Labels of voxels become closed meshes and solids: balls against their formulas, any spacing and orientation.
#include "enamel/collision/label_volume.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>

#include "enamel/collision/proximity.hpp"
#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"
#include "support/run_length.hpp"

namespace enamel::test_label_volume {

namespace {

constexpr double kPi = 3.14159265358979323846;

double sum(const RemovedVolume& volume) { return std::accumulate(volume.begin(), volume.end(), 0.0); }
double ballVolume(double radius) { return 4.0 / 3.0 * kPi * radius * radius * radius; }

// Label each voxel by the position of its centre.
LabelVolume volumeOf(const std::array<int, 3>& size, const Vec3& spacing, const Vec3& origin, const Mat3& axes,
                     const std::function<int(const Vec3&)>& labelAt) {
  LabelVolume volume{size, spacing, origin, axes, {}};
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x)
        volume.labels.push_back(
            static_cast<std::uint16_t>(labelAt(origin + axes * Vec3(x, y, z).cwiseProduct(spacing))));
  return volume;
}

// Three balls around one centre: pulp 3, dentine 2, enamel 1.
LabelVolume tooth(const std::array<int, 3>& size, const Vec3& spacing, const Mat3& axes, Vec3& centre) {
  const Vec3 origin(1e-3, -2e-3, 3e-3);
  centre =
      origin + axes * Vec3(0.5 * (size[0] - 1), 0.5 * (size[1] - 1) + 0.3, 0.5 * (size[2] - 1)).cwiseProduct(spacing);
  return volumeOf(size, spacing, origin, axes, [&](const Vec3& p) {
    const double r = (p - centre).norm();
    return r < 0.6e-3 ? 3 : r < 1.2e-3 ? 2 : r < 2e-3 ? 1 : 0;
  });
}

// Root mean square of the angle between the triangles of a ball and the ball, deg.
double tiltOf(const TriangleMesh& mesh, const Vec3& centre) {
  double all = 0.0, weighted = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[static_cast<std::size_t>(t[0])], &b = mesh.vertices[static_cast<std::size_t>(t[1])],
               &c = mesh.vertices[static_cast<std::size_t>(t[2])];
    const Vec3 normal = (b - a).cross(c - a), out = (a + b + c) / 3.0 - centre;
    const double angle = std::atan2(normal.cross(out).norm(), normal.dot(out)), area = normal.norm();
    all += area;
    weighted += area * angle * angle;
  }
  return std::sqrt(weighted / all) * 180.0 / kPi;
}

}  // namespace

TEST_CASE("labels: a ball of voxels becomes a ball, for any spacing and orientation", "[unit]") {
  test::Random random(5720);
  for (const Vec3& spacing : {Vec3(1e-4, 1e-4, 1e-4), Vec3(0.8e-4, 1e-4, 1.3e-4)})
    for (const bool isReflected : {false, true}) {
      CAPTURE(spacing.z(), isReflected);
      Mat3 axes = random.rotation(3.0);
      if (isReflected) axes.col(1) *= -1.0;
      Vec3 centre;
      const LabelVolume volume = tooth({54, 48, 46}, spacing, axes, centre);
      for (const double radius : {2e-3, 1.2e-3}) {
        const std::vector<int> labels = radius > 1.5e-3 ? std::vector<int>{1, 2, 3} : std::vector<int>{3, 2};
        const double smoothing = 1e-4;
        const TriangleMesh mesh = surfaceOf(volume, labels, smoothing);
        const MeshReport report = inspect(mesh);
        CHECK(report.watertight);
        CHECK_FALSE(report.inwards);
        CHECK(report.nonManifoldEdges + report.nonManifoldVertices + report.flippedEdges == 0);
        CHECK(report.degenerateTriangles + report.duplicateTriangles == 0);
        CHECK(report.components == 1);
        CHECK(isSound(MeshModel(mesh)));
        // The surface moves inwards by smoothing^2 / R. Labels locate it to half a voxel.
        const double expected = radius - smoothing * smoothing / radius;
        double worst = 0.0, mean = 0.0;
        for (const Vec3& v : mesh.vertices) {
          worst = std::max(worst, std::abs((v - centre).norm() - expected));
          mean += ((v - centre).norm() - expected) / static_cast<double>(mesh.vertices.size());
        }
        CHECK(worst < 0.5 * spacing.maxCoeff());
        CHECK(std::abs(mean) < 0.02 * spacing.maxCoeff());
        CHECK(report.volume == Approx(ballVolume(expected)).epsilon(0.005));
        // Without smoothing the surface has the steps of the voxels.
        const double smooth = tiltOf(mesh, centre), stepped = tiltOf(surfaceOf(volume, labels, 0.0), centre);
        if (test::longRun())
          std::printf("%.1f mm: %.1f um off at most, %.2f um on average; tilt %.1f deg, without smoothing %.1f deg\n",
                      1e3 * radius, 1e6 * worst, 1e6 * mean, smooth, stepped);
        CHECK(smooth < 0.3 * stepped);
      }
    }
}

TEST_CASE("labels: layers of a solid, and a tooth that touches the border of the volume", "[unit]") {
  Vec3 centre;
  const double smoothing = 1e-4;
  const LabelVolume volume = tooth({48, 48, 48}, Vec3::Constant(1e-4), Mat3::Identity(), centre);
  std::vector<LabelLayer> layers(3);
  layers[0].layer.name = "enamel";
  layers[0].labels = {1};
  layers[1].layer.name = "dentine";
  layers[1].layer.hardness = 0.6e9;
  layers[1].labels = {2};
  layers[2].layer.name = "pulp";
  layers[2].labels = {3};
  const Solid solid = solidOf(volume, layers, smoothing, {1e-4});
  const auto radius = [&](double r) { return r - smoothing * smoothing / r; };
  CHECK(sum(solid.volume()) == Approx(ballVolume(radius(2e-3))).epsilon(0.005));
  // A cell has the layer of its corner: a border is off by up to half a cell.
  for (int k = 0; k < 2; ++k) {
    const double inner = radius(k == 0 ? 1.2e-3 : 0.6e-3);
    double within = 0.0;
    for (std::size_t j = static_cast<std::size_t>(k) + 1; j < 3; ++j) within += solid.volume()[j];
    CHECK(within == Approx(ballVolume(inner)).margin(4.0 * kPi * inner * inner * 0.5e-4));
  }
  CHECK(solid.layerAt(centre) == 2);
  CHECK(solid.layerAt(centre + Vec3(0.9e-3, 0.0, 0.0)) == 1);
  CHECK(solid.layerAt(centre + Vec3(0.0, 1.6e-3, 0.0)) == 0);
  CHECK(solid.layers()[1].hardness == 0.6e9);
  // Of a block that fills the volume, the mesh is closed at the border, half a voxel outside of the last centres.
  const LabelVolume full =
      volumeOf({10, 8, 6}, Vec3::Constant(1e-4), Vec3::Zero(), Mat3::Identity(), [](const Vec3&) { return 7; });
  const MeshReport block = inspect(surfaceOf(full, {7}, 0.0));
  CHECK(block.watertight);
  CHECK((block.low - Vec3::Constant(-0.5e-4)).norm() < 1e-12);
  CHECK((block.high - Vec3(9.5e-4, 7.5e-4, 5.5e-4)).norm() < 1e-12);
  CHECK(block.volume == Approx(480e-12).epsilon(0.05));  // edges are cut off
}

TEST_CASE("labels: what is refused", "[unit]") {
  const auto label = [](const Vec3& p) { return p.norm() < 5e-4 ? 1 : 0; };
  const LabelVolume volume =
      volumeOf({16, 16, 16}, Vec3::Constant(1e-4), Vec3::Constant(-7.5e-4), Mat3::Identity(), label);
  CHECK_FALSE(surfaceOf(volume, {1}, 1e-4).triangles.empty());
  CHECK(surfaceOf(volume, {5, -1, 1 << 20}, 1e-4).triangles.empty());
  CHECK(surfaceOf(volume, {}, 1e-4).triangles.empty());
  const auto refused = [&](const std::function<void(LabelVolume&)>& change, const char* why, double smoothing = 1e-4) {
    LabelVolume changed = volume;
    change(changed);
    INFO(why);
    CHECK_THROWS_WITH(surfaceOf(changed, {1}, smoothing), test::ContainsSubstring(why));
  };
  const double bad = std::nan("");
  refused([](LabelVolume& v) { v.size[1] = 0; }, "at least 1");
  refused([](LabelVolume& v) { v.size = {1 << 20, 1 << 20, 1 << 20}; }, "2^28");
  refused([](LabelVolume& v) { v.labels.pop_back(); }, "4095 labels");
  refused([](LabelVolume& v) { v.spacing.y() = 0.0; }, "spacing");
  refused([&](LabelVolume& v) { v.origin.x() = bad; }, "orthonormal");
  refused([](LabelVolume& v) { v.axes(0, 1) = 0.1; }, "orthonormal");
  refused([](LabelVolume&) {}, "smoothing", -1e-6);
  refused([](LabelVolume&) {}, "smoothing", 2e-3);
  refused([](LabelVolume&) {}, "smoothing", bad);
  CHECK_THROWS_WITH(solidOf(volume, {}, 1e-4), test::ContainsSubstring("at least one layer"));
  std::vector<LabelLayer> layers(2);
  layers[0].labels = {1};
  layers[1].layer.name = "pulp";
  layers[1].labels = {2};
  CHECK_THROWS_WITH(solidOf(volume, layers, 1e-4), test::ContainsSubstring("layer \"pulp\": no voxels"));
}

}  // namespace enamel::test_label_volume
