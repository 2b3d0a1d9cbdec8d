#include "device_view.hpp"

#include <vtkActorCollection.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "obstacle_view.hpp"

namespace enamel::viewer {
namespace {

// Sizes of parts that no device file contains, m (radii of Rods in mm).
constexpr double kMotorHeight = 0.030, kHub = 0.020, kNeedleLength = 0.032;

Vec3 inPlatform(const Pose& pose, const Vec3& local) { return pose.position + pose.rotation * local; }

bool hasChains(const std::vector<Bar>& bars) {
  return std::any_of(bars.begin(), bars.end(), [](const Bar& bar) { return bar.chain >= 0; });
}

bool isLastOfChain(const std::vector<Bar>& bars, std::size_t i) {
  return i + 1 == bars.size() || bars[i + 1].chain != bars[i].chain;
}

bool isFirstOfChain(const std::vector<Bar>& bars, std::size_t i) {
  return i == 0 || bars[i - 1].chain != bars[i].chain;
}

// Draw the frame that carries three chains' motors: a beam through the two lower ones, and a mast from it to the upper
// one.
void addColumn(vtkRenderer* renderer, std::vector<Vec3> bases) {
  if (bases.size() != 3) return;
  std::stable_sort(bases.begin(), bases.end(), [](const Vec3& a, const Vec3& b) { return a.y() < b.y(); });
  const Vec3 top = bases[2], foot = 0.5 * (bases[0] + bases[1]), mast(foot.x(), foot.y(), top.z());
  Rod(renderer, 6.0, {kColumn}).place(bases[0], bases[1]);
  Rod(renderer, 6.0, {kColumn}).place(foot, mast);
  Rod(renderer, 7.5, {kColumn}).place(mast - Vec3(0.0, 0.02, 0.0), top + Vec3(0.0, 0.03, 0.0));
  Ball(renderer, 7.5, {kColumn}).place(mast);
}

}  // namespace

ToolView::ToolView(vtkRenderer* renderer, const Tool& tool, const Bur* cutting, const ToolLook& look)
    : parts_(tool.parts.begin(), tool.parts.begin() + tool.count),
      beyond_(1e-3 * (look.growth - 1.0)),
      handle_(renderer, 3.6 * look.growth, {look.grip, look.opacity, 0.35}),
      hub_(renderer, 8.5 * look.growth, {look.body, look.opacity}) {
  if (cutting != nullptr) {
    burPart_ = parts_[static_cast<std::size_t>(cutting->part)];
    parts_.erase(parts_.begin() + cutting->part);
    bur_.emplace(renderer, kMillimetres * burPart_.radius, kMillimetres * (burPart_.b - burPart_.a).norm());
  }
  parts_.erase(std::remove_if(parts_.begin(), parts_.end(), [](const ToolPart& part) { return part.radius == 0.0; }),
               parts_.end());
  for (const ToolPart& part : parts_)
    solids_.emplace_back(renderer, kMillimetres * part.radius * look.growth, Finish{look.tip, look.opacity, 0.4});
  if (parts_.empty() && !bur_) needle_.emplace_back(renderer, 2.6 * look.growth, Finish{look.tip, look.opacity}, true);
}

void ToolView::place(const Pose& pose, double burAngle) {
  if (bur_) {
    const Vec3 along = burPart_.b - burPart_.a;
    const Vec3 axis = along.norm() > 0.0 ? Vec3(along.normalized()) : Vec3::UnitZ();
    const Mat3 turned = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), axis).toRotationMatrix();
    bur_->place(inPlatform(pose, burPart_.a), pose.rotation * turned, burAngle);
  }
  for (std::size_t i = 0; i < parts_.size(); ++i)
    solids_[i].place(inPlatform(pose, parts_[i].a), inPlatform(pose, parts_[i].b));
  for (Rod& rod : needle_) rod.place(pose.position, inPlatform(pose, {0.0, 0.0, kNeedleLength}));
  const auto from = [&](double low, double high, Rod& rod) {
    rod.place(inPlatform(pose, {0.0, 0.0, low - beyond_}), inPlatform(pose, {0.0, 0.0, high + beyond_}));
  };
  from(kHub, kHandleEnd, handle_);
  from(kHub - 0.003, kHub + 0.004, hub_);
}

