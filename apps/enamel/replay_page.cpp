#include "replay_page.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "colours/renderers.hpp"
#include "colours/tooth_colours.hpp"
#include "enamel/collision/solid_surface.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "page_text.hpp"
#include "study/page.hpp"
#ifdef ENAMEL_REPLAY_PAGE
#include <zlib.h>
#endif

namespace enamel::app {
namespace {

using nlohmann::json;

constexpr double kPictures = 60.0, kBrickPeriod = 0.1;
constexpr std::size_t kMostPictures = 36000, kMostBuckets = 20000;
constexpr std::size_t kPose = 7, kContact = 6;  // numbers in each picture

// Return the name of a number type on the page: f32, u16.
template <typename T>
std::string nameOf() {
  const char* const kind = std::is_floating_point_v<T> ? "f" : std::is_signed_v<T> ? "i" : "u";
  return kind + std::to_string(8 * sizeof(T));
}

// Convert m to mm.
json millimetres(const Vec3& v) { return {1e3 * v.x(), 1e3 * v.y(), 1e3 * v.z()}; }

Vec3 rgbOf(unsigned rgb) {
  const viewer::Colour c = viewer::colour(rgb);
  return {c.r, c.g, c.b};
}

// Return for every vertex the mean of its triangles' normals, weighted by their areas.
std::vector<Vec3> normalsOf(const TriangleMesh& mesh) {
  const std::vector<int> place = weld(mesh);
  std::vector<Vec3> sums(mesh.vertices.size(), Vec3::Zero()), normals;
  const auto at = [&](int vertex) { return static_cast<std::size_t>(place[static_cast<std::size_t>(vertex)]); };
  const auto corner = [&](int vertex) -> const Vec3& { return mesh.vertices[static_cast<std::size_t>(vertex)]; };
  for (const auto& t : mesh.triangles) {
    const Vec3 normal = (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0]));
    for (const int vertex : t) sums[at(vertex)] += normal;
  }
  for (std::size_t i = 0; i < sums.size(); ++i)
    normals.push_back(sums[static_cast<std::size_t>(place[i])].stableNormalized());
  return normals;
}

// Keep every second row of `width` values.
template <typename T>
void keepEverySecond(std::vector<T>& values, std::size_t width) {
  const std::size_t kept = (values.size() / width + 1) / 2;
  for (std::size_t row = 0; row < kept; ++row)
    std::copy_n(values.data() + 2 * row * width, width, values.data() + row * width);
  values.resize(kept * width);
}

}  // namespace

template <typename T>
json PageNumbers::add(const std::vector<T>& values) {
  bytes_.resize((bytes_.size() + 3) / 4 * 4, '\0');
  const std::size_t at = bytes_.size();
  if (!values.empty()) bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  return {{"at", at}, {"count", values.size()}, {"type", nameOf<T>()}};
}

void PageSide::Curve::add(double value, bool isNew) {
  const auto v = static_cast<float>(value);
  if (isNew) {
    low.push_back(v);
    high.push_back(v);
  }
  low.back() = std::min(low.back(), v);
  high.back() = std::max(high.back(), v);
}

PageSide::PageSide(std::string title, const RecordingHeader& header, const SceneFile& scene, const Drill* drill,
                   bool isAsked)
    : title_(std::move(title)),
      header_(header),
      scene_(scene),
      drill_(drill),
      isAsked_(isAsked),
      everyPicture_(static_cast<std::uint64_t>(std::max(1.0, std::round(1.0 / (kPictures * header.guard.period))))) {
  if (isAsked) return;  // the first side shows them
  for (const auto& solid : scene.solids) {
    Copy copy;
    copy.solid = solid;
    for (int brick = 0; solid && brick < solid->bricks(); ++brick) copy.uncut.push_back(solid->samples(brick));
    copies_.push_back(std::move(copy));
  }
}

