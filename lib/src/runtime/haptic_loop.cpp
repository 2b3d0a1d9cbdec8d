#include "enamel/runtime/haptic_loop.hpp"

#include <chrono>
#include <cmath>
#include <iostream>
#include <thread>

#include "core/message.hpp"
#include "core/system_process.hpp"

namespace enamel {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kShortestPeriod = 1e-4, kLongestPeriod = 2e-3;  // limits of the period, s
constexpr int kLongestCall = 2;                                  // s, before the end of a loop names the call

double since(Clock::time_point begin) noexcept { return std::chrono::duration<double>(Clock::now() - begin).count(); }

std::atomic<int> locks{0};

}  // namespace

void describe(const HapticTick& haptics, LoopTick& tick) noexcept {
  const TickFrame& frame = haptics.frame();
  tick.pose = frame.kinematics.pose;
  tick.twist = frame.kinematics.twist;
  tick.requested = frame.output.torque;
  tick.normalForce = frame.output.normalForce;
  tick.mode = frame.output.mode;
  tick.reason = frame.reason;
}

LoopBody::LoopBody(HapticDevice& device, HapticTick& haptics, const HapticLoopOptions& options)
    : device_(device),
      haptics_(haptics),
      sink_(options.sink),
      period_(options.period),
      ticks_(haptics.guard().options().period) {
  const GuardOptions& guard = haptics.guard().options();
  require(guard.on, "haptic loop: the guard is off; switch it on: only simulations may run without it");
  if (period_ == 0.0) period_ = ticks_;
  require(period_ >= kShortestPeriod && period_ <= kLongestPeriod && period_ <= ticks_,
          "haptic loop: the period is " + formatNumber(period_) + " s, must be in " + formatNumber(kShortestPeriod) +
              " to " + formatNumber(kLongestPeriod) + " s and at most that of the ticks, " + formatNumber(ticks_) +
              " s");
  device_.open();
  const auto begin = Clock::now();
  Status status = device_.measure(measurement_);
  for (bool isOver = false; status != Status::ok && !isOver;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    // Check the time before measuring, so that a delayed thread tries once more.
    isOver = since(begin) >= options.firstMeasurement;
    status = device_.measure(measurement_);
  }
  if (status != Status::ok) {
    device_.close();
    throw Error("haptic loop: the device gave no measurement within " + formatNumber(options.firstMeasurement) +
                " s: " + toString(status));
  }
  // Faults and elapsed time of an earlier loop do not belong to this one.
  if (haptics.guard().kept() > 0) haptics.reset();
  tick_.pose = haptics.frame().kinematics.pose;
  tick_.requested = command_.effort = JointVector::Zero(guard.torque.size());
}

LoopBody::~LoopBody() { device_.close(); }

Status LoopBody::send() noexcept {
  calling_.store("actuate() of the device", std::memory_order_relaxed);
  const Status sent = device_.actuate(command_);
  calling_.store(nullptr, std::memory_order_relaxed);
  if (sent == Status::ok) return sent;
  unsent_.fetch_add(1, std::memory_order_relaxed);
  if (sink_ != nullptr) sink_->unsent();
  return sent;
}

bool LoopBody::step() noexcept {
  const auto begin = Clock::now();
  if (first_ && sink_ != nullptr) sink_->atStart();
  const GuardOptions& guard = haptics_.guard().options();
  // The first tick uses the constructor's measurement unless a newer one exists.
  Measurement fresh = measurement_;
  calling_.store("measure() of the device", std::memory_order_relaxed);
  Status device = device_.measure(fresh);
  calling_.store("a renderer or a hook in the tick", std::memory_order_relaxed);
  const bool fails = device != Status::ok && device != Status::stale;
  if (device == Status::ok || first_) {
    if (device == Status::ok) measurement_ = fresh;
    measurement_.age = 0;
    measurement_.failed = fails;
    silence_ = 0.0;
  } else {
    measurement_.failed = measurement_.failed || fails;
    silence_ += period_;
    if (silence_ > guard.longestGap * ticks_) reset_ = false;
    heldAll_.fetch_add(1, std::memory_order_relaxed);
    // If the loop polls faster than the device measures, a sample may be late by half of the difference.
    if (silence_ < ((measurement_.age + 1) * ticks_ + 0.5 * (ticks_ - period_)) * (1.0 - 1e-9)) {
      (void)send();
      return true;
    }
    ++measurement_.age;
    measurement_.time += ticks_;
  }
  first_ = false;
  const auto measured = Clock::now();
  tick_.measurement = measurement_;
  tick_.reset = reset_ && silence_ == 0.0 && !stopping_;  // on a measurement, because the time continues from there
  if (tick_.reset) {
    reset_ = false;
    haptics_.reset();
    faulty_ = false;
  }
  if (stopping_) tick_.measurement.enabled = false;
  if (sink_ != nullptr) sink_->before(tick_.measurement);
  tick_.status = haptics_(tick_.measurement, command_);
  tick_.command = command_;
  tick_.compute = since(measured);
  const Status sent = send();
  tick_.age = since(begin);
  tick_.device = device != Status::ok ? device : sent;
  age_.add(tick_.age);

  describe(haptics_, tick_);
  if (sink_ != nullptr) sink_->tick(tick_, haptics_);
  ++tick_.number;

  // The ramp out begins with stop(), and again with a fault during it.
  const bool fault = haptics_.guard().fault() != GuardReason::none;
  if (!stopping_ || (fault && !faulty_)) left_ = static_cast<int>(std::ceil(guard.rampOut / ticks_)) + 2;
  faulty_ = fault;
  return !stopping_ || (left_ > 0 && --left_ > 0);
}

HapticLoop::MemoryLock::MemoryLock(bool wanted) noexcept {
  held = wanted && system::lockMemory();
  if (held) ++locks;
}

HapticLoop::MemoryLock::~MemoryLock() {
  if (held && --locks == 0) system::unlockMemory();
}

HapticLoop::HapticLoop(HapticDevice& device, HapticTick& haptics, const HapticLoopOptions& options)
    : lock_(options.lockMemory),
      body_(device, haptics, options),
      thread_(
          body_.period(), [this] { period(); }, options.priority) {}

HapticLoop::~HapticLoop() {
  // Ends within a bounded number of periods, whatever the device reports.
  std::uint64_t periods = 0;
  auto lastPeriod = Clock::now();
  for (bool isNamed = false; !thread_.ended();) {
    if (stopped())
      thread_.stop();
    else
      stop();
    std::this_thread::sleep_for(std::chrono::duration<double>(body_.period()));
    if (const std::uint64_t now = timing().periods; now != periods) {
      periods = now;
      lastPeriod = Clock::now();
    }
    const char* const call = body_.calling();
    if (isNamed || call == nullptr || since(lastPeriod) < kLongestCall) continue;
    isNamed = true;
    std::cerr << "haptic loop: " + std::string(call) + " has not returned for " + std::to_string(kLongestCall) +
                     " s; the loop cannot stop before it returns\n";
  }
}

void HapticLoop::period() noexcept {
  LoopCommand command;
  while (commands_.pop(command)) command == LoopCommand::stop ? body_.stop() : body_.reset();
  const std::uint64_t before = body_.tick().number;
  const bool more = body_.step();
  if (body_.tick().number != before) {
    state_.next() = body_.tick();
    state_.publish();
  }
  if (!more) stopped_.store(true, std::memory_order_release);
}

}  // namespace enamel
