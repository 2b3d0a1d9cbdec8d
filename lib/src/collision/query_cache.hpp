// The content of a ProximityCache: plain data of fixed size (6.3 KB). Like all data of the loops, it has no inline
// functions of the standard library.
#pragma once

#include <stdint.h>

namespace enamel::kernel {

inline constexpr int kListed = 128;  ///< triangles of a list
inline constexpr int kSpare = 16;    ///< rows are written 16 at a time

/// Every triangle that can be nearest while the tool stays in a ball. As seen from the origin each lies behind a plane,
/// so its distance from the origin plus e is at least height + normal.e. All lists are in local coordinates.
struct NearList {
  int32_t count = 0;
  double origin[3] = {};
  double radius = -1.0;  ///< of the ball; negative: empty, or not complete
  float slack = 0.0f;    ///< error of the float distances from the origin
  int32_t slot[kListed + kSpare] = {};
  float normal[3][kListed + kSpare] = {};
  float height[kListed + kSpare] = {};
};

/// The list in use, and the next one, built ahead of the tool in small steps. near_list.inl has the functions.
struct NearLists {
  static constexpr int kNodes = 48;
  static constexpr int kLeaves = 32;

  NearList list[2];
  int32_t active = 0;  ///< index of the list in use

  // The list in progress: nodes and leaves of the hierarchy. Those from firstNode and firstLeaf on are not yet visited.
  int32_t firstNode = 0, nodes = 0;
  int32_t firstLeaf = 0, leaves = 0;
  int32_t node[kNodes + kSpare] = {};
  int32_t leaf[kLeaves + kSpare] = {};
  double witness[3] = {};  // a point of the mesh, close to the nearest one to the origin
  double ball = 0.0;       // its radius
  int32_t work = 0;        // spent on it
  int32_t rest = 0;        // queries before the next one is begun
  int32_t pause = 0;       // rest after the next abandoned list
  double margin = 0.0;     // radius of the next one
};

struct Cache {
  uint64_t revision = 0;   ///< of the mesh that the content belongs to; 0: empty
  double query[3] = {};    ///< the last query point, in local coordinates
  double surface[3] = {};  ///< its answer
  NearLists near;

  // The last query of the winding number, and the distance within which its answer holds, m, in the mesh's frame.
  uint64_t signRevision = 0;
  double signAt[3] = {}, signWithin = -1.0;
  int32_t isInside = 0;
};

}  // namespace enamel::kernel
