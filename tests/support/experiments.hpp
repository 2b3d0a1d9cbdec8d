// Experiments of the viewer for tests, and a tooth that they drill.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "servoed_device.hpp"
#include "support/devices.hpp"
#include "support/meshes.hpp"

namespace enamel::viewer::fixture {

const ServoedDevice& nominal();

SceneFile shipped(const std::string& name);

Hand handAt(const Vec3& position);

std::unique_ptr<Experiment> experiment(const SceneFile& scene, RendererSlot slot, const Settings& settings = {},
                                       const ServoedDevice& device = nominal());

// Return a block of enamel on dentine, with a ball that cuts it.
SceneFile tooth();

std::vector<BrickSamples> samplesOf(const Solid& solid);

}  // namespace enamel::viewer::fixture
