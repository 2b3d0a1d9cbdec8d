#include "enamel/collision/scene.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "collision/mesh_data.hpp"
#include "core/message.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

bool isSameShape(const HalfSpace&, const HalfSpace&) noexcept { return true; }
bool isSameShape(const Box& a, const Box& b) noexcept { return a.half == b.half; }
bool isSameShape(const Sphere& a, const Sphere& b) noexcept { return a.radius == b.radius; }
bool isSameShape(const Capsule& a, const Capsule& b) noexcept {
  return a.radius == b.radius && a.halfLength == b.halfLength;
}
template <typename Model>
bool isSameShape(const std::shared_ptr<const Model>& a, const std::shared_ptr<const Model>& b) noexcept {
  return a == b;
}

// Compare two shapes of the same kind, the I-th or a later one.
template <std::size_t I>
bool isSame(const Shape& a, const Shape& b) noexcept {
  if constexpr (I + 1 < std::variant_size_v<Shape>)
    if (a.index() != I) return isSame<I + 1>(a, b);
  return isSameShape(*std::get_if<I>(&a), *std::get_if<I>(&b));
}

bool isNear(const Vec3& position) noexcept { return position.cwiseAbs().maxCoeff() <= kFarthest; }
bool isSlow(const Vec6& twist) noexcept {
  return twist.head<3>().cwiseAbs().maxCoeff() <= kFastest && twist.tail<3>().cwiseAbs().maxCoeff() <= kFastestTurn;
}

}  // namespace

void Scene::check(const Obstacle& obstacle, std::size_t number) const {
  const std::string name = "obstacle \"" + obstacle.name + "\"";
  if (obstacle.name.empty()) throw Error("the name of an obstacle is empty");
  for (std::size_t i = 0; i < obstacles_.size(); ++i)
    if (i != number && obstacles_[i].name == obstacle.name) throw Error(name + " occurs twice in the scene");
  const Mat3& R = obstacle.pose.rotation;
  if (!obstacle.pose.position.allFinite() || !R.allFinite() || !obstacle.twist.allFinite())
    throw Error(name + ": pose or twist is not finite");
  if (!isNear(obstacle.pose.position) || !isSlow(obstacle.twist))
    throw Error(name + ": must be within " + formatNumber(kFarthest) + " m of the origin and slower than " +
                formatNumber(kFastest) + " m/s and " + formatNumber(kFastestTurn) +
                " rad/s; are its lengths in metres?");
  if (!isRotation(R)) throw Error(name + ": the rotation is not a right-handed orthonormal matrix to 1e-6");
  const auto positive = [](double x) { return x > 0.0 && std::isfinite(x); };
  bool sized = true;
  if (const auto* box = std::get_if<Box>(&obstacle.shape))
    sized = positive(box->half.minCoeff()) && box->half.allFinite();
  if (const auto* sphere = std::get_if<Sphere>(&obstacle.shape)) sized = positive(sphere->radius);
  if (const auto* capsule = std::get_if<Capsule>(&obstacle.shape))
    sized = positive(capsule->radius) && positive(capsule->halfLength);
  if (const auto* mesh = std::get_if<std::shared_ptr<const MeshModel>>(&obstacle.shape)) sized = *mesh != nullptr;
  if (const auto* solid = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape)) sized = *solid != nullptr;
  if (!sized)
    throw Error(name + ": the size of the shape must be positive and finite, its mesh or solid must not be null");
  checkMaterial(obstacle.material, name);
  checkTap(obstacle.tap, name);
  if (obstacle.tap.frequency > 0.0 && std::holds_alternative<std::shared_ptr<const Solid>>(obstacle.shape))
    throw Error(name + ": a solid has the taps of its layers");
  const bool isMesh = std::holds_alternative<std::shared_ptr<const MeshModel>>(obstacle.shape);
  if (!(obstacle.thickness >= 0.0 && std::isfinite(obstacle.thickness)) || (obstacle.thickness > 0.0 && !isMesh))
    throw Error(name + ": the thickness must be at least 0 m and finite, and 0 m unless the shape is a mesh");
  if (!obstacle.suspension) return;
  const Suspension& s = *obstacle.suspension;
  const auto isSound = [](const Vec6& v) { return v.allFinite() && v.minCoeff() >= 0.0; };
  const bool isHeavy = (s.inertia.array() == 0.0 || s.inertia.array() >= kLeastMovableInertia).all();
  if (!s.centre.allFinite() || !isNear(s.centre) || !isSound(s.inertia) || !isSound(s.stiffness) ||
      !isSound(s.damping) || s.inertia.isZero(0.0) || !isHeavy)
    throw Error(name +
                ": inertia, stiffness and damping of the suspension must be at least 0 and finite, an inertia 0 or at "
                "least " +
                formatNumber(kLeastMovableInertia) + ", one of them above 0, and its centre within " +
                formatNumber(kFarthest) + " m");
}

