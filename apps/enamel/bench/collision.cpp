#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include "bench/measurement.hpp"
#include "bench/scene_cost.hpp"
#include "enamel/collision/contacts.hpp"
#include "enamel/collision/mesh_update.hpp"
#include "enamel/collision/sweep.hpp"
#include "mesh_generator.hpp"

#ifdef ENAMEL_BENCH_EMBREE
#include <embree3/rtcore.h>
#endif
#ifdef ENAMEL_BENCH_FCL
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/distance.h>
#endif

namespace enamel::bench {
namespace {

constexpr double kTick = 50e-6;  // m: 50 mm/s at 1 kHz
constexpr double kTurn = 0.02;   // rad: 20 rad/s at 1 kHz

// Return a random walk along the surface, from 0.5 mm inside to 2 mm outside, with one tick between its points.
std::vector<Vec3> hapticPath(const MeshModel& model, int count) {
  Numbers numbers;
  std::vector<Vec3> path;
  Vec3 p = model.mesh().vertices[model.mesh().vertices.size() / 3], direction = numbers.vector().normalized();
  for (int i = 0; i < count; ++i) {
    const SurfacePoint near = signedDistance(model, p + kTick * direction);
    const Vec3 turned = direction + 0.05 * numbers.vector();
    direction = (turned - near.normal * near.normal.dot(turned)).normalized();
    Vec3 step = near.point + near.normal * 1e-3 * (0.75 + 1.25 * std::sin(0.004 * i)) - p;
    if (step.norm() > kTick) step *= kTick / step.norm();
    p += step;
    path.push_back(p);
  }
  return path;
}

std::vector<Vec3> randomPoints(const MeshReport& report, int count) {
  Numbers numbers;
  std::vector<Vec3> points;
  const Vec3 centre = 0.5 * (report.low + report.high), half = 0.6 * (report.high - report.low);
  for (int i = 0; i < count; ++i) points.push_back(centre + half.cwiseProduct(numbers.vector()));
  return points;
}

template <typename Distance>
double largestError(const TriangleMesh& mesh, const std::vector<Vec3>& points, const Distance& distance) {
  double worst = 0.0;
  const std::size_t checks = std::max<std::size_t>(5, 2000000 / mesh.triangles.size());
  const std::size_t stride = std::max<std::size_t>(1, points.size() / std::min<std::size_t>(checks, 100));
  for (std::size_t i = 0; i < points.size(); i += stride)
    worst = std::max(worst, std::abs(distance(points[i]) - exhaustiveDistance(mesh, points[i])));
  return worst;
}

#ifdef ENAMEL_BENCH_EMBREE
// Embree's point query in its usual form: the caller computes the distance to each triangle that Embree offers, in
// float.
class EmbreeMesh {
 public:
  explicit EmbreeMesh(const TriangleMesh& mesh) : device_(rtcNewDevice("")), scene_(rtcNewScene(device_)) {
    for (const Vec3& v : mesh.vertices) vertices_.push_back(v.cast<float>());
    vertices_.push_back(Eigen::Vector3f::Zero());  // Embree reads 16 bytes at the last vertex
    for (const auto& t : mesh.triangles)
      triangles_.push_back({static_cast<unsigned>(t[0]), static_cast<unsigned>(t[1]), static_cast<unsigned>(t[2])});
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices_.data(), 0, 12,
                               mesh.vertices.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles_.data(), 0, 12,
                               triangles_.size());
    rtcSetGeometryPointQueryFunction(geometry, &tryTriangle);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  ~EmbreeMesh() {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  EmbreeMesh(const EmbreeMesh&) = delete;
  EmbreeMesh& operator=(const EmbreeMesh&) = delete;

  /// With `hint`, the search starts from the distance to the triangle that was nearest in the last call.
  double distance(const Vec3& p, bool hint) {
    point_ = p.cast<float>();
    RTCPointQuery query;
    query.x = point_.x();
    query.y = point_.y();
    query.z = point_.z();
    query.time = 0.0f;
    query.radius = hint ? (nearestOn(nearest_) - point_).norm() * 1.00001f + 1e-9f : 1e9f;
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &query, &context, nullptr, this);
    return static_cast<double>(distance_);
  }

 private:
  static bool tryTriangle(RTCPointQueryFunctionArguments* arguments) {
    auto& self = *static_cast<EmbreeMesh*>(arguments->userPtr);
    const float distance = (self.nearestOn(arguments->primID) - self.point_).norm();
    if (!(distance < arguments->query->radius)) return false;
    arguments->query->radius = self.distance_ = distance;
    self.nearest_ = arguments->primID;
    return true;
  }

