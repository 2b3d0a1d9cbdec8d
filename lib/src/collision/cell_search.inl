// The surface of a solid in 16 cells at once: bounds of its distance from a point, and its place nearest to the point.
// The latter is approach() of solid_patch.inl in float, without its second start. No product is fused, so that every
// SIMD level finds the same bits.
#pragma once

#include "lanes.inl"

constexpr int kCellsOfBrick = kBrickEdge - 1;
constexpr float kNoSlope = 1e-6f;             // squared gradient
constexpr float kBesideCell = 0.25f;          // cells: from the end of a way along the normal to the cell
constexpr float kAlignedCosine = 0.9396926f;  // of 20 deg: way and normal at a minimum
constexpr float kSmooth = 0.1f, kHalfDiagonal = 0.8660254f;

// The centres of the cells of two rows of a slice, along the rows and across them.
struct Ramp {
  float x[kWidth], y[4][kWidth];
};
constexpr Ramp makeRamp() {
  Ramp ramp{};
  for (int i = 0; i < kWidth; ++i) {
    ramp.x[i] = static_cast<float>(i % kCellsOfBrick) + 0.5f;
    for (int pair = 0; pair < 4; ++pair) ramp.y[pair][i] = static_cast<float>(2 * pair + i / kCellsOfBrick) + 0.5f;
  }
  return ramp;
}
constexpr Ramp kCentres = makeRamp();

inline V squaredBeyond(float point, const float* centres) {
  const V beyond = positive(absolute(load(centres) - set(point)) - set(0.5f));
  return beyond * beyond;
}

void seeCells(const uint64_t* marked, const float* samples, const float point[3], float reach, uint32_t number,
              CellRows* cells) {
  static_assert(2 * kCellsOfBrick == kWidth);
  constexpr int kPairs = kCellsOfBrick / 2, kBack = kBrickEdge, kUp = kBrickEdge * kBrickEdge;
  V rows[kPairs];  // two rows of a slice at a time
  for (int pair = 0; pair < kPairs; ++pair)
    rows[pair] = squaredBeyond(point[0], kCentres.x) + squaredBeyond(point[1], kCentres.y[pair]);
  float slices[kWidth], away[3][kWidth];
  store(slices, squaredBeyond(point[2], kCentres.x));
  for (int i = 0; i < 3; ++i) store(away[i], set(point[i]) - (load(kCentres.x) - set(0.5f)));
  int count = cells->count;
  for (int z = 0; z < kCellsOfBrick; ++z) {
    if (marked[z] == 0) continue;
    const V left = set(reach * reach - slices[z]);
    uint64_t near = 0;
    for (int pair = 0; pair < kPairs; ++pair)
      near |= static_cast<uint64_t>(lessOrEqualMask(rows[pair], left) & 0xffffu) << (kWidth * pair);
    for (near &= marked[z]; near != 0; near &= near - 1, ++count) {
      const unsigned bit = static_cast<unsigned>(__builtin_ctzll(near)), x = bit % kCellsOfBrick,
                     y = bit / kCellsOfBrick;
      const float* s = samples + z * kUp + static_cast<int>(y * kBack + x);
      cells->cell[count] = number + static_cast<unsigned>(z * kCellsOfBrick * kCellsOfBrick) + bit;
      cells->point[0][count] = away[0][x];
      cells->point[1][count] = away[1][y];
      cells->point[2][count] = away[2][z];
      for (int i = 0; i < 8; ++i) cells->samples[i][count] = s[(i >> 2) * kUp + (i >> 1 & 1) * kBack + (i & 1)];
    }
  }
  cells->count = count;
}

// The trilinear interpolation of the corners' samples and its gradient.
inline V interpolate(const V* s, const V3& u, V3& gradient) {
  const V front = s[1] - s[0], back = s[3] - s[2], above = s[5] - s[4], behind = s[7] - s[6];
  const V x00 = s[0] + u[0] * front, x10 = s[2] + u[0] * back, x01 = s[4] + u[0] * above, x11 = s[6] + u[0] * behind;
  const V low = x10 - x00, high = x11 - x01;
  const V y0 = x00 + u[1] * low, y1 = x01 + u[1] * high;
  const V dx0 = front + u[1] * (back - front), dx1 = above + u[1] * (behind - above);
  gradient[0] = dx0 + u[2] * (dx1 - dx0);
  gradient[1] = low + u[2] * (high - low);
  gradient[2] = y1 - y0;
  return y0 + u[2] * gradient[2];
}