int Scene::add(Obstacle obstacle) {
  check(obstacle, obstacles_.size());
  obstacles_.push_back(std::move(obstacle));
  return static_cast<int>(obstacles_.size()) - 1;
}

void Scene::replace(int obstacle, Obstacle by) {
  const auto number = static_cast<std::size_t>(obstacle);
  if (number >= obstacles_.size())
    throw Error("the scene has no obstacle " + std::to_string(obstacle) + ", only 0 to " +
                std::to_string(static_cast<int>(obstacles_.size()) - 1));
  check(by, number);
  obstacles_[number] = std::move(by);
}

Status Scene::activate(int obstacle, bool active) noexcept {
  if (static_cast<std::size_t>(obstacle) >= obstacles_.size()) return Status::outOfRange;
  obstacles_[static_cast<std::size_t>(obstacle)].active = active;
  return Status::ok;
}

Status Scene::move(int obstacle, const Pose& pose, const Vec6& twist) noexcept {
  if (obstacle < 0 || static_cast<std::size_t>(obstacle) >= obstacles_.size()) return Status::outOfRange;
  if (!pose.position.allFinite() || !pose.rotation.allFinite() || !twist.allFinite()) return Status::notFinite;
  if (!isRotation(pose.rotation) || !isNear(pose.position) || !isSlow(twist)) return Status::outOfRange;
  obstacles_[static_cast<std::size_t>(obstacle)].pose = pose;
  obstacles_[static_cast<std::size_t>(obstacle)].twist = twist;
  return Status::ok;
}

void Scene::setGuides(std::vector<Guide> guides) {
  if (guides.size() > kMaxGuides)
    throw Error("the scene has " + std::to_string(guides.size()) + " guides, must have at most " +
                std::to_string(kMaxGuides));
  for (std::size_t i = 0; i < guides.size(); ++i) checkGuide(guides[i], "guide " + std::to_string(i));
  guides_ = guides.empty() ? nullptr : std::make_shared<const std::vector<Guide>>(std::move(guides));
}

bool isSameObstacle(const Scene& before, const Scene& now, std::size_t number) noexcept {
  if (number >= before.obstacles().size() || number >= now.obstacles().size()) return false;
  const Obstacle& a = before.obstacles()[number];
  const Obstacle& b = now.obstacles()[number];
  if (!a.active || !b.active || a.thickness != b.thickness || a.name != b.name || a.shape.index() != b.shape.index())
    return false;
  return isSame<0>(a.shape, b.shape);
}

Tap tapOf(const std::string& name) {
  std::string names;
  for (const NamedTap& known : kNamedTaps) {
    if (name == known.name) return known.tap;
    names += (names.empty() ? "\"" : ", \"") + std::string(known.name) + '"';
  }
  throw Error("is \"" + name + "\", must be one of " + names);
}

void checkTap(const Tap& tap, const std::string& name) {
  const bool isOff = tap.frequency == 0.0 && tap.decay == 0.0;
  if (!isOff && !(tap.frequency >= 10.0 && tap.frequency <= 1000.0 && tap.decay >= 0.0 && tap.decay <= 2000.0))
    throw Error(name + ": a tap has a frequency of 10 to 1000 Hz and a decay of 0 to 2000 1/s, or both 0; not " +
                formatNumber(tap.frequency) + " Hz and " + formatNumber(tap.decay) + " 1/s");
}

