// The hot loops of the mesh queries and the plain data that they read. The loops are compiled once per SIMD level from
// kernel_loops.inl, each level in a file of its own. Inline functions of Eigen or of the standard library are forbidden
// here: the linker keeps one copy for all levels, and this machine may not be able to run it.
//
// Local coordinates: q = (p - centre) * scale, so that the mesh fills [-1, 1]. Floats only bound distances from below.
// Every returned distance is computed in double from the original coordinates. So the answer does not depend on the
// order of the search, on the cache or on the SIMD level.
#pragma once

#include <stdint.h>

#include "query_cache.hpp"

namespace enamel::kernel {

inline constexpr int kWidth = 16;     ///< children of a node, triangles of a leaf
inline constexpr int kBrickEdge = 9;  ///< samples of a solid's brick
inline constexpr int kBrickVolume = kBrickEdge * kBrickEdge * kBrickEdge;
inline constexpr int kMaxDepth = 48;    ///< levels; the builder makes at most 37: 14, and 23 that halve 2^23 leaves
inline constexpr int kStackSize = 768;  ///< entries; a level of the tree needs at most kWidth - 1
inline constexpr int kFrameRows = 20;   ///< of a leaf
inline constexpr int kBoxRows = 15;     ///< of the boxes of a node
static_assert(kStackSize >= kMaxDepth * (kWidth - 1) + kWidth, "the stack holds every child on a path");

/// Oriented boxes of 16 children: |axis * q + offset| <= half. Unused lanes are far away.
struct alignas(64) Node {
  float row[kBoxRows][kWidth];  ///< three axes, offsets, half sizes
  ///< cos^2 of the angle between the third axis and the farthest direction as in Leaf::front, or 0
  float cone[kWidth];
  int32_t child[kWidth];  ///< node number, or ~leaf number
  uint32_t lanes;         ///< bit mask of used lanes
  uint32_t leaves;        ///< bit mask of lanes that hold a leaf
};

/// Axis-aligned boxes of the same children, rounded outwards. Unused lanes hold an empty box.
struct alignas(64) AlignedBoxes {
  float low[3][kWidth];
  float high[3][kWidth];
};

/// 16 triangles in local coordinates, each in a frame of its own. Corner a is at the origin, the longest edge along u,
/// the opposite corner at v >= 0, and the plane at h = 0. Unused lanes are far away. `front` and `back` bound the
/// directions to points whose distance may have a local minimum here, in front of the triangle or behind it. Each is
/// cos^2 of the largest angle to the normal, or 0.
struct alignas(64) Leaf {
  float row[kFrameRows][kWidth];
  float front[kWidth];
  float back[kWidth];
};

/// Sums over the triangles of the same children, for the winding number.
enum MomentRow : int {
  kCentre = 0,  ///< three: centre of the areas
  kRadius = 3,  ///< largest distance of a corner from the centre
  kArea = 4,
  kNormal = 5,  ///< three: sum of area times unit normal
  kSpread = 8,  ///< six, xx yy zz xy xz yz: area times normal times offset from the centre, symmetric part
  kMomentRows = 14
};
struct alignas(64) MomentRows {
  float row[kMomentRows][kWidth];
};

/// Rows of a leaf.
enum FrameRow : int {
  kAxis = 0,     ///< nine: u, v, h of the frame's rotation
  kOffset = 9,   ///< three: (u, v, h) = axis * q + offset
  kLength = 12,  ///< three edge lengths: along u; from its end to the third corner; from a to the third corner
  kCosine = 15,  ///< two: directions of the second and third edge in (u, v)
  kSine = 17,    ///< two
  kInside = 19   ///< 0; -1e30 for a triangle that is bounded by its edges alone
};
static_assert(kInside + 1 == kFrameRows);

inline constexpr float kFarAway = 1e18f;  ///< its square is finite, and larger than that of any local coordinate

/// Value of an unused lane in a row: a point far away.
static constexpr float unusedRow(int row) {
  return row >= kOffset && row < kLength        ? kFarAway
         : row == kCosine || row == kCosine + 1 ? 1.0f
         : row == kInside                       ? -1e30f
                                                : 0.0f;
}

/// A triangle in double, in the order of the leaves: slot = 16 * leaf + lane.
struct Triangle {
  double corner[3][3];
  int32_t index;  ///< number in the mesh; -1 for an unused slot
  ///< cos^2 of the angle to the farthest normal around it, or 0; -1: long or flat, needs the careful path
  float cone;
};

/// The part of a mesh that the loops read.
struct Mesh {
  const Node* nodes;
  const Leaf* leaves;
  const AlignedBoxes* boxes;  ///< by node
  const Triangle* triangles;
  int32_t root;  ///< as in Node::child; always a node
  double centre[3];
  double scale;
  double extent;  ///< bound of all local coordinates of the mesh; 1 when it is built
  int32_t tight;  ///< 1 while every box holds a triangle; removing may leave empty ones
  uint64_t revision;
};

/// The feature of a triangle that holds the closest point: corner i, the edge from corner i, or the face.
enum TriangleFeature : int32_t { kCorner0, kCorner1, kCorner2, kEdge01, kEdge12, kEdge20, kFace };

/// The point of a triangle with plane (x - a).n = 0 that is nearest to p.
struct Candidate {
  double squared;  ///< distance^2
  double point[3];
  int32_t feature;
  double overPlane;      ///< (p - a).n
  double normalSquared;  ///< n.n; both are 0 for a long or flat triangle, whose normal is unreliable
};

/// If nothing is found: the limit^2, p, kFace, 0, 0 and slot -1.
struct Answer {
  Candidate nearest;
  int32_t slot;
};

struct SegmentAnswer {
  double squared;    ///< distance^2; if nothing is found, a lower bound for all triangles
  double parameter;  ///< of the segment's nearest point
  double point[3];   ///< on the mesh
  int32_t feature;
  int32_t slot;  ///< -1 if nothing is found
};

/// Cells of a solid around an axis, by component, so that 16 are computed at once. Lengths are in cells.
struct CellRows {
  static constexpr int kMost = 95 * kWidth;  ///< not a power of two: rows would share cache lines
  int32_t count;
  float axis[3];            ///< unit vector; zero for a point, which has no `back` and `ahead`
  uint32_t cell[kMost];     ///< number of the brick, z, y, x
  float point[3][kMost];    ///< place of the axis, relative to the first corner of the cell
  float back[kMost];        ///< the place nearest to the cell may be up to this length back along the axis
  float ahead[kMost];       ///< or ahead
  float samples[8][kMost];  ///< at the corners, x fastest
  // Filled by Loops::boundCells().
  float least[kMost];     ///< lower bound of the distance of the surface in the cell
  float flatness[kMost];  ///< largest distance of the surface from a plane; normals turn by about four times as much
};

/// The places of the surface that are nearest to the points of 16 cells.
struct CellPlaces {
  float way[3][kWidth];    ///< from the place to the point
  float distance[kWidth];  ///< its length; off by a few thousandths of a cell, more where `least` is lower
  float least[kWidth];     ///< lower bound of the distance from the axis
  unsigned minima;         ///< bits of those that may be a new minimum
  unsigned nearest;        ///< bits of those that may be nearer than KnownMinima::best
};

inline constexpr float kCellError = 2e-3f;               ///< cells: twice the accuracy of approach() in solid_patch.inl
inline constexpr float kRepresentedCosine = 0.8660254f;  ///< of 30 deg: a minimum represents directions within it

/// Minima of the distance from a point that were found before.
struct KnownMinima {
  static constexpr int kMost = 8;
  int32_t count = 0;
  float distance[kMost]{}, direction[3][kMost]{};  ///< unit vectors to the point
  float best = 0.0f;                               ///< least distance of all places
  float most = 0.0f;                               ///< larger distances do not matter
};

/// A bur at one place in the grid of a solid. Lengths are in cells. Squared distances at the ends of the band around
/// its surface are inner^2 and most.
struct BurAt {
  float span[3];    ///< of the axis
  float perLength;  ///< 1 / |span|^2; 0 for a ball
  float reach;      ///< of the surface
  float inner, most;
  float band;  ///< larger distances are stored as this value
};

/// Samples of a brick that a bur changed.
struct CutSamples {
  int32_t count;
  int32_t index[kBrickVolume + kWidth];
  float taken[kBrickVolume + kWidth];  ///< lost share of the cell around the sample, above 0
  bool isTurned;                       ///< a sample is outside now
};

/// Called for every triangle that may be within reach. Returns the new reach; visitMinima may keep the first one.
using Visit = double (*)(void* context, int32_t slot, double reach);

/// Called before the first sample of a brick changes.
using BeforeCut = void (*)(void* context);

struct Loops {
  /// Find the nearest triangle within sqrt(limitSquared); of equally near ones, that with the smallest index.
  void (*closest)(const Mesh& mesh, const double point[3], double limitSquared, Cache* cache, Answer* answer);
  /// Visit every triangle within `reach` of the segment from -> to (and some more), in any order.
  void (*visit)(const Mesh& mesh, const double from[3], const double to[3], double reach, Visit visit, void* context);
  /// The same, the near ones first and few additional ones.
  void (*visitSegment)(const Mesh& mesh, const double from[3], const double to[3], double reach, Visit visit,
                       void* context);
  /// Find the nearest triangle to the segment within `reach`; of equally near ones, that with the smallest index. If
  /// nothing is found, return a lower bound of the distance of all triangles. The bound is inexact above `reach` and at
  /// most `far`. `hint`: a slot that is likely to hold the nearest one, or -1.
  void (*closestToSegment)(const Mesh& mesh, const double from[3], const double to[3], double reach, double far,
                           int32_t hint, SegmentAnswer* answer);
  /// Visit every triangle within `reach` that may hold a local minimum of the distance from the point: Leaf::front or
  /// back permits the direction.
  void (*visitMinima)(const Mesh& mesh, const double point[3], double reach, Visit visit, void* context);
  /// Compute the solid angles of 16 children of a node from their moments, as seen from a point in local coordinates.
  /// Returns bits of those farther away than `accept` times their radius. The same bits at every SIMD level.
  unsigned (*clusterAngles)(const MomentRows& moments, const double point[3], float accept, float* angles);
  /// Compute the solid angles of 16 triangles of a leaf: each is twice the argument of re + i im, and |re| + |im| = 1.
  /// It is 0 in an unused slot. The same bits at every SIMD level.
  void (*solidAngles)(const Triangle* triangles, const double point[3], double* re, double* im);
  /// Append the cells of a brick whose boxes are within `reach` of a point: as many as 512. `number`: of the first cell
  /// of the brick, whose marked cells are bits x + 8 y of entry z. The same bits at every SIMD level.
  void (*seeCells)(const uint64_t* marked, const float* samples, const float point[3], float reach, uint32_t number,
                   CellRows* cells);
  /// Bound the distances of cells of a solid. The same bits at every SIMD level. Writes up to 15 rows after the last
  /// cell.
  void (*boundCells)(CellRows* cells);
  /// Find the nearest places in `count` cells, at most 16. The same bits at every SIMD level.
  void (*nearestOnCells)(const CellRows& cells, const int16_t* which, int count, const KnownMinima& known,
                         CellPlaces* places);
  /// Raise the samples of a brick, slices `first` to `last`, to the distance from the bur. `away`: offsets of the
  /// samples from the bur along each axis. Returns whether a sample changed. The same bits at every SIMD level.
  bool (*cutBrick)(float* samples, const float away[3][kBrickEdge], int first, int last, const BurAt& bur,
                   BeforeCut before, void* context, CutSamples* cut);
};

extern const Loops kBaselineLoops;
#ifdef ENAMEL_X86_KERNELS
extern const Loops kAvx2Loops;
extern const Loops kAvx512Loops;
#endif

}  // namespace enamel::kernel
