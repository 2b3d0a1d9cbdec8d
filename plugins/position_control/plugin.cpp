// The position servo of enamel::PositionControlRenderer as a plugin: its gain comes from a file, or is designed on
// activation, for the period.
#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_file.hpp"
#include "enamel/plugin/author.hpp"
#include "enamel/render/position_control.hpp"

namespace {

const EnamelParameter kParameters[] = {
    {"gain", "designed", "file of a servo (enamel design --output), or designed: for the device at home"},
    {"release", "on", "on: the hold ends when the wall would pull; off: never"},
    {"release-force", "0.3", "pull at which the hold ends, N"},
    {"anti-windup", "off", "on: the integrators stop while a motor is saturated"},
};

class PositionControl {
 public:
  static const EnamelDescription& describe() noexcept {
    static const EnamelDescription description = {
        "position-control", "0.2.0", "A wall as a position servo: discrete LQR with integral action, mode hold",
        kParameters, std::size(kParameters)};
    return description;
  }

  explicit PositionControl(const enamel::PluginConfiguration& configuration)
      : mechanism_(enamel::makeMechanism(configuration.device())) {
    if (const std::string& gain = configuration.text("gain"); gain != "designed") servo_ = enamel::loadServo(gain);
    options_.release = configuration.flag("release");
    options_.releaseForce = configuration.number("release-force", 0.0, 100.0, "N");
    options_.antiWindup = configuration.flag("anti-windup");
  }

  std::unique_ptr<enamel::Renderer> activate(double period) const {
    const enamel::ServoFile servo =
        servo_ ? *servo_ : enamel::ServoFile{"", period, enamel::designServo(mechanism_, enamel::Pose{}, period).K};
    return std::make_unique<enamel::PositionControlRenderer>(servo.gain, servo.period, options_);
  }

 private:
  std::shared_ptr<const enamel::Mechanism> mechanism_;
  std::optional<enamel::ServoFile> servo_;
  enamel::PositionControlOptions options_;
};

}  // namespace

ENAMEL_PLUGIN(PositionControl)
