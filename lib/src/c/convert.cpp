#include "c/convert.hpp"

#include <cmath>
#include <limits>

#include "core/message.hpp"
#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/solid_surface.hpp"

namespace enamel::c {
namespace {

template <typename Struct>
const Struct& known(const Struct& given, const char* name) {
  require(isKnown(given), std::string(name) + ".size is " + std::to_string(given.size) + ", must be " +
                              std::to_string(sizeof(Struct)) +
                              ": initialise the struct, and use the header of this library");
  return given;
}

MeshModel meshOf(const EnamelObstacleDef& def) {
  if (def.file != nullptr) return MeshModel(loadMesh(def.file, def.unit));
  require(def.vertices != nullptr && def.triangles != nullptr, "a mesh needs vertices and triangles");
  constexpr std::size_t kMost = 1U << 27U;
  require(def.vertex_count <= kMost && def.triangle_count <= kMost,
          "a mesh has " + std::to_string(def.vertex_count) + " vertices and " + std::to_string(def.triangle_count) +
              " triangles, must be at most " + std::to_string(kMost));
  TriangleMesh mesh;
  for (std::size_t i = 0; i < def.vertex_count; ++i)
    mesh.vertices.emplace_back(Eigen::Map<const Vec3>(def.vertices + 3 * i));
  for (std::size_t i = 0; i < def.triangle_count; ++i)
    mesh.triangles.push_back({def.triangles[3 * i], def.triangles[3 * i + 1], def.triangles[3 * i + 2]});
  return MeshModel(std::move(mesh));
}

std::vector<SolidLayer> layersOf(const EnamelObstacleDef& def) {
  require(def.layers != nullptr && def.layer_count > 0, "a solid needs layers");
  std::vector<SolidLayer> layers;
  for (std::size_t i = 0; i < def.layer_count; ++i)
    layers.push_back({"layer " + std::to_string(i), materialOf(def.layers[i].material), def.layers[i].hardness,
                      def.layers[i].depth, nullptr});
  return layers;
}

}  // namespace

Tool toolOf(const EnamelTool& given) {
  const EnamelTool& in = known(given, "EnamelTool");
  require(in.count >= 0 && in.count <= kMaxToolParts,
          "EnamelTool.count is " + std::to_string(in.count) + ", must be in 0 to " + std::to_string(kMaxToolParts));
  Tool tool;
  tool.count = in.count;
  for (int i = 0; i < in.count; ++i)
    tool.parts[static_cast<std::size_t>(i)] = {Eigen::Map<const Vec3>(in.parts[i].a),
                                               Eigen::Map<const Vec3>(in.parts[i].b), in.parts[i].radius};
  if (in.head != 0) tool.head = in.head;
  return tool;
}

Bur burOf(const EnamelBur& given) {
  const EnamelBur& in = known(given, "EnamelBur");
  Bur bur{in.part, in.wear, in.turns};
  if (in.torque != 0.0) bur.torque = in.torque;
  if (in.inertia != 0.0) bur.inertia = in.inertia;
  bur.drag = in.drag;
  bur.runOut = in.run_out;
  bur.blades = in.blades;
  bur.shaftCompliance = in.shaft_compliance;
  bur.shaftFrequency = in.shaft_frequency;
  bur.shaftDamping = in.shaft_damping;
  return bur;
}

SessionObstacle obstacleOf(const EnamelObstacleDef& given) {
  const EnamelObstacleDef& def = known(given, "EnamelObstacleDef");
  SessionObstacle obstacle;
  obstacle.name = def.name == nullptr ? "" : def.name;
  obstacle.pose = poseOf(def.pose);
  obstacle.material = materialOf(def.material);
  obstacle.thickness = def.thickness;
  obstacle.active = def.active != 0;
  const double* d = def.dimensions;
  switch (def.shape) {
    case ENAMEL_HALF_SPACE: obstacle.shape = HalfSpace{}; break;
    case ENAMEL_BOX: obstacle.shape = Box{Eigen::Map<const Vec3>(d)}; break;
    case ENAMEL_SPHERE: obstacle.shape = Sphere{d[0]}; break;
    case ENAMEL_CAPSULE: obstacle.shape = Capsule{d[0], d[1]}; break;
    case ENAMEL_MESH: obstacle.mesh = std::make_shared<MeshModel>(meshOf(def)); break;
    case ENAMEL_SOLID:
      obstacle.solid = def.solid != nullptr
                           ? def.solid->solid
                           : std::make_shared<const Solid>(meshOf(def), layersOf(def), SolidOptions{def.cell});
      break;
    default:
      throw Error("EnamelObstacleDef.shape is " + std::to_string(def.shape) + ", must be an EnamelShape, 0 to 5");
  }
  return obstacle;
}

MeshModel targetOf(const EnamelObstacleDef& given) {
  const EnamelObstacleDef& def = known(given, "EnamelObstacleDef");
  if (def.shape == ENAMEL_SOLID && def.solid != nullptr) return MeshModel(surfaceOf(*def.solid->solid));
  require(def.shape == ENAMEL_MESH, "the target must be an ENAMEL_MESH, or an ENAMEL_SOLID with `solid`");
  return meshOf(def);
}

std::vector<Guide> guidesOf(const EnamelGuide* guides, std::size_t count) {
  require(count <= kMaxGuides,
          "there are " + std::to_string(count) + " guides, must be at most " + std::to_string(kMaxGuides));
  std::vector<Guide> result;
  for (std::size_t i = 0; i < count; ++i) {
    const EnamelGuide& in = guides[i];
    const double* d = in.dimensions;
    Guide& guide = result.emplace_back();
    switch (in.shape) {
      case ENAMEL_GUIDE_LINE: {
        const std::size_t points = in.points == nullptr ? 0 : in.point_count;
        require(points <= kMaxGuidePoints, "guide " + std::to_string(i) + ": the line has " + std::to_string(points) +
                                               " points, must have 1 to " + std::to_string(kMaxGuidePoints));
        Polyline line{{}, d[0]};
        for (std::size_t p = 0; p < points; ++p) line.points.emplace_back(Eigen::Map<const Vec3>(in.points + 3 * p));
        guide.shape = std::move(line);
        break;
      }
      case ENAMEL_GUIDE_PLANE: guide.shape = Plane{}; break;
      case ENAMEL_GUIDE_HALF_SPACE: guide.shape = HalfSpace{}; break;
      case ENAMEL_GUIDE_BOX: guide.shape = Box{Eigen::Map<const Vec3>(d)}; break;
      default:
        throw Error("EnamelGuide.shape is " + std::to_string(in.shape) + ", must be an EnamelGuideShape, 0 to 3");
    }
    guide.pose = poseOf(in.pose);
    guide.stiffness = in.stiffness;
    guide.maxForce = in.max_force;
  }
  return result;
}

std::map<std::string, std::string> parametersOf(const EnamelParameter* parameters, std::size_t count) {
  require(parameters != nullptr || count == 0, "the list of parameters is NULL");
  std::map<std::string, std::string> result;
  for (std::size_t i = 0; i < count; ++i) {
    require(parameters[i].key != nullptr && parameters[i].value != nullptr,
            "parameter " + std::to_string(i) + " has no key or no value");
    result[parameters[i].key] = parameters[i].value;
  }
  return result;
}

void toPlain(const Snapshot& in, EnamelSnapshot& out) noexcept {
  out = EnamelSnapshot{};
  out.size = sizeof out;
  const LoopTick& tick = in.tick;
  out.joints = static_cast<std::int32_t>(tick.command.effort.size());
  out.tick = tick.number;
  out.time = tick.measurement.time;
  toPlain(tick.pose, out.position, out.rotation);
  Eigen::Map<Vec6>(out.twist) = tick.twist;
  Eigen::Map<Vec6>(out.wrench) = in.wrench;
  out.normal_force = tick.normalForce;
  Eigen::Map<Vec3>(out.base) = in.base;
  enamel::toPlain(tick.measurement.q, out.q);
  enamel::toPlain(tick.command.effort, out.command);
  out.gripper = tick.measurement.gripper.value_or(std::numeric_limits<double>::quiet_NaN());
  out.heat = tick.measurement.heat;
  std::copy(in.removed.begin(), in.removed.end(), out.removed);
  out.missed = in.missed;
  out.held = in.held;
  out.dropped_events = in.droppedEvents;
  out.lost_cuts = in.lostCuts;
  out.unsent = in.unsent;
  out.since_tick = in.sinceTick;
  out.mode = static_cast<std::int32_t>(tick.mode);
  out.status = resultOf(tick.status);
  out.reason = static_cast<std::int32_t>(tick.reason);
  out.fault = static_cast<std::int32_t>(in.fault);
  out.enabled = in.enabled ? 1 : 0;
  out.clutched = in.clutched ? 1 : 0;
  out.spins = in.spins ? 1 : 0;
  out.bur_turns = in.burTurns;
  out.bur_torque = in.burTorque;
  out.bur_chatter = in.burChatter;
  out.buttons = tick.measurement.buttons;
  out.conditions = tick.measurement.conditions;
  out.contact_count = storedContacts(in.contacts.count);
  out.omitted_contacts = in.contacts.omitted;
  for (int i = 0; i < out.contact_count; ++i) enamel::toPlain(in.contacts.contacts[i], out.contacts[i]);
}

void toPlain(const SessionEvent& in, EnamelEvent& out) noexcept {
  out = EnamelEvent{};
  out.size = sizeof out;
  out.kind = static_cast<std::int32_t>(in.kind);
  out.tick = in.tick;
  out.time = in.time;
  out.obstacle = {in.obstacle.slot, in.obstacle.generation};
  Eigen::Map<Vec3>(out.point) = in.point;
  Eigen::Map<Vec3>(out.normal) = in.normal;
  out.speed = in.speed;
  out.impulse = in.impulse;
  std::copy(in.removed.begin(), in.removed.end(), out.removed);
  out.count = in.count;
  out.extent = in.extent;
  out.part = in.part;
  out.reason = static_cast<std::int32_t>(in.reason);
}

}  // namespace enamel::c
