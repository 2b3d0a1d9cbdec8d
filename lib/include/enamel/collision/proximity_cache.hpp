// What a tool remembers of its last query on a mesh, so that the next one, close by, is answered faster. The answer
// is the same bit for bit with a cache, with a cache of another place or mesh, and without one.
#pragma once

#include <stdint.h>

namespace enamel {

/// One for each tool shape and obstacle; not shared between threads. Plain data of fixed size (11 KB): a copy is as
/// good as the original. The content is private to the queries.
struct ProximityCache {
  static constexpr int kTriangles = 48;
  static constexpr int kLeaves = 32;
  static constexpr int kSpare = 16;  // rows are written 16 at a time
  static constexpr int kFrameRows = 20;
  static constexpr int kBoxRows = 15;
  static constexpr int kRegion = 64;
  static constexpr int kStack = 96;

  uint64_t revision = 0;   // of the mesh that the content belongs to; 0: empty
  double query[3] = {};    // the last query point (local coordinates of the hierarchy, like all that follows)
  double surface[3] = {};  // its answer

  // What can hold the nearest point while the tool stays in a ball.
  struct List {
    int32_t count = 0;
    double origin[3] = {};
    double radius = -1.0;
    double margin = 0.0;  // radius of the next one
  };
  // Triangles for a few ticks' way, as in the leaves of the hierarchy.
  struct Triangles : List {
    int32_t uses = 0;  // queries that the list has answered
    int32_t slot[kTriangles + kSpare] = {};
    float row[kFrameRows][kTriangles + kSpare] = {};
  };
  // Leaves for a longer way, with their oriented boxes: where the triangles are taken from.
  struct Leaves : List {
    int32_t leaf[kLeaves + kSpare] = {};
    float row[kBoxRows][kLeaves + kSpare] = {};
  };
  Triangles triangles;
  Leaves leaves;

  // Every node with leaves within `reach` of its origin: where the leaves are taken from.
  struct Region {
    int32_t count = 0;
    double origin[3] = {};
    double reach = -1.0;
    int32_t node[kRegion] = {};
    float low[3][kRegion] = {};
    float high[3][kRegion] = {};
  };
  Region region[2];
  int32_t active = 0;  // region in use; the other one is being prepared
  int32_t open = -1;   // entries on the stack of the region being prepared; -1: none is
  int32_t stack[kStack] = {};
  double span = 0.0;  // how much farther than the leaves the next region reaches
};

}  // namespace enamel
