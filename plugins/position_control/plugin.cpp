// The position servo of enamel::PositionControlRenderer as a plugin: its gain is designed on activation, for the
// period.
#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_design.hpp"
#include "enamel/plugin/author.hpp"
#include "enamel/render/position_control.hpp"

namespace {

const EnamelParameter kParameters[] = {
    {"release", "on", "on: the hold ends when the wall would pull; off: never"},
    {"release-force", "0.3", "pull at which the hold ends, N"},
    {"anti-windup", "off", "on: the integrators stop while a motor is saturated"},
};

class PositionControl {
 public:
  static const EnamelDescription& describe() noexcept {
    static const EnamelDescription description = {
        "position-control", "0.1.0", "A wall as a position servo: discrete LQR with integral action, mode hold",
        kParameters, std::size(kParameters)};
    return description;
  }

  explicit PositionControl(const enamel::PluginConfiguration& configuration)
      : model_(enamel::makeModel(configuration.device())) {
    options_.release = configuration.flag("release");
    options_.releaseForce = configuration.number("release-force", 0.0, 100.0, "N");
    options_.antiWindup = configuration.flag("anti-windup");
  }

  std::unique_ptr<enamel::Renderer> activate(double period) const {
    return std::make_unique<enamel::PositionControlRenderer>(
        model_, enamel::designServo(model_, enamel::Pose{}, period).K, period, options_);
  }

 private:
  enamel::TauModel model_;
  enamel::PositionControlOptions options_;
};

}  // namespace

ENAMEL_PLUGIN(PositionControl)
