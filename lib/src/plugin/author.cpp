#include "enamel/plugin/author.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "convert.hpp"
#include "core/message.hpp"
#include "enamel/core/error.hpp"

namespace enamel {
namespace {

[[noreturn]] void refuse(const std::string& key, const std::string& problem) {
  throw ConfigurationError("plugin parameters", 0, key, problem);
}

int32_t explain(const std::exception& error, const EnamelMessage& message) noexcept {
  if (message.text != nullptr && message.size > 0) std::snprintf(message.text, message.size, "%s", error.what());
  return ENAMEL_BAD_CONFIGURATION;
}

int32_t explainOrder(const char* what, const EnamelMessage& message) noexcept {
  if (message.text != nullptr && message.size > 0) std::snprintf(message.text, message.size, "%s", what);
  return ENAMEL_WRONG_ORDER;
}

}  // namespace

PluginConfiguration::PluginConfiguration(const EnamelDescription& description, const EnamelConfiguration& given) {
  for (std::size_t i = 0; i < description.parameter_count; ++i)
    parameters_[description.parameters[i].key] = description.parameters[i].value;
  if (given.parameter_count > 0 && given.parameters == nullptr)
    refuse("", "is NULL, must have " + std::to_string(given.parameter_count) + " entries");
  std::map<std::string, bool> seen;
  for (std::size_t i = 0; i < given.parameter_count; ++i) {
    if (given.parameters[i].key == nullptr || given.parameters[i].value == nullptr)
      refuse("number " + std::to_string(i), "has no key or no value (NULL)");
    const std::string key = given.parameters[i].key;
    const auto known = parameters_.find(key);
    if (known == parameters_.end()) refuse(key, std::string("is not a parameter of ") + description.name);
    if (std::exchange(seen[key], true)) refuse(key, "is given twice");
    known->second = given.parameters[i].value;
  }
  for (const auto& [key, value] : parameters_)
    if (value.empty()) refuse(key, "has no default and was not given");
  const auto nameOf = [](const char* path, const char* other) { return std::string(path == nullptr ? other : path); };
  if (given.device_text != nullptr)
    device_ = parseDevice(given.device_text, nameOf(given.device_path, "device"));
  else if (given.device_path != nullptr)
    device_ = loadDevice(given.device_path);
  if (given.scene_text != nullptr)
    scene_ = parseScene(given.scene_text, nameOf(given.scene_path, "scene"));
  else if (given.scene_path != nullptr)
    scene_ = loadScene(given.scene_path);
}

const DeviceParameters& PluginConfiguration::device() const {
  if (!device_) throw ConfigurationError("plugin configuration", 0, "device", "is missing: give its path or its text");
  return *device_;
}

const std::string& PluginConfiguration::text(const std::string& key) const {
  const auto found = parameters_.find(key);
  if (found == parameters_.end()) refuse(key, "is not in the plugin's description");
  return found->second;
}

double PluginConfiguration::number(const std::string& key, double low, double high, const std::string& unit) const {
  const std::string& value = text(key);
  char* end = nullptr;
  const double number = std::strtod(value.c_str(), &end);
  if (end == value.c_str() || *end != 0 || !std::isfinite(number))
    refuse(key, "is \"" + value + "\", must be a number");
  if (!(number >= low && number <= high))
    refuse(key, "is " + value + ", must be in " + formatNumber(low) + " to " + formatNumber(high) + " " + unit);
  return number;
}

bool PluginConfiguration::flag(const std::string& key) const {
  const std::string& value = text(key);
  if (value != "on" && value != "off") refuse(key, "is \"" + value + "\", must be on or off");
  return value == "on";
}

int32_t PluginInstance::configure(const EnamelConfiguration& configuration, EnamelMessage message) noexcept {
  if (renderer_) return explainOrder("configure() while active", message);
  try {
    activate_ = configure_(configuration);
    return ENAMEL_OK;
  } catch (const std::exception& error) {
    return explain(error, message);
  } catch (...) {
    return explain(Error("the plugin threw an exception that is not a std::exception"), message);
  }
}

int32_t PluginInstance::activate(double period, EnamelMessage message) noexcept {
  if (renderer_) return explainOrder("activate() while active", message);
  if (!activate_) return explainOrder("activate() before configure()", message);
  try {
    std::unique_ptr<Renderer> renderer = activate_(period);
    renderer->activate(period);
    renderer_ = std::move(renderer);
    return ENAMEL_OK;
  } catch (const std::exception& error) {
    return explain(error, message);
  } catch (...) {
    return explain(Error("the plugin threw an exception that is not a std::exception"), message);
  }
}

int32_t PluginInstance::step(const EnamelTickInput& input, EnamelTickOutput& output) noexcept {
  TickOutput answer;
  Status status = Status::inactive;
  if (renderer_ && input.joint_count >= 1 && input.joint_count <= kMaxJoints) {
    fromPlain(input, needsInertia_, frame_);
    if (needsInertia_) (void)fillContactRows(frame_);  // step() rejects an incomplete frame
    status = renderer_->step(frame_, answer);
  } else if (renderer_) {
    status = Status::outOfRange;
  }
  toPlain(answer, output);
  return static_cast<int32_t>(status);
}

void PluginInstance::reset() noexcept {
  if (renderer_) renderer_->reset();
}

void PluginInstance::saveState(void* state) const noexcept {
  if (renderer_) renderer_->saveState(state);
}

void PluginInstance::loadState(const void* state) noexcept {
  if (renderer_) renderer_->loadState(state);
}

}  // namespace enamel