void ToolView::show(bool visible) {
  for (CapsuleSolid& solid : solids_) solid.show(visible);
  for (Rod& rod : needle_) rod.show(visible);
  for (Rod* rod : {&handle_, &hub_}) rod->show(visible);
}

std::vector<vtkActor*> ToolView::actors() const {
  std::vector<vtkActor*> all{handle_.actor(), hub_.actor()};
  for (const CapsuleSolid& solid : solids_)
    for (vtkActor* actor : solid.actors()) all.push_back(actor);
  for (const Rod& rod : needle_) all.push_back(rod.actor());
  return all;
}

bool ToolView::fadeBefore(const Vec3& eye, const Vec3& point) {
  const bool handle = handle_.fadeBefore(eye, point), hub = hub_.fadeBefore(eye, point);
  return handle || hub;
}

DeviceView::DeviceView(vtkRenderer* renderer, const std::vector<Bar>& bars, float scale) {
  const int others = renderer->GetActors()->GetNumberOfItems();
  std::vector<Vec3> bases;
  const bool chains = hasChains(bars);
  for (std::size_t i = 0; i < bars.size(); ++i) {
    if (bars[i].chain < 0) {
      if (chains)
        arms_.push_back({Rod(renderer, 2.6, {kPlatform}), Rod(renderer, 2.6, {kPlatform})});
      else
        axes_.emplace_back(renderer, 1.2, Finish{kLink2});
      continue;
    }
    const bool first = isFirstOfChain(bars, i), last = isLastOfChain(bars, i);
    links_.push_back({Rod(renderer, first ? 5.0 : 3.6, {first ? kLink1 : kLink2}),
                      last ? Ball(renderer, 5.2, {kMotor, 1.0, 0.4}) : Ball(renderer, 6.5, {kMotor})});
    if (!first) continue;
    const Vec3 base = bars[i].from, y(0.0, 0.5 * kMotorHeight, 0.0);
    Rod(renderer, 11.5, {kMotor}).place(base - y, base + y);
    Rod(renderer, 8.0, {kLink1}).place(base + y, base + y + Vec3(0.0, 0.005, 0.0));
    bases.push_back(base);
  }
  addColumn(renderer, bases);
  addWorkspace(renderer, scale);
  vtkActorCollection* const actors = renderer->GetActors();
  for (int i = others; i < actors->GetNumberOfItems(); ++i)
    all_.push_back(vtkActor::SafeDownCast(actors->GetItemAsObject(i)));
}

void DeviceView::show(bool visible) {
  for (vtkActor* actor : all_) actor->SetVisibility(visible);
}

void DeviceView::place(const std::vector<Bar>& bars, const Pose& pose) {
  std::size_t link = 0, arm = 0, axis = 0;
  for (const Bar& bar : bars) {
    if (bar.chain >= 0) {
      links_[link].rod.place(bar.from, bar.to);
      links_[link++].joint.place(bar.to);
    } else if (arms_.empty()) {
      axes_[axis++].place(bar.from, bar.to);
    } else {
      const Vec3 corner = pose.rotation.transpose() * (bar.from - pose.position);
      const Vec3 bend = inPlatform(pose, {corner.x(), corner.y(), kHub});
      arms_[arm].arm.place(inPlatform(pose, {0.0, 0.0, kHub}), bend);
      arms_[arm++].post.place(bend, bar.from);
    }
  }
}

bool DeviceView::fadeBefore(const Vec3& eye, const Vec3& point) {
  bool changes = false;
  const auto fade = [&](auto& one) { changes |= one.fadeBefore(eye, point); };
  for (Link& one : links_) {
    fade(one.rod);
    fade(one.joint);
  }
  for (Arm& one : arms_) {
    fade(one.arm);
    fade(one.post);
  }
  return changes;
}

std::vector<vtkActor*> DeviceView::actors() const {
  std::vector<vtkActor*> all;
  for (const Link& link : links_) all.insert(all.end(), {link.rod.actor(), link.joint.actor()});
  for (const Arm& arm : arms_) all.insert(all.end(), {arm.arm.actor(), arm.post.actor()});
  return all;
}

}  // namespace enamel::viewer
