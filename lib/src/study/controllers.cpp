#include "enamel/study/controllers.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/message.hpp"
#include "enamel/control/device_plant.hpp"
#include "enamel/core/file.hpp"
#include "enamel/render/hold.hpp"
#include "enamel/render/impedance.hpp"
#include "enamel/render/passivity.hpp"
#include "enamel/render/virtual_coupling.hpp"

namespace enamel {
namespace {

using Json = nlohmann::ordered_json;
using Values = std::vector<double>;

const ControllerParameter kStiffness{"stiffness", "N/m", 1000.0, 50.0, 2e5, 0.3, true};
const ControllerParameter kDamping{"damping", "N s/m", 3.0, 1e-3, 200.0, 0.4, true};
const std::vector<ControllerParameter> kWeights = {{"rate weight", "", 0.02, 1e-8, 1e6, 1.0, true},
                                                   {"position weight", "", 300.0, 1e-4, 1e8, 1.0, true},
                                                   {"integral weight", "", 1e6, 1e-2, 1e12, 1.0, true}};

MakeRenderer impedance(const ControllerUse&, const Values& v) {
  return [wall = ImpedanceOptions{v[0], v[1]}] { return std::make_unique<ImpedanceRenderer>(wall); };
}

template <PassivityBound bound>
MakeRenderer passivity(const ControllerUse&, const Values& v) {
  return [wall = ImpedanceOptions{v[0], v[1]}] {
    return std::make_unique<PassivityRenderer>(std::make_unique<ImpedanceRenderer>(wall), bound);
  };
}

MakeRenderer virtualCoupling(const ControllerUse&, const Values& v) {
  return [coupling = VirtualCouplingOptions{v[0], v[1], v[2]}] {
    return std::make_unique<VirtualCouplingRenderer>(coupling);
  };
}

MakeRenderer holdWith(const ControllerUse& use, const Values& v, int foreseen) {
  const ServoDesign design = designServo(use.device, Pose{}, use.period, {v[0], v[1], v[2], 1.0});
  const DelayedServo servo = servoForDelay(design, foreseen);
  HoldOptions options;
  options.antiWindup = true;
  options.commandGain = servo.commandGain;
  return [gain = ServoGain(servo.K), period = use.period, options] {
    return std::make_unique<HoldRenderer>(gain, period, options);
  };
}

MakeRenderer hold(const ControllerUse& use, const Values& v) { return holdWith(use, v, 0); }
MakeRenderer holdDelay(const ControllerUse& use, const Values& v) {
  return holdWith(use, v, (use.delay.low + use.delay.high + 1) / 2);
}

}  // namespace

const std::vector<ControllerSpec>& rivalSpecs() {
  static const std::vector<ControllerSpec> specs = {
      {"impedance", "spring, tuned", {kStiffness, kDamping}, impedance},
      {"passivity", "spring under passivity control, tuned", {kStiffness, kDamping}, passivity<PassivityBound::energy>},
      {"passivity-memory",
       "spring under memory-based passivity control, tuned",
       {kStiffness, kDamping},
       passivity<PassivityBound::memory>},
      {"virtual-coupling",
       "virtual coupling, tuned",
       {kStiffness, kDamping, {"mass", "kg", 0.02, 1e-3, 1.0, 0.4, true}},
       virtualCoupling},
      {"hold", "hold, tuned", kWeights, hold},
      {"hold-delay", "hold that foresees the delay, tuned", kWeights, holdDelay},
  };
  return specs;
}

const ControllerSpec& rivalSpec(const std::string& name) {
  std::string names;
  for (const ControllerSpec& spec : rivalSpecs()) {
    if (spec.name == name) return spec;
    names += (names.empty() ? "" : ", ") + spec.name;
  }
  throw Error("unknown controller \"" + name + "\": must be one of " + names);
}

ControllerFile loadControllers(const std::string& path) {
  const auto refuse = [&path](const std::string& key, const std::string& problem) {
    throw ConfigurationError(path, 0, key, problem);
  };
  const Json file = Json::parse(readJson(path), nullptr, false);
  const bool old = file.is_object() && !file.contains("controllers") && file.contains("laws");  // file of version 0.2
  const std::string list = old ? "laws" : "controllers", name = old ? "law" : "controller";
  if (!file.is_object() || !file.contains(list) || !file[list].is_array()) refuse("", "has no list \"" + list + "\"");
  ControllerFile result;
  if (file.contains("model") && file["model"].is_string()) result.model = file["model"].get<std::string>();
  for (std::size_t i = 0; i < file[list].size(); ++i) {
    const Json& entry = file[list][i];
    const std::string at = list + "[" + std::to_string(i) + "]";
    if (!entry.is_object() || !entry.contains(name) || !entry[name].is_string()) refuse(at + "." + name, "is missing");
    ControllerValues read;
    read.controller = entry[name].get<std::string>();
    const ControllerSpec* spec = nullptr;
    try {
      spec = &rivalSpec(read.controller);
    } catch (const Error& error) {
      refuse(at + "." + name, error.what());
    }
    const Json delay = entry.value("delay", Json());
    if (!delay.is_array() || delay.size() != 2 || !delay[0].is_number_unsigned() || !delay[1].is_number_unsigned() ||
        delay[0] > delay[1] || delay[1] > 1000)
      refuse(at + ".delay", "must be the smallest and the largest delay in whole ticks");
    read.delayLow = delay[0].get<int>();
    read.delayHigh = delay[1].get<int>();
    for (const ControllerParameter& p : spec->parameters) {
      const Json value = entry.value(p.name, Json());
      if (!value.is_number() || !(value.get<double>() >= p.low && value.get<double>() <= p.high))
        refuse(at + "." + p.name, "must be a number in " + formatNumber(p.low) + " to " + formatNumber(p.high) +
                                      (p.unit.empty() ? "" : " " + p.unit));
      read.values.push_back(value.get<double>());
    }
    result.controllers.push_back(std::move(read));
  }
  return result;
}

std::string controllersText(const ControllerFile& written) {
  Json file;
  file["model"] = written.model;
  file["controllers"] = Json::array();
  for (const ControllerValues& found : written.controllers) {
    const ControllerSpec& spec = rivalSpec(found.controller);
    require(found.values.size() == spec.parameters.size(),
            "controllers: " + found.controller + " has " + std::to_string(found.values.size()) + " values, must have " +
                std::to_string(spec.parameters.size()));
    Json entry;
    entry["controller"] = found.controller;
    entry["delay"] = {found.delayLow, found.delayHigh};
    for (std::size_t i = 0; i < found.values.size(); ++i) entry[spec.parameters[i].name] = found.values[i];
    file["controllers"].push_back(entry);
  }
  return file.dump(1) + "\n";
}

}  // namespace enamel
