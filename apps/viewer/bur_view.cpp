#include "bur_view.hpp"

#include <algorithm>
#include <cmath>

namespace enamel::viewer {
namespace {

const ToolPart& burOf(const SceneFile& scene) { return scene.tool.parts[static_cast<std::size_t>(scene.bur->part)]; }

// Return the centre of the bur's tip.
Vec3 tipOf(const SceneFile& scene, const Pose& tool) { return tool.position + tool.rotation * burOf(scene).a; }

// Return the distance to the nearest solid before any cut, m; very large without a solid.
double uncutDistance(const SceneFile& scene, const std::vector<SolidCopy>& solids, const Vec3& point) {
  double distance = 1.0;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    if (!solids[i].uncut) continue;
    const Pose& solid = scene.scene.obstacles()[i].pose;
    const Vec3 inSolid = solid.rotation.transpose() * (point - solid.position);
    distance = std::min(distance, signedDistance(*solids[i].uncut, inSolid).distance);
  }
  return distance;
}

// Return the load of a bur that cuts these volumes in `seconds`.
BurLoad loadOf(const RemovedVolume& cut, double seconds, const DrillState& drilled,
               const std::vector<SolidLayer>& layers) {
  BurLoad load;
  load.turns = drilled.turns;
  load.pitch = drilled.pitch;
  load.chatter = 2.0 * M_PI * drilled.pitch * drilled.chatter;
  double power = 0.0;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    load.removal += cut[i] / seconds;
    power += layers[i].hardness * cut[i] / seconds;
  }
  if (power > 0.0) load.hardness = power / load.removal;
  return load;
}

}  // namespace

const std::vector<SolidLayer>* layersOf(const std::vector<SolidCopy>& solids) {
  for (const SolidCopy& solid : solids)
    if (solid.uncut) return &solid.uncut->layers();
  return nullptr;
}

double burDepth(const SceneFile& scene, const std::vector<SolidCopy>& solids, const Pose& tool) {
  if (!scene.bur) return 0.0;
  return std::max(0.0, burOf(scene).radius - uncutDistance(scene, solids, tipOf(scene, tool)));
}

const char* BurView::update(const Frame& frame, const SceneFile& scene, const std::vector<SolidCopy>& solids,
                            bool isHeard) {
  constexpr double shownTurns = 1.7;  // per second: real speeds are too fast to see
  const DrillState& drilled = frame.drilled;
  if (frame.record.time < time_) chips_ = Chips();
  const double passed = std::max(0.0, frame.record.time - time_);
  time_ = frame.record.time;
  if (drilled.spins) angle_ += 2.0 * M_PI * shownTurns * passed;
  RemovedVolume cut{};
  for (std::size_t i = 0; i < cut.size(); ++i) cut[i] = std::max(0.0, drilled.removed[i] - removed_[i]);
  removed_ = drilled.removed;
  // Chips leave a hole at its mouth.
  const Vec3 axis = frame.record.pose.rotation.col(2);
  const double radius = burOf(scene).radius;
  Vec3 mouth = tipOf(scene, frame.record.pose);
  for (int i = 0; cut != RemovedVolume{} && i < 20; ++i) {
    const double left = 0.5 * radius - uncutDistance(scene, solids, mouth);
    if (left <= 0.0) break;
    mouth += std::max(0.1 * radius, left) * axis;
  }
  chips_.advance(passed, cut, mouth, axis, radius);

  if (isHeard && !sound_) sound_.emplace();
  if (!sound_ || (passed == 0.0 && !frame.paused)) return nullptr;  // keep the sound in slow motion
  const auto* const layers = layersOf(solids);
  const bool turns = isHeard && drilled.turns > 0.0 && !frame.paused && layers != nullptr;
  sound_->set(turns ? loadOf(cut, passed, drilled, *layers) : BurLoad());
  return sound_->trouble();
}

}  // namespace enamel::viewer
