// Solids apart from sessions: files, labels of a CT, and the comparison with a target.
#include "c/convert.hpp"
#include "core/message.hpp"
#include "enamel/collision/label_volume.hpp"
#include "enamel/collision/solid_file.hpp"

using namespace enamel;

namespace {

// Make a handle of the solid that `make` returns.
template <typename Make>
std::int32_t give(EnamelSolid** solid, const EnamelMessage& message, const Make& make) noexcept {
  return c::attempt(message, [&] { *solid = new EnamelSolid{std::make_shared<const Solid>(make()), {}, {}}; });
}

std::int32_t wrongSize(const char* name, const EnamelMessage& message) noexcept {
  c::copyText((std::string(name) + ".size is wrong: initialise it, and use the header of this library").c_str(),
              message);
  return ENAMEL_SIZE;
}

Solid solidOfLabels(const EnamelLabels& in) {
  LabelVolume volume;
  constexpr std::int64_t kMost = 1 << 28;
  std::int64_t count = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    volume.size[axis] = in.voxels[axis];
    count = in.voxels[axis] > 0 && count <= kMost ? count * in.voxels[axis] : 0;
  }
  require(count > 0 && count <= kMost, "EnamelLabels.voxels: there must be 1 to 2^28 voxels");
  require(in.labels != nullptr && in.layers != nullptr, "EnamelLabels needs labels and layers");
  require(in.layer_count <= ENAMEL_MAX_LAYERS, "EnamelLabels has " + std::to_string(in.layer_count) +
                                                   " layers, must have at most " + std::to_string(ENAMEL_MAX_LAYERS));
  volume.labels.assign(in.labels, in.labels + count);
  volume.spacing = Eigen::Map<const Vec3>(in.spacing);
  volume.origin = Eigen::Map<const Vec3>(in.origin);
  volume.axes = Eigen::Map<const RowMajor>(in.axes);
  std::vector<LabelLayer> layers;
  for (std::size_t i = 0; i < in.layer_count; ++i) {
    const EnamelLabelLayer& layer = in.layers[i];
    require(layer.labels != nullptr && layer.label_count <= 1U << 16U,
            "a layer of EnamelLabels needs 1 to 65536 labels");
    LabelLayer& part = layers.emplace_back();
    part.layer = {"layer " + std::to_string(i), c::materialOf(layer.material), layer.hardness, 0.0, nullptr};
    part.labels.assign(layer.labels, layer.labels + layer.label_count);
  }
  return solidOf(volume, layers, in.smoothing < 0.0 ? volume.spacing.mean() : in.smoothing, SolidOptions{in.cell});
}

void toPlain(const CutDifference& in, EnamelCutDifference& out) noexcept {
  std::copy(in.overCut.begin(), in.overCut.end(), out.over_cut);
  std::copy(in.underCut.begin(), in.underCut.end(), out.under_cut);
  out.area = in.area;
  out.mean = in.mean;
  out.p95 = in.p95;
  out.deepest = in.deepest;
  out.highest = in.highest;
}

}  // namespace

extern "C" {

std::int32_t enamel_solid_load(const char* file, EnamelSolid** solid, EnamelMessage message) {
  if (solid != nullptr) *solid = nullptr;
  if (file == nullptr || solid == nullptr) return ENAMEL_NULL;
  return give(solid, message, [&] { return loadSolid(file); });
}

std::int32_t enamel_labels_defaults(EnamelLabels* labels) {
  if (labels == nullptr) return ENAMEL_NULL;
  *labels = EnamelLabels{};
  labels->size = sizeof *labels;
  const LabelVolume volume;
  Eigen::Map<Vec3>(labels->spacing) = volume.spacing;
  Eigen::Map<RowMajor>(labels->axes) = volume.axes;
  labels->smoothing = -1.0;
  labels->cell = SolidOptions{}.cell;
  return ENAMEL_OK;
}

std::int32_t enamel_solid_from_labels(const EnamelLabels* labels, EnamelSolid** solid, EnamelMessage message) {
  if (solid != nullptr) *solid = nullptr;
  if (labels == nullptr || solid == nullptr) return ENAMEL_NULL;
  if (!isKnown(*labels)) return wrongSize("EnamelLabels", message);
  return give(solid, message, [&] { return solidOfLabels(*labels); });
}

void enamel_solid_destroy(EnamelSolid* solid) { delete solid; }

std::int32_t enamel_solid_save(const EnamelSolid* solid, const char* file, EnamelMessage message) {
  if (solid == nullptr || file == nullptr) return ENAMEL_NULL;
  return c::attempt(message, [&] { saveSolid(*solid->solid, file); });
}

std::int32_t enamel_solid_compare(EnamelSolid* solid, const EnamelObstacleDef* target, const double* axis,
                                  EnamelCutComparison* comparison, EnamelMessage message) {
  if (solid == nullptr || target == nullptr || comparison == nullptr) return ENAMEL_NULL;
  if (!isKnown(*comparison)) return wrongSize("EnamelCutComparison", message);
  return c::attempt(message, [&] {
    const Vec3 up = axis == nullptr ? Vec3(Vec3::UnitZ()) : Vec3(Eigen::Map<const Vec3>(axis));
    CutComparison found = compareCut(*solid->solid, c::targetOf(*target), up);
    solid->prepared.assign(found.isPrepared.begin(), found.isPrepared.end());
    solid->compared = std::move(found);
    const CutComparison& in = solid->compared;
    *comparison = EnamelCutComparison{};
    comparison->size = sizeof *comparison;
    std::copy(in.removed.begin(), in.removed.end(), comparison->removed);
    std::copy(in.planned.begin(), in.planned.end(), comparison->planned);
    toPlain(in.whole, comparison->whole);
    toPlain(in.floors, comparison->floors);
    toPlain(in.walls, comparison->walls);
    comparison->vertex_count = in.surface.vertices.size();
    comparison->triangle_count = in.surface.triangles.size();
    if (comparison->vertex_count == 0) return;
    comparison->vertices = in.surface.vertices.front().data();
    comparison->distance = in.distance.data();
    comparison->prepared = solid->prepared.data();
    comparison->triangles = in.surface.triangles.front().data();
  });
}

}  // extern "C"