// Value and gradient at the centre.
inline V planeAtCentre(const V* s, V3& gradient) {
  const V low = s[0] + s[1], back = s[2] + s[3], up = s[4] + s[5], far = s[6] + s[7], quarter = set(0.25f);
  gradient[0] = quarter * ((s[1] - s[0]) + (s[3] - s[2]) + (s[5] - s[4]) + (s[7] - s[6]));
  gradient[1] = quarter * ((back - low) + (far - up));
  gradient[2] = quarter * ((up - low) + (far - back));
  return set(0.125f) * ((low + back) + (up + far));
}

// Step from u to the surface, and along it by the way. A step stays on the border of the cell.
inline void stepInCells(V value, V3 gradient, V3 way, V3& u) {
  const V zero = set(0.0f), one = set(1.0f);
  for (int pass = 0;; ++pass) {
    const V perSquared = one / maximum(plainDot(gradient, gradient), set(kNoSlope));
    const V share = (value + plainDot(gradient, way)) * perSquared;
    V3 next;
    unsigned isOut = 0;
    for (int i = 0; i < 3; ++i) {
      next[i] = u[i] + way[i] - gradient[i] * share;
      const V below = selectGreater(u[i], zero, zero, zero - next[i]);
      const V above = selectGreater(one, u[i], zero, next[i] - one);
      const V out = maximum(below, above);
      isOut |= ~lessOrEqualMask(out, zero);
      gradient[i] = selectGreater(out, zero, zero, gradient[i]);
      way[i] = selectGreater(out, zero, zero, way[i]);
    }
    if (pass == 2 || (isOut & 0xffffu) == 0) {
      for (int i = 0; i < 3; ++i) u[i] = between(next[i], zero, one);
      return;
    }
  }
}

inline bool isPoint(const CellRows& cells) {
  return cells.axis[0] == 0.0f && cells.axis[1] == 0.0f && cells.axis[2] == 0.0f;
}
inline V3 axisOf(const CellRows& cells) { return {{set(cells.axis[0]), set(cells.axis[1]), set(cells.axis[2])}}; }

// The first place is that of the tangent plane at the centre; then one step, and one back to the surface.
void nearestOnCells(const CellRows& cells, const int16_t* which, int count, const KnownMinima& known,
                    CellPlaces* places) {
  float corners[8][kWidth], points[3][kWidth], flatness[kWidth], back[kWidth] = {}, ahead[kWidth] = {};
  const bool hasAxis = !isPoint(cells);
  for (int lane = 0; lane < kWidth; ++lane) {
    const int cell = which[lane < count ? lane : 0];
    for (int i = 0; i < 8; ++i) corners[i][lane] = cells.samples[i][cell];
    for (int i = 0; i < 3; ++i) points[i][lane] = cells.point[i][cell];
    flatness[lane] = cells.flatness[cell];
    if (hasAxis) back[lane] = cells.back[cell];
    if (hasAxis) ahead[lane] = cells.ahead[cell];
  }
  V s[8];
  V3 q, u, gradient, way;
  for (int i = 0; i < 8; ++i) s[i] = load(corners[i]);
  for (int i = 0; i < 3; ++i) q[i] = load(points[i]);
  const V zero = set(0.0f), one = set(1.0f), half = set(0.5f);
  const V3 toCentre = {{q[0] - half, q[1] - half, q[2] - half}};
  V value = planeAtCentre(s, gradient);
  V share = (value + plainDot(gradient, toCentre)) / maximum(plainDot(gradient, gradient), set(kNoSlope));
  for (int i = 0; i < 3; ++i) u[i] = between(q[i] - share * gradient[i], zero, one);
  value = interpolate(s, u, gradient);
  for (int i = 0; i < 3; ++i) way[i] = q[i] - u[i];
  stepInCells(value, gradient, way, u);
  value = interpolate(s, u, gradient);
  stepInCells(value, gradient, {{zero, zero, zero}}, u);
  value = interpolate(s, u, gradient);
  const V squared = maximum(plainDot(gradient, gradient), set(kNoSlope)), perNorm = one / root(squared);
  share = value / squared;
  for (int i = 0; i < 3; ++i) {
    way[i] = q[i] - (u[i] - gradient[i] * share);
    store(places->way[i], way[i]);
  }
  const V distance = root(plainDot(way, way));
  // The distance is convex along the axis where the surface is flat, so its slope bounds it. Where the surface curves
  // towards the axis, normals turn by four times the flatness across a cell.
  const V slope = plainDot(way, axisOf(cells)) / maximum(distance, set(1e-6f));
  const V furthest = maximum(load(back), load(ahead)), bend = set(2.0f) * load(flatness) * furthest * furthest;
  const V gain = maximum(slope * load(back), (zero - slope) * load(ahead)) + bend;
  const V least = distance - gain - absolute(value) * perNorm - set(kCellError);
  store(places->distance, distance);
  store(places->least, least);
  // At a minimum the way is along the normal. A minimum on the border between cells may belong to either of them.
  const V height = plainDot(way, gradient) * perNorm, across = distance * distance - height * height;
  const V aside = set(kBesideCell) + set(2.0f) * load(flatness) * distance;
  unsigned minima = lessOrEqualMask(across, aside * aside) & lessOrEqualMask(set(kAlignedCosine) * distance, height) &
                    lessOrEqualMask(least, known.most);
  // Walls that meet in an edge are resolved at larger angles only: there the tangent planes' edge is farther away than
  // the places by distance (1 - cosine) / 4.
  const V cosine = maximum(one - one / maximum(distance * distance, one), set(kRepresentedCosine));
  for (int i = 0; i < known.count; ++i) {
    const V along =
        set(known.direction[0][i]) * way[0] + set(known.direction[1][i]) * way[1] + set(known.direction[2][i]) * way[2];
    minima &= lessOrEqualMask(along, cosine * distance) |
              ~lessOrEqualMask(set(known.distance[i]), distance + set(kCellError));
  }
  const unsigned used = (2u << (count - 1)) - 1u;
  places->minima = minima & used;
  places->nearest = lessOrEqualMask(least, known.best) & used;
}

