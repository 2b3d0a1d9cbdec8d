// The solids of a scene while a bur drills them: what was taken away, stroke by stroke, and how it comes back.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "enamel/collision/solid_changes.hpp"

namespace enamel::viewer {

/// What was drilled so far. Plain data.
struct DrillState {
  bool spins = false;
  double feed = 0.0;        ///< m/s
  RemovedVolume removed{};  ///< by layer, without what came back, m^3
  int strokes = 0;          ///< that undo() can bring back
};

/// Outlasts the experiments on its scene, which replace each other when settings change. Belongs to the thread that
/// ticks; only takeChange() is for the one that draws. Realtime: all but the constructor.
class DrilledSolids {
 public:
  static constexpr int kStrokes = 64;

  explicit DrilledSolids(const SceneFile& scene);

  /// What is cut from now on comes back with one undo().
  void beginStroke() noexcept;
  /// Of one tick: m^3 by layer.
  void add(const RemovedVolume& removed) noexcept;
  /// False: there is nothing, or more was cut than a solid keeps (SolidOptions::undoBricks).
  bool undo() noexcept;
  void restore() noexcept;
  /// Tells the thread that draws what has changed, as far as there is room: once a period.
  void publish() noexcept;

  const RemovedVolume& removed() const noexcept { return removed_; }
  int strokes() const noexcept { return strokes_ - (strokes_ > 0 && removed_ == before_[last()] ? 1 : 0); }

  /// Of the obstacle's solid; it must have one. Drawing thread.
  bool takeChange(std::size_t obstacle, BrickChange& change) noexcept { return changes_[obstacle]->take(change); }

 private:
  std::size_t last() const noexcept { return static_cast<std::size_t>(strokes_ - 1); }

  std::vector<std::shared_ptr<Solid>> solids_;  // by obstacle, or null
  std::vector<std::unique_ptr<SolidChanges>> changes_;
  RemovedVolume removed_{};
  std::array<RemovedVolume, kStrokes> before_{};  // what had been removed before each stroke
  int strokes_ = 0;
};

}  // namespace enamel::viewer
