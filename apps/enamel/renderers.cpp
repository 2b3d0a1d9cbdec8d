#include "renderers.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "enamel/core/error.hpp"
#include "plugin_folder.hpp"

namespace enamel::app {

Delay parseDelay(const std::string& text) {
  int low = 0, high = 0;
  char rest = 0;
  if (text == "none") return {0, 0};
  if (std::sscanf(text.c_str(), "constant:%d%c", &low, &rest) == 1) return {low, low};
  if (std::sscanf(text.c_str(), "random:%d..%d%c", &low, &high, &rest) == 2) return {low, high};
  throw Error("--delay is \"" + text + "\", must be none, constant:D or random:A..B with whole ticks");
}

RendererSource findRenderer(const std::string& nameOrPath) {
  if (nameOrPath == kPositionControl || nameOrPath == kImpedance) return {nameOrPath, nullptr};
  auto library = findPlugin(nameOrPath, pluginFolder());
  return {library->description().name, library};
}

std::unique_ptr<Renderer> makeRenderer(const std::string& name, const TauModel& model, double period,
                                       const PositionControlOptions& servo, const ImpedanceOptions& impedance) {
  if (name == kImpedance) return std::make_unique<ImpedanceRenderer>(model, impedance);
  return std::make_unique<PositionControlRenderer>(model, designServo(model, Pose{}, period).K, period, servo);
}

TauModel plantFor(const std::string& name, TauParameters device, const ImpedanceOptions& impedance) {
  if (name == kImpedance) device.platform.damping[2] += impedance.deviceDamping;
  return makeModel(device);
}

nlohmann::ordered_json toJson(const PushMetrics& m) {
  nlohmann::ordered_json json;
  const auto optional = [](const std::optional<double>& v) { return v ? nlohmann::ordered_json(*v) : nullptr; };
  json["D_z1 [m]"] = optional(m.firstDepth);
  json["K_z1 [N/m]"] = optional(m.firstStiffness);
  json["D_zs [m]"] = m.steadyDepth;
  json["C_zs [m/N]"] = m.steadyCompliance;
  json["rms_depth [m]"] = m.rmsDepth;
  json["depth_95 [m]"] = m.depth95;
  json["largest_depth [m]"] = m.largestDepth;
  json["chatter [N m]"] = m.chatter;
  json["saturated_share"] = m.saturatedShare;
  json["tangential_force [N]"] = m.tangentialForce;
  json["work [J]"] = m.work;
  json["drift [m]"] = m.drift;
  json["faults"] = m.faults;
  return json;
}

}  // namespace enamel::app
