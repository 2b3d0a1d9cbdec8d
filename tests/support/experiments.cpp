#include "support/experiments.hpp"

namespace enamel::viewer::fixture {

const ServoedDevice& nominal() {
  static const ServoedDevice device = loadServoedDevice(test::deviceFile("tau-nominal.toml"));
  return device;
}

SceneFile shipped(const std::string& name) { return loadScene(ENAMEL_SOURCE_DIR "/data/scenes/" + name); }

Hand handAt(const Vec3& position) {
  Hand hand;
  hand.target = hand.position = position;
  return hand;
}

std::unique_ptr<Experiment> experiment(const SceneFile& scene, RendererSlot slot, const Settings& settings,
                                       const ServoedDevice& device) {
  Pose start;
  start.position = scene.start;
  return std::make_unique<Experiment>(device, settings, scene, start, handAt(scene.start), slot);
}

SceneFile tooth() {
  SceneFile file;
  file.start = {0.0, 0.0, 2e-4};
  file.tool.parts[0].a = file.tool.parts[0].b = {0.0, 0.0, 1e-3};
  file.tool.parts[0].radius = 1e-3;
  const auto solid = std::make_shared<Solid>(
      MeshModel(test::boxMesh(Vec3(4e-3, 4e-3, 3e-3))),
      std::vector<SolidLayer>{{"enamel", {}, 3.4e9, 0.0, nullptr}, {"dentine", {}, 0.6e9, 5e-4, nullptr}},
      SolidOptions{2e-4});
  Pose pose;
  pose.position = {0.0, 0.0, -3e-3};
  file.scene.add({"tooth", std::shared_ptr<const Solid>(solid), pose, Vec6::Zero(), {}});
  file.solids = {solid};
  file.bur = Bur{0, 1.0, 2000.0};
  return file;
}

std::vector<BrickSamples> samplesOf(const Solid& solid) {
  std::vector<BrickSamples> all;
  for (int brick = 0; brick < solid.bricks(); ++brick) all.push_back(solid.samples(brick));
  return all;
}

}  // namespace enamel::viewer::fixture
