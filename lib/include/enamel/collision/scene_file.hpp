// Scene files: the tool, its start position and the obstacles.
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
  Vec3 start = Vec3::Zero();  ///< TCP in W, m; the tool touches nothing there
  Tool tool;                  ///< default: a point at the TCP
  Scene scene;
  /// One for each obstacle, null for other shapes: the meshes of the scene, for edits.
  std::vector<std::shared_ptr<MeshModel>> meshes;
  std::vector<std::shared_ptr<Solid>> solids;  ///< one for each obstacle, null for other shapes: for cuts
  std::optional<Bur> bur;                      ///< empty if the file has none
  std::vector<std::string> notes;              ///< warnings, one line each: unclear inside, unit, size of a cell
  double maxForce = std::numeric_limits<double>::infinity();  ///< largest rendered force that a guard should allow, N
};

/// Read a scene file. Lengths are in m, angles in deg, and `euler_deg` (default 0) means R = Rz Ry Rx. Realtime: no.
///
/// Keys of the file:
/// - `name`, `start` [m], optional `max_force` [N];
/// - optional `tool`: a name (toolOf()), or a list of capsules in the platform's frame: `from`, optional `to` (default:
///   a sphere), `radius`;
/// - optional table `bur`: the tool's `part`, and the numbers of Bur: `wear`, `turns`, `torque`, `inertia`, `drag`,
///   `run_out`, `blades`, `shaft_compliance`, `shaft_frequency` and `shaft_damping`;
/// - list `obstacle` of tables, each with `name`, `shape`, the keys of its shape, and optionally its material and a
///   table `suspension`;
/// - optional list `guide` of tables, each with `shape`, the keys of its shape, `stiffness` [N/m] and `max_force` [N].
///
/// Keys of a guide's shapes: "line": `points` [m], optional `radius` (default 0). "plane" and "half_space": `point`,
/// `normal` (of a half space: to the side where the TCP shall be). "box": `centre`, `size`, optional `euler_deg`.
///
/// Keys of a material: `stiffness` [N/m] (default: rigid), `friction` (default 0), `sliding_friction` (default:
/// `friction`), `stribeck_speed` [m/s] (default 0), `viscosity` [N s/m] (default 0). Of a rough surface also:
/// `roughness` and `wavelength` [m]. Of a compliant layer also: `exponent` (default 1), `layer_thickness` [m] (default:
/// none), `hysteresis` [s/m] (default 0), `puncture_force` [N] (default: none). See Material.
///
/// Keys of a suspension: `inertia` (six numbers), `stiffness` and `damping` (default 0), `centre` (default: the origin
/// of the obstacle's frame). See Suspension.
///
/// Keys of the shapes:
/// - "half_space": `point`, `normal` (outward, of any length).
/// - "box": `centre`, `size`, optional `euler_deg`.
/// - "sphere": `centre`, `radius`.
/// - "capsule": `from`, `to`, `radius`.
/// - "mesh": `file` (relative to the scene file, or absolute), `unit` of its coordinates ("m", "mm" or "um"), optional
///   `scale` (default 1), `position` (of its origin) and `euler_deg`. With `thin = true` the mesh is a sheet with two
///   sides and no inside, with the key `thickness`.
/// - "solid": the keys of a mesh without `thin` and `thickness`, optional `cell` (default 1e-4), and a list `layer` of
///   tables. The mesh must be closed. If `file` ends in ".solid", it is a saved solid (loadSolid()); then only
///   `position` and `euler_deg` are allowed.
///
/// Keys of a layer: `name`, `hardness` [Pa], optionally its material, and `depth` (default 0) or `file`. `file` is a
/// mesh in the same coordinates at whose surface the layer begins.
///
/// `spare`: room for updates in every mesh.
///
/// Throws ConfigurationError, with file, line, key, value and limit, for:
/// - a file that cannot be read, or malformed TOML;
/// - unknown or missing keys, wrong types, values outside their range;
/// - an empty scene, two obstacles with the same name, or a guide that checkGuide() rejects;
/// - a start inside an obstacle;
/// - a mesh that loadMesh() or checkMesh() rejects.
SceneFile loadScene(const std::string& path, SpareCapacity spare = {});

/// Read a scene from text in memory, as loadScene(). Messages name `file`; mesh paths are relative to it.
SceneFile parseScene(std::string_view text, const std::string& file, SpareCapacity spare = {});

/// The text of a scene file, and its mesh files. In `text` the meshes have the names "mesh-0.ply", "mesh-1.stl" and so
/// on, so that all files can be in one folder.
struct PackedScene {
  struct File {
    std::string name, path;  ///< name in `text`, and present path
  };
  std::string text;
  std::vector<File> files;
};

/// Read a scene file that will be copied to another place. Throws ConfigurationError as loadScene(). Realtime: no.
PackedScene packScene(const std::string& path);

}  // namespace enamel
