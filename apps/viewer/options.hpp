// What the command line says.
#pragma once

#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <string>

#include "settings.hpp"

namespace enamel::viewer {

struct Options {
  std::string play;  ///< recording; or empty, then:
  std::string scene, device;
  std::string gain;  ///< file, or empty: loadServoedDevice()
  RendererSlot begin = RendererSlot::positionControl;
  std::shared_ptr<const PluginLibrary> plugin;  ///< or nullptr
  std::map<std::string, std::string> pluginParameters;
  bool headless = false, overwrite = false;
  std::string script, record, report;
  glm::ivec2 size{1280, 720};
  float scale = 1.0f;
  double frameRate = 60.0;  ///< of the window, 1/s, at most
  bool fixedStep = false;   ///< of the window: each picture takes 1 / frameRate of the script's time

  /// For pictures, clips and recordings.
  std::string folder() const { return record.empty() ? "." : record; }
};

}  // namespace enamel::viewer
