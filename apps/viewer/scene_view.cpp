#include "scene_view.hpp"

#include <vtkCamera.h>

#include <algorithm>
#include <cmath>

#include "bur_shapes.hpp"
#include "bur_view.hpp"
#include "device_view.hpp"
#include "obstacle_view.hpp"

namespace enamel::viewer {
namespace {

constexpr double kArrowPerNewton = 0.003, kArrowHead = 0.010, kNormal = 0.025;  // m/N, m, m
constexpr double kMarkedFrom = 230.0;                         // mm: at smaller distances, marks of the contact shrink
constexpr double kSmallestForce = 0.1, kLargestForce = 40.0;  // N: range of the force arrow
constexpr std::size_t kShownContacts = 3;

}  // namespace

struct SceneView::Parts {
  Parts(vtkRenderer* renderer, vtkRenderer* above, const std::vector<Bar>& bars, const SceneFile& scene,
        const std::vector<SolidLayer>* layers, float scale);

  // Draw transparent parts last, with the reference pose first among them.
  void raiseFaded(vtkRenderer* renderer);
  void showHand(const SceneState& state);
  void showContacts(const SceneState& state, double size);
  void showForce(const SceneState& state, double size);

  ToolView tool, ghost;
  DeviceView device;
  Rod arrow, arrowHead, pull;
  Ball hand;
  std::vector<Rod> normals;
  std::vector<Ball> contacts;
  std::optional<ChipView> chips;
};

SceneView::Parts::Parts(vtkRenderer* renderer, vtkRenderer* above, const std::vector<Bar>& bars, const SceneFile& scene,
                        const std::vector<SolidLayer>* layers, float scale)
    : tool(renderer, scene.tool, scene.bur ? &*scene.bur : nullptr, {kPlatform, kHandle, kNeedle}),
      ghost(renderer, scene.tool, nullptr, {kReference, kReference, kReference, 0.25, 1.3}),
      device(renderer, bars, scale),
      arrow(above, 1.5, {kForce, 1.0, 0.1}),
      arrowHead(above, 3.8, {kForce, 1.0, 0.1}, true),
      pull(above, 1.0, {kHand, 1.0, 0.0}),
      hand(above, 6.0, {kHand, 1.0, 0.2}) {
  for (std::size_t i = 0; i < kShownContacts; ++i) {
    normals.emplace_back(above, 0.5, Finish{kInk, 1.0, 0.0});
    contacts.emplace_back(above, 2.2, Finish{kForce, 1.0, 0.1});
  }
  if (scene.bur && layers != nullptr) chips.emplace(renderer, *layers);
  raiseFaded(renderer);
}

void SceneView::Parts::raiseFaded(vtkRenderer* renderer) {
  for (vtkActor* actor : ghost.actors()) drawLast(renderer, actor);
  for (const auto& actors : {tool.actors(), device.actors()})
    for (vtkActor* actor : actors)
      if (actor->GetForceOpaque() != 0) drawLast(renderer, actor);
}

void SceneView::Parts::showHand(const SceneState& state) {
  hand.show(state.hand.has_value());
  pull.show(state.hand.has_value());
  if (!state.hand) return;
  const Vec3 grip = state.pose.rotation * Vec3(0.0, 0.0, kHandleEnd);
  hand.place(*state.hand + grip);
  pull.place(state.pose.position + grip, *state.hand + grip);
}

void SceneView::Parts::showContacts(const SceneState& state, double size) {
  for (std::size_t i = 0; i < kShownContacts; ++i) {
    const bool touching = i < state.touching.size();
    contacts[i].show(touching);
    normals[i].show(touching);
    if (!touching) continue;
    const Contact& contact = state.touching[i];
    const Vec3 surface = contact.point - contact.gap * contact.normal;
    contacts[i].place(surface, size);
    normals[i].place(surface, surface + size * kNormal * contact.normal, size);
  }
}

void SceneView::Parts::showForce(const SceneState& state, double size) {
  const double force = state.force.norm();
  const bool visible = !state.touching.empty() && force > kSmallestForce;
  arrow.show(visible);
  arrowHead.show(visible);
  if (!visible) return;
  const Vec3 along = state.force / force, from = state.pose.position;
  const Vec3 neck = from + size * kArrowPerNewton * std::min(force, kLargestForce) * along;
  arrow.place(from, neck, size);
  arrowHead.place(neck + size * kArrowHead * along, neck, size);
}

SceneView::SceneView(vtkRenderer* renderer, vtkRenderer* above) : renderer_(renderer), above_(above) {
  const Colour ground = colour(kGround);
  renderer->SetBackground(ground.r, ground.g, ground.b);
  renderer->SetAutomaticLightCreation(false);
  above->SetAutomaticLightCreation(false);
  above->SetActiveCamera(renderer->GetActiveCamera());
  for (vtkRenderer* lit : {renderer, above}) {
    addLight(lit, -0.9, 0.6, 1.0, 0.8);
    addLight(lit, 1.0, 0.5, 0.5, 0.6);
    addLight(lit, 0.0, 0.0, 1.0, 0.15);
  }
}

SceneView::~SceneView() = default;

void SceneView::build(const std::vector<Bar>& bars, const SceneFile& file, const std::vector<SolidCopy>& solids,
                      const std::optional<CutPlane>& plane, float scale) {
  renderer_->RemoveAllViewProps();
  above_->RemoveAllViewProps();
  movable_ = addObstacles(renderer_, file, solids, plane, scale);
  const std::vector<CutPlane> hidden = opaquePlanes(file.scene);
  solids_.clear();
  for (std::size_t i = 0; i < file.scene.obstacles().size(); ++i) {
    const Pose& pose = file.scene.obstacles()[i].pose;
    const bool has = i < solids.size() && solids[i].uncut;
    solids_.push_back(has ? std::make_unique<SolidView>(renderer_, solids[i], pose, plane, hidden, scale) : nullptr);
  }
  parts_ = std::make_unique<Parts>(renderer_, above_, bars, file, layersOf(solids), scale);
}

void SceneView::change(std::size_t obstacle, int brick) {
  if (obstacle < solids_.size() && solids_[obstacle]) solids_[obstacle]->change(brick);
}

void SceneView::update(const SceneState& state) {
  Parts& p = *parts_;
  p.device.place(state.bars, state.pose);
  p.tool.place(state.pose, state.burAngle);
  const bool whole = state.distance >= kDeviceFrom;
  p.device.show(whole);
  p.tool.showGrip(true, whole);
  const bool device = p.device.fadeBefore(state.eye, state.watched), tool = p.tool.fadeBefore(state.eye, state.watched);
  if (device || tool) p.raiseFaded(renderer_);
  for (const auto& solid : solids_)
    if (solid) solid->update();
  for (std::size_t i = 0; i < std::min(movable_.size(), state.movable.size()); ++i)
    if (state.movable[i]) movable_[i].place(*state.movable[i]);
  p.ghost.show(state.ghost.has_value());
  if (!whole) p.ghost.showGrip(false, false);
  if (state.ghost) p.ghost.place(*state.ghost, 0.0);
  if (p.chips && state.chips != nullptr) p.chips->show(*state.chips);
  p.showHand(state);
  const double size = std::pow(std::min(1.0, state.distance / kMarkedFrom), 1.4);
  p.showContacts(state, size);
  p.showForce(state, size);
}

void SceneView::look(const Camera& camera, double aspect) {
  vtkCamera* c = renderer_->GetActiveCamera();
  const glm::dvec3 eye = camera.eye();
  c->SetPosition(eye.x, eye.y, eye.z);
  c->SetFocalPoint(camera.focus.x, camera.focus.y, camera.focus.z);
  c->SetViewUp(0.0, 1.0, 0.0);
  c->SetViewAngle(glm::degrees(camera.height(aspect)));
  renderer_->ResetCameraClippingRange();
}

}  // namespace enamel::viewer
