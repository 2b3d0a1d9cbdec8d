// A plant as a unit.
#pragma once

#include "enamel/sim/plant_maker.hpp"
#include "unit.hpp"

namespace enamel::fmi {

/// Inputs are the motors' torques and the person's force. They are constant over a step of any length.
class PlantUnit final : public Unit {
 public:
  /// Throws Error: as makerOf().
  PlantUnit(const UnitConfiguration& configuration, const DeviceParameters& parameters);

  void begin() override;
  void step(double step) override;

  std::unique_ptr<UnitState> copyState() const override;
  void putState(const UnitState& state) override;

 private:
  struct Saved;

  void show();  // write the outputs

  MakePlant make_;
  std::unique_ptr<Plant> plant_;
  Pose start_;
  Vec3 normal_ = Vec3::UnitZ();
};

}  // namespace enamel::fmi
