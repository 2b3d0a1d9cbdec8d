// A plant as a unit.
#pragma once

#include "enamel/sim/plant_maker.hpp"
#include "unit.hpp"

namespace enamel::fmi {

/// Inputs are the torques of the motors and the force of the person, held over a step of any length.
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

  void show();  // outputs

  MakePlant make_;
  std::unique_ptr<Plant> plant_;
  Pose start_;
  Vec3 normal_ = Vec3::UnitZ();
};

}  // namespace enamel::fmi
