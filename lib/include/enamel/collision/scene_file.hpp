// Scene files: what the tool is, where it begins and what it can touch.
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enamel/collision/scene.hpp"
#include "enamel/collision/tool.hpp"

namespace enamel {

/// Content of a scene file.
struct SceneFile {
  std::string name;
  Vec3 start = Vec3::Zero();  ///< of the TCP in W, m; the tool does not touch there
  Tool tool;                  ///< a point at the TCP where the file names none
  Scene scene;
  std::vector<std::shared_ptr<MeshModel>>
      meshes;                                  ///< by obstacle, null for other shapes: what the scene holds, to edit
  std::vector<std::shared_ptr<Solid>> solids;  ///< by obstacle, null for other shapes: what the scene holds, to cut
  std::optional<Bur> bur;                      ///< where the file names one
  std::vector<std::string> notes;              ///< a line for each doubt: inside, unit, size of a cell
  double maxForce = std::numeric_limits<double>::infinity();  ///< that a guard should let a renderer put on the tool, N
};

/// Reads a scene file: `name`, `start` [m], optional `tool` and `max_force` [N], and a list `obstacle` of tables with
/// `name`, `shape` and optionally the material: `stiffness` [N/m] (default: rigid), `friction` (default 0),
/// `sliding_friction` (default: `friction`), `viscosity` [N s/m] (default 0). Lengths in m, angles in deg, R = Rz Ry Rx
/// of `euler_deg` (default 0).
/// - tool: list of capsules in the platform's frame, `from`, optional `to` (default: a sphere), `radius`
/// - bur: table with the tool's `part` (default 0), `wear` and `turns` a second (defaults: those of Bur)
/// - shape = "half_space": `point`, `normal` (outward, of any length)
/// - shape = "box": `centre`, `size`, optional `euler_deg`
/// - shape = "sphere": `centre`, `radius`
/// - shape = "capsule": `from`, `to`, `radius`
/// - shape = "mesh": `file` (beside the scene file, or absolute), `unit` of its coordinates ("m", "mm" or "um"),
///   optional `scale` (default 1), `position` (of its origin) and `euler_deg`; with `thin = true` it is a sheet with
///   two sides and no inside, `thickness` thick
/// - shape = "solid": as a mesh, which must be closed, with `cell` (default 1e-4) and a list `layer` of tables with
///   `name`, `hardness` [Pa], a material as above and either `depth` (default 0) or `file`, a mesh in the same
///   coordinates at whose surface the layer begins
/// Throws ConfigurationError, with file, line, key, value and limit, on a file that cannot be read, malformed TOML,
/// unknown or missing keys, wrong types, values out of their range, an empty scene, two obstacles of one name, a start
/// inside an obstacle, and as loadMesh() and checkMesh(). Realtime: no.
/// `spare`: room in every mesh for updates.
SceneFile loadScene(const std::string& path, SpareCapacity spare = {});

/// The same for text in memory; `file` stands in messages, meshes are looked for beside it.
SceneFile parseScene(std::string_view text, const std::string& file, SpareCapacity spare = {});

/// A scene file's text, and the files that it names: `text` names them "mesh-0.ply", "mesh-1.stl" and so on, in a
/// folder of their own.
struct PackedScene {
  struct File {
    std::string name, path;  ///< in `text`; where it is now
  };
  std::string text;
  std::vector<File> files;
};

/// Read a scene file that will be copied to another place. Throw ConfigurationError as loadScene(). Realtime: no.
PackedScene packScene(const std::string& path);

}  // namespace enamel