// The tangent plane at the centre of a cell bounds the distance of the surface in it: the surface is within `flatness`
// of the plane, and in the cell. A smooth surface may be nearer by some hundredths of a cell: in a pit that fits the
// bur, all places are about equally near.
template <bool kHasAxis>
inline void boundCellsOf(CellRows* cells) {
  const V3 axis = axisOf(*cells);
  const V zero = set(0.0f), half = set(0.5f);
  for (int first = 0; first < cells->count; first += kWidth) {
    V s[8];
    V3 q;
    for (int i = 0; i < 8; ++i) s[i] = load(cells->samples[i] + first);
    for (int i = 0; i < 3; ++i) q[i] = load(cells->point[i] + first) - half;
    V3 gradient;
    const V atCentre = planeAtCentre(s, gradient);
    const V perSquared = set(1.0f) / (plainDot(gradient, gradient) + set(1e-12f)), perNorm = root(perSquared);
    const V height = atCentre + plainDot(gradient, q), share = height * perSquared;
    const V x00 = s[1] - s[0], x10 = s[3] - s[2], x01 = s[5] - s[4], x11 = s[7] - s[6];
    const V y0 = s[2] + s[3] - s[0] - s[1], y1 = s[6] + s[7] - s[4] - s[5];
    const V xy = absolute(x10 - x00) + absolute(x11 - x01), xz = absolute(x01 - x00) + absolute(x11 - x10);
    const V twist = xy + xz + absolute(y1 - y0) + absolute((x11 - x01) - (x10 - x00));
    const V flatness = set(0.125f) * twist * perNorm;
    V outside[3];  // from the plane's place nearest to q to the cell
    for (int i = 0; i < 3; ++i) outside[i] = absolute(q[i] - share * gradient[i]) - half - flatness;
    V rise = absolute(height);
    if (kHasAxis) {
      const V back = load(cells->back + first), ahead = load(cells->ahead + first), furthest = maximum(back, ahead);
      const V climb = plainDot(gradient, axis), perHeight = climb * perSquared;  // of the axis from the plane
      for (int i = 0; i < 3; ++i) outside[i] = outside[i] - absolute(axis[i] - perHeight * gradient[i]) * furthest;
      const V away = selectGreater(height, zero, climb, zero - climb);  // > 0: nearer to the plane if it goes back
      rise = rise - maximum(away * back, (zero - away) * ahead);
    }
    V aside = zero;
    for (int i = 0; i < 3; ++i) aside = aside + positive(outside[i]) * positive(outside[i]);
    const V slack = selectGreater(set(kSmooth), flatness, set(0.1f) * flatness, flatness);
    const V above = positive(rise * perNorm - slack);
    const V least = maximum(root(above * above + aside), root(plainDot(q, q)) - set(kHalfDiagonal));
    store(cells->least + first, least);
    store(cells->flatness + first, flatness);
  }
}

void boundCells(CellRows* cells) { isPoint(*cells) ? boundCellsOf<false>(cells) : boundCellsOf<true>(cells); }
