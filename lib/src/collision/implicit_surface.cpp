#include "enamel/collision/implicit_surface.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "grid_surface.hpp"

namespace enamel {

TriangleMesh surfaceOf(const std::function<double(const Vec3&)>& field, const Vec3& low, const Vec3& high,
                       double cell) {
  constexpr double kMostSamples = 1 << 28;
  require(low.allFinite() && high.allFinite() && (high - low).minCoeff() > 0.0,
          "implicit surface: the box is empty or not finite");
  require(std::isfinite(cell) && cell > 0.0,
          "implicit surface: the cell is " + formatNumber(cell) + " m, must be above 0");
  const Vec3 cells = ((high - low) / cell).array().ceil();
  require((cells.array() + 1.0).prod() <= kMostSamples,
          "implicit surface: cells of " + formatNumber(cell) + " m need more than 2^28 samples");
  const std::array<int, 3> size = {static_cast<int>(cells.x()) + 1, static_cast<int>(cells.y()) + 1,
                                   static_cast<int>(cells.z()) + 1};
  const auto place = [&](const Vec3& grid) -> Vec3 { return low + cell * grid; };
  std::vector<double> samples;
  samples.reserve(static_cast<std::size_t>((cells.array() + 1.0).prod()));
  for (int z = 0; z < size[2]; ++z)
    for (int y = 0; y < size[1]; ++y)
      for (int x = 0; x < size[0]; ++x) {
        const double value = field(place(Vec3(x, y, z)));
        require(std::isfinite(value), "implicit surface: the field is not finite");
        const bool isBorder = x == 0 || y == 0 || z == 0 || x + 1 == size[0] || y + 1 == size[1] || z + 1 == size[2];
        samples.push_back(isBorder ? std::max(value, 0.0) : value);
      }
  return kernel::surfaceOfGrid(
      size, [&](std::size_t sample) { return samples[sample]; }, place);
}

}  // namespace enamel
