#include "enamel/collision/solid.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "mesh_data.hpp"
#include "solid_query.hpp"

namespace enamel {
namespace {

using kernel::Inside;

constexpr double kBorder = Solid::kBand + 1.0;                      // cells around the mesh
constexpr double kHalfDiagonal = 0.8660254037844386 * kBrickCells;  // of a brick, cells
constexpr double kLongestMove = 0.02, kLongestAxis = 0.1;           // m
constexpr int kMostBricks = 4096;                                   // limit of a cut; the rest is left
constexpr double kSubstep = 0.5;  // cells that an end moves between two positions of a capsule
constexpr int kSlice = kBrickSamples * kBrickSamples;
static_assert(kBrickSamples == kernel::kBrickEdge);

int sampleAt(int x, int y, int z) { return z * kSlice + y * kBrickSamples + x; }
int cellAt(int x, int y, int z) { return (z * kBrickCells + y) * kBrickCells + x; }

// Share of a cell's volume below a plane at this distance from its centre.
double shareOf(float value) { return std::clamp(0.5 - static_cast<double>(value), 0.0, 1.0); }

// Visit the samples of a brick along a path on which neighbours follow each other.
template <typename Visit>
void forEachAlongPath(int size, const Visit& visit) {
  for (int z = 0; z < size; ++z)
    for (int j = 0; j < size; ++j) {
      const int y = z % 2 == 0 ? j : size - 1 - j;
      for (int i = 0; i < size; ++i) visit((z * size + j) % 2 == 0 ? i : size - 1 - i, y, z);
    }
}

void checkLayers(const std::vector<SolidLayer>& layers) {
  if (layers.empty() || layers.size() > kMaxSolidLayers)
    throw Error("the solid has " + std::to_string(layers.size()) + " layers, must have 1 to " +
                std::to_string(kMaxSolidLayers));
  double depth = 0.0;
  for (const SolidLayer& layer : layers) {
    kernel::checkLayer(layer);
    if (layer.within != nullptr) {
      if (!Inside::of(*layer.within).closed)
        throw Error("layer \"" + layer.name + "\": the mesh where it begins must be closed");
      continue;
    }
    if (!(layer.depth >= depth && std::isfinite(layer.depth)))
      throw Error("layer \"" + layer.name + "\": depth is " + formatNumber(layer.depth) +
                  " m, must be at least that of the layer before, " + formatNumber(depth) + " m");
    depth = layer.depth;
  }
}

}  // namespace

void kernel::checkLayer(const SolidLayer& layer) {
  checkMaterial(layer.material, "layer \"" + layer.name + "\"");
  checkTap(layer.tap, "layer \"" + layer.name + "\"");
  if (!(layer.hardness > 0.0 && std::isfinite(layer.hardness)))
    throw Error("layer \"" + layer.name + "\": hardness is " + formatNumber(layer.hardness) +
                ", must be greater than 0 Pa");
}

Solid::Solid(const MeshModel& surface, const std::vector<SolidLayer>& layers, const SolidOptions& options)
    : cell_(options.cell), layers_(layers) {
  checkLayers(layers_);
  const kernel::MeshData& data = Inside::of(surface);
  if (!data.closed) throw Error("the mesh of a solid must be closed; this one has open edges");
  if (!(cell_ > 0.0 && std::isfinite(cell_)))
    throw Error("the cell of a solid is " + formatNumber(cell_) + " m, must be greater than 0 m");
  origin_ = data.low - Vec3::Constant(kBorder * cell_);
  const Vec3 cells = (data.high - data.low) / cell_ + Vec3::Constant(2.0 * kBorder);
  const Vec3 along = (cells / kBrickCells).array().ceil();
  const auto refuseCell = [this](const std::string& why) {
    throw Error("cells of " + std::to_string(1e3 * cell_) + " mm are too " + why + ", or check the unit of the mesh");
  };
  const char* const small = "small: the solid needs more than 1 GB; make them larger";
  if (!(along.prod() <= kernel::kMostSolidPlaces)) refuseCell(small);
  if (cell_ < kSmallestCell)
    throw Error("the cell of a solid is " + formatNumber(cell_) + " m, must be at least " +
                formatNumber(kSmallestCell) + " m");
  for (int i = 0; i < 3; ++i) count_[i] = static_cast<int>(along[i]);

  ProximityCache cache;
  std::vector<std::array<int, 3>> places;
  const double least = kHalfDiagonal + kBand;
  index_.assign(static_cast<std::size_t>(along.prod()), -1);
  std::size_t at = 0;
  for (int z = 0; z < count_[2]; ++z)
    for (int y = 0; y < count_[1]; ++y)
      for (int x = 0; x < count_[0]; ++x, ++at) {
        const Vec3 centre = origin_ + cell_ * (kBrickCells * Vec3(x + 0.5, y + 0.5, z + 0.5));
        if (enamel::signedDistance(surface, centre, &cache).distance > least * cell_) continue;
        index_[at] = static_cast<std::int32_t>(places.size());
        places.push_back({x, y, z});
        if (static_cast<double>(places.size()) * (sizeof(Brick) + sizeof(BrickSamples)) > kernel::kMostSolidBytes)
          refuseCell(small);
      }
  fill(surface, places);
  prepare(options.undoBricks);
  if (std::none_of(hasSurface_.begin(), hasSurface_.end(), [](auto has) { return has != 0; })) {
    // A convex body contains a ball with this radius, and the ball a corner of such a cell.
    const MeshReport body = inspect(surface.mesh());
    refuseCell("large: no corner of a cell is inside, so nothing of the body would remain; make them at most " +
               std::to_string(1e3 * std::abs(body.volume) / body.area) + " mm, its volume / area");
  }
  for (const Brick& brick : bricks_) original_.push_back(brick.samples);
}

// Find the surface and reserve memory.
void Solid::prepare(int undoBricks) {
  if (undoBricks < 0) throw Error("the room for undo is " + std::to_string(undoBricks) + " bricks, must be at least 0");
  hasSurface_.resize(bricks_.size());
  for (Brick& brick : bricks_) findSurface(brick);
  kept_.resize(static_cast<std::size_t>(undoBricks));
  changed_.resize(bricks_.size());
}

void Solid::fill(const MeshModel& surface, const std::vector<std::array<int, 3>>& places) {
  bricks_.resize(places.size());
  ProximityCache cache, layerCache;
  for (std::size_t b = 0; b < places.size(); ++b) {
    Brick& brick = bricks_[b];
    std::copy(places[b].begin(), places[b].end(), brick.place.begin());
    const Vec3 low = lowOf(static_cast<int>(b)), centre = low + Vec3::Constant(0.5 * kBrickCells * cell_);
    const Vec3 corner = kBrickCells * Vec3(places[b][0], places[b][1], places[b][2]);
    kernel::sampleMesh(surface, origin_, cell_, corner, cache, brick.samples);
    brick.layer.fill(0);
    for (std::size_t k = 1; k < layers_.size(); ++k) {
      const SolidLayer& layer = layers_[k];
      const MeshModel& border = layer.within != nullptr ? *layer.within : surface;
      const double depth = layer.within != nullptr ? 0.0 : layer.depth;
      const double below = depth + enamel::signedDistance(border, centre, &layerCache).distance;
      if (below > kHalfDiagonal * cell_) continue;
      const bool isWhole = below < -kHalfDiagonal * cell_;
      forEachAlongPath(kBrickCells, [&](int x, int y, int z) {
        if (isWhole || depth + enamel::signedDistance(border, low + cell_ * Vec3(x, y, z), &layerCache).distance < 0.0)
          brick.layer[cellAt(x, y, z)] = static_cast<std::uint8_t>(k);
      });
    }
  }
}

Vec3 Solid::high() const noexcept { return origin_ + cell_ * kBrickCells * Vec3(count_[0], count_[1], count_[2]); }

Vec3 Solid::lowOf(int brick) const noexcept {
  const auto& place = bricks_[static_cast<std::size_t>(brick)].place;
  return origin_ + cell_ * kBrickCells * Vec3(place[0], place[1], place[2]);
}

std::size_t Solid::bytes() const noexcept {
  return sizeof(Solid) + index_.size() * sizeof(index_[0]) + bricks_.size() * sizeof(Brick) +
         original_.size() * sizeof(BrickSamples) + hasSurface_.size() + kept_.size() * sizeof(Kept) +
         changed_.size() * sizeof(changed_[0]);
}

void kernel::sampleMesh(const MeshModel& mesh, const Vec3& origin, double cell, const Vec3& corner,
                        ProximityCache& cache, BrickSamples& samples) {
  const Vec3 centre = origin + cell * (corner + Vec3::Constant(0.5 * kBrickCells));
  const double atCentre = signedDistance(mesh, centre, &cache).distance, most = (kHalfDiagonal + Solid::kBand) * cell;
  if (std::abs(atCentre) > most) return samples.fill(std::copysign(Solid::kBand, static_cast<float>(atCentre)));
  forEachAlongPath(kBrickSamples, [&](int x, int y, int z) {
    const Vec3 p = origin + cell * (corner + Vec3(x, y, z));  // the same bits from every brick that has it
    const double distance = signedDistance(mesh, p, &cache).distance;
    samples[sampleAt(x, y, z)] = std::clamp(static_cast<float>(distance / cell), -Solid::kBand, Solid::kBand);
  });
}

// A cell counts by its mean value. For a curved surface the errors of mean and rounding cancel out.
double kernel::filledShare(const BrickSamples& samples, int x, int y, int z) noexcept {
  constexpr int up = kSlice, back = kBrickSamples;
  const float* s = samples.data() + sampleAt(x, y, z);
  return shareOf(0.125f * (s[0] + s[1] + s[back] + s[back + 1] + s[up] + s[up + 1] + s[up + back] + s[up + back + 1]));
}

RemovedVolume Solid::volume() const {
  RemovedVolume volume{};
  for (const Brick& brick : bricks_)
    for (int z = 0; z < kBrickCells; ++z)
      for (int y = 0; y < kBrickCells; ++y)
        for (int x = 0; x < kBrickCells; ++x)
          volume[brick.layer[cellAt(x, y, z)]] += kernel::filledShare(brick.samples, x, y, z) * cell_ * cell_ * cell_;
  return volume;
}

std::array<std::uint64_t, kBrickCells> kernel::surfaceCells(const BrickSamples& samples) noexcept {
  std::array<std::uint64_t, kBrickCells> cells;
  std::array<std::uint8_t, std::tuple_size<BrickSamples>::value> isNegative;
  for (std::size_t i = 0; i < isNegative.size(); ++i) isNegative[i] = samples[i] < 0.0f ? 1 : 0;
  std::uint32_t negative[kSlice];  // bit x: of the sample in that row
  for (int row = 0; row < kSlice; ++row) {
    const std::uint8_t* first = isNegative.data() + row * kBrickSamples;
    std::uint64_t bytes;
    std::memcpy(&bytes, first, sizeof(bytes));
    // The factor moves the lowest bit of byte x to bit 56 + x.
    negative[row] = static_cast<std::uint32_t>(bytes * 0x0102040810204080u >> 56) |
                    static_cast<std::uint32_t>(first[kBrickCells]) << kBrickCells;
  }
  for (int z = 0; z < kBrickCells; ++z) {
    std::uint64_t slice = 0;
    for (int y = 0; y < kBrickCells; ++y) {
      const std::uint32_t* row = negative + z * kBrickSamples + y;
      const std::uint32_t any = row[0] | row[1] | row[kBrickSamples] | row[kBrickSamples + 1];
      const std::uint32_t all = row[0] & row[1] & row[kBrickSamples] & row[kBrickSamples + 1];
      const std::uint32_t mixed = (any | any >> 1) & ~(all & all >> 1) & 0xffu;
      slice |= static_cast<std::uint64_t>(mixed) << (kBrickCells * y);
    }
    cells[z] = slice;
  }
  return cells;
}

void Solid::findSurface(Brick& brick) noexcept {
  brick.surface = kernel::surfaceCells(brick.samples);
  const auto number = static_cast<std::size_t>(&brick - bricks_.data());
  hasSurface_[number] = std::any_of(brick.surface.begin(), brick.surface.end(), [](auto slice) { return slice != 0; });
}

RemovedVolume Solid::cut(const Segment& from, const Segment& to, double radius, double* reached) noexcept {
  RemovedVolume removed{};
  if (reached != nullptr) *reached = 0.0;
  const double move = std::max((to.a - from.a).norm(), (to.b - from.b).norm());
  if (!(move <= kLongestMove && radius > 0.0 && radius <= kLargestBur && from.a.allFinite() && from.b.allFinite() &&
        (from.b - from.a).norm() <= kLongestAxis))
    return removed;
  const int steps = 1 + static_cast<int>(move / (kSubstep * cell_));
  int bricks = 0;
  for (int i = 1; i <= steps && bricks < kMostBricks; ++i) {
    const double t = static_cast<double>(i) / steps;
    bricks += cutCapsule({from.a + t * (to.a - from.a), from.b + t * (to.b - from.b)}, radius, removed);
    if (reached != nullptr) *reached = t;
  }
  return removed;
}

// A bur at one place; lengths in cells, positions from the grid's origin.
struct Solid::Capsule : kernel::BurAt {
  Vec3 a;
  double cellVolume;                   // of a cell, m^3
  std::array<int, 3> first{}, last{};  // samples within reach
};

// Returns the number of bricks that it visited.
int Solid::cutCapsule(const Segment& axis, double radius, RemovedVolume& removed) noexcept {
  const Vec3 a = (axis.a - origin_) / cell_, b = (axis.b - origin_) / cell_;
  const double r = radius / cell_;
  Capsule capsule{};
  capsule.a = a;
  capsule.cellVolume = cell_ * cell_ * cell_;
  // The interpolation of a curved distance lies above it by a twelfth of its Laplacian on average. Along the path of a
  // bur the Laplacian is 1 / r. The grid cannot resolve the curvature of a bur smaller than a cell.
  capsule.reach = static_cast<float>(r + (r > 1.0 ? 1.0 / (12.0 * r) : r / 12.0));
  capsule.band = kBand;
  capsule.inner = std::max(capsule.reach - kBand, 0.0f),
  capsule.most = (capsule.reach + kBand) * (capsule.reach + kBand);
  const double around = static_cast<double>(capsule.reach) + kBand;
  const Eigen::Vector3f span = (b - a).cast<float>();
  std::copy_n(span.data(), 3, capsule.span);
  if (!span.isZero(0.0f)) capsule.perLength = 1.0f / span.squaredNorm();
  const Vec3 low = (a.cwiseMin(b).array() - around).ceil(), high = (a.cwiseMax(b).array() + around).floor();
  std::array<int, 3> firstBrick, lastBrick;
  for (int i = 0; i < 3; ++i) {
    const int first = static_cast<int>(std::max(low[i], 0.0));
    const int last = static_cast<int>(std::min(high[i], static_cast<double>(kBrickCells) * count_[i]));
    if (first > last) return 0;
    capsule.first[i] = first, capsule.last[i] = last;
    firstBrick[i] = std::max((first - 1) / kBrickCells, 0);
    lastBrick[i] = std::min(last / kBrickCells, count_[i] - 1);
  }
  // A brick whose centre is farther away is out of reach.
  const float farthest = static_cast<float>(around + kHalfDiagonal) + 1e-3f;
  int bricks = 0;
  for (int bz = firstBrick[2]; bz <= lastBrick[2]; ++bz)
    for (int by = firstBrick[1]; by <= lastBrick[1]; ++by)
      for (int bx = firstBrick[0]; bx <= lastBrick[0]; ++bx) {
        const std::int32_t number = brickAt(bx, by, bz);
        if (number < 0) continue;
        if (capsule.perLength != 0.0f) {  // a long diagonal axis: most bricks of its box are out of reach
          const Eigen::Vector3f middle = (kBrickCells * (Vec3(bx, by, bz).array() + 0.5) - a.array()).cast<float>();
          const float t = std::clamp(middle.dot(span) * capsule.perLength, 0.0f, 1.0f);
          if ((middle - t * span).squaredNorm() > farthest * farthest) continue;
        }
        ++bricks;
        cutBrick(number, capsule, removed);
      }
  return bricks;
}

void Solid::cutBrick(std::int32_t number, const Capsule& capsule, RemovedVolume& removed) noexcept {
  Brick& brick = bricks_[static_cast<std::size_t>(number)];
  float away[3][kBrickSamples];  // offsets of the samples from a, with the same bits in every brick that has them
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < kBrickSamples; ++k)
      away[i][k] = static_cast<float>(kBrickCells * brick.place[i] + k - capsule.a[i]);
  const int first = std::max(capsule.first[2] - kBrickCells * brick.place[2], 0);
  const int last = std::min(capsule.last[2] - kBrickCells * brick.place[2], kBrickCells);
  std::pair<Solid*, Brick*> kept{this, &brick};
  const auto keepIt = [](void* context) {
    const auto& [solid, changed] = *static_cast<std::pair<Solid*, Brick*>*>(context);
    solid->keep(*changed);
  };
  kernel::CutSamples cut;
  if (!kernel::loops().cutBrick(brick.samples.data(), away, first, last, capsule, keepIt, &kept, &cut)) return;
  for (int i = 0; i < cut.count; ++i) {
    const int x = cut.index[i] % kBrickSamples, y = cut.index[i] / kBrickSamples % kBrickSamples,
              z = cut.index[i] / kSlice;
    if (x < kBrickCells && y < kBrickCells && z < kBrickCells)
      removed[brick.layer[cellAt(x, y, z)]] += static_cast<double>(cut.taken[i]) * capsule.cellVolume;
  }
  if (cut.isTurned) findSurface(brick);
  tellChanged(number);
}

