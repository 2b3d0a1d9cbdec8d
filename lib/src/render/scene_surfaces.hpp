// The surfaces of a scene: those of its obstacles, and of the layers of its solids.
#pragma once

#include <algorithm>
#include <memory>
#include <variant>

#include "enamel/collision/scene.hpp"

namespace enamel {

/// Return whether `test(material, tap)` is true for a surface of the scene.
template <typename Test>
bool anySurface(const Scene& scene, const Test& test) {
  return std::any_of(scene.obstacles().begin(), scene.obstacles().end(), [&test](const Obstacle& obstacle) {
    const auto* const solid = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape);
    if (solid == nullptr) return test(obstacle.material, obstacle.tap);
    return std::any_of((*solid)->layers().begin(), (*solid)->layers().end(),
                       [&test](const SolidLayer& layer) { return test(layer.material, layer.tap); });
  });
}

}  // namespace enamel
