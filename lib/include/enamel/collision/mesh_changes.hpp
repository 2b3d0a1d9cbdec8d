// What changed in a mesh, on its way from the thread that edits it to one that draws it; neither waits for the other.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "enamel/core/types.hpp"

namespace enamel {

/// Everything that is different since the change taken before: values, so that the reader need not look at the model.
struct MeshChange {
  std::uint64_t revision = 0;               ///< the mesh is now as it was after so many edits
  std::vector<int> vertices;                ///< moved or added, each once, in no particular order
  std::vector<Vec3> positions;              ///< where they are now, m
  std::vector<int> triangles;               ///< added, replaced or removed, each once
  std::vector<std::array<int, 3>> corners;  ///< their vertices now; all -1: removed
};

/// One thread tells and publishes, one takes. Changes that are not taken wait and are joined with later ones: none is
/// lost, and no list is longer than the mesh. Memory: three lists of all vertices and triangles.
class MeshChanges {
 public:
  /// For numbers below these. Realtime: no.
  MeshChanges(int vertices, int triangles);
  MeshChanges(const MeshChanges&) = delete;
  MeshChanges& operator=(const MeshChanges&) = delete;

  /// A vertex is at this place now. Editing thread. Realtime: yes.
  void recordVertex(int vertex, const Vec3& position) noexcept;

  /// A triangle has these corners now, all -1 where it was removed. Editing thread. Realtime: yes.
  void recordTriangle(int triangle, const std::array<int, 3>& corners) noexcept;

  /// What was told since the last call is one edit more. Where the reader has taken all that was published, what was
  /// told since then is published; call it now and then, a tick is often enough, as long as something waits. Returns
  /// how many edits there were. Editing thread. Realtime: yes.
  std::uint64_t publish() noexcept;

  /// The newest change, or null if nothing was published since the last call; it stays as it is until the next call.
  /// Reading thread. Realtime: yes.
  const MeshChange* take() noexcept;

 private:
  // Where an item stands in a list that holds each once.
  struct List {
    MeshChange change;
    std::vector<int> ofVertex, ofTriangle;  // -1: not in it
    void clear() noexcept;
  };
  std::array<List, 3> lists_;
  List* told_ = &lists_[0];       // the editing thread's
  List* published_ = &lists_[1];  // the reading thread's while isFull_, else the editing one's
  List* taken_ = &lists_[2];      // the reading thread's
  std::atomic<bool> isFull_{false};
  bool isEdited_ = false;
  std::uint64_t edits_ = 0;
};

}  // namespace enamel
