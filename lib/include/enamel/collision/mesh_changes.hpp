// Changes of a mesh, passed from the thread that edits it to one that draws it. Neither thread waits.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "enamel/core/types.hpp"

namespace enamel {

/// All differences since the previous change. It contains values, so the reader does not need the model.
struct MeshChange {
  std::uint64_t revision = 0;               ///< number of edits of the mesh, including those of this change
  std::vector<int> vertices;                ///< moved or added vertices, each once, in any order
  std::vector<Vec3> positions;              ///< their present positions, m
  std::vector<int> triangles;               ///< added, replaced or removed triangles, each once
  std::vector<std::array<int, 3>> corners;  ///< their present vertices; all -1: removed
};

/// A list of mesh changes: one thread records and publishes, another takes. Changes that are not taken stay and merge
/// with later ones. Nothing is lost, and no list is longer than the mesh. Memory: three lists of all vertices and
/// triangles.
class MeshChanges {
 public:
  /// Make lists for vertex and triangle numbers below these. Realtime: no.
  MeshChanges(int vertices, int triangles);
  MeshChanges(const MeshChanges&) = delete;
  MeshChanges& operator=(const MeshChanges&) = delete;

  /// Record the present position of a vertex. Editing thread. Realtime: yes.
  void recordVertex(int vertex, const Vec3& position) noexcept;

  /// Record the present corners of a triangle, all -1 if it was removed. Editing thread. Realtime: yes.
  void recordTriangle(int triangle, const std::array<int, 3>& corners) noexcept;

  /// End an edit, and return the number of edits so far. Records since the last call form one edit. They are published
  /// if the reader has taken everything that was published before. Otherwise call again later, for example at each
  /// tick. Editing thread. Realtime: yes.
  std::uint64_t publish() noexcept;

  /// Return the newest change, or null if nothing was published since the last call. It stays valid until the next
  /// call. Reading thread. Realtime: yes.
  const MeshChange* take() noexcept;

 private:
  // A change, and the position of each item in its lists.
  struct List {
    MeshChange change;
    std::vector<int> ofVertex, ofTriangle;  // -1: not in the list
    void clear() noexcept;
  };
  std::array<List, 3> lists_;
  List* told_ = &lists_[0];       // owned by the editing thread
  List* published_ = &lists_[1];  // owned by the reading thread while isFull_, otherwise by the editing thread
  List* taken_ = &lists_[2];      // owned by the reading thread
  std::atomic<bool> isFull_{false};
  bool isEdited_ = false;
  std::uint64_t edits_ = 0;
};

}  // namespace enamel
