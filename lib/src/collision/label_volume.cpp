#include "enamel/collision/label_volume.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "core/message.hpp"
#include "enamel/collision/proximity.hpp"
#include "enamel/core/error.hpp"
#include "grid_surface.hpp"

namespace enamel {
namespace {

constexpr double kMostVoxels = 1 << 28;
constexpr double kReach = 4.0;           // standard deviations of the Gaussian that count
constexpr double kMostSmoothing = 10.0;  // spacings
constexpr double kOrthonormal = 1e-3;    // files have rounded directions

void check(const LabelVolume& v, double smoothing) {
  double voxels = 1.0;
  for (const int size : v.size) {
    require(size > 0, "a volume of labels has " + std::to_string(size) + " voxels along an axis, must be at least 1");
    voxels *= size;
  }
  require(voxels <= kMostVoxels, "a volume of labels has more than 2^28 voxels: crop it");
  require(static_cast<double>(v.labels.size()) == voxels,
          "a volume of labels has " + std::to_string(v.labels.size()) + " labels, must have one for each voxel");
  require(v.spacing.allFinite() && v.spacing.minCoeff() > 0.0, "the spacing of a volume of labels must be above 0 m");
  require(v.origin.allFinite() && v.axes.allFinite() &&
              (v.axes.transpose() * v.axes - Mat3::Identity()).cwiseAbs().maxCoeff() < kOrthonormal,
          "the axes of a volume of labels must be orthonormal");
  require(smoothing >= 0.0 && smoothing <= kMostSmoothing * v.spacing.minCoeff(),
          "the smoothing is " + formatNumber(smoothing) + " m, must be in 0 to " +
              formatNumber(kMostSmoothing * v.spacing.minCoeff()) + " m");
}

// Samples of the mean, with a border so wide that it is 0 at the end.
class Field {
 public:
  Field(const LabelVolume& volume, const std::vector<int>& labels, double smoothing) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double sigma = smoothing / volume.spacing[static_cast<Eigen::Index>(i)];
      border_[i] = 1 + static_cast<int>(std::ceil(kReach * sigma));
      size_[i] = volume.size[i] + 2 * border_[i];
    }
    samples_.assign(
        static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(size_[2]),
        0.0f);
    std::vector<char> counts(std::size_t{1} << 16);
    for (const int label : labels)
      if (label >= 0 && label < static_cast<int>(counts.size())) counts[static_cast<std::size_t>(label)] = 1;
    std::size_t voxel = 0;
    for (int z = 0; z < volume.size[2]; ++z)
      for (int y = 0; y < volume.size[1]; ++y)
        for (int x = 0; x < volume.size[0]; ++x, ++voxel)
          if (counts[volume.labels[voxel]] != 0) samples_[at(x + border_[0], y + border_[1], z + border_[2])] = 1.0f;
    for (std::size_t i = 0; i < 3; ++i) smoothAlong(i, smoothing / volume.spacing[static_cast<Eigen::Index>(i)]);
  }

  const std::array<int, 3>& size() const { return size_; }
  std::size_t at(int x, int y, int z) const {
    return static_cast<std::size_t>(x) + stride(1) * static_cast<std::size_t>(y) +
           stride(2) * static_cast<std::size_t>(z);
  }
  std::size_t stride(std::size_t axis) const {
    return axis == 0   ? 1
           : axis == 1 ? static_cast<std::size_t>(size_[0])
                       : static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]);
  }
  float operator[](std::size_t sample) const { return samples_[sample]; }
  Vec3 voxelOf(const Vec3& sample) const { return sample - Vec3(border_[0], border_[1], border_[2]); }

 private:
  void smoothAlong(std::size_t axis, double sigma) {
    const int reach = border_[axis] - 1;
    if (reach == 0) return;
    std::vector<double> weights(static_cast<std::size_t>(reach) + 1);
    double sum = 0.0;
    for (int k = 0; k <= reach; ++k) {
      weights[static_cast<std::size_t>(k)] = std::exp(-0.5 * k * k / (sigma * sigma));
      sum += (k == 0 ? 1.0 : 2.0) * weights[static_cast<std::size_t>(k)];
    }
    for (double& weight : weights) weight /= sum;
    const std::size_t step = stride(axis), count = static_cast<std::size_t>(size_[axis]);
    std::vector<double> line(count + 2 * static_cast<std::size_t>(reach));
    for (std::size_t first = 0; first < samples_.size(); ++first) {
      if (first / step % count != 0) continue;  // not the first of a line
      for (std::size_t i = 0; i < count; ++i)
        line[i + static_cast<std::size_t>(reach)] = static_cast<double>(samples_[first + i * step]);
      for (std::size_t i = 0; i < count; ++i) {
        const double* centre = line.data() + i + reach;
        double mean = weights[0] * centre[0];
        for (int k = 1; k <= reach; ++k) mean += weights[static_cast<std::size_t>(k)] * (centre[k] + centre[-k]);
        samples_[first + i * step] = static_cast<float>(mean);
      }
    }
  }

  std::array<int, 3> size_{}, border_{};
  std::vector<float> samples_;
};

}  // namespace

TriangleMesh surfaceOf(const LabelVolume& volume, const std::vector<int>& labels, double smoothing) {
  check(volume, smoothing);
  const Field field(volume, labels, smoothing);
  TriangleMesh mesh = kernel::surfaceOfGrid(
      field.size(), [&](std::size_t sample) { return 0.5 - static_cast<double>(field[sample]); },
      [&](const Vec3& grid) -> Vec3 {
        return volume.origin + volume.axes * field.voxelOf(grid).cwiseProduct(volume.spacing);
      });
  if (volume.axes.determinant() < 0.0)  // a reflection turns the mesh inside out
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

Solid solidOf(const LabelVolume& volume, const std::vector<LabelLayer>& layers, double smoothing,
              const SolidOptions& options) {
  require(!layers.empty(), "a solid of labels needs at least one layer");
  std::vector<SolidLayer> solidLayers;
  std::vector<int> labels;
  std::shared_ptr<const MeshModel> border;
  for (auto layer = layers.rbegin(); layer != layers.rend(); ++layer) {
    labels.insert(labels.end(), layer->labels.begin(), layer->labels.end());
    TriangleMesh mesh = surfaceOf(volume, labels, smoothing);
    require(!mesh.triangles.empty(), "layer \"" + layer->layer.name + "\": no voxels of its labels remain");
    border = std::make_shared<const MeshModel>(std::move(mesh));
    solidLayers.insert(solidLayers.begin(), layer->layer);
    solidLayers.front().depth = 0.0;
    solidLayers.front().within = border;
  }
  return Solid(*border, solidLayers, options);
}

}  // namespace enamel
