// A haptic tick as a unit: contacts, renderer, guard.
#pragma once

#include <optional>

#include "enamel/collision/scene_file.hpp"
#include "enamel/render/tick.hpp"
#include "unit.hpp"

namespace enamel::fmi {

/// Inputs are the measurements of a device; outputs depend on them directly. Each step is one period.
class RendererUnit final : public Unit {
 public:
  /// Throws Error: as makeLinked().
  RendererUnit(const UnitConfiguration& configuration, const DeviceParameters& parameters, SceneFile scene);

  void begin() override;
  void step(double step) override;

  std::unique_ptr<UnitState> copyState() const override;
  void putState(const UnitState& state) override;
  std::string bytesOf(const UnitState& state) const override;
  std::unique_ptr<UnitState> stateOf(const std::string& bytes) const override;

 private:
  struct Saved;

  void refresh() override;
  void makeTick();

  SceneFile scene_;
  std::unique_ptr<Renderer> renderer_;
  std::optional<HapticTick> tick_;
  std::vector<char> before_;  // state of the tick at the communication point
  std::uint64_t number_ = 0;  // number of the tick
};

}  // namespace enamel::fmi
