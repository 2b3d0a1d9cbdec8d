// All real assembly modes of the TAU for given joint angles, and a slow continuation that finds the mode on the branch
// of home. It shares only the parameters with lib/device.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <optional>
#include <vector>

#include "enamel/device/tau/parameters.hpp"

namespace enamel::test {

struct Legs {
  Vec3 knee[3], u[3];
  double length2[3], side[3];  // side[k]: distance of tips k and k + 1

  Vec3 tip(int i, double w) const { return knee[i] + length2[i] * (std::cos(w) * u[i] + std::sin(w) * Vec3::UnitY()); }
  Vec3 slope(int i, double w) const { return length2[i] * (-std::sin(w) * u[i] + std::cos(w) * Vec3::UnitY()); }
};

inline Legs legsAt(const TauParameters& device, const Vec6& q) {
  Legs legs;
  for (int i = 0; i < 3; ++i) {
    const ChainParameters& c = device.chain[i];
    legs.u[i] = {std::sin(q[2 * i]), 0.0, std::cos(q[2 * i])};
    legs.knee[i] =
        c.base + c.link1.length * (std::cos(q[2 * i + 1]) * legs.u[i] + std::sin(q[2 * i + 1]) * Vec3::UnitY());
    legs.length2[i] = c.link2.length;
    legs.side[i] = (c.platform - device.chain[(i + 1) % 3].platform).norm();
  }
  return legs;
}

/// Return the rigid motion of the platform's points onto three tips (Kabsch by an orthonormal triad).
inline Pose poseOfTips(const TauParameters& device, const Vec3 tips[3]) {
  const auto triad = [](const Vec3& a, const Vec3& b, const Vec3& c) {
    Mat3 m;
    m.col(0) = (b - a).normalized();
    m.col(2) = (b - a).cross(c - a).normalized();
    m.col(1) = m.col(2).cross(m.col(0));
    return m;
  };
  Pose pose;
  pose.rotation = triad(tips[0], tips[1], tips[2]) *
                  triad(device.chain[0].platform, device.chain[1].platform, device.chain[2].platform).transpose();
  pose.position = tips[0] - pose.rotation * device.chain[0].platform;
  return pose;
}

/// Return the elevation of leg i at which its tip has a given distance from a point, on sheet +1 or -1; nothing if
/// impossible.
inline std::optional<double> elevationAtDistance(const Legs& legs, int i, const Vec3& from, double distance,
                                                 int sheet) {
  const Vec3 d = legs.knee[i] - from;
  const double a = d.dot(legs.u[i]), b = d.y(), amplitude = std::hypot(a, b);
  const double c =
      (distance * distance - d.squaredNorm() - legs.length2[i] * legs.length2[i]) / (2.0 * legs.length2[i]);
  if (!(amplitude > 0.0) || std::abs(c) > amplitude) return std::nullopt;
  return std::atan2(b, a) + sheet * std::acos(c / amplitude);
}

/// Return the elevations (w0, w1, w2) of every real assembly mode. w1 and w2 follow from w0 on four sheets, and the
/// last distance must have no error. Sign changes are bracketed on a fine grid that ends exactly at the ends of a
/// sheet.
inline std::vector<Vec3> assemblyModes(const Legs& legs, int samples = 4000) {
  std::vector<Vec3> modes;
  for (int sheet = 0; sheet < 4; ++sheet) {
    const int s1 = sheet & 1 ? 1 : -1, s2 = sheet & 2 ? 1 : -1;
    Vec3 w = Vec3::Zero();
    const auto gap = [&](double w0) -> std::optional<double> {
      const Vec3 p0 = legs.tip(0, w0);
      const auto w1 = elevationAtDistance(legs, 1, p0, legs.side[0], s1);
      const auto w2 = elevationAtDistance(legs, 2, p0, legs.side[2], s2);
      if (!w1 || !w2) return std::nullopt;
      w = {w0, *w1, *w2};
      return (legs.tip(1, *w1) - legs.tip(2, *w2)).norm() - legs.side[1];
    };
    const auto edge = [&](double inside, double outside) {  // last point of the sheet
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (inside + outside);
        (gap(middle) ? inside : outside) = middle;
      }
      return inside;
    };
    const auto search = [&](double low, double high) {
      double gapLow = *gap(low);
      const double gapHigh = *gap(high);
      if (gapLow * gapHigh > 0.0) return;
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + high);
        const auto g = gap(middle);
        if (!g) break;
        if (*g * gapLow > 0.0) {
          low = middle;
          gapLow = *g;
        } else {
          high = middle;
        }
      }
      (void)gap(low);
      modes.push_back(w);
    };
    double previous = 0.0;
    for (int k = 1; k <= samples; ++k) {
      const double next = 2.0 * M_PI * k / samples;
      const bool here = gap(previous).has_value(), there = gap(next).has_value();
      if (here && there) search(previous, next);
      if (here && !there) search(previous, edge(previous, next));
      if (!here && there) search(edge(next, previous), next);
      previous = next;
    }
  }
  return modes;
}