void Solid::tellChanged(std::int32_t brick) noexcept {
  Brick& changed = bricks_[static_cast<std::size_t>(brick)];
  if (std::exchange(changed.isChanged, true)) return;
  changed_[(changedBegin_ + changedCount_++) % changed_.size()] = brick;
}

int Solid::takeChanged() noexcept {
  if (changedCount_ == 0) return -1;
  const std::int32_t brick = changed_[changedBegin_];
  changedBegin_ = (changedBegin_ + 1) % changed_.size();
  --changedCount_;
  bricks_[static_cast<std::size_t>(brick)].isChanged = false;
  return brick;
}

void Solid::keep(Brick& brick) noexcept {
  if (brick.marked == mark_) return;
  brick.marked = mark_;
  if (kept_.empty()) {
    lostMark_ = mark_;
    return;
  }
  if (keptCount_ == kept_.size()) {
    lostMark_ = kept_[keptBegin_].mark;
    keptBegin_ = (keptBegin_ + 1) % kept_.size();
    --keptCount_;
  }
  Kept& kept = kept_[(keptBegin_ + keptCount_++) % kept_.size()];
  kept.brick = static_cast<std::int32_t>(&brick - bricks_.data());
  kept.mark = mark_;
  kept.samples = brick.samples;
}

void Solid::mark() noexcept { ++mark_; }

