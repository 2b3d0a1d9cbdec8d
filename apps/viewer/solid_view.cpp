#include "solid_view.hpp"

#include <vtkMapper.h>
#include <vtkProperty.h>
#include <vtkTypeInt32Array.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace enamel::viewer {
namespace {

constexpr int kGroup = 4;                       // bricks along an edge of a group
constexpr Finish kFinish{0xFFFFFF, 1.0, 0.25};  // below the layers' colours

std::vector<Vec3> coloursOf(const Solid& solid) {
  std::vector<Vec3> colours;
  for (const SolidLayer& layer : solid.layers()) colours.push_back(rgbOf(layerColour(layer.name, colours.size())));
  return colours;
}

}  // namespace

SolidCopy copyOf(const Solid& solid) {
  SolidCopy copy;
  for (int brick = 0; brick < solid.bricks(); ++brick) copy.samples.push_back(solid.samples(brick));
  auto uncut = std::make_shared<Solid>(solid);
  uncut->restore();
  copy.uncut = std::move(uncut);
  return copy;
}

SolidView::SolidView(vtkRenderer* renderer, const SolidCopy& solid, const Pose& pose,
                     const std::optional<CutPlane>& plane, const std::vector<CutPlane>& hidden, float scale)
    : renderer_(renderer), solid_(solid), pose_(pose), plane_(plane), scale_(scale), colours_(coloursOf(*solid.uncut)) {
  if (plane) {
    const Vec3 point = kMillimetres * plane->point, behind = -plane->normal;
    clip_->SetOrigin(point.data());
    clip_->SetNormal(behind.data());
  }
  const Solid& uncut = *solid.uncut;
  const double edge = kBrickCells * uncut.cell();
  const auto place = [&](const Vec3& p) { return ((p - uncut.low()) / edge).array().round().cast<int>().eval(); };
  const Eigen::Array3i groups = (place(uncut.high()) + kGroup - 1) / kGroup;
  groups_.resize(static_cast<std::size_t>(groups.prod()));
  for (int brick = 0; brick < uncut.bricks(); ++brick) {
    const Eigen::Array3i in = place(uncut.lowOf(brick)) / kGroup;
    const Vec3 centre = pose.position + pose.rotation * (uncut.lowOf(brick) + Vec3::Constant(0.5 * edge));
    const bool isHidden = std::any_of(hidden.begin(), hidden.end(), [&](const CutPlane& wall) {
      return wall.normal.dot(centre - wall.point) < -0.87 * edge;
    });
    const int number = (in[2] * groups[1] + in[1]) * groups[0] + in[0];
    Group& group = groups_[static_cast<std::size_t>(number)];
    if (!isHidden) group.bricks.push_back(brick);
    group.isCut = group.isCut || solid.samples[static_cast<std::size_t>(brick)] != uncut.samples(brick);
    groupOf_.push_back(number);
  }
}

void SolidView::change(int brick) {
  Group& group = groupOf(brick);
  group.isChanged = true;
  if (!std::exchange(group.isCut, true))  // neighbours adapt to the finer step of its bricks
    for (const int one : group.bricks)
      forEachNeighbour(*solid_.uncut, one, [&](int, int other) { groupOf(other).isChanged |= groupOf(other).isCut; });
  isSectionChanged_ = true;
}

void SolidView::update() {
  for (Group& group : groups_)
    if (group.isChanged) build(group);
  if (isSectionChanged_) buildSection();
}

void SolidView::build(Group& group) {
  group.isChanged = false;
  surface_.clear();
  for (const int brick : group.bricks) {
    std::uint32_t coarser = 0;
    if (group.isCut)
      forEachNeighbour(*solid_.uncut, brick,
                       [&](int bit, int other) { coarser |= groupOf(other).isCut ? 0u : 1u << bit; });
    appendSurface(*solid_.uncut, brick, solid_.samples[static_cast<std::size_t>(brick)], surface_, group.isCut ? 1 : 2,
                  coarser);
  }
  if (group.actor) renderer_->RemoveActor(group.actor);
  group.actor = nullptr;
  if (surface_.mesh.triangles.empty()) return;
  Polygons polygons(static_cast<vtkIdType>(surface_.mesh.vertices.size()));
  for (std::size_t i = 0; i < surface_.mesh.vertices.size(); ++i) {
    polygons.append(pose_.position + pose_.rotation * surface_.mesh.vertices[i], pose_.rotation * surface_.normals[i]);
    polygons.paint(colourAt(surface_.mesh.vertices[i], surface_.layers[i]));
  }
  vtkNew<vtkTypeInt32Array> corners;
  corners->SetNumberOfValues(3 * static_cast<vtkIdType>(surface_.mesh.triangles.size()));
  int* next = corners->GetPointer(0);
  for (const auto& triangle : surface_.mesh.triangles) next = std::copy(triangle.begin(), triangle.end(), next);
  polygons.cells()->SetData(3, corners);
  group.actor = polygons.addTo(renderer_, kFinish, false);
  if (plane_) group.actor->GetMapper()->AddClippingPlane(clip_);
}

