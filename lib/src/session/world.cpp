#include "session/world.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "enamel/render/tick.hpp"

namespace enamel::session {
namespace {

// Give the obstacles with a solid the session's own copy of it.
Scene withSolids(const Scene& scene, const std::vector<std::shared_ptr<Solid>>& solids) {
  Scene own = scene;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    if (!solids[i]) continue;
    Obstacle obstacle = own.obstacles()[i];
    obstacle.shape = std::shared_ptr<const Solid>(solids[i]);
    own.replace(static_cast<int>(i), std::move(obstacle));
  }
  return own;
}

}  // namespace

bool TakenChanges::take() noexcept {
  bool isAny = false;
  for (BrickChange change; sent.take(change); isAny = true) {
    newest.set(change.brick, change.samples);
    unread[static_cast<std::size_t>(change.brick)] = change.revision;
  }
  return isAny;
}

bool TakenChanges::next(BrickChange& change) noexcept {
  const auto found = std::find_if(unread.begin(), unread.end(), [](std::uint64_t revision) { return revision != 0; });
  if (found == unread.end()) return false;
  change.brick = static_cast<int>(found - unread.begin());
  change.revision = std::exchange(*found, 0);
  change.samples = newest.samples(change.brick);
  return true;
}

Obstacle freeSlot(int slot) {
  Obstacle free{"(free slot " + std::to_string(slot) + ")", HalfSpace{}, Pose{}, Vec6::Zero(), Material{}, 0.0};
  free.active = false;
  return free;
}

std::unique_ptr<World> makeWorld(const Obstacles& obstacles, const Obstacles& before, const OwnSolids& own,
                                 const SessionTool& tool, bool isNewTool) {
  auto world = std::make_unique<World>();
  const std::size_t slots = obstacles.generation.size();
  world->generation = obstacles.generation;
  world->revision = obstacles.revision;
  world->solids.resize(slots);
  world->changes.resize(slots);
  for (std::size_t i = 0; i < slots; ++i) {
    if (!obstacles.solids[i]) continue;
    const bool continues = i < own.solids.size() && before.generation[i] == obstacles.generation[i] &&
                           before.revision[i] == obstacles.revision[i];
    world->solids[i] = continues ? own.solids[i] : std::make_shared<Solid>(*obstacles.solids[i]);
    world->changes[i] = continues ? own.changes[i] : std::make_shared<TakenChanges>(*obstacles.solids[i]);
  }
  world->forDrill = world->solids;
  world->scene = withSolids(obstacles.scene, world->solids);
  world->tick = std::make_unique<TickScene>(world->scene, tool.tool);
  world->keepsDrill = !isNewTool;
  if (isNewTool && tool.bur) world->drill = std::make_unique<Drill>(tool.tool, world->forDrill, *tool.bur);
  return world;
}

void exchange(HapticTick& tick, std::unique_ptr<World>& world, std::unique_ptr<World>& next) noexcept {
  // The loop knows the newest poses, also those of beforeTick.
  const std::size_t slots = std::min(world->generation.size(), next->generation.size());
  for (std::size_t i = 0; i < slots; ++i) {
    if (next->generation[i] == 0 || next->generation[i] != world->generation[i]) continue;
    const Obstacle& now = world->scene.obstacles()[i];
    (void)next->scene.move(static_cast<int>(i), now.pose, now.twist);
    (void)next->scene.activate(static_cast<int>(i), now.active);
  }
  tick.exchange(*next->tick);
  if (next->keepsDrill && world->drill) {
    world->drill->exchangeSolids(next->forDrill);
    std::swap(next->drill, world->drill);
  }
  tick.attach(next->drill.get());
  std::swap(next->tick, world->tick);  // the old obstacles go with the old world
  std::swap(next, world);
}

}  // namespace enamel::session
