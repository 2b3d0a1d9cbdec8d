// Obstacles of a session, and its recordings.
#include <cmath>
#include <filesystem>
#include <utility>

#include "core/message.hpp"
#include "enamel/collision/mesh_update.hpp"
#include "session/impl.hpp"

namespace enamel {

using session::Obstacles;
using Lock = std::unique_lock<std::mutex>;

namespace {

// The obstacle with the shape of its mesh or solid.
Obstacle shapedOf(const SessionObstacle& obstacle) {
  require(!obstacle.mesh || !obstacle.solid, "obstacle \"" + obstacle.name + "\": it has both a mesh and a solid");
  Obstacle shaped = obstacle;
  if (obstacle.mesh) shaped.shape = std::shared_ptr<const MeshModel>(obstacle.mesh);
  if (obstacle.solid) shaped.shape = obstacle.solid;
  return shaped;
}

[[noreturn]] void refuseShape(const Obstacles& all, ObstacleId id) {
  throw Error("obstacle \"" + all.scene.obstacles()[static_cast<std::size_t>(id.slot)].name + "\": it is not a solid");
}

// The scene of a recording without a scene file.
bool isFlatWall(const Scene& scene, const session::SessionTool& tool) {
  const Scene wall = flatWall();
  if (scene.obstacles().size() != 1 || !isSameObstacle(wall, scene, 0)) return false;
  const Obstacle& own = scene.obstacles()[0];
  const Material& m = own.material;
  const bool isSmoothAndRigid =
      std::isinf(m.stiffness) && m.friction == 0.0 && m.slidingFriction == 0.0 && m.viscosity == 0.0;
  const ToolPart& part = tool.tool.parts[0];
  const bool isPoint = tool.tool.count == 1 && part.a.isZero(0.0) && part.b.isZero(0.0) && part.radius == 0.0;
  return !scene.guides() && !own.suspension && own.tap.frequency == 0.0 && own.pose.position.isZero(0.0) &&
         own.pose.rotation == wall.obstacles()[0].pose.rotation && isSmoothAndRigid && isPoint && !tool.bur;
}

std::string absoluteOf(const std::string& path) {
  return std::filesystem::absolute(std::filesystem::u8path(path)).u8string();
}

}  // namespace

ObstacleId Session::add(const SessionObstacle& obstacle) {
  const Lock lock = impl_->lock();
  session::Group& group = *impl_->group;
  Obstacles next = group.obstacles;
  Obstacle shaped = shapedOf(obstacle);
  shaped.twist.setZero();
  std::size_t slot = 0;
  while (slot < next.generation.size() && next.generation[slot] != 0) ++slot;
  if (slot == next.generation.size()) {
    next.scene.add(std::move(shaped));
    next.generation.push_back(0);
    next.revision.push_back(0);
    next.meshes.emplace_back();
    next.solids.emplace_back();
  } else {
    next.scene.replace(static_cast<int>(slot), std::move(shaped));
  }
  const ObstacleId id{static_cast<int>(slot), group.lastGeneration + 1};
  next.generation[slot] = next.revision[slot] = id.generation;
  next.meshes[slot] = obstacle.mesh;
  next.solids[slot] = obstacle.solid;
  impl_->changeObstacles(std::move(next));
  ++group.lastGeneration;
  impl_->checkSize(id);
  return id;
}

void Session::replace(ObstacleId id, const SessionObstacle& by) {
  const Lock lock = impl_->lock();
  const std::size_t slot = impl_->slotOf(id);
  Obstacles next = impl_->group->obstacles;
  const Obstacle& now = next.scene.obstacles()[slot];
  Obstacle shaped = shapedOf(by);
  shaped.name = now.name;
  shaped.pose = now.pose;
  shaped.twist = now.twist;
  shaped.active = now.active;
  next.scene.replace(id.slot, std::move(shaped));
  next.revision[slot] = impl_->group->lastGeneration + 1;
  next.meshes[slot] = by.mesh;
  next.solids[slot] = by.solid;
  impl_->changeObstacles(std::move(next));
  ++impl_->group->lastGeneration;
  impl_->checkSize(id);
}

void Session::setMaterial(ObstacleId id, const Material& material) {
  impl_->changeObstacle(id, [&](Obstacle& changed) {
    require(!impl_->group->obstacles.solids[static_cast<std::size_t>(id.slot)],
            "obstacle \"" + changed.name + "\": a solid has the materials of its layers");
    changed.material = material;
  });
}

void Session::setTap(ObstacleId id, const Tap& tap) {
  impl_->changeObstacle(id, [&](Obstacle& changed) { changed.tap = tap; });
}

void Session::setSuspension(ObstacleId id, const std::optional<Suspension>& suspension) {
  impl_->changeObstacle(id, [&](Obstacle& changed) {
    changed.suspension = suspension ? std::make_shared<const Suspension>(*suspension) : nullptr;
  });
}

void Session::setGuides(std::vector<Guide> guides) {
  const Lock lock = impl_->lock();
  Obstacles next = impl_->group->obstacles;
  next.scene.setGuides(std::move(guides));
  impl_->changeObstacles(std::move(next));
}

void Session::remove(ObstacleId id) {
  const Lock lock = impl_->lock();
  const std::size_t slot = impl_->slotOf(id);
  Obstacles next = impl_->group->obstacles;
  next.scene.replace(id.slot, session::freeSlot(id.slot));
  next.generation[slot] = 0;
  next.meshes[slot] = nullptr;
  next.solids[slot] = nullptr;
  impl_->changeObstacles(std::move(next));
}

ObstacleId Session::find(const std::string& name) const {
  const Lock lock = impl_->lock();
  const Obstacles& all = impl_->group->obstacles;
  for (std::size_t i = 0; i < all.generation.size(); ++i)
    if (all.generation[i] != 0 && all.scene.obstacles()[i].name == name)
      return {static_cast<int>(i), all.generation[i]};
  return {};
}

void Session::move(ObstacleId id, const Pose& pose, const Vec6& twist) {
  const Lock lock = impl_->lock();
  const std::size_t slot = impl_->slotOf(id);
  for (Impl* member : impl_->group->members) member->requireRoom();
  const Status status = impl_->group->obstacles.scene.move(id.slot, pose, twist);
  require(status == Status::ok, "obstacle \"" + impl_->group->obstacles.scene.obstacles()[slot].name +
                                    "\": its new pose or twist is " + toString(status));
  for (Impl* member : impl_->group->members)
    member->post([member, id, pose, twist]() noexcept {
      member->stray();
      if (member->exists(id)) (void)member->world->scene.move(id.slot, pose, twist);
    });
}

void Session::activate(ObstacleId id, bool active) {
  const Lock lock = impl_->lock();
  (void)impl_->slotOf(id);
  for (Impl* member : impl_->group->members) member->requireRoom();
  (void)impl_->group->obstacles.scene.activate(id.slot, active);
  for (Impl* member : impl_->group->members)
    member->post([member, id, active]() noexcept {
      member->stray();
      if (member->exists(id)) (void)member->world->scene.activate(id.slot, active);
    });
}

void Session::moveVertices(ObstacleId id, std::vector<int> vertices, std::vector<Vec3> positions) {
  const Lock lock = impl_->lock();
  const std::size_t slot = impl_->slotOf(id);
  const std::string name = "obstacle \"" + impl_->group->obstacles.scene.obstacles()[slot].name + "\": ";
  const std::shared_ptr<MeshModel>& mesh = impl_->group->obstacles.meshes[slot];
  require(mesh != nullptr, name + "only a SessionObstacle::mesh can be edited");
  require(impl_->group->members.size() == 1, name + "two sessions share it; use replace()");
  require(vertices.size() == positions.size(),
          name + std::to_string(vertices.size()) + " vertices and " + std::to_string(positions.size()) + " positions");
  const auto count = static_cast<int>(mesh->mesh().vertices.size());  // constant while the session has the mesh
  for (const int vertex : vertices)
    require(vertex >= 0 && vertex < count,
            name + "vertex " + std::to_string(vertex) + ", must be in 0 to " + std::to_string(count - 1));
  for (const Vec3& position : positions) require(position.allFinite(), name + "a position is not finite");
  impl_->requireRoom();
  impl_->post([s = impl_.get(), mesh, vertices = std::move(vertices), positions = std::move(positions)]() noexcept {
    s->stray();
    (void)enamel::moveVertices(*mesh, vertices.data(), positions.data(), static_cast<int>(vertices.size()));
  });
}

void Session::restore(ObstacleId id) {
  const Lock lock = impl_->lock();
  const std::size_t slot = impl_->slotOf(id);
  if (!impl_->group->obstacles.solids[slot]) refuseShape(impl_->group->obstacles, id);
  Obstacles next = impl_->group->obstacles;
  // A new copy: Solid::restore() of the old one would take the loop some ms.
  next.revision[slot] = impl_->group->lastGeneration + 1;
  impl_->changeObstacles(std::move(next));
  ++impl_->group->lastGeneration;
}

bool Session::takeChange(ObstacleId id, BrickChange& change) {
  const Lock lock = impl_->lock();
  session::TakenChanges* const changes = impl_->solids.changes[impl_->slotOf(id)].get();
  if (changes == nullptr) refuseShape(impl_->group->obstacles, id);
  (void)changes->take();
  return changes->next(change);
}

// A solid that only this session cuts.
std::shared_ptr<Solid> Session::Impl::ownSolid(ObstacleId id) {
  const std::shared_ptr<Solid>& solid = solids.solids[slotOf(id)];
  if (!solid) refuseShape(group->obstacles, id);
  require(group->members.size() == 1, "obstacle \"" +
                                          group->obstacles.scene.obstacles()[static_cast<std::size_t>(id.slot)].name +
                                          "\": two sessions share it; use restore()");
  requireRoom();
  return solid;
}

void Session::mark(ObstacleId id) {
  const Lock lock = impl_->lock();
  impl_->post([solid = impl_->ownSolid(id)]() noexcept { solid->mark(); });
}

void Session::undo(ObstacleId id) {
  const Lock lock = impl_->lock();
  impl_->post([s = impl_.get(), solid = impl_->ownSolid(id)]() noexcept {
    s->stray();
    (void)solid->undo();
  });
}

Solid Session::cutSolid(ObstacleId id) {
  const Lock lock = impl_->lock();
  const std::size_t slot = impl_->slotOf(id);
  session::TakenChanges* const changes = impl_->solids.changes[slot].get();
  if (changes == nullptr) refuseShape(impl_->group->obstacles, id);
  do {
    if (!impl_->isLive()) (void)changes->sent.publish(*impl_->solids.solids[slot]);  // what the loop had not sent
  } while (changes->take() && !impl_->isLive());
  return changes->newest;
}

std::shared_ptr<const Solid> Session::solid(ObstacleId id) const {
  const Lock lock = impl_->lock();
  return impl_->group->obstacles.solids[impl_->slotOf(id)];
}

void Session::record(const std::string& path) {
  const Lock lock = impl_->lock();
  const auto refuse = [](const char* what) {
    throw Error(std::string("session: ") + what + ", so a recording could not be replayed");
  };
  require(!impl_->recorder, "session: a recording is under way; call stopRecording() first");
  impl_->requireRoom();
  impl_->awaitLoop();
  if (impl_->mapped) refuse("it has a workspace map");
  if (impl_->group->members.size() > 1) refuse("it shares its obstacles");
  if (impl_->deviceText.empty()) refuse("it has no device file");
  if (impl_->sceneText.empty() && !isFlatWall(impl_->group->obstacles.scene, impl_->tool_))
    refuse("it has no scene file");
  if (impl_->strays) refuse("its obstacles or its tool were changed, moved or cut, or it had an effect");
  if (impl_->def.tool || impl_->def.bur) refuse("its tool is not that of the scene file");
  if (impl_->choice.name.empty()) refuse("its renderer has no name");
  RecordingHeader header;
  header.deviceFile = impl_->deviceFile.empty() ? impl_->device->name() : absoluteOf(impl_->deviceFile);
  header.deviceText = impl_->deviceText;
  if (!impl_->def.scene.empty()) header.sceneFile = absoluteOf(impl_->def.scene);
  header.sceneText = impl_->sceneText;
  header.start = impl_->start;
  nameRenderer(impl_->choice.name, impl_->choice.plugin, impl_->choice.parameters, impl_->group->obstacles.scene,
               header);
  impl_->recorder = std::make_unique<Recorder>(path, std::move(header), *impl_->haptics);
  impl_->post([s = impl_.get(), recorder = impl_->recorder.get()]() noexcept { s->recording = recorder; });
}

RecordingResult Session::stopRecording() {
  const Lock lock = impl_->lock();
  if (!impl_->recorder) return {};
  impl_->requireRoom();
  impl_->post([s = impl_.get()]() noexcept { s->recording = nullptr; });
  impl_->awaitLoop();
  const RecordingResult result = impl_->recorder->close();
  impl_->recorder.reset();
  return result;
}

}  // namespace enamel
