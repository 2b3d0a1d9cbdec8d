// The loop equations of the TAU in the three elevations w_i: f_k = (|P_i - P_j|^2 - side_k^2) / 2 = 0 for the pairs
// (0,1), (1,2), (2,0). Each depends on two elevations, so the 3 x 3 matrix is cyclic and has a closed solution.
#pragma once

#include <array>

#include "enamel/device/tau/model.hpp"

namespace enamel {

/// Smaller values of sin c, rho / (L1 + L2) and the loop measure count as singular.
inline constexpr double kSingular = 1e-6;

/// Return the direction in a chain's plane with an elevation given by its cosine and sine.
inline Vec3 elevated(const ChainConfiguration& c, double cosine, double sine) noexcept {
  return {cosine * c.sinYaw, sine, cosine * c.cosYaw};
}

inline Vec3 link2Direction(const ChainConfiguration& c) noexcept { return elevated(c, c.cosLink2, c.sinLink2); }

/// Matrix of the loop equations: row k has `own[k]` in column k and `next[k]` in column k + 1 (mod 3).
struct LoopMatrix {
  std::array<double, 3> own;
  std::array<double, 3> next;

  double determinant() const noexcept { return own[0] * own[1] * own[2] + next[0] * next[1] * next[2]; }

  /// Return the inverse times the determinant.
  Mat3 adjugate() const noexcept {
    Mat3 m;
    m << own[1] * own[2], -next[0] * own[2], next[0] * next[1],  //
        next[1] * next[2], own[2] * own[0], -next[1] * own[0],   //
        -next[2] * own[1], next[2] * next[0], own[0] * own[1];
    return m;
  }

  /// Return the solution of the system times the determinant (Cramer's rule).
  Vec3 solveScaled(const Vec3& r) const noexcept {
    return {(r[0] * own[1] - next[0] * r[1]) * own[2] + next[0] * next[1] * r[2],
            (r[1] * own[2] - next[1] * r[2]) * own[0] + next[1] * next[2] * r[0],
            (r[2] * own[0] - next[2] * r[0]) * own[1] + next[2] * next[0] * r[1]};
  }
};

/// Return the derivative of a tip by its elevation, L2 n2, in W, m.
inline Vec3 tipPerElevation(const ChainModel& chain, const ChainConfiguration& c) noexcept {
  const double s = -chain.length2 * c.sinLink2;
  return {s * c.sinYaw, chain.length2 * c.cosLink2, s * c.cosYaw};
}

/// Return the vectors between the tips, from the second of a pair to the first, m.
inline std::array<Vec3, 3> sidesOf(const TauConfiguration& configuration) noexcept {
  const auto& c = configuration.chain;
  return {c[0].tip - c[1].tip, c[1].tip - c[2].tip, c[2].tip - c[0].tip};
}

/// Return tipPerElevation() of the three chains.
inline std::array<Vec3, 3> slopesOf(const TauModel& model, const TauConfiguration& configuration) noexcept {
  return {tipPerElevation(model.chain[0], configuration.chain[0]),
          tipPerElevation(model.chain[1], configuration.chain[1]),
          tipPerElevation(model.chain[2], configuration.chain[2])};
}

/// Return the loop matrix of the tips and their derivatives by the elevations.
inline LoopMatrix loopMatrix(const std::array<Vec3, 3>& sides, const std::array<Vec3, 3>& slopes) noexcept {
  LoopMatrix m;
  for (int k = 0; k < 3; ++k) {
    m.own[k] = sides[k].dot(slopes[k]);
    m.next[k] = -sides[k].dot(slopes[(k + 1) % 3]);
  }
  return m;
}

/// Return the factor that makes the determinant dimensionless, between -2 and 2.
inline double loopScale(const TauModel& model) noexcept {
  double scale = 1.0;
  for (int k = 0; k < 3; ++k) scale *= model.chain[k].length2 * model.side[k];
  return scale;
}

/// Return the dimensionless determinant of the loop matrix of a configuration; 0 at a parallel singularity.
double loopMeasure(const TauModel& model, const TauConfiguration& configuration) noexcept;

}  // namespace enamel
