// Visible and audible effects of a bur: its rotation, chips and sound.
#pragma once

#include <optional>
#include <vector>

#include "chips.hpp"
#include "experiment.hpp"
#include "solid_view.hpp"
#include "sound_output.hpp"

namespace enamel::viewer {

/// Return the layers of the first solid, or nullptr.
const std::vector<SolidLayer>* layersOf(const std::vector<SolidCopy>& solids);

/// Return the depth of the bur's tip below the uncut solids, m; 0 if it is outside or the scene has no bur.
double burDepth(const SceneFile& scene, const std::vector<SolidCopy>& solids, const Pose& tool);

class BurView {
 public:
  /// Process the time since the last frame. The scene must have a bur. Return the reason why nothing is heard although
  /// `isHeard` is set, or nullptr.
  const char* update(const Frame& frame, const SceneFile& scene, const std::vector<SolidCopy>& solids, bool isHeard);
  /// End the sound.
  void silence() { sound_.reset(); }

  double angle() const { return angle_; }  ///< rotation so far, rad
  const Chips& chips() const { return chips_; }

 private:
  double time_ = 0.0;        // of the last frame, s
  RemovedVolume removed_{};  // at that time, m^3
  double angle_ = 0.0;
  Chips chips_;
  std::optional<SoundOutput> sound_;  // exists since the sound was first requested
};

}  // namespace enamel::viewer
