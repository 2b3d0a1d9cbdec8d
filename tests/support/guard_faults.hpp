// Faults around a renderer and the required reactions of the guard, for linked renderers and plugins.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "enamel/device/tau/mechanism.hpp"
#include "enamel/render/tick.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_device.hpp"
#include "support/catch.hpp"
#include "support/devices.hpp"

namespace enamel::test {

/// Passes on another renderer's output, until it spoils it.
class Spoiled final : public Renderer {
 public:
  using Spoil = std::function<Status(int ticks, TickOutput&)>;  // ticks since the start of the fault
  Spoiled(Renderer& inner, int from, Spoil spoil) : inner_(inner), from_(from), spoil_(std::move(spoil)) {}
  bool needsInertia() const noexcept override { return inner_.needsInertia(); }

 private:
  void prepare(double period) override { inner_.activate(period); }
  Status render(const TickFrame& input, TickOutput& output) noexcept override {
    const Status status = inner_.step(input, output);
    return spoil_ && ++ticks_ > from_ && status == Status::ok ? spoil_(ticks_ - from_, output) : status;
  }
  void resetState() noexcept override { inner_.reset(); }
  StateBlock stateBlock() noexcept override { return {nullptr, 0}; }

  Renderer& inner_;
  int from_, ticks_ = 0;
  Spoil spoil_;
};

/// A fault. From tick kFaultAt on, the measurement or the output is spoiled, or ticks are missed.
inline constexpr int kFaultAt = 400;
struct Fault {
  std::string name;
  GuardReason reason;                                      ///< required reason
  int within = 1;                                          ///< ticks in which the guard must detect it
  std::function<void(int ticks, Measurement&)> measure{};  ///< ticks since kFaultAt
  Spoiled::Spoil answer{};
  int missed = 0;                         ///< missed ticks
  GuardReason other = GuardReason::none;  ///< a further permitted reason
};

std::vector<Fault> guardFaults();

/// Run a renderer through a fault, in contact and held by a hand with tremor. Requirements: torque and slew are within
/// the limits at every tick. The fault is detected in time with its reason, and remains. At most the stated ramp later,
/// the torque is gravity's, or zero if the configuration is unknown. `echo`: the device reports the torque that acted.
void requireGuarded(Renderer& renderer, const Fault& fault, bool echo);

}  // namespace enamel::test
