// What is seen and heard of a bur that cuts: how it turns, its chips, its sound.
#pragma once

#include <optional>
#include <vector>

#include "chips.hpp"
#include "experiment.hpp"
#include "solid_view.hpp"
#include "sound_output.hpp"

namespace enamel::viewer {

/// Layers of the first solid, or nullptr.
const std::vector<SolidLayer>* layersOf(const std::vector<SolidCopy>& solids);

/// How deep the tip of a scene's bur is below the uncut solids, m; 0: outside, or there is no bur.
double burDepth(const SceneFile& scene, const std::vector<SolidCopy>& solids, const Pose& tool);

class BurView {
 public:
  /// What happened between the frame before and this one. The scene has a bur. Why nothing is heard although
  /// `isHeard`, or nullptr.
  const char* update(const Frame& frame, const SceneFile& scene, const std::vector<SolidCopy>& solids, bool isHeard);
  /// Ends the sound.
  void silence() { sound_.reset(); }

  double angle() const { return angle_; }  ///< that it has turned, rad
  const Chips& chips() const { return chips_; }

 private:
  double time_ = 0.0;        // of the frame before, s
  RemovedVolume removed_{};  // then, m^3
  double angle_ = 0.0;
  Chips chips_;
  std::optional<SoundOutput> sound_;  // since it was first wanted
};

}  // namespace enamel::viewer
