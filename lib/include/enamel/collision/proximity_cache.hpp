// What a tool remembers of its last query on a mesh, so that the next one, close by, is answered faster. The answer
// is the same bit for bit with a cache, with a cache of another place or mesh, and without one.
#pragma once

#include <stdint.h>

namespace enamel {

/// One for each tool shape and obstacle; not shared between threads. Plain data of fixed size: copying is cheap and
/// always valid. The content is private to the queries.
struct ProximityCache {
  static constexpr int kCapacity = 48;

  uint64_t revision = 0;  // of the mesh that the content belongs to; 0: empty
  int32_t slot = -1;      // of the last answer's triangle
  int32_t count = 0;      // of listed leaves; 0: no list
  double last[3] = {};    // last query (local coordinates of the hierarchy, like all that follows)
  double origin[3] = {};  // centre of the ball in which the list is complete
  double radius = 0.0;    // of that ball
  double margin = 0.0;    // radius to try next
  int32_t leaf[kCapacity] = {};
  float low[3][kCapacity] = {};
  float high[3][kCapacity] = {};
};

}  // namespace enamel
