// The obstacles of a session: the list that callers see, and what the loop of each session works with.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "enamel/render/drill.hpp"
#include "enamel/render/tick_scene.hpp"
#include "enamel/session/session.hpp"

namespace enamel::session {

/// The obstacles as callers know them. An obstacle that was removed leaves an inactive one until its slot is used
/// again.
struct Obstacles {
  Scene scene;
  std::vector<std::uint32_t> generation;             // by slot; 0: free
  std::vector<std::uint32_t> revision;               // by slot: rises with each new shape and each restored solid
  std::vector<std::shared_ptr<MeshModel>> meshes;    // by slot: can be edited; may be null
  std::vector<std::shared_ptr<const Solid>> solids;  // by slot: uncut originals of copies; may be null
};

/// The tool of a session.
struct SessionTool {
  Tool tool;
  std::optional<Bur> bur;
};

/// Changes of a solid: those on their way from the loop, and the solid as the callers know it.
struct TakenChanges {
  explicit TakenChanges(const Solid& solid) : newest(solid), unread(static_cast<std::size_t>(solid.bricks()), 0) {}

  SolidChanges sent;
  Solid newest;                       // for callers, as the next ones
  std::vector<std::uint64_t> unread;  // revisions of the bricks that next() has not returned yet; else 0

  bool take() noexcept;  // what was sent; return false if there was nothing
  bool next(BrickChange& change) noexcept;
};

/// The session's own copies of the solids, and their changes for drawing, by slot; null for other shapes.
struct OwnSolids {
  std::vector<std::shared_ptr<Solid>> solids;
  std::vector<std::shared_ptr<TakenChanges>> changes;
};

/// The obstacles and the bur of the loop of one session. Built on a caller's thread; the loop exchanges it as a whole.
struct World : OwnSolids {
  Scene scene;                                      // stated poses, from the callers and from beforeTick
  std::vector<std::uint32_t> generation, revision;  // by slot
  std::vector<std::shared_ptr<Solid>> forDrill;
  std::unique_ptr<TickScene> tick;  // refers to `scene`
  std::unique_ptr<Drill> drill;     // null: no bur
  bool keepsDrill = false;          // the tool is the same: continue with the drill of the world before
};

/// Build a world. `own` are the copies for the obstacles `before`; a copy continues if obstacle and revision are the
/// same. Throws Error as makeToolTrack() and Drill.
std::unique_ptr<World> makeWorld(const Obstacles& obstacles, const Obstacles& before, const OwnSolids& own,
                                 const SessionTool& tool, bool isNewTool);

/// Make `next` the world of a tick; `next` then has the old one. Realtime: yes.
void exchange(HapticTick& tick, std::unique_ptr<World>& world, std::unique_ptr<World>& next) noexcept;

/// The place of a removed obstacle.
Obstacle freeSlot(int slot);

}  // namespace enamel::session