bool Solid::undo() noexcept {
  const auto last = [&]() -> Kept& { return kept_[(keptBegin_ + keptCount_ - 1) % kept_.size()]; };
  if (keptCount_ == 0 || last().mark <= lostMark_) return false;
  for (const std::uint64_t mark = last().mark; keptCount_ > 0 && last().mark == mark; --keptCount_)
    set(last().brick, last().samples);
  ++mark_;
  ++restorations_;
  return true;
}

void Solid::restore() noexcept {
  for (std::size_t i = 0; i < bricks_.size(); ++i)
    if (bricks_[i].samples != original_[i]) set(static_cast<std::int32_t>(i), original_[i]);
  keptCount_ = 0;
  ++mark_;
  ++restorations_;
}

void Solid::set(int number, const BrickSamples& samples) noexcept {
  Brick& brick = bricks_[static_cast<std::size_t>(number)];
  brick.samples = samples;
  findSurface(brick);
  tellChanged(number);
}

int Solid::brickAt(const Vec3& p) const noexcept {
  const Vec3 place = (p - origin_) / (kBrickCells * cell_);
  for (int i = 0; i < 3; ++i)
    if (!(place[i] >= 0.0 && place[i] < count_[static_cast<std::size_t>(i)])) return -1;
  const Eigen::Vector3i at = place.cast<int>();
  return brickAt(at[0], at[1], at[2]);
}

int Solid::layerAt(const Vec3& p) const noexcept {
  const Vec3 around = (p - origin_) / cell_ + Vec3::Constant(0.5);  // the next lower number is the nearest sample
  for (int i = 0; i < 3; ++i)
    if (!(around[i] >= 0.0 && around[i] < static_cast<double>(kBrickCells) * count_[i])) return 0;
  const Eigen::Vector3i at = around.cast<int>();
  const std::int32_t brick = brickAt(at[0] / kBrickCells, at[1] / kBrickCells, at[2] / kBrickCells);
  if (brick < 0) return 0;
  return bricks_[static_cast<std::size_t>(brick)]
      .layer[static_cast<std::size_t>(cellAt(at[0] % kBrickCells, at[1] % kBrickCells, at[2] % kBrickCells))];
}

}  // namespace enamel
