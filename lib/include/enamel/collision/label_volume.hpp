// Volumes of labels, such as a segmented CT of a tooth, become closed meshes and solids with layers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "enamel/collision/mesh.hpp"
#include "enamel/collision/solid.hpp"

namespace enamel {

/// A label for each voxel.
struct LabelVolume {
  std::array<int, 3> size{};            ///< number of voxels along the axes
  Vec3 spacing = Vec3::Constant(1e-4);  ///< between the centres of voxels, m
  Vec3 origin = Vec3::Zero();           ///< centre of the first voxel, m
  Mat3 axes = Mat3::Identity();         ///< columns: directions of the axes; a rotation, or a reflection
  std::vector<std::uint16_t> labels;    ///< the first axis is the fastest
};

/// A layer of a solid and the labels of its voxels.
struct LabelLayer {
  SolidLayer layer;  ///< its `depth` and `within` are not used
  std::vector<int> labels;
};

/// Return a closed mesh around all voxels with one of the labels, in m. Realtime: no, about 0.5 us a voxel.
///
/// The mesh is where a Gaussian mean of 1 inside and 0 outside is 1/2. `smoothing` is its standard deviation, m. That
/// of one voxel removes the steps. Labels locate a surface to half a voxel. Where the surface has the mean
/// radius of curvature R, it also moves towards its centre by smoothing^2 / R. Parts thinner than about the smoothing
/// vanish. The mesh is empty if nothing remains.
///
/// Throws Error for:
/// - a size that is not positive, above 2^28 voxels, or not that of `labels`;
/// - a spacing that is not positive, axes that are not orthonormal, or a value that is not finite;
/// - a smoothing below 0 or above 10 times the smallest spacing.
TriangleMesh surfaceOf(const LabelVolume& volume, const std::vector<int>& labels, double smoothing);

/// Make a solid of all voxels with a label of the layers, outermost layer first. A layer reaches as far as its own
/// labels and those of all later layers. Voxels without such a label are outside. Realtime: no.
///
/// Throws Error as surfaceOf() and Solid::Solid(), and for a layer that vanishes.
Solid solidOf(const LabelVolume& volume, const std::vector<LabelLayer>& layers, double smoothing,
              const SolidOptions& options = {});

}  // namespace enamel