// Return the colour of a vertex in the solid's frame: of its layer, or of its distance from the target, where the
// surface is prepared or should be.
Vec3 SolidView::colourAt(const Vec3& p, int layer) {
  if (!solid_.target) return colours_[static_cast<std::size_t>(layer)];
  const double cell = solid_.uncut->cell(), distance = signedDistance(*solid_.target, p, &nearest_).distance;
  const bool isPrepared = std::abs(distance) > cell || std::abs(signedDistance(*solid_.uncut, p).distance) > cell;
  return isPrepared ? cutColour(distance / kCutRange) : rgbOf(kMuted);
}

float SolidView::at(const Vec3& p) const {
  const int brick = solid_.uncut->brickAt(p);
  if (brick < 0) return Solid::kBand;
  const Vec3 q = (p - solid_.uncut->lowOf(brick)) / solid_.uncut->cell();
  std::array<int, 3> cell;
  std::array<float, 3> t;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = q[static_cast<Eigen::Index>(i)];
    cell[i] = std::clamp(static_cast<int>(x), 0, kBrickCells - 1);
    t[i] = static_cast<float>(x - cell[i]);
  }
  constexpr int up = kBrickSamples, back = kBrickSamples * kBrickSamples;
  const float* s = solid_.samples[static_cast<std::size_t>(brick)].data() + cell[2] * back + cell[1] * up + cell[0];
  const auto along = [&](int i) { return s[i] + t[0] * (s[i + 1] - s[i]); };
  const auto across = [&](int i) { return along(i) + t[1] * (along(i + up) - along(i)); };
  return across(0) + t[2] * (across(back) - across(0));
}

// Build the section in the plane from squares of a cell's size, each clipped where the field is 0.
void SolidView::buildSection() {
  isSectionChanged_ = false;
  for (const auto& actor : section_) renderer_->RemoveActor(actor);
  section_.clear();
  if (!plane_) return;
  const Solid& uncut = *solid_.uncut;
  const double step = uncut.cell();
  const auto inSolid = [&](const Vec3& p) { return Vec3(pose_.rotation.transpose() * (p - pose_.position)); };
  const Vec3 centre = pose_.position + pose_.rotation * (0.5 * (uncut.low() + uncut.high()));
  const Vec3 n = plane_->normal, u = n.unitOrthogonal(), v = n.cross(u);
  const Vec3 origin = centre - n.dot(centre - plane_->point) * n;
  const int reach = static_cast<int>(0.5 * (uncut.high() - uncut.low()).norm() / step) + 1, side = 2 * reach + 1;
  const auto placeOf = [&](int i, int j) { return Vec3(origin + step * ((i - reach) * u + (j - reach) * v)); };
  std::vector<float> field(static_cast<std::size_t>(side * side));
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i) field[static_cast<std::size_t>(j * side + i)] = at(inSolid(placeOf(i, j)));

  Polygons polygons(side * side / 2);
  std::vector<vtkIdType> corners(field.size(), -1), polygon;
  std::vector<std::array<Vec3, 2>> outline;
  const auto append = [&](const Vec3& p) {  // layers are known per cell: smooth their borders over three cells
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 27; ++i)
      sum += colours_[static_cast<std::size_t>(
          uncut.layerAt(inSolid(p) + step * Vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)))];
    polygons.paint(sum / 27.0);
    return polygons.append(p, n);
  };
  constexpr int di[] = {0, 1, 1, 0}, dj[] = {0, 0, 1, 1};
  for (int j = 0; j + 1 < side; ++j)
    for (int i = 0; i + 1 < side; ++i) {
      polygon.clear();
      std::array<Vec3, 4> crossings;
      std::size_t crossed = 0;
      for (int k = 0; k < 4; ++k) {
        const int l = (k + 1) % 4;
        const auto here = static_cast<std::size_t>((j + dj[k]) * side + i + di[k]),
                   next = static_cast<std::size_t>((j + dj[l]) * side + i + di[l]);
        const Vec3 p = placeOf(i + di[k], j + dj[k]);
        if (field[here] < 0.0f) {
          if (corners[here] < 0) corners[here] = append(p);
          polygon.push_back(corners[here]);
        }
        if ((field[here] < 0.0f) == (field[next] < 0.0f)) continue;
        const double t = static_cast<double>(field[here] / (field[here] - field[next]));
        crossings[crossed] = p + t * (placeOf(i + di[l], j + dj[l]) - p);
        polygon.push_back(append(crossings[crossed++]));
      }
      if (polygon.size() > 2) polygons.cells()->InsertNextCell(static_cast<vtkIdType>(polygon.size()), polygon.data());
      if (crossed == 2) outline.push_back({crossings[0] + 5e-5 * n, crossings[1] + 5e-5 * n});
    }
  section_.push_back(polygons.addTo(renderer_, kFinish, false));
  vtkProperty* const flat = section_.back()->GetProperty();
  flat->SetAmbient(0.85);
  flat->SetDiffuse(0.12);
  flat->SetSpecular(0.0);
  section_.push_back(addLines(renderer_, outline, kSectionEdge, 2.0f * scale_));
}

}  // namespace enamel::viewer
