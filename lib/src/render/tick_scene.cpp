#include "enamel/render/tick_scene.hpp"

#include <utility>

#include "enamel/render/roughness.hpp"
#include "enamel/render/tap_transient.hpp"

namespace enamel {
namespace {

bool isSame(const Tool& a, const Tool& b) noexcept {
  if (a.count != b.count) return false;
  for (int k = 0; k < a.count; ++k) {
    const ToolPart& p = a.parts[static_cast<std::size_t>(k)];
    const ToolPart& q = b.parts[static_cast<std::size_t>(k)];
    if (p.a != q.a || p.b != q.b || p.radius != q.radius) return false;
  }
  return true;
}

}  // namespace

TickScene::TickScene(const Scene& scene, const Tool& tool)
    : stated_(&scene),
      tool_(tool),
      motion_(scene),
      compliance_(scene),
      track_(makeToolTrack(scene, tool)),
      hasTaps_(enamel::hasTaps(scene)),
      isRough_(enamel::isRough(scene)) {}

Status TickScene::findContacts(const Pose& pose, double time, double elapsed, const PartRange& bur, double recession,
                               ContactSnapshot& contacts) noexcept {
  const Scene& now = motion_.follow(*stated_, time, elapsed);
  compliance_.letIn(tool_, track_);
  const Status status = followContacts(now, tool_, pose, kContactMargin, track_, contacts);
  compliance_.enter(now, tool_, bur, recession * elapsed, contacts);
  return status;
}

void TickScene::takeOver(TickScene& old) noexcept {
  motion_.takeOver(old.motion_);
  if (!isSame(tool_, old.tool_)) return;
  track_.takeOver(old.track_, old.motion_.scene(), motion_.scene());
  compliance_.takeOver(old.compliance_, old.motion_.scene(), motion_.scene());
}

void TickScene::saveState(double* state) const noexcept {
  motion_.saveState(state);
  state += motion_.stateSize();
  track_.saveState(motion_.scene(), state);
  compliance_.saveState(state + track_.stateSize());
}

void TickScene::loadState(const double* state) noexcept {
  reset();
  motion_.loadState(state);
  state += motion_.stateSize();
  track_.loadState(motion_.scene(), state);
  compliance_.loadState(state + track_.stateSize());
}

}  // namespace enamel
