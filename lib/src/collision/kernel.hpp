// The hot loops of the mesh queries and the plain data they read. The loops are compiled once per SIMD level, each in
// a file of its own, from kernel_loops.inl. Nothing here may contain inline functions of Eigen or of the standard
// library: the linker would keep one copy of them for all levels, possibly one that this machine cannot run.
//
// Local coordinates: q = (p - centre) * scale, so that the mesh fills [-1, 1]. Floats only ever bound distances from
// below; every distance that is answered is computed in double from the original coordinates, so the answer does
// not depend on the order of the search, on the cache or on the SIMD level.
#pragma once

#include <stdint.h>

#include "query_cache.hpp"

namespace enamel::kernel {

inline constexpr int kWidth = 16;       ///< children of a node, triangles of a leaf
inline constexpr int kMaxDepth = 48;    ///< levels; the builder makes 37 at most: 14, and 23 that halve 2^23 leaves
inline constexpr int kStackSize = 768;  ///< entries; a level of the tree needs at most kWidth - 1
inline constexpr int kFrameRows = 20;   ///< of a leaf
inline constexpr int kBoxRows = 15;     ///< of a node's boxes
static_assert(kStackSize >= kMaxDepth * (kWidth - 1) + kWidth, "the stack holds every child on a path");

/// Oriented boxes of 16 children: |axis * q + offset| <= half. Unused lanes lie far away.
struct alignas(64) Node {
  float row[kBoxRows][kWidth];  ///< three axes, offsets, half sizes
  float cone[kWidth];     ///< cos^2 of the angle between the third axis and the farthest direction as Leaf::front, or 0
  int32_t child[kWidth];  ///< node number, or ~leaf number
  uint32_t lanes;         ///< bit mask of those in use
  uint32_t leaves;        ///< of those that hold a leaf
};

/// The same children between planes along the axes, rounded outwards. Unused lanes hold an empty box.
struct alignas(64) AlignedBoxes {
  float low[3][kWidth];
  float high[3][kWidth];
};

/// 16 triangles in local coordinates, each in a plane frame of its own: corner a at the origin, the longest edge along
/// u, the opposite corner at v >= 0, the plane at h = 0. Unused lanes lie far away. `front` and `back`: cos^2 of the
/// angle between the normal and the farthest direction to a point in front of the triangle, or behind it, that it may
/// hold a local minimum of the distance from, or 0.
struct alignas(64) Leaf {
  float row[kFrameRows][kWidth];
  float front[kWidth];
  float back[kWidth];
};

/// Sums over the triangles of the same children, for the winding number.
enum MomentRow : int {
  kCentre = 0,  ///< three: of the areas
  kRadius = 3,  ///< about it, of all corners
  kArea = 4,
  kNormal = 5,  ///< three: sum of area times unit normal
  kSpread = 8,  ///< six, xx yy zz xy xz yz: of area times normal times offset from the centre, symmetric part
  kMomentRows = 14
};
struct alignas(64) MomentRows {
  float row[kMomentRows][kWidth];
};

/// Rows of a leaf.
enum FrameRow : int {
  kAxis = 0,     ///< nine: u, v, h of the frame's rotation
  kOffset = 9,   ///< three: (u, v, h) = axis * q + offset
  kLength = 12,  ///< three, of the edges: along u; from its end to the third corner; from a to the third corner
  kCosine = 15,  ///< two: directions of the second and third edge in (u, v)
  kSine = 17,    ///< two
  kInside = 19   ///< 0; -1e30 for a triangle that is bounded by its edges alone
};
static_assert(kInside + 1 == kFrameRows);

inline constexpr float kFarAway = 1e18f;  ///< its square is finite, and larger than that of any local coordinate

/// What an unused lane holds in a row: a point far away.
static constexpr float unusedRow(int row) {
  return row >= kOffset && row < kLength        ? kFarAway
         : row == kCosine || row == kCosine + 1 ? 1.0f
         : row == kInside                       ? -1e30f
                                                : 0.0f;
}

/// One triangle in double, in the order of the leaves: slot = 16 * leaf + lane.
struct Triangle {
  double corner[3][3];
  int32_t index;  ///< number in the mesh; -1 for an unused slot
  float cone;     ///< cos^2 of the angle to the farthest normal around it, or 0; -1: long or without area, needs the
                  ///< careful path
};

/// What the loops see of a mesh.
struct Mesh {
  const Node* nodes;
  const Leaf* leaves;
  const AlignedBoxes* boxes;  ///< by node
  const Triangle* triangles;
  int32_t root;  ///< as Node::child; always a node
  double centre[3];
  double scale;
  double extent;  ///< no local coordinate of the mesh is larger: 1 when it is built
  int32_t tight;  ///< 1 while every box holds a triangle; removing may leave empty ones
  uint64_t revision;
};

/// What of a triangle the closest point lies on: corner i, the edge from corner i, the face.
enum TriangleFeature : int32_t { kCorner0, kCorner1, kCorner2, kEdge01, kEdge12, kEdge20, kFace };

/// The point of a triangle with plane (x - a).n = 0 that is nearest to p.
struct Candidate {
  double squared;  ///< distance^2
  double point[3];
  int32_t feature;
  double overPlane;      ///< (p - a).n
  double normalSquared;  ///< n.n; both are 0 for a long or flat triangle, whose n says little
};

/// Where nothing was found: the limit^2, p, kFace, 0, 0 and slot -1.
struct Answer {
  Candidate nearest;
  int32_t slot;
};

struct SegmentAnswer {
  double squared;    ///< distance^2; where nothing was found, of a distance that every triangle keeps
  double parameter;  ///< of the segment's nearest point
  double point[3];   ///< on the mesh
  int32_t feature;
  int32_t slot;  ///< -1 where nothing was found
};

/// Called for every triangle that may be within reach; answers the reach from now on (visitMinima may go on with the
/// first one).
using Visit = double (*)(void* context, int32_t slot, double reach);

struct Loops {
  /// Nearest triangle not farther than sqrt(limitSquared); of equally near ones the one of smallest index.
  void (*closest)(const Mesh& mesh, const double point[3], double limitSquared, Cache* cache, Answer* answer);
  /// Every triangle within `reach` of the segment from -> to (and some more), in no particular order.
  void (*visit)(const Mesh& mesh, const double from[3], const double to[3], double reach, Visit visit, void* context);
  /// The same, the near ones first and few more.
  void (*visitSegment)(const Mesh& mesh, const double from[3], const double to[3], double reach, Visit visit,
                       void* context);
  /// Nearest triangle to the segment, not farther than `reach`; of equally near ones the one of smallest index. Where
  /// there is none, how far away all are at least: above `reach` not exactly, and not above `far`. `hint`: a slot that
  /// is likely to hold the nearest one, or -1.
  void (*closestToSegment)(const Mesh& mesh, const double from[3], const double to[3], double reach, double far,
                           int32_t hint, SegmentAnswer* answer);
  /// Every triangle within `reach` that may hold a local minimum of the distance from the point: Leaf::front and back
  /// allow the direction there.
  void (*visitMinima)(const Mesh& mesh, const double point[3], double reach, Visit visit, void* context);
};

extern const Loops kBaselineLoops;
#ifdef ENAMEL_X86_KERNELS
extern const Loops kAvx2Loops;
extern const Loops kAvx512Loops;
#endif

}  // namespace enamel::kernel