void checkMaterial(const Material& m, const std::string& name) {
  if (!(m.stiffness > 0.0) || !(m.friction >= 0.0 && m.friction <= 10.0) ||
      !(m.slidingFriction >= 0.0 && m.slidingFriction <= m.friction) ||
      !(m.viscosity >= 0.0 && m.viscosity <= kLargestViscosity))
    throw Error(name +
                ": the material must have a stiffness above 0 N/m, friction in 0 to 10, sliding friction in 0 to "
                "friction, and a viscosity in 0 to " +
                formatNumber(kLargestViscosity) + " N s/m");
  if (!(m.exponent >= 1.0 && m.exponent <= kLargestExponent) || !(m.thickness > 0.0) ||
      !(m.hysteresis >= 0.0 && m.hysteresis <= kLargestHysteresis) || !(m.puncture > 0.0))
    throw Error(name + ": the material must have an exponent in 1 to " + formatNumber(kLargestExponent) +
                ", a thickness above 0 m, a hysteresis in 0 to " + formatNumber(kLargestHysteresis) +
                " s/m, and a puncture force above 0 N");
  if (!(m.stribeck >= 0.0 && m.stribeck <= kLargestStribeck))
    throw Error(name + ": the material has a Stribeck speed of " + formatNumber(m.stribeck) + " m/s, must be in 0 to " +
                formatNumber(kLargestStribeck) + " m/s");
  if (!(m.wavelength >= 0.0 && m.wavelength <= kLongestWave) || !(m.roughness >= 0.0) || m.isTooSteep())
    throw Error(name + ": the material has a roughness of " + formatNumber(m.roughness) + " m and a wavelength of " +
                formatNumber(m.wavelength) + " m; the wavelength must be in 0 to " + formatNumber(kLongestWave) +
                " m, and the roughness in 0 to " + formatNumber(kSteepestRoughness) + " of it");
  const bool isRigid = std::isinf(m.stiffness);
  if (isRigid && (m.isLayer() || !std::isinf(m.puncture)))
    throw Error(name + ": an exponent, a thickness, a hysteresis or a puncture force needs a finite stiffness");
  if (std::isfinite(m.puncture) && std::isinf(m.thickness))
    throw Error(name + ": a puncture force needs a thickness: the ground below it holds the tool");
}

double unusualSize(const Obstacle& obstacle, double scale) {
  constexpr double kSmallest = 1e-3, kLargest = 1.0;  // m, for devices that move the tool by some centimetres
  double size = 0.0;
  if (const auto* mesh = std::get_if<std::shared_ptr<const MeshModel>>(&obstacle.shape)) {
    const kernel::MeshData& data = kernel::Inside::of(**mesh);
    size = (data.high - data.low).maxCoeff();
  } else if (const auto* solid = std::get_if<std::shared_ptr<const Solid>>(&obstacle.shape)) {
    size = ((*solid)->high() - (*solid)->low()).maxCoeff();
  }
  return size > scale * kLargest || (size > 0.0 && size < scale * kSmallest) ? size : 0.0;
}

Mat3 frameAlong(const Vec3& axis) noexcept {
  const Vec3 side = (std::abs(axis.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY());
  Mat3 frame;
  frame.col(2) = axis;
  frame.col(1) = axis.cross(side).normalized();
  frame.col(0) = frame.col(1).cross(axis);
  return frame;
}

Obstacle halfSpace(const std::string& name, const Vec3& point, const Vec3& normal) {
  return {name, HalfSpace{}, {point, frameAlong(normal)}, Vec6::Zero(), {}};
}

Scene flatWall(const Vec3& point, const Vec3& normal) {
  Scene scene;
  scene.add(halfSpace("wall", point, normal));
  return scene;
}

}  // namespace enamel
