#include "enamel/render/roughness.hpp"

#include <algorithm>
#include <cmath>

#include "core/trigonometry.hpp"
#include "enamel/render/renderer.hpp"
#include "render/scene_surfaces.hpp"

namespace enamel {
namespace {

constexpr int kWaveCount = 24;
constexpr double kHurst = 0.8;  // exponent of a self-affine surface
constexpr double kDecade = 10.0;

using Numbers = Eigen::Array<double, kWaveCount, 1>;

// The waves of a surface whose longest wavelength is 1 and whose root mean square height is 1.
struct Waves {
  Numbers length, amplitude, phase;
  Eigen::Matrix<double, kWaveCount, 3> q;  // wave vectors
};

// Directions lie on a spiral over the sphere, in an order without a trend; phases follow the golden ratio.
const Waves kUnitWaves = [] {
  constexpr double kGolden = 0.6180339887498949;
  constexpr int kStride = 7;  // has no divisor in common with kWaveCount
  Waves waves;
  for (int k = 0; k < kWaveCount; ++k) {
    const int place = k * kStride % kWaveCount;
    const double z = 1.0 - (2.0 * place + 1.0) / kWaveCount, turn = 2.0 * M_PI * kGolden * place;
    const double across = std::sqrt(1.0 - z * z);
    waves.phase[k] = 2.0 * M_PI * std::fmod(kGolden * (k + 1), 1.0);
    waves.length[k] = std::pow(kDecade, -k / (kWaveCount - 1.0));
    waves.q.row(k) = 2.0 * M_PI / waves.length[k] * Vec3(across * std::cos(turn), across * std::sin(turn), z);
    waves.amplitude[k] = std::pow(waves.length[k], kHurst);
  }
  waves.amplitude *= std::sqrt(2.0 / waves.amplitude.square().sum());
  return waves;
}();

}  // namespace

SurfaceHeight heightAt(const Material& material, const Vec3& place, double radius, double passed) noexcept {
  SurfaceHeight surface;
  if (!(material.roughness > 0.0)) return surface;
  const Numbers length = material.wavelength * kUnitWaves.length;
  Numbers amplitude =
      (material.roughness * kUnitWaves.amplitude).min(length.square() / (16.0 * std::max(radius, 1e-9)));
  const double step = std::max(passed, 1e-12);
  amplitude *= (length / step).unaryExpr(&sampledShare);
  const Numbers angle = (kUnitWaves.q * (place / material.wavelength)).array() + kUnitWaves.phase;
  Numbers sine, cosine;
  sinCos<kWaveCount>(angle, sine, cosine);
  surface.height = (amplitude * cosine).sum();
  surface.gradient = kUnitWaves.q.transpose() * (amplitude * sine).matrix() / -material.wavelength;
  return surface;
}

bool isRough(const Scene& scene) noexcept {
  return anySurface(scene, [](const Material& material, const Tap&) { return material.roughness > 0.0; });
}

void roughen(const Scene& scene, const Tool& tool, const Kinematics& kinematics, const JointVector& encoderStep,
             double period, const PartRange& smooth, ContactSnapshot& contacts) noexcept {
  for (int i = 0; i < contacts.count; ++i) {
    Contact& contact = contacts.contacts[static_cast<std::size_t>(i)];
    if (!(contact.material.roughness > 0.0) || smooth.has(contact.part)) continue;
    const Vec3 n = contact.normal, arm = contact.point - kinematics.pose.position;
    const auto along = [&n](const Vec3& v) { return Vec3(v - n.dot(v) * n); };
    double passed = period * along(contactVelocity(kinematics, contact)).norm();
    double square = 0.0;
    for (Eigen::Index j = 0; j < encoderStep.size(); ++j)
      square += along(translationAt(kinematics.jacobian.col(j), arm) * encoderStep[j]).squaredNorm();
    passed = std::max(passed, std::sqrt(square));
    const Pose& pose = scene.obstacles()[static_cast<std::size_t>(contact.obstacle)].pose;
    const Vec3 place = pose.rotation.transpose() * (contact.point - contact.gap * n - pose.position);
    const double radius = tool.parts[static_cast<std::size_t>(contact.part)].radius;
    const SurfaceHeight surface = heightAt(contact.material, place, radius, passed);
    contact.gap -= surface.height;
    contact.normal = (n - along(pose.rotation * surface.gradient)).normalized();
  }
  sortByDepth(contacts);
}

}  // namespace enamel
