#include "enamel/core/types.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <random>

#include "support/catch.hpp"

namespace enamel::test_types {

namespace {

constexpr double kPi = 3.14159265358979323846;

Vec3 randomVector(std::mt19937& engine, double length) {
  std::normal_distribution<double> normal;
  return length * Vec3(normal(engine), normal(engine), normal(engine)).normalized();
}

}  // namespace

// Rodrigues: R a = a, and R b = b cos(angle) + (a x b) sin(angle) for b across the axis a.
TEST_CASE("a rotation vector turns about itself by its length, and comes back", "[types]") {
  std::mt19937 engine(1);
  std::uniform_real_distribution<double> angles(0.0, 3.0);
  for (int i = 0; i < 1000; ++i) {
    const double angle = i < 20 ? std::pow(10.0, -i) : angles(engine);
    const Vec3 vector = randomVector(engine, angle), axis = vector / angle;
    const Vec3 across = axis.cross(randomVector(engine, 1.0)).normalized();
    const Mat3 rotation = rotationFromVector(vector);
    INFO(angle);
    CHECK(isRotation(rotation));
    // 1e-15: a few rounding errors of numbers up to 1.
    CHECK((rotation * axis - axis).norm() < 1e-15);
    // 4e-15: three rows of six rounding errors each, 1.2e-15; the vector's length, 4 rounding errors of 3 rad, 1.3e-15;
    // those of the right side, 1e-15.
    CHECK((rotation * across - (std::cos(angle) * across + std::sin(angle) * axis.cross(across))).norm() < 4e-15);
    // The angle comes from a trace near 1 + 2 cos(angle): below 3 rad it has only a few rounding errors.
    CHECK((rotationVector(rotation) - vector).norm() < 1e-14 + 1e-15 * angle);
    CHECK(std::abs(angleBetween(Mat3::Identity(), rotation) - angle) < 1e-14);
  }
  CHECK(rotationFromVector(Vec3::Zero()) == Mat3::Identity());
  CHECK(rotationVector(Mat3::Identity()) == Vec3::Zero());
}

TEST_CASE("the angle between two orientations does not depend on the frame", "[types]") {
  std::mt19937 engine(2);
  for (int i = 0; i < 200; ++i) {
    const double angle = kPi * i / 199.0;
    const Mat3 base = rotationFromVector(randomVector(engine, 2.0));
    const Mat3 turn = rotationFromVector(randomVector(engine, angle));
    // At pi the sine is a rounding error of the matrix.
    CHECK(std::abs(angleBetween(base, base * turn) - angle) < 5e-15);
    CHECK(std::abs(angleBetween(base * turn, base) - angle) < 5e-15);
  }
}

TEST_CASE("Euler angles at the singularity leave alpha zero", "[types]") {
  for (const double sign : {1.0, -1.0}) {
    const Mat3 rotation = rotationFromEuler({0.3, sign * 0.5 * kPi, 0.7});
    const Vec3 euler = eulerFromRotation(rotation);
    CHECK(euler.x() == 0.0);
    CHECK(euler.y() == Approx(sign * 0.5 * kPi));
    CHECK((rotationFromEuler(euler) - rotation).norm() < 1e-15);
  }
}

TEST_CASE("what is no rotation is refused", "[types]") {
  const Mat3 rotation = rotationFromEuler({0.1, 0.2, 0.3});
  CHECK(isRotation(rotation));
  CHECK(isRotation(rotation * (1.0 + 4e-7)));
  CHECK_FALSE(isRotation(rotation * (1.0 + 6e-7)));  // rows of squared length 1 + 1.2e-6
  CHECK_FALSE(isRotation(-rotation));
  CHECK_FALSE(isRotation(Mat3::Zero()));
  for (int i = 0; i < 9; ++i) {
    Mat3 wrong = rotation;
    wrong(i / 3, i % 3) = std::numeric_limits<double>::quiet_NaN();
    CHECK_FALSE(isRotation(wrong));
  }
  for (int row = 0; row < 3; ++row) {  // each pair of rows
    Mat3 sheared = Mat3::Identity();
    sheared(row, (row + 1) % 3) = 1.1e-6;
    CHECK_FALSE(isRotation(sheared));
  }
}

TEST_CASE("the matrix of the cross product", "[types]") {
  const Vec3 a(1.0, 2.0, 3.0), b(-4.0, 5.0, 7.0);
  CHECK(crossMatrix(a) * b == a.cross(b));
}

}  // namespace enamel::test_types
