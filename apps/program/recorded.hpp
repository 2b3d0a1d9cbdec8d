// Builds device, scene and renderer of a recording again.
#pragma once

#include <memory>

#include "enamel/collision/scene_file.hpp"
#include "enamel/device/mechanism.hpp"
#include "enamel/runtime/recording.hpp"

namespace enamel::app {

/// Return the device of a recording, or its scene. Throws Error: as parseDevice() and parseScene().
std::shared_ptr<const Mechanism> recordedDevice(const RecordingHeader& header);
SceneFile recordedScene(const RecordingHeader& header);

/// Return a renderer for a recording of that device: the recorded one, or another one by name or path. Its parameters
/// are the recorded ones that it knows, and `set`. Prints a warning on stderr if a file that the header names has
/// changed. Throws Error: as findRenderer(), makeLinked() and makeRenderer(); the renderer does not know a key of
/// `set`.
std::unique_ptr<Renderer> recordedRenderer(const RecordingHeader& header,
                                           const std::shared_ptr<const Mechanism>& device, const Scene& scene,
                                           const std::string& renderer, const std::map<std::string, std::string>& set);

}  // namespace enamel::app
