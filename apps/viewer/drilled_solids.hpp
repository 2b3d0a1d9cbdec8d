// The solids of a scene while a bur drills them: material removed by each stroke, and undo.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "enamel/collision/solid_changes.hpp"

namespace enamel::viewer {

/// State of the drilling. Plain data.
struct DrillState {
  bool spins = false;
  double turns = 0.0;       ///< per second
  double feed = 0.0;        ///< m/s
  double chatter = 0.0;     ///< amplitude, m
  double pitch = 0.0;       ///< of the chatter, Hz
  RemovedVolume removed{};  ///< by layer, m^3; undone strokes do not count
  int strokes = 0;          ///< number of strokes that undo() can restore
};

/// Outlives the experiments on its scene, which are replaced when settings change. Belongs to the haptic thread; only
/// takeChange() belongs to the drawing thread. Realtime: all except the constructor.
class DrilledSolids {
 public:
  static constexpr int kStrokes = 64;

  explicit DrilledSolids(const SceneFile& scene);

  /// Begin a stroke: one undo() restores everything that is cut from now on.
  void beginStroke() noexcept;
  /// Add the removed volumes of one tick: m^3 by layer.
  void add(const RemovedVolume& removed) noexcept;
  /// Undo a stroke. Return false if nothing was cut, or if the stroke cut more than a solid keeps
  /// (SolidOptions::undoBricks).
  bool undo() noexcept;
  void restore() noexcept;
  /// Send changes to the drawing thread as far as there is room. Call it once per period.
  void publish() noexcept;

  const RemovedVolume& removed() const noexcept { return removed_; }
  int strokes() const noexcept { return strokes_ - (strokes_ > 0 && removed_ == before_[last()] ? 1 : 0); }

  /// Take a change of the obstacle's solid; the obstacle must have one. Drawing thread.
  bool takeChange(std::size_t obstacle, BrickChange& change) noexcept { return changes_[obstacle]->take(change); }

 private:
  std::size_t last() const noexcept { return static_cast<std::size_t>(strokes_ - 1); }

  std::vector<std::shared_ptr<Solid>> solids_;  // by obstacle; may be null
  std::vector<std::unique_ptr<SolidChanges>> changes_;
  RemovedVolume removed_{};
  std::array<RemovedVolume, kStrokes> before_{};  // removed volumes before each stroke
  int strokes_ = 0;
};

}  // namespace enamel::viewer
