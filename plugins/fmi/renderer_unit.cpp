#include "renderer_unit.hpp"

#include <cmath>
#include <cstring>

#include "enamel/core/error.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "enamel/sim/plant_maker.hpp"

namespace enamel::fmi {

struct RendererUnit::Saved final : UnitState {
  std::vector<char> before;
  std::uint64_t number;

  Saved(Condition condition, std::vector<char> tick, std::uint64_t ofTick)
      : UnitState(std::move(condition)), before(std::move(tick)), number(ofTick) {}
};

RendererUnit::RendererUnit(const UnitConfiguration& configuration, const DeviceParameters& parameters, SceneFile scene)
    : Unit(configuration,
           makeMechanism(modelFor(configuration.plant.empty() ? kClosedForm : configuration.plant, parameters))),
      scene_(std::move(scene)),
      renderer_(makeLinked(configuration.renderer, configuration.parameters, device_, configuration.period)) {}

void RendererUnit::makeTick() {
  GuardOptions guard = guardFor(*device_, configuration_.period);
  guard.on = configuration_.guarded;
  if (configuration_.force > 0.0) guard.force = configuration_.force;
  tick_.emplace(*device_, scene_.scene, scene_.tool, *renderer_, guard, startPose());
  before_.resize(tick_->stateSize());
  tick_->saveState(before_.data());
}

void RendererUnit::begin() {
  makeTick();
  number_ = 0;
  now_.isNew = true;
}

// Run the tick at the communication point with the present inputs. It can be repeated with other inputs.
void RendererUnit::refresh() {
  if (!now_.isNew || !tick_) return;
  tick_->loadState(before_.data());
  Measurement m;
  m.time = now_.start + static_cast<double>(number_) * configuration_.period;
  m.q = joints("q");
  m.rates = joints("rates");
  m.applied = joints("applied");
  m.enabled = value("enabled")[0] != 0.0;
  m.age = static_cast<int>(value("age")[0]);
  Command command;
  const enamel::Status status = (*tick_)(m, command);
  put("torque", command.effort);
  put("requested", tick_->frame().output.torque);
  value("normal_force")[0] = tick_->frame().output.normalForce;
  value("mode")[0] = static_cast<double>(tick_->frame().output.mode);
  value("saturated")[0] = tick_->frame().output.saturated ? 1.0 : 0.0;
  value("status")[0] = static_cast<double>(status);
  value("guard")[0] = static_cast<double>(tick_->frame().reason);
  now_.isNew = false;
}

void RendererUnit::step(double step) {
  if (!(std::abs(step - configuration_.period) <= 1e-9 * configuration_.period))
    throw Error("the step is " + std::to_string(step) + " s, must be the period of the ticks, " +
                std::to_string(configuration_.period) + " s");
  now_.isNew = true;  // also if outputs were read: a state may have been set since
  refresh();
  tick_->saveState(before_.data());
  ++number_;
}

std::unique_ptr<UnitState> RendererUnit::copyState() const { return std::make_unique<Saved>(now_, before_, number_); }

void RendererUnit::putState(const UnitState& state) {
  const auto& saved = static_cast<const Saved&>(state);
  if (saved.before.empty()) {  // of a unit that had not begun
    if (saved.now.phase == Phase::stepping) throw Error("the state belongs to another unit");
    tick_.reset();
  } else {
    if (!tick_) makeTick();  // of another instance
    if (saved.before.size() != before_.size()) throw Error("the state belongs to another unit");
    tick_->loadState(saved.before.data());
  }
  now_ = saved.now;
  before_ = saved.before;
  number_ = saved.number;
}

std::string RendererUnit::bytesOf(const UnitState& state) const {
  const auto& saved = static_cast<const Saved&>(state);
  std::string bytes;
  const auto append = [&bytes](const auto& number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  append(saved.now.start);
  append(saved.now.last);
  append(static_cast<std::int64_t>(saved.now.phase));
  append(static_cast<std::int64_t>(saved.now.isNew));
  append(saved.number);
  for (const auto& values : saved.now.values)
    for (const double number : values) append(number);
  bytes.append(saved.before.begin(), saved.before.end());
  return bytes;
}

std::unique_ptr<UnitState> RendererUnit::stateOf(const std::string& bytes) const {
  auto saved = std::make_unique<Saved>(now_, std::vector<char>(), 0);
  std::size_t at = 0;
  const auto take = [&](auto& number) {
    if (bytes.size() - at < sizeof number) throw Error("the bytes belong to the state of another unit");
    std::memcpy(&number, bytes.data() + at, sizeof number);
    at += sizeof number;
  };
  std::int64_t phase = 0, isNew = 0;
  take(saved->now.start);
  take(saved->now.last);
  take(phase);
  take(isNew);
  take(saved->number);
  if (phase < 0 || phase > static_cast<std::int64_t>(Phase::terminated))
    throw Error("the bytes belong to the state of another unit");
  saved->now.phase = static_cast<Phase>(phase);
  saved->now.isNew = isNew != 0;
  for (auto& values : saved->now.values)
    for (double& number : values) take(number);
  saved->before.assign(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end());
  if (!saved->before.empty() && tick_ && saved->before.size() != tick_->stateSize())
    throw Error("the bytes belong to the state of another unit");
  return saved;
}

}  // namespace enamel::fmi
