// The delta's dynamics in the conventional way. Each leg is a tree of upper link, near crossbar, two bars and far
// crossbar; the platform is free to turn; the loops are closed at the joints. The loops are overconstrained, because a
// real delta with revolute joints is. The KKT system is therefore solved in the null space of the closures: first the
// accelerations that satisfy them, then d'Alembert's principle in the remaining directions. It shares only the
// parameters with lib/device. Every bar is a separate body.
#pragma once

#include <array>

#include "enamel/device/delta/parameters.hpp"

namespace enamel::test {

class AssembledDelta {
 public:
  /// Five joints per leg (base, elbow, bar, other bar, far crossbar on the first bar), then the platform's twist.
  static constexpr int kCoordinates = 21;
  /// Per leg: far end of the other bar on the far crossbar (3), platform joint (3), its axis (2). 6 of 24 are
  /// redundant.
  static constexpr int kClosures = 24;

  /// `q` and `position` must match; closureError() returns the mismatch. `extraInertia` is a tensor of the platform
  /// about `com`: for a platform that cannot turn, neither may have an effect.
  AssembledDelta(const DeltaParameters& device, const Vec3& q, const Vec3& position, const Vec3& velocity,
                 const Vec3& com, const Mat3& extraInertia);

  double closureError() const { return closureError_; }
  Vec3 drivenRates() const { return {rates_[0], rates_[5], rates_[10]}; }
  double kineticEnergy() const;
  double potentialEnergy() const { return potential_; }

  /// Return [q''; V'] for torques and a wrench on the platform at the TCP.
  Eigen::Matrix<double, 9, 1> accelerations(const Vec3& torque, const Vec6& wrench) const;

  /// Return the degrees of freedom of the closed mechanism, counted by accelerations().
  int freedoms() const { return freedoms_; }

 private:
  struct Leg {
    Vec3 u, v, base, arm, upper, lower, bar;
  };
  struct Frame;

  static Frame carried(const Frame& parent, const Vec3& offset);
  Frame jointed(const Frame& parent, const Vec3& offset, const Vec3& axis, int coordinate) const;
  void addBody(const Frame& f, double mass, const Mat3& inertia);
  void close(int row, const Frame& a, const Frame& b);
  void assemble();

  const DeltaParameters device_;
  const Vec3 position_, com_;
  const Mat3 inertia_;
  std::array<Leg, 3> legs_;
  // One dynamic type: fixed sizes would save no time, and Eigen takes seconds to compile each of them.
  Eigen::MatrixXd mass_{kCoordinates, kCoordinates}, closures_{kClosures, kCoordinates};
  Eigen::VectorXd rates_{kCoordinates}, force_{kCoordinates}, closureBias_{kClosures};
  double closureError_ = 0.0, potential_ = 0.0;
  mutable int freedoms_ = 0;
};

}  // namespace enamel::test
