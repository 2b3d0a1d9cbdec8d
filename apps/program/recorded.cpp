#include "program/recorded.hpp"

#include <fmt/core.h>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "program/plugin_folder.hpp"

namespace enamel::app {
std::shared_ptr<const Mechanism> recordedDevice(const RecordingHeader& header) {
  return makeMechanism(parseDevice(header.deviceText, header.deviceFile));
}

SceneFile recordedScene(const RecordingHeader& header) {
  if (!header.sceneText.empty()) return parseScene(header.sceneText, header.sceneFile);
  SceneFile scene;
  scene.scene = flatWall();
  return scene;
}

std::unique_ptr<Renderer> recordedRenderer(const RecordingHeader& header,
                                           const std::shared_ptr<const Mechanism>& device, const Scene& scene,
                                           const std::string& renderer, const std::map<std::string, std::string>& set) {
  const std::string own = header.plugin.empty() ? header.renderer : header.plugin;
  const RendererSource source = findRenderer(renderer.empty() ? own : renderer, pluginFolder());
  std::map<std::string, std::string> parameters = set;
  const auto knows = [&](const std::string& key) {
    if (!source.plugin) return true;
    const EnamelDescription& d = source.plugin->description();
    for (std::size_t i = 0; i < d.parameter_count; ++i)
      if (d.parameters[i].key == key) return true;
    return false;
  };
  for (const auto& [key, value] : header.parameters)
    if (knows(key)) parameters.emplace(key, value);
  if (filesHaveChanged(header, scene))
    fmt::print(stderr, "enamel: warning: a mesh or the servo file has changed since the recording was made\n");
  if (!source.plugin) return makeLinked(source.name, parameters, device, header.guard.period);
  return makeRenderer(source.plugin,
                      {header.deviceFile, header.deviceText, header.sceneFile, header.sceneText, parameters});
}

}  // namespace enamel::app
