// enamel::PositionControlRenderer (mode surface) and enamel::HoldRenderer (mode hold) as a plugin.
#include <cmath>

#include "enamel/control/device_plant.hpp"
#include "enamel/control/servo_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/plugin/author.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/render/position_control.hpp"

namespace {

const EnamelParameter kParameters[] = {
    {"mode", "surface",
     "surface: a servo in contact space; hold: the paper's servo, which sticks to the point of touch"},
    {"gain", "designed", "servo of hold: file of enamel design, or designed: for the device at home"},
    {"delay", "0", "delay of the command for surface, the smallest, ticks"},
    {"delay-high", "same", "the same, the largest, ticks; same: as delay"},
    {"drive", "device",
     "drives known to surface. device: cables, motor lag and friction as in [imperfections]; rigid: without cables; "
     "ideal: none of these"},
    {"release", "on", "hold ends when the wall would pull; off: it never ends"},
    {"release-force", "0.3", "pull at which hold ends, N"},
    {"anti-windup", "off", "the integrators of hold stop while a motor is saturated"},
};

[[noreturn]] void refuse(const char* key, const std::string& problem) {
  throw enamel::ConfigurationError("plugin parameters", 0, key, problem);
}

int ticksOf(const enamel::PluginConfiguration& configuration, const char* key) {
  const double ticks = configuration.number(key, 0.0, enamel::kMaxLoopDelay, "ticks");
  if (ticks != std::floor(ticks)) refuse(key, "is " + configuration.text(key) + ", must be a whole number of ticks");
  return static_cast<int>(ticks);
}

class PositionControl {
 public:
  static constexpr bool kNeedsInertia = true;

  static const EnamelDescription& describe() noexcept {
    static const EnamelDescription description = {
        "position-control", "0.3.0", "A wall as a position servo, in contact space or as in the paper (hold)",
        kParameters, std::size(kParameters)};
    return description;
  }

  explicit PositionControl(const enamel::PluginConfiguration& configuration) {
    const std::string &mode = configuration.text("mode"), &gain = configuration.text("gain"),
                      &drive = configuration.text("drive");
    if (mode != "surface" && mode != "hold") refuse("mode", "is \"" + mode + "\", must be surface or hold");
    if (drive != "device" && drive != "rigid" && drive != "ideal")
      refuse("drive", "is \"" + drive + "\", must be device, rigid or ideal");
    surface_ = mode == "surface";
    enamel::DeviceParameters device = configuration.device();
    if (drive == "rigid") enamel::stiffenCables(device);
    if (drive == "ideal") device = enamel::idealOf(device);
    mechanism_ = enamel::makeMechanism(device);
    low_ = ticksOf(configuration, "delay");
    high_ = configuration.text("delay-high") == "same" ? low_ : ticksOf(configuration, "delay-high");
    hold_.release = configuration.flag("release");
    hold_.releaseForce = configuration.number("release-force", 0.0, 100.0, "N");
    hold_.antiWindup = configuration.flag("anti-windup");
    if (surface_ && gain != "designed") refuse("gain", "is only for mode hold: mode surface does not need a file");
    if (gain != "designed") servo_ = enamel::loadServo(gain);
    if (surface_) enamel::PositionControlRenderer{enamel::positionControlFor(*mechanism_, 1e-3, low_, high_)};
  }

  std::unique_ptr<enamel::Renderer> activate(double period) const {
    if (surface_)
      return std::make_unique<enamel::PositionControlRenderer>(
          enamel::positionControlFor(*mechanism_, period, low_, high_));
    const enamel::ServoFile servo =
        servo_ ? *servo_ : enamel::ServoFile{"", period, enamel::designServo(mechanism_, enamel::Pose{}, period).K};
    return std::make_unique<enamel::HoldRenderer>(servo.gain, servo.period, hold_);
  }

 private:
  std::shared_ptr<const enamel::Mechanism> mechanism_;
  bool surface_ = true;
  int low_ = 0, high_ = 0;                  // delay, ticks
  std::optional<enamel::ServoFile> servo_;  // given servo of mode hold
  enamel::HoldOptions hold_;
};

}  // namespace

ENAMEL_PLUGIN(PositionControl)
