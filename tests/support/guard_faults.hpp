// What can go wrong around a renderer, and what the guard must do then: for linked renderers and plugins.
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

/// Passes on what another renderer answers, until it spoils it.
class Spoiled final : public Renderer {
 public:
  using Spoil = std::function<Status(int ticks, TickOutput&)>;  // ticks since it began to
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

/// One way to fail. At tick kFaultAt the measurement or the answer begins to be spoiled, or ticks are missed.
inline constexpr int kFaultAt = 400;
struct Fault {
  std::string name;
  GuardReason reason;                                      ///< what the guard must call it
  int within = 1;                                          ///< ticks in which it must see it
  std::function<void(int ticks, Measurement&)> measure{};  ///< ticks since kFaultAt
  Spoiled::Spoil answer{};
  int missed = 0;                         ///< ticks
  GuardReason other = GuardReason::none;  ///< what it may call it as well
};

std::vector<Fault> guardFaults();

/// Runs a renderer in contact, held by a hand that trembles, through a fault: torque and slew within the limits at
/// every tick; the fault seen in time, under its name and kept; gravity's torque, or zero where the configuration is
/// not known, at most the stated ramp later and from then on. `echo`: the device tells what acted.
void requireGuarded(Renderer& renderer, const Fault& fault, bool echo);

}  // namespace enamel::test
