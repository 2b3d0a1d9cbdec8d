#include "drilled_solids.hpp"

#include <algorithm>

namespace enamel::viewer {

DrilledSolids::DrilledSolids(const SceneFile& scene) : solids_(scene.solids) {
  for (const auto& solid : solids_) changes_.push_back(solid ? std::make_unique<SolidChanges>() : nullptr);
}

void DrilledSolids::beginStroke() noexcept {
  if (strokes_ > 0 && removed_ == before_[last()]) return;  // the last stroke removed nothing
  if (strokes_ == kStrokes) {
    std::copy(before_.begin() + 1, before_.end(), before_.begin());
    --strokes_;
  }
  before_[static_cast<std::size_t>(strokes_++)] = removed_;
  for (const auto& solid : solids_)
    if (solid) solid->mark();
}

void DrilledSolids::add(const RemovedVolume& removed) noexcept {
  for (std::size_t i = 0; i < removed.size(); ++i) removed_[i] += removed[i];
}

bool DrilledSolids::undo() noexcept {
  while (strokes_ > 0 && removed_ == before_[last()]) --strokes_;
  if (strokes_ == 0) return false;
  bool undone = false;
  for (const auto& solid : solids_) undone = (solid && solid->undo()) || undone;
  if (!undone) {
    strokes_ = 0;  // older strokes cannot be undone either
    return false;
  }
  removed_ = before_[last()];
  --strokes_;
  return true;
}

void DrilledSolids::restore() noexcept {
  for (const auto& solid : solids_)
    if (solid) solid->restore();
  removed_ = RemovedVolume{};
  strokes_ = 0;
}

void DrilledSolids::publish() noexcept {
  for (std::size_t i = 0; i < solids_.size(); ++i)
    if (solids_[i]) changes_[i]->publish(*solids_[i]);
}

}  // namespace enamel::viewer
