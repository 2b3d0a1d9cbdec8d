#include "bur_view.hpp"

#include <algorithm>

namespace enamel::viewer {
namespace {

const ToolPart& burOf(const SceneFile& scene) { return scene.tool.parts[static_cast<std::size_t>(scene.bur->part)]; }

// Centre of the bur's tip.
Vec3 tipOf(const SceneFile& scene, const Pose& tool) { return tool.position + tool.rotation * burOf(scene).a; }

// From the nearest solid as it was before anything was cut, m; none is far.
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

// What is cut in so many seconds.
BurLoad loadOf(const RemovedVolume& cut, double seconds, double turns, const std::vector<SolidLayer>& layers) {
  BurLoad load;
  load.turns = turns;
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
  constexpr double shownTurns = 1.7;  // a second: those of a bur are too fast to be seen
  const DrillState& drilled = frame.drilled;
  if (frame.record.time < time_) chips_ = Chips();
  const double passed = std::max(0.0, frame.record.time - time_);
  time_ = frame.record.time;
  if (drilled.spins) angle_ += 6.283185307179586 * shownTurns * passed;
  RemovedVolume cut{};
  for (std::size_t i = 0; i < cut.size(); ++i) cut[i] = std::max(0.0, drilled.removed[i] - removed_[i]);
  removed_ = drilled.removed;
  // Out of a hole chips come at its mouth.
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
  if (!sound_ || (passed == 0.0 && !frame.paused)) return nullptr;  // in slow motion it goes on
  const auto* const layers = layersOf(solids);
  const bool turns = isHeard && drilled.spins && !frame.paused && layers != nullptr;
  sound_->set(turns ? loadOf(cut, passed, scene.bur->turns, *layers) : BurLoad());
  return sound_->trouble();
}

}  // namespace enamel::viewer
