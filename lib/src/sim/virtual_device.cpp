#include "enamel/sim/virtual_device.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/assert.hpp"
#include "core/message.hpp"

namespace enamel {
namespace {

const VirtualDeviceSetup& checked(const VirtualDeviceSetup& setup) {
  checkVirtualDevice(setup);
  return setup;
}

Kinematics started(Plant* plant, const Pose& start) {
  require(plant != nullptr, "virtual device: the plant is missing");
  Kinematics kinematics;
  Status status = plant->start(start);
  if (status == Status::ok) status = plant->mechanism().reach(start, Vec6::Zero(), false, kinematics);
  require(status == Status::ok, std::string("the start pose is ") + toString(status));
  return kinematics;
}

}  // namespace

std::optional<Delay> readDelay(std::string_view text) noexcept {
  constexpr std::string_view kTo = "..";
  const auto number = [](std::string_view digits, int& value) {
    const char* const end = digits.data() + digits.size();
    const auto [rest, error] = std::from_chars(digits.data(), end, value);
    return error == std::errc{} && rest == end;
  };
  const std::size_t to = text.find(kTo);
  const bool isRange = to != std::string_view::npos;
  Delay delay;
  if (!number(text.substr(0, to), delay.low)) return std::nullopt;
  if (!number(isRange ? text.substr(to + kTo.size()) : text, delay.high)) return std::nullopt;
  return delay;
}

std::string toText(const Delay& delay) {
  return std::to_string(delay.low) + (delay.high > delay.low ? ".." + std::to_string(delay.high) : "");
}

Encoders::Encoders(const EncoderOptions& options, const JointVector& encoderStep, double period) noexcept
    : options_(options),
      encoderStep_(encoderStep),
      period_(period),
      gain_(options.rates == RateSource::lowPass ? -std::expm1(-2.0 * M_PI * options.cutoff * period) : 1.0),
      last_(JointVector::Zero(encoderStep.size())),
      filtered_(last_) {}

void Encoders::measure(const JointVector& q, const JointVector& rates, Measurement& measurement) noexcept {
  measurement.q = q;
  measurement.rates = rates;
  if (options_.quantised)
    for (Eigen::Index i = 0; i < q.size(); ++i)
      measurement.q[i] = encoderStep_[i] * std::nearbyint(q[i] / encoderStep_[i]);
  if (options_.rates == RateSource::exact) return;
  if (started_) filtered_ += gain_ * ((measurement.q - last_) / period_ - filtered_);
  started_ = true;
  last_ = measurement.q;
  measurement.rates = filtered_;
}

Motors::Motors(const Delay& delay, const JointVector& initial) noexcept : delay_(delay), initial_(initial) {
  ENAMEL_ASSERT(delay.low >= 0 && delay.low <= delay.high && delay.high <= kMaxDelay);
  commands_.fill(initial);
}

JointVector Motors::actuate(std::uint64_t tick, const JointVector& command, const RandomStream& random) noexcept {
  commands_[tick % commands_.size()] = command;
  int delay = delay_.low;
  if (delay_.high > delay_.low) {
    const int choices = delay_.high - delay_.low + 1;
    delay += std::min(choices - 1, static_cast<int>(choices * random.uniform(RandomStream::Purpose::delay, tick)));
  }
  return static_cast<std::uint64_t>(delay) > tick ? initial_ : commands_[(tick - delay) % commands_.size()];
}

void checkVirtualDevice(const VirtualDeviceSetup& setup) {
  requirePeriod(setup.period, "");
  require(setup.start.position.allFinite() && isRotation(setup.start.rotation),
          "the start pose is not finite, or its rotation is not a right-handed orthonormal matrix to 1e-6");
  require(setup.substeps >= 1 && setup.substeps <= 1000,
          "substeps is " + std::to_string(setup.substeps) + ", must be in 1 to 1000");
  require(0 <= setup.delay.low && setup.delay.low <= setup.delay.high && setup.delay.high <= kMaxDelay,
          "delay is " + std::to_string(setup.delay.low) + ".." + std::to_string(setup.delay.high) +
              ", must be in 0 to " + std::to_string(kMaxDelay) + " ticks, the smaller first");
  require(setup.jitter >= 0.0 && setup.jitter <= 1.0,
          "jitter is " + formatNumber(setup.jitter) + ", must be in 0 to 1 of the period");
  require(setup.lostSamples >= 0.0 && setup.lostSamples <= 0.5,
          "lost samples are " + formatNumber(setup.lostSamples) + ", must be in 0 to 0.5 of the ticks");
  require(setup.encoders.cutoff > 0.0 && std::isfinite(setup.encoders.cutoff),
          "cutoff of the rate filter is " + formatNumber(setup.encoders.cutoff) + ", must be greater than 0 Hz");
}

VirtualDevice::VirtualDevice(const Mechanism& mechanism, const VirtualDeviceSetup& setup)
    : VirtualDevice(std::make_unique<ClosedFormPlant>(mechanism, setup.integrator, checked(setup).substeps), setup) {}

VirtualDevice::VirtualDevice(std::unique_ptr<Plant> plant, const VirtualDeviceSetup& setup)
    : setup_(checked(setup)),
      plant_(std::move(plant)),
      random_(setup.seed, setup.run),
      kinematics_(started(plant_.get(), setup.start)),
      encoders_(setup.encoders, plant_->mechanism().limits().encoderStep, setup.period),
      motors_(setup.delay, kinematics_.gravity),
      torque_(kinematics_.gravity) {}

Status VirtualDevice::restart(const Pose& start) {
  Kinematics there;
  if (const Status status = plant_->mechanism().reach(start, Vec6::Zero(), false, there); status != Status::ok)
    return status;
  if (const Status status = plant_->start(start); status != Status::ok) return status;
  setup_.start = start;
  kinematics_ = there;
  encoders_ = Encoders(setup_.encoders, plant_->mechanism().limits().encoderStep, setup_.period);
  motors_ = Motors(setup_.delay, kinematics_.gravity);
  torque_ = kinematics_.gravity;
  tick_ = 0;
  return Status::ok;
}

Status VirtualDevice::measure(Measurement& measurement) noexcept {
  const DeviceState& state = plant_->state();
  const Status status = plant_->mechanism().reach(state.pose(), state.twist, false, kinematics_);
  if (status != Status::ok) return status;
  if (setup_.lostSamples > 0.0 && tick_ > 0 && random_.uniform(RandomStream::Purpose::loss, tick_) < setup_.lostSamples)
    return Status::stale;
  measurement.time = time();
  measurement.applied = torque_;
  JointVector q, rates;
  plant_->read(kinematics_, q, rates);
  encoders_.measure(q, rates, measurement);
  return Status::ok;
}

Status VirtualDevice::actuate(const Command& command) noexcept {
  torque_ = motors_.actuate(tick_, command.effort, random_);
  return Status::ok;
}

double VirtualDevice::timeOf(std::uint64_t tick) const noexcept {
  const double late = setup_.jitter > 0.0 ? setup_.jitter * random_.uniform(RandomStream::Purpose::jitter, tick) : 0.0;
  return (static_cast<double>(tick) + late) * setup_.period;
}

double VirtualDevice::duration() const noexcept {
  return setup_.jitter > 0.0 ? timeOf(tick_ + 1) - timeOf(tick_) : setup_.period;
}

Status VirtualDevice::advance(const ExternalWrench& load) noexcept {
  const Status status = plant_->advance(time(), duration(), torque_, load);
  if (status == Status::ok) ++tick_;
  return status;
}

Status VirtualDevice::advance(const ExternalWrench& before, double instant, const ExternalWrench& after) noexcept {
  const double whole = duration(), first = std::min(instant, whole);
  Status status = plant_->advance(time(), first, torque_, before);
  if (status == Status::ok) status = plant_->advance(time() + first, whole - first, torque_, after);
  if (status == Status::ok) ++tick_;
  return status;
}

}  // namespace enamel
