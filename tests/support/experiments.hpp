// The viewer's experiments as tests begin them, and a tooth that they drill.
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

// A block of enamel on dentine, and a ball that cuts it.
SceneFile tooth();

std::vector<BrickSamples> samplesOf(const Solid& solid);

}  // namespace enamel::viewer::fixture
