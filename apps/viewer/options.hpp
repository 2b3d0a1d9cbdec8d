// Options of the command line.
#pragma once

#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <string>

#include "enamel/render/guard.hpp"
#include "settings.hpp"

namespace enamel::viewer {

struct Options {
  std::string play;                           ///< recording; if empty, the following apply:
  std::string scene, device;                  ///< device: file, or URL of a connected device
  std::string renderer = "position-control";  ///< of a connected device, as in SessionDef
  double maxForce = kUnlimited;               ///< of a connected device, as in SessionDef, N
  std::string target;                         ///< file: how the first solid should be cut; may be empty
  std::string gain;                           ///< file; empty: see loadServoedDevice()
  RendererSlot begin = RendererSlot::positionControl;
  std::shared_ptr<const PluginLibrary> plugin;  ///< may be nullptr
  std::map<std::string, std::string> pluginParameters;
  bool headless = false, overwrite = false;
  std::string script, record, report;
  glm::ivec2 size{1280, 720};
  float scale = 1.0f;
  double frameRate = 60.0;  ///< largest frame rate of the window, 1/s
  bool fixedStep = false;   ///< in a window: each picture advances the script by 1 / frameRate

  /// Return the folder for pictures, clips and recordings.
  std::string folder() const { return record.empty() ? "." : record; }
};

}  // namespace enamel::viewer
