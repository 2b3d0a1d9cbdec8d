// What the tool can touch: a list of named obstacles, and the file that they are read from.
#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "enamel/collision/box.hpp"
#include "enamel/collision/half_space.hpp"

namespace enamel {

/// One solid at rest.
struct Obstacle {
  std::string name;
  std::variant<HalfSpace, Box> shape;
  int material = 0;
};

/// Obstacles, and where the tool begins. Obstacles may overlap: each answers for itself.
struct Scene {
  std::string name;
  Vec3 start = Vec3::Zero();  ///< of the TCP in W, m; not inside an obstacle
  std::vector<Obstacle> obstacles;
};

/// The scene of one flat wall, with the tool on its surface.
Scene flatWall(const HalfSpace& wall);

/// Contacts of a tool point with every obstacle, near or far, the deepest first; among equals in the order of the
/// scene. With more than kMaxContacts obstacles the farthest are left out. Realtime: yes.
void queryContacts(const Scene& scene, const Vec3& toolPoint, ContactSnapshot& snapshot) noexcept;

/// Reads a scene file: `name`, `start` [m], and a list `obstacle` of tables with `name`, `shape`, optional `material`
/// (default 0), and for shape = "half_space": `point` [m], `normal` (outward, of any length); for shape = "box":
/// `centre` [m], `size` [m], optional `euler_deg` (alpha, beta, gamma; R = Rz Ry Rx).
/// Throws ConfigurationError, with file, line, key, value and limit, on a file that cannot be read, malformed TOML,
/// unknown or missing keys, wrong types, values out of their range, an empty scene, two obstacles of one name, and a
/// start inside an obstacle. Realtime: no.
Scene loadScene(const std::string& path);

/// The same for text in memory; `file` stands in messages.
Scene parseScene(std::string_view text, const std::string& file);

}  // namespace enamel