void PageSide::see(const RecordedTick& recorded, const HapticTick& tick) {
  if (ticks_ == 0) begin_ = recorded.measurement.time;
  const double time = recorded.measurement.time - begin_;
  if (!std::isfinite(time) || recorded.status == Status::notFinite) return;  // nothing to show
  end_ = std::max(end_, time);
  const ContactSnapshot& contacts = tick.frame().contacts;
  const Contact& contact = contacts.contacts[0];
  // The force that a person feels: the command without the torque that compensates gravity.
  const Kinematics& k = tick.frame().kinematics;
  const JointVector& torque = isAsked_ ? tick.frame().output.torque : recorded.command;
  const bool acts = recorded.status == Status::ok && torque.size() == k.gravity.size() && !torque.isZero();
  const Vec3 push = acts ? Vec3(wrenchOf(k, torque - k.gravity).head<3>()) : Vec3(Vec3::Zero());
  const double force = push.norm();
  const double depth = contacts.count > 0 ? std::max(0.0, -contact.gap) : 0.0;
  if (force_.low.size() == kMostBuckets && ticks_ % everyCurve_ == 0) halveCurves();
  const bool isNew = ticks_ % everyCurve_ == 0;
  force_.add(force, isNew);
  depth_.add(1e3 * depth, isNew);
  if (drill_ != nullptr)
    for (std::size_t i = 0; i < sum_.size(); ++i) sum_[i] += drill_->removed()[i];
  if (drill_ != nullptr && time >= bricksAt_) {
    takeBricks(static_cast<float>(time));
    bricksAt_ = time + kBrickPeriod;
  }
  if (times_.size() == kMostPictures && ticks_ % everyPicture_ == 0) halvePictures();
  if (ticks_++ % everyPicture_ != 0) return;
  const Pose& pose = k.pose;
  const Eigen::Quaterniond turn(pose.rotation);
  times_.push_back(static_cast<float>(time));
  for (const double x : pose.position) poses_.push_back(static_cast<float>(1e3 * x));
  for (const double x : {turn.x(), turn.y(), turn.z(), turn.w()}) poses_.push_back(static_cast<float>(x));
  forces_.push_back(static_cast<float>(force));
  depths_.push_back(static_cast<float>(1e3 * depth));
  const bool touches = contacts.count > 0 && tick.frame().output.mode == RenderMode::contact;
  for (const double x : contact.point) contacts_.push_back(static_cast<float>(touches ? 1e3 * x : NAN));
  for (const double x : push) contacts_.push_back(static_cast<float>(touches ? x : NAN));
  guards_.push_back(static_cast<std::uint8_t>(recorded.reason));
  for (const double volume : sum_) removed_.push_back(static_cast<float>(1e9 * volume));
}

// Merge pairs of buckets; each then covers twice as many ticks.
void PageSide::halveCurves() {
  for (Curve* curve : {&force_, &depth_}) {
    for (std::size_t i = 0; i < kMostBuckets / 2; ++i) {
      curve->low[i] = std::min(curve->low[2 * i], curve->low[2 * i + 1]);
      curve->high[i] = std::max(curve->high[2 * i], curve->high[2 * i + 1]);
    }
    curve->low.resize(kMostBuckets / 2);
    curve->high.resize(kMostBuckets / 2);
  }
  everyCurve_ *= 2;
}

void PageSide::halvePictures() {
  for (auto* list : {&times_, &forces_, &depths_}) keepEverySecond(*list, 1);
  keepEverySecond(poses_, kPose);
  keepEverySecond(contacts_, kContact);
  keepEverySecond(removed_, sum_.size());
  keepEverySecond(guards_, 1);
  everyPicture_ *= 2;
}

void PageSide::takeBricks(float time) {
  for (Copy& copy : copies_) {
    if (!copy.solid) continue;
    for (int brick = 0; (brick = copy.solid->takeChanged()) >= 0;)
      copy.changes.push_back({time, brick, copy.solid->samples(brick)});
  }
}