inline Pose poseOfMode(const TauParameters& device, const Legs& legs, const Vec3& mode) {
  const Vec3 tips[3] = {legs.tip(0, mode[0]), legs.tip(1, mode[1]), legs.tip(2, mode[2])};
  return poseOfTips(device, tips);
}

/// Return the determinant of the loop equations, divided by the lengths: its sign and its distance from zero.
inline double loopDeterminant(const Legs& legs, const Vec3& w) {
  Mat3 m = Mat3::Zero();
  double scale = 1.0;
  for (int k = 0; k < 3; ++k) {
    const int j = (k + 1) % 3;
    const Vec3 side = legs.tip(k, w[k]) - legs.tip(j, w[j]);
    m(k, k) = side.dot(legs.slope(k, w[k]));
    m(k, j) = -side.dot(legs.slope(j, w[j]));
    scale *= legs.side[k] * legs.length2[k];
  }
  return m.determinant() / scale;
}

struct Walk {
  bool arrived = false;
  Vec3 elevations = Vec3::Zero();
  double smallestDeterminant = 0.0;  // along the path, times its sign at home
  double smallestSinElbow = 1.0;     // along the path, times the elbow's sign
  double smallestRadius = 1.0;       // along the path: distance of a tip from its yaw axis / length of the chain
};

/// Follow the straight line in joint space from home with plain Newton steps, in very small steps.
inline Walk slowWalk(const TauParameters& device, const Vec6& home, const Vec3& homeElevations, const Vec6& way,
                     double stepAngle) {
  Walk walk;
  walk.elevations = homeElevations;
  const double sign = loopDeterminant(legsAt(device, home), homeElevations) > 0.0 ? 1.0 : -1.0;
  walk.smallestDeterminant = 2.0;
  const int steps = std::max(1, static_cast<int>(std::ceil(way.cwiseAbs().maxCoeff() / stepAngle)));
  for (int step = 1; step <= steps; ++step) {
    const Vec6 q = home + way * (static_cast<double>(step) / steps);
    const Legs legs = legsAt(device, q);
    double size = 1.0;
    for (int iteration = 0; iteration < 20 && size > 1e-13; ++iteration) {
      Mat3 m = Mat3::Zero();
      Vec3 residual;
      for (int k = 0; k < 3; ++k) {
        const int j = (k + 1) % 3;
        const Vec3 side = legs.tip(k, walk.elevations[k]) - legs.tip(j, walk.elevations[j]);
        m(k, k) = side.dot(legs.slope(k, walk.elevations[k]));
        m(k, j) = -side.dot(legs.slope(j, walk.elevations[j]));
        residual[k] = 0.5 * (side.squaredNorm() - legs.side[k] * legs.side[k]);
      }
      const Vec3 delta = m.inverse() * residual;
      walk.elevations -= delta;
      size = delta.cwiseAbs().maxCoeff();
      if (!(size < 0.5)) return walk;
    }
    if (!(size < 1e-9)) return walk;
    walk.smallestDeterminant = std::min(walk.smallestDeterminant, sign * loopDeterminant(legs, walk.elevations));
    for (int i = 0; i < 3; ++i) {
      const ChainParameters& chain = device.chain[i];
      const double lift = q[2 * i + 1], w = walk.elevations[i], l1 = chain.link1.length, l2 = chain.link2.length;
      walk.smallestSinElbow = std::min(walk.smallestSinElbow, chain.elbow * std::sin(w - lift));
      walk.smallestRadius = std::min(walk.smallestRadius, (l1 * std::cos(lift) + l2 * std::cos(w)) / (l1 + l2));
    }
    if (walk.smallestDeterminant <= 0.0) return walk;
  }
  walk.arrived = true;
  return walk;
}

}  // namespace enamel::test