  Eigen::Vector3f nearestOn(unsigned triangle) const {  // regions: Ericson, Real-Time Collision Detection, 5.1.5
    const auto& t = triangles_[triangle];
    const Eigen::Vector3f &a = vertices_[t[0]], &b = vertices_[t[1]], &c = vertices_[t[2]];
    const Eigen::Vector3f ab = b - a, ac = c - a, ap = point_ - a, bp = point_ - b, cp = point_ - c;
    const float abA = ab.dot(ap), acA = ac.dot(ap), abB = ab.dot(bp), acB = ac.dot(bp), abC = ab.dot(cp),
                acC = ac.dot(cp);
    if (abA <= 0.0f && acA <= 0.0f) return a;
    if (abB >= 0.0f && acB <= abB) return b;
    if (acC >= 0.0f && abC <= acC) return c;
    const float overC = abA * acB - abB * acA, overB = abC * acA - abA * acC, overA = abB * acC - abC * acB;
    if (overC <= 0.0f && abA >= 0.0f && abB <= 0.0f) return a + abA / (abA - abB) * ab;
    if (overB <= 0.0f && acA >= 0.0f && acC <= 0.0f) return a + acA / (acA - acC) * ac;
    if (overA <= 0.0f && acB >= abB && abC >= acC) return b + (acB - abB) / (acB - abB + abC - acC) * (c - b);
    return a + (overB * ab + overC * ac) / (overA + overB + overC);
  }

  RTCDevice device_;
  RTCScene scene_;
  std::vector<Eigen::Vector3f> vertices_;
  std::vector<std::array<unsigned, 3>> triangles_;
  Eigen::Vector3f point_ = Eigen::Vector3f::Zero();
  unsigned nearest_ = 0;
  float distance_ = 0.0f;
};
#endif

#ifdef ENAMEL_BENCH_FCL
// FCL has no points: a sphere with a radius of 1 nm represents one.
class FclMesh {
 public:
  explicit FclMesh(const TriangleMesh& mesh) : model_(std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>()) {
    std::vector<fcl::Triangle> triangles;
    for (const auto& t : mesh.triangles)
      triangles.emplace_back(static_cast<std::size_t>(t[0]), static_cast<std::size_t>(t[1]),
                             static_cast<std::size_t>(t[2]));
    model_->beginModel();
    model_->addSubModel(mesh.vertices, triangles);
    model_->endModel();
    object_ = std::make_unique<fcl::CollisionObjectd>(model_);
    ball_ = std::make_unique<fcl::CollisionObjectd>(std::make_shared<fcl::Sphered>(1e-9));
  }
  double distance(const Vec3& p) {
    ball_->setTranslation(p);
    fcl::DistanceResultd result;
    fcl::distance(object_.get(), ball_.get(), fcl::DistanceRequestd(), result);
    return result.min_distance + 1e-9;
  }

 private:
  std::shared_ptr<fcl::BVHModel<fcl::OBBRSSd>> model_;
  std::unique_ptr<fcl::CollisionObjectd> object_, ball_;
};
#endif

struct Workload {
  std::string size;
  std::shared_ptr<MeshModel> model;
  std::vector<Vec3> path, random;
  int displacedCalls = 0;  // calls with other work between them, which takes longer than they
};

// In a simulator, graphics and physics run between two ticks and displace cached data. Touching 8 MB imitates them.
class OtherWork {
 public:
  void operator()() {
    for (std::size_t i = 0; i < memory_.size(); i += 64) memory_[i] = static_cast<char>(memory_[i] + 1);
    keep(memory_[0]);
  }

 private:
  std::vector<char> memory_ = std::vector<char>(std::size_t{8} << 20, '\0');
};

// Searches the nearest point from the root of the tree, within the distance to the last answer: a ProximityCache
// without its list of triangles.
class Followed {
 public:
  explicit Followed(const MeshModel& model) : model_(model) {}
  void moveTo(const Vec3& p) {
    const double limit = last_.triangle < 0 ? kNoLimit : (last_.point - p).norm() * (1.0 + 1e-9);
    last_ = closestPoint(model_, p, nullptr, limit);
    keep(last_);
  }