// Quantise coordinates to 65535 steps of the bounding box, and normals to 127 steps.
json PageSide::meshOf(const std::vector<Vec3>& vertices, const std::vector<Vec3>& normals,
                      const std::vector<Vec3>& colours, const std::vector<std::array<int, 3>>& triangles,
                      PageNumbers& numbers) const {
  Vec3 low = vertices.front(), high = low;
  for (const Vec3& v : vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
  const Vec3 step = ((high - low) / 65535.0).cwiseMax(1e-12);
  std::vector<std::uint16_t> places;
  std::vector<std::int8_t> directions;
  std::vector<std::uint8_t> rgb;
  for (const Vec3& v : vertices)
    for (int i = 0; i < 3; ++i) places.push_back(static_cast<std::uint16_t>(std::lround((v[i] - low[i]) / step[i])));
  for (const Vec3& n : normals)
    for (const double x : n) directions.push_back(static_cast<std::int8_t>(std::lround(127.0 * x)));
  for (const Vec3& c : colours)
    for (const double x : c) rgb.push_back(static_cast<std::uint8_t>(std::lround(255.0 * x)));
  json mesh = {{"low", millimetres(low)},
               {"step", millimetres(step)},
               {"places", numbers.add(places)},
               {"normals", numbers.add(directions)},
               {"colours", numbers.add(rgb)}};
  const auto corners = [&](auto zero) {
    std::vector<decltype(zero)> list;
    for (const auto& t : triangles)
      for (const int i : t) list.push_back(static_cast<decltype(zero)>(i));
    return numbers.add(list);
  };
  mesh["corners"] = vertices.size() < 65536 ? corners(std::uint16_t{0}) : corners(std::uint32_t{0});
  return mesh;
}

// Bricks that the bur never cuts become one mesh at half resolution. Each cut brick becomes a piece at full resolution
// for each time at which it changed.
json PageSide::solidOf(const Copy& copy, PageNumbers& numbers) const {
  const Solid& solid = *copy.solid;
  std::vector<bool> isCut(copy.uncut.size(), false);
  for (const Brick& brick : copy.changes) isCut[static_cast<std::size_t>(brick.number)] = true;
  const auto colourOf = [&](std::size_t layer) { return viewer::layerColour(solid.layers()[layer].name, layer); };
  const auto piece = [&](const SolidSurface& surface) {
    std::vector<Vec3> colours;
    for (const int layer : surface.layers) colours.push_back(rgbOf(colourOf(static_cast<std::size_t>(layer))));
    return meshOf(surface.mesh.vertices, surface.normals, colours, surface.mesh.triangles, numbers);
  };
  const auto append = [&](int brick, const BrickSamples& samples, SolidSurface& surface) {
    const bool isFine = isCut[static_cast<std::size_t>(brick)];
    std::uint32_t coarser = 0;
    if (isFine)
      forEachNeighbour(solid, brick, [&](int bit, int other) {
        if (!isCut[static_cast<std::size_t>(other)]) coarser |= 1u << bit;
      });
    appendSurface(solid, brick, samples, surface, isFine ? 1 : 2, coarser);
  };
  json result = {{"pieces", json::array()}};
  SolidSurface rest, one;
  const auto add = [&](float time, int brick, const BrickSamples& samples) {
    one.clear();
    append(brick, samples, one);
    json entry = {{"time", time}, {"brick", brick}};
    if (!one.mesh.triangles.empty()) entry["mesh"] = piece(one);
    result["pieces"].push_back(std::move(entry));
  };
  for (int brick = 0; brick < solid.bricks(); ++brick) {
    const BrickSamples& samples = copy.uncut[static_cast<std::size_t>(brick)];
    if (isCut[static_cast<std::size_t>(brick)])
      add(0.0f, brick, samples);
    else
      append(brick, samples, rest);
  }
  if (!rest.mesh.triangles.empty()) result["rest"] = piece(rest);
  for (const Brick& brick : copy.changes) add(brick.time, brick.number, brick.samples);
  for (std::size_t layer = 0; layer < solid.layers().size(); ++layer)
    result["layers"].push_back({{"name", solid.layers()[layer].name}, {"colour", colourOf(layer)}});
  return result;
}

json PageSide::obstacleOf(std::size_t number, PageNumbers& numbers) const {
  const Obstacle& obstacle = scene_.scene.obstacles()[number];
  const Eigen::Quaterniond turn(obstacle.pose.rotation);
  json entry = {{"name", obstacle.name},
                {"position", millimetres(obstacle.pose.position)},
                {"turn", {turn.x(), turn.y(), turn.z(), turn.w()}},
                {"colour", obstacle.name == "gum" ? viewer::kGum : viewer::kEnamel}};
  if (std::holds_alternative<HalfSpace>(obstacle.shape)) entry["plane"] = true;
  if (const auto* box = std::get_if<Box>(&obstacle.shape)) entry["box"] = millimetres(box->half);
  if (const auto* sphere = std::get_if<Sphere>(&obstacle.shape)) entry["capsule"] = {1e3 * sphere->radius, 0.0};
  if (const auto* capsule = std::get_if<Capsule>(&obstacle.shape))
    entry["capsule"] = {1e3 * capsule->radius, 1e3 * capsule->halfLength};
  if (const auto* model = std::get_if<std::shared_ptr<const MeshModel>>(&obstacle.shape)) {
    const TriangleMesh mesh = presentMesh(**model);
    if (!mesh.triangles.empty())
      entry["mesh"] = meshOf(mesh.vertices, normalsOf(mesh),
                             viewer::toothColours(mesh, obstacle.name == "arch" ? viewer::kGumLine : viewer::kNoGum),
                             mesh.triangles, numbers);
  }
  if (number < copies_.size() && copies_[number].solid) entry["solid"] = solidOf(copies_[number], numbers);
  return entry;
}

json PageSide::finish(PageNumbers& numbers) {
  if (times_.empty()) throw Error(title_ + ": has no tick that can be shown");
  takeBricks(static_cast<float>(end_));
  const viewer::RendererLook* look = viewer::lookOf(title_);
  json side = {{"title", title_},
               {"colour", look != nullptr ? look->colour : viewer::kBrown},
               {"renderer", header_.renderer},
               {"period", header_.guard.period},
               {"end", end_},
               {"times", numbers.add(times_)},
               {"forces", numbers.add(forces_)},
               {"depths", numbers.add(depths_)},
               {"guards", numbers.add(guards_)},
               {"bucket", static_cast<double>(everyCurve_) * header_.guard.period}};
  if (drill_ != nullptr) side["removed"] = numbers.add(removed_);
  for (const auto& [name, curve] : {std::pair{"force", &force_}, {"depth", &depth_}})
    side[name] = {{"low", numbers.add(curve->low)}, {"high", numbers.add(curve->high)}};
  side["reasons"] = json::array();
  for (int i = 0; i < static_cast<int>(kGuardReasons); ++i)
    side["reasons"].push_back(toString(static_cast<GuardReason>(i)));
  if (isAsked_) return side;
  side["scene"] = scene_.name;
  side["start"] = millimetres(scene_.start);
  side["bur"] = drill_ != nullptr && scene_.bur ? scene_.bur->part : -1;
  side["poses"] = numbers.add(poses_);
  side["contacts"] = numbers.add(contacts_);
  for (int i = 0; i < scene_.tool.count; ++i) {
    const ToolPart& part = scene_.tool.parts[static_cast<std::size_t>(i)];
    side["tool"].push_back({{"a", millimetres(part.a)}, {"b", millimetres(part.b)}, {"radius", 1e3 * part.radius}});
  }
  side["obstacles"] = json::array();
  for (std::size_t i = 0; i < scene_.scene.obstacles().size(); ++i) side["obstacles"].push_back(obstacleOf(i, numbers));
  return side;
}

#ifdef ENAMEL_REPLAY_PAGE

namespace {

std::string compressed(const std::string& bytes) {
  z_stream stream{};
  constexpr int kGzip = 16 + MAX_WBITS, kMemory = 9;
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzip, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw Error("zlib cannot start");
  std::string result(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));  // zlib does not write to it
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  const int status = deflate(&stream, Z_FINISH);
  result.resize(stream.total_out);
  deflateEnd(&stream);
  if (status != Z_STREAM_END) throw Error("zlib cannot compress the recording");
  return result;
}

void put(std::string& page, const std::string& mark, const std::string& text) {
  const std::size_t at = page.find(mark);
  if (at == std::string::npos) throw Error("the template of the page has no " + mark);
  page.replace(at, mark.size(), text);
}

}  // namespace

void writeReplayPage(const std::string& path, const std::vector<json>& sides, const PageNumbers& numbers) {
  std::string head = json{{"sides", sides}}.dump();
  head.resize((head.size() + 3) / 4 * 4, ' ');
  const auto size = static_cast<std::uint32_t>(head.size());
  std::string data(sizeof(size), '\0');
  std::memcpy(data.data(), &size, sizeof(size));
  std::string page = kReplayPage;
  put(page, "/*STYLE*/", kReplayStyle);
  put(page, "/*DATA*/", base64(compressed(data + head + numbers.bytes())));
  put(page, "/*SCRIPT*/", kReplayScript);
  put(page, "/*THREE*/", kThree);
  writeFile(path, page);
}

void checkReplayPage() {}

#else

void writeReplayPage(const std::string&, const std::vector<json>&, const PageNumbers&) { checkReplayPage(); }

void checkReplayPage() {
  throw Error("--html: this enamel was built without three.js or zlib (Debian: libjs-three, zlib1g-dev)");
}

#endif

}  // namespace enamel::app
