// The surface of a solid in one cell: the zeros of a trilinear interpolation, and the nearest of them to a point.
// Lengths are in cells, places are relative to the cell's corner. Included by solid_cells.inl.
#pragma once

#include <algorithm>

#include "enamel/collision/solid.hpp"

namespace enamel::kernel {
namespace {

constexpr double kSettled = 1e-3;
constexpr int kSteps = 2, kReturns = 3;
constexpr double kShortest = 0.1;     // share of a step
constexpr double kNoGradient = 1e-6;  // squared

// Offsets of the samples at the corners of a cell, x fastest, from the first of them.
constexpr int kBack = kBrickSamples, kUp = kBrickSamples * kBrickSamples;
constexpr int kCorners[8] = {0, 1, kBack, kBack + 1, kUp, kUp + 1, kUp + kBack, kUp + kBack + 1};

// Trilinear interpolation in a cell and its gradient.
struct Patch {
  double c[8];

  explicit Patch(const float* s) {
    for (int i = 0; i < 8; ++i) c[i] = static_cast<double>(s[kCorners[i]]);
  }

  double at(const Vec3& u, Vec3& gradient) const {
    const double x = u[0], y = u[1], z = u[2];
    const double x00 = c[0] + x * (c[1] - c[0]), x10 = c[2] + x * (c[3] - c[2]);
    const double x01 = c[4] + x * (c[5] - c[4]), x11 = c[6] + x * (c[7] - c[6]);
    const double y0 = x00 + y * (x10 - x00), y1 = x01 + y * (x11 - x01);
    const double dx0 = (c[1] - c[0]) + y * ((c[3] - c[2]) - (c[1] - c[0]));
    const double dx1 = (c[5] - c[4]) + y * ((c[7] - c[6]) - (c[5] - c[4]));
    gradient = Vec3(dx0 + z * (dx1 - dx0), (x10 - x00) + z * ((x11 - x01) - (x10 - x00)), y1 - y0);
    return y0 + z * (y1 - y0);
  }
};

Vec3 inCell(const Vec3& u) { return u.cwiseMax(0.0).cwiseMin(1.0); }

struct Touch {
  Vec3 point, gradient;  // point in the cell
};

// Step from a place of the cell with this value towards the surface, and along it by `length` of `way`. A step stays on
// the border of the cell. `along`: the part of `way` along the surface.
bool step(Vec3 way, double length, double value, Vec3 gradient, Vec3& u, Vec3& along) {
  Vec3 next;
  for (bool isOut = true; isOut;) {
    const double squared = gradient.squaredNorm();
    if (!(squared > kNoGradient)) return false;
    const double perSquared = 1.0 / squared;
    along = way - gradient * (gradient.dot(way) * perSquared);
    next = u - gradient * (value * perSquared) + length * along;
    isOut = false;
    for (int i = 0; i < 3; ++i) {
      if (gradient[i] == 0.0 || !(u[i] <= 0.0 ? next[i] < 0.0 : u[i] >= 1.0 && next[i] > 1.0)) continue;
      gradient[i] = way[i] = 0.0;
      isOut = true;
    }
  }
  u = inCell(next);
  return true;
}

// Move to the place of the patch nearest to q. Only the part of the way along the surface counts. The step length is
// the one that was right for the last step (Barzilai and Borwein 1988). Whole steps diverge where the surface curves by
// more than 1 over the distance. Returns false if it ends in a corner off the surface.
bool approach(const Patch& patch, const Vec3& q, Touch& touch) {
  Vec3 &u = touch.point, &g = touch.gradient;
  Vec3 move = Vec3::Zero(), along = Vec3::Zero();
  for (int round = 0; round < kSteps; ++round) {
    const double f = patch.at(u, g);
    const Vec3 from = u, way = q - u;
    double length = 1.0;
    if (round > 0) {
      const double turned = move.dot(along - (way - g * (g.dot(way) / g.squaredNorm())));
      if (turned > 0.0) length = std::clamp(move.squaredNorm() / turned, kShortest, 1.0);
    }
    if (!step(way, length, f, g, u, along)) return false;
    move = u - from;
    if (move.cwiseAbs().maxCoeff() < kSettled) break;
  }
  for (int round = 0; round < kReturns; ++round) {
    const double f = patch.at(u, g);
    if (f * f <= kSettled * kSettled * g.squaredNorm()) return true;
    if (round + 1 == kReturns || !step(Vec3::Zero(), 0.0, f, g, u, along)) return false;
  }
  return false;
}

bool nearestOn(const Patch& patch, const Vec3& q, Touch& touch) {
  touch.point = inCell(q);
  if (approach(patch, q, touch)) return true;
  // Try again from where the surface meets an edge of the cell.
  double least = kNoLimit;
  for (int corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis) {
      const int next = corner | 1 << axis;
      const double from = patch.c[corner], to = patch.c[next];
      if (next == corner || (from < 0.0) == (to < 0.0)) continue;
      Vec3 u(corner & 1, corner >> 1 & 1, corner >> 2);
      u[axis] = from / (from - to);
      const double squared = (q - u).squaredNorm();
      if (squared >= least) continue;
      least = squared;
      touch.point = u;
    }
  const Vec3 onEdge = touch.point;
  if (least < kNoLimit && !approach(patch, q, touch)) {
    touch.point = onEdge;
    patch.at(onEdge, touch.gradient);
  }
  return least < kNoLimit;
}

}  // namespace
}  // namespace enamel::kernel