 private:
  const MeshModel& model_;
  SurfacePoint last_;
};

void addRow(std::vector<Measurement>& rows, const std::string& name, const Timing& timing, double error,
            const std::string& errorOf, double reference_us = std::numeric_limits<double>::quiet_NaN()) {
  Measurement row;
  row.name = name;
  row.median_us = timing.median_us;
  row.p99_us = timing.p99_us;
  row.error = error;
  row.errorOf = errorOf;
  row.reference_us = reference_us;
  rows.push_back(row);
}

void measureNearest(const Workload& work, std::vector<Measurement>& rows) {
  const MeshModel& model = *work.model;
  const int count = static_cast<int>(work.path.size()), warm = count / 10;
  const TriangleMesh& mesh = model.mesh();
  const std::string truth = "m, against all triangles", size = ", " + work.size;
  ProximityCache plain, withSign;
  Followed followed(model);
  std::vector<std::function<void(int)>> onPath = {[&](int i) { keep(closestPoint(model, work.path[i], &plain)); },
                                                  [&](int i) { keep(signedDistance(model, work.path[i], &withSign)); },
                                                  [&](int i) { keep(closestPoint(model, work.path[i])); },
                                                  [&](int i) { followed.moveTo(work.path[i]); }};
  std::vector<std::function<void(int)>> atRandom = {[&](int i) { keep(closestPoint(model, work.random[i])); }};
#ifdef ENAMEL_BENCH_EMBREE
  EmbreeMesh embree(mesh);
  onPath.push_back([&](int i) { keep(embree.distance(work.path[i], true)); });
  atRandom.push_back([&](int i) { keep(embree.distance(work.random[i], false)); });
#endif
  const std::vector<Timing> path = timeInTurns(count, warm, onPath), random = timeInTurns(count, warm, atRandom),
                            cold = timeInTurns(work.displacedCalls, work.displacedCalls / 10, onPath, OtherWork());
  double embreePath = std::numeric_limits<double>::quiet_NaN(), embreeRandom = embreePath, embreeCold = embreePath;
#ifdef ENAMEL_BENCH_EMBREE
  const auto embreeDistance = [&](const Vec3& p) { return embree.distance(p, false); };
  addRow(rows, "Embree 3 (float), haptic path, hint" + size, path[4], largestError(mesh, work.path, embreeDistance),
         truth);
  addRow(rows, "Embree 3 (float), haptic path, hint, 8 MB between" + size, cold[4],
         largestError(mesh, work.path, embreeDistance), truth);
  addRow(rows, "Embree 3 (float), random points" + size, random[1], largestError(mesh, work.random, embreeDistance),
         truth);
  embreePath = path[4].median_us;
  embreeCold = cold[4].median_us;
  embreeRandom = random[1].median_us;
#endif
#ifdef ENAMEL_BENCH_FCL
  {
    FclMesh fcl(mesh);
    const Timing haptic = timeEachCall(count / 10, warm / 10, [&](int i) { keep(fcl.distance(work.path[i])); });
    addRow(rows, "FCL, haptic path" + size, haptic,
           largestError(mesh, work.path, [&](const Vec3& p) { return fcl.distance(p); }), truth);
  }
#endif
  const auto distance = [&](const Vec3& p) { return closestPoint(model, p).distance; };
  const double error = largestError(mesh, work.path, distance);
  addRow(rows, "closest point, haptic path, cache" + size, path[0], error, truth, embreePath);
  addRow(rows, "signed distance, haptic path, cache" + size, path[1], error, truth, embreePath);
  addRow(rows, "closest point, haptic path, no cache" + size, path[2], error, truth, embreePath);
  addRow(rows, "closest point, haptic path, last point but no list" + size, path[3], error, truth, embreePath);
  addRow(rows, "closest point, haptic path, cache, 8 MB between" + size, cold[0], error, truth, embreeCold);
  addRow(rows, "closest point, haptic path, no cache, 8 MB between" + size, cold[2], error, truth, embreeCold);
  addRow(rows, "closest point, haptic path, last point but no list, 8 MB between" + size, cold[3], error, truth,
         embreeCold);
  addRow(rows, "closest point, random points" + size, random[0], largestError(mesh, work.random, distance), truth,
         embreeRandom);
}

void measureSweep(const Workload& work, std::vector<Measurement>& rows) {
  const MeshModel& model = *work.model;
  const int count = static_cast<int>(work.path.size()) - 2;
  constexpr double kRadius = 0.5e-3;
  ProximityCache cache;
  double error = 0.0;
  for (int i = 0; i < count; i += 10) {
    const Vec3 from = work.path[i], to = from + 1e-4 * (work.path[i + 2] - from).normalized();
    const SweepHit hit = sweepSphere(model, from, to, kRadius);
    if (hit.hit && hit.time > 0.0)
      error = std::max(error, std::abs(closestPoint(model, from + hit.time * (to - from)).distance - kRadius));
  }
  addRow(rows, "swept sphere of 0.5 mm, 0.1 mm a tick, " + work.size,
         timeEachCall(count, count / 10,
                      [&](int i) {
                        const Vec3 from = work.path[i];
                        keep(sweepSphere(model, from, from + 1e-4 * (work.path[i + 2] - from).normalized(), kRadius,
                                         &cache));
                      }),
         error, "m, gap at the touch");
}

// The same mesh with holes. The sign comes from the winding number; the reference is the unsigned distance.
void measureOpen(const Workload& work, std::vector<Measurement>& rows) {
  Numbers numbers;
  TriangleMesh open = work.model->mesh();
  open.triangles.erase(std::remove_if(open.triangles.begin(), open.triangles.end(),
                                      [&](const auto&) { return numbers(0.0, 1.0) < 0.05; }),
                       open.triangles.end());
  const MeshModel model(open);
  const int count = static_cast<int>(work.path.size());
  ProximityCache plain, withSign;
  const std::vector<Timing> times = timeInTurns(count, count / 10,
                                                {[&](int i) { keep(closestPoint(model, work.path[i], &plain)); },
                                                 [&](int i) { keep(signedDistance(model, work.path[i], &withSign)); },
                                                 [&](int i) { keep(closestPoint(model, work.random[i])); },
                                                 [&](int i) { keep(signedDistance(model, work.random[i])); }});
  const auto error = [&](const std::vector<Vec3>& points) {
    return largestError(open, points, [&](const Vec3& p) { return std::abs(signedDistance(model, p).distance); });
  };
  const std::string truth = "m, against all triangles", size = ", open mesh, " + work.size;
  addRow(rows, "closest point, haptic path, cache" + size, times[0], error(work.path), truth);
  addRow(rows, "signed distance, haptic path, cache" + size, times[1], error(work.path), truth, times[0].median_us);
  addRow(rows, "closest point, random points" + size, times[2], error(work.random), truth);
  addRow(rows, "signed distance, random points" + size, times[3], error(work.random), truth, times[2].median_us);
}

void measureUpdates(const Workload& work, std::vector<Measurement>& rows) {
  constexpr int kTriangles = 100, kRounds = 300;
  MeshModel& model = *work.model;
  const TriangleMesh& mesh = model.mesh();
  std::vector<int> patch, vertices;
  const Vec3 centre = mesh.vertices[mesh.triangles[mesh.triangles.size() / 2][0]];
  std::vector<std::pair<double, int>> byDistance;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    byDistance.emplace_back((mesh.vertices[mesh.triangles[t][0]] - centre).norm(), static_cast<int>(t));
  std::sort(byDistance.begin(), byDistance.end());
  std::vector<std::array<int, 3>> corners;
  for (int i = 0; i < kTriangles; ++i) {
    patch.push_back(byDistance[i].second);
    corners.push_back(mesh.triangles[patch.back()]);
    for (const int v : corners.back()) vertices.push_back(v);
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  std::vector<Vec3> positions, home;
  for (const int v : vertices) {
    home.push_back(mesh.vertices[v]);
    positions.push_back(mesh.vertices[v] + Vec3(0, 0, -1e-5));
  }
  const int count = static_cast<int>(vertices.size());
  const auto errorHere = [&] {
    const auto distance = [&](const Vec3& p) { return closestPoint(model, p).distance; };
    return largestError(mesh, {centre + Vec3(0, 0, 1e-3), centre - Vec3(0, 1e-3, 0)}, distance);
  };
  const Timing moved = timeEachCall(kRounds, 10, [&](int i) {
    keep(moveVertices(model, vertices.data(), (i % 2 == 0 ? positions : home).data(), count));
  });
  addRow(rows, fmt::format("{} vertices of 100 triangles and more moved, {}", count, work.size), moved, errorHere(),
         "m, against all triangles");
  std::vector<double> times_us;
  bool isReplaced = true;
  for (int i = 0; i < kRounds; ++i) {
    const Timing once = timeEachCall(1, 0, [&](int) { keep(removeTriangles(model, patch.data(), kTriangles)); });
    times_us.push_back(once.median_us);
    isReplaced = isReplaced && replaceTriangles(model, patch.data(), corners.data(), kTriangles) == Status::ok;
  }
  std::sort(times_us.begin(), times_us.end());
  addRow(rows, "100 triangles removed, " + work.size, {percentile(times_us, 0.5), percentile(times_us, 0.99)},
         isReplaced ? errorHere() : 1.0, "m, against all triangles, after replacing them");
}

void measureContacts(const Workload& work, std::vector<Measurement>& rows) {
  Tool bur;  // three parts: sphere, neck and shaft
  bur.parts[0].radius = 0.5e-3;
  bur.parts[1] = {{0, 0, 1e-3}, {0, 0, 5e-3}, 0.3e-3};
  bur.parts[2] = {{0, 0, 5e-3}, {0, 0, 15e-3}, 0.8e-3};
  bur.count = 3;
  ContactSnapshot contacts;
  for (const bool wall : {false, true}) {
    Scene scene;
    if (wall) {
      scene.add({"wall", HalfSpace{}, Pose(), Vec6::Zero(), {}});
    } else {
      scene.add({"jaw", std::shared_ptr<const MeshModel>(work.model), Pose(), Vec6::Zero(), {}});
    }
    ToolCache cache = makeToolCache(scene, bur);
    std::vector<Pose> poses;  // the shaft follows the surface's normal at the speed of a hand
    Eigen::Quaterniond turned = Eigen::Quaterniond::Identity();
    for (const Vec3& p : work.path) {
      const Vec3 n = signedDistance(*work.model, p).normal;  // target of the z axis, reached by the shortest rotation
      const Eigen::Quaterniond wanted = Eigen::Quaterniond(1.0 + n.z(), -n.y(), n.x(), 1e-9).normalized();
      const double angle = turned.angularDistance(wanted);
      turned = angle > kTurn && !poses.empty() ? turned.slerp(kTurn / angle, wanted) : wanted;
      poses.push_back({p, turned.toRotationMatrix()});
    }
    // Interruptions of a call must not count: take the minimum of three runs along the same path.
    std::vector<double> times_us(poses.size(), 1e9), followed_us = times_us;
    const auto timeTick = [](double& least_us, const auto& call) { least_us = std::min(least_us, timeOnce(call)); };
    for (int run = 0; run < 3; ++run) {
      cache = makeToolCache(scene, bur);
      ToolTrack track = makeToolTrack(scene, bur);
      for (std::size_t i = 0; i < poses.size(); ++i)
        timeTick(times_us[i], [&] { keep(findContacts(scene, bur, poses[i], 1e-4, &cache, contacts)); });
      for (std::size_t i = 0; i < poses.size(); ++i)
        timeTick(followed_us[i], [&] { keep(followContacts(scene, bur, poses[i], 1e-4, track, contacts)); });
    }
    std::sort(times_us.begin(), times_us.end());
    std::sort(followed_us.begin(), followed_us.end());
    double error = 0.0;
    for (std::size_t i = 0; i < poses.size(); i += poses.size() / 20) {
      if (findContacts(scene, bur, poses[i], 1e-4, &cache, contacts) != Status::ok) error = 1.0;
      for (int k = 0; k < contacts.count; ++k) {  // outside, the gap is the distance of the contact point
        const Contact& contact = contacts.contacts[k];
        const double distance = wall ? contact.point.z() : closestPoint(*work.model, contact.point).distance;
        if (contact.gap > 0.0) error = std::max(error, std::abs(contact.gap - distance));
      }
    }
    addRow(rows, wall ? "contacts of a bur with a plane" : "contacts of a bur with a jaw, " + work.size,
           {percentile(times_us, 0.5), percentile(times_us, 0.99)}, error, "m, gap of the contact point");
    rows.back().p999_us = percentile(times_us, 0.999);
    if (wall) continue;
    addRow(rows, "the same, followed, " + work.size, {percentile(followed_us, 0.5), percentile(followed_us, 0.99)},
           error, "m, gap of the contact point", percentile(times_us, 0.5));
    rows.back().p999_us = percentile(followed_us, 0.999);
  }
}

}  // namespace

std::vector<Measurement> measureCollision(double scale) {
  std::vector<Measurement> rows;
  const struct {
    const char* size;
    int along, around;
  } kSizes[] = {{"10 k", 125, 40}, {"100 k", 400, 125}, {"1 M", 1250, 400}};
  const int calls = std::max(2000, static_cast<int>(20000 * scale));
  for (const auto& [size, along, around] : kSizes) {
    if (scale < 0.2 && along > 400) continue;
    Workload work;
    work.size = size;
    work.model = std::make_shared<MeshModel>(app::makeJaw(along, around));
    work.path = hapticPath(*work.model, calls);
    work.random = randomPoints(inspect(work.model->mesh()), calls);
    work.displacedCalls = std::clamp(static_cast<int>(5000 * scale), 100, 500);
    measureNearest(work, rows);
    if (along == 400) {
      measureOpen(work, rows);
      measureSweep(work, rows);
      measureUpdates(work, rows);
    }
    if (along >= 400) measureContacts(work, rows);
  }
  return rows;
}

}  // namespace enamel::bench
