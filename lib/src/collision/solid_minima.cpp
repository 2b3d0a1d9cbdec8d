// Local minima of the distance between a point and a solid.
#include "solid_axis.inl"
#include "solid_query.hpp"

namespace enamel {

namespace {

constexpr double kAligned = 0.9396926207859084;  // cos 20 deg
constexpr double kResolved = 0.25;               // times h^2 / R: the error of the interpolation

// A place that may be a minimum. Unless it is exact, only cell, distance and direction are known, as estimates.
struct Candidate {
  std::uint32_t cell;
  float distance;
  Eigen::Vector3f direction;  // to the point
  bool isExact = false;
  Nearest place = {};
};

// The minima of the distance from a point, nearest first.
struct Collected : KnownMinima {
  std::array<Candidate, kMost> all;

  // Keep the others for which `keeps` is true, and insert this one.
  template <typename Keeps>
  void add(const Candidate& candidate, const Keeps& keeps) {
    int kept = 0, place = 0;
    for (int i = 0; i < count; ++i)
      if (keeps(i)) {
        if (kept != i) all[kept] = all[i];
        ++kept;
        if (all[i].distance <= candidate.distance) place = kept;
      }
    if (place < kMost) {
      kept = std::min(kept, kMost - 1);
      std::copy_backward(all.begin() + place, all.begin() + kept, all.begin() + kept + 1);
      all[place] = candidate;
      ++kept;
    }
    count = kept;
    for (int i = 0; i < count; ++i) {
      distance[i] = all[i].distance;
      for (int k = 0; k < 3; ++k) direction[k][i] = all[i].direction[k];
    }
  }
};

struct MinimaSearch : SolidQuery {
  using SolidQuery::SolidQuery;

  void minima(double reach, SolidMinima& minima) const {
    Nearest best{reach};
    Collected found;
    forEachSeen([&] { return reach; }, [&](const SeenCells& cells) { collect(cells, reach, best, found); });
    if (best.found) add(exact(0, best), found);  // also counts if the surface has no normal there that points to p
    minima.count = 0;
    for (int i = 0; i < found.count; ++i) {
      Nearest place = found.all[i].place;
      if (!found.all[i].isExact && !searchCell(found.all[i].cell, place)) continue;
      int at = minima.count++;  // estimates may have another order
      for (; at > 0 && place.distance * solid.cell() < minima.all[at - 1].distance; --at)
        minima.all[at] = minima.all[at - 1];
      minima.all[at] = answer(place, 1.0);
    }
  }

 private:
  // Whether two minima belong to two walls that meet in an edge. In a pit that fits the tool, the edge of their tangent
  // planes lies in the material. Directions are unit vectors to the point.
  bool areWalls(const Eigen::Vector3f& way, float distance, const Eigen::Vector3f& otherWay, float other) const {
    const float cosine = way.dot(otherWay), scale = 1.0f / std::max(1.0f - cosine * cosine, 1e-6f);
    const float share = (distance - cosine * other) * scale, otherShare = (other - cosine * distance) * scale;
    if (!(share > 0.0f && otherShare > 0.0f)) return false;  // the edge is not between them
    const Vec3 toEdge = -(share * way + otherShare * otherWay).cast<double>();
    const double far = std::max(distance, other), beyond = toEdge.norm() - far;
    return beyond > kResolved / far && valueAt(a + toEdge) > -0.5 * beyond;
  }

  // Whether a place in this direction (unit vector) is represented by a minimum that is not farther.
  bool isKnown(const Collected& found, const Eigen::Vector3f& unit, float distance) const {
    // At small angles the edge of areWalls() is not resolved: there `beyond` is distance (1 - cosine) / 4.
    const float resolved = 1.0f - 4.0f * static_cast<float>(kResolved) / std::max(distance * distance, 1.0f);
    const auto& [x, y, z] = found.direction;
    float cosine[Collected::kMost];
    for (int i = 0; i < Collected::kMost; ++i) cosine[i] = x[i] * unit.x() + y[i] * unit.y() + z[i] * unit.z();
    for (int i = 0; i < found.count && found.distance[i] <= distance; ++i)
      if (cosine[i] > kRepresentedCosine &&
          (cosine[i] > resolved || !areWalls(found.all[i].direction, found.distance[i], unit, distance)))
        return true;
    return false;
  }

  void add(const Candidate& one, Collected& found) const {
    if (isKnown(found, one.direction, one.distance)) return;
    found.add(one, [&](int i) {
      const Candidate& other = found.all[i];
      return other.direction.dot(one.direction) <= kRepresentedCosine || other.distance <= one.distance ||
             areWalls(other.direction, other.distance, one.direction, one.distance);
    });
  }

  Candidate exact(std::uint32_t cell, const Nearest& place) const {
    return {cell, static_cast<float>(place.distance), (a - place.point).cast<float>().stableNormalized(), true, place};
  }

  bool searchCell(std::uint32_t cell, Nearest& place) const {
    const Vec3 low = lowOf(cell), q = a - low;
    Touch touch;
    if (!nearestOn(Patch(samplesOf(cell)), q, touch)) return false;
    place = {(q - touch.point).norm(), 0.0, low + touch.point, touch.gradient, true};
    return true;
  }

  // The likely nearest first, so that others in the same direction need no closer look.
  void collect(const SeenCells& cells, double reach, Nearest& best, Collected& found) const {
    const Order order(cells, reach);
    CellPlaces places;
    for (int first = 0; first < cells.count; first += kWidth) {
      const double most = found.count < found.kMost
                              ? reach
                              : std::max(best.distance, static_cast<double>(found.distance[found.count - 1]));
      if (order.least(first) > most) return;
      found.best = static_cast<float>(best.distance);
      found.most = static_cast<float>(most);
      const std::int16_t* const which = order.cells.data() + first;
      loops().nearestOnCells(cells, which, std::min(cells.count - first, kWidth), found, &places);
      unsigned lanes = places.minima | places.nearest;
      while (lanes != 0) {
        const int lane = takeNearest(places, lanes);
        lookAt(cells.cell[which[lane]], places, lane, reach, best, found);
      }
    }
  }

  void lookAt(std::uint32_t cell, const CellPlaces& places, int lane, double reach, Nearest& best,
              Collected& found) const {
    const float distance = places.distance[lane], least = places.least[lane];
    if (static_cast<double>(least) < best.distance || distance - least > 2.0f * kCellError) {
      Nearest place{};
      if (!searchCell(cell, place)) return;
      if (place.distance < best.distance) best = place;
      if (place.distance <= reach &&
          (a - place.point).dot(place.gradient) > kAligned * place.distance * place.gradient.norm())
        add(exact(cell, place), found);
    } else if ((places.minima >> lane & 1) != 0) {
      const Eigen::Vector3f way(places.way[0][lane], places.way[1][lane], places.way[2][lane]);
      add({cell, distance, way / std::max(distance, 1e-6f)}, found);
    }
  }
};

}  // namespace

void kernel::findMinima(const Solid& solid, const Vec3& p, double reach, SolidMinima& minima) noexcept {
  minima.count = 0;
  if (p.allFinite() && reach >= 0.0) MinimaSearch(solid, p, p).minima(reach / solid.cell(), minima);
}

}  // namespace enamel
