// What a recording is of, and how that is built again.
#pragma once

#include <memory>

#include "enamel/collision/scene_file.hpp"
#include "enamel/device/mechanism.hpp"
#include "enamel/runtime/recording.hpp"

namespace enamel::app {

/// Completes a header with a renderer (`plugin`: its file, or empty) and the check of the files that it only names.
void nameRenderer(const std::string& renderer, const std::string& plugin,
                  const std::map<std::string, std::string>& parameters, const Scene& scene, RecordingHeader& header);

/// The device and the scene of a recording. Throws Error: as parseDevice() and parseScene().
std::shared_ptr<const Mechanism> recordedDevice(const RecordingHeader& header);
SceneFile recordedScene(const RecordingHeader& header);

/// Whether a file that the header names, a mesh or that of a servo, is another one now. Throws Error: the servo's
/// cannot be read.
bool filesHaveChanged(const RecordingHeader& header, const Scene& scene);

/// A renderer for a recording of that device: that of the recording, or another one by its name or path. Parameters are
/// those that were recorded, where it knows them, and `set`. Warns on stderr where a file that the header names has
/// changed. Throws Error: as findRenderer(), makeLinked() and makeRenderer(); a key that the renderer does not know.
std::unique_ptr<Renderer> recordedRenderer(const RecordingHeader& header,
                                           const std::shared_ptr<const Mechanism>& device, const Scene& scene,
                                           const std::string& renderer, const std::map<std::string, std::string>& set);

}  // namespace enamel::app
