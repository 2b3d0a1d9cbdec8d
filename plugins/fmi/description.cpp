#include "description.hpp"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/core/old_names.hpp"
#include "enamel/sim/plant_maker.hpp"

namespace enamel::fmi {

std::string textOf(const UnitConfiguration& c) {
  nlohmann::ordered_json json;
  json["renderer"] = c.renderer;
  json["parameters"] = c.parameters;
  json["plant"] = c.plant;
  json["substeps"] = c.substeps;
  json["period"] = c.period;
  json["guarded"] = c.guarded;
  json["force"] = c.force;
  json["seed"] = c.seed;
  return json.dump(2) + "\n";
}

UnitConfiguration readUnit(const std::string& path) {
  try {
    const auto json = nlohmann::json::parse(readJson(path));
    UnitConfiguration c;
    json.at("renderer").get_to(c.renderer);
    json.at("parameters").get_to(c.parameters);
    c.plant = presentName("plant", json.at("plant").get_ref<const std::string&>());
    json.at("substeps").get_to(c.substeps);
    json.at("period").get_to(c.period);
    json.at("guarded").get_to(c.guarded);
    json.at("force").get_to(c.force);
    json.at("seed").get_to(c.seed);
    return c;
  } catch (const nlohmann::json::exception& e) {
    throw ConfigurationError(path, 0, "", e.what());
  }
}

bool canSerialise(const UnitConfiguration& c) noexcept { return !c.renderer.empty(); }

std::vector<Variable> variablesOf(const UnitConfiguration& c, const Mechanism& device) {
  const auto n = static_cast<std::size_t>(device.joints());
  // If J is the identity, the joints are the axes of the TCP and slide. Otherwise all joints turn.
  const bool turns = !device.home().jacobian.isIdentity(0.0);
  const char *angle = turns ? "rad" : "m", *rate = turns ? "rad/s" : "m/s", *torque = turns ? "N.m" : "N";
  const std::vector<double> zeros(n, 0.0), three(3, 0.0), upright{1.0, 0.0, 0.0, 0.0};
  const JointVector& gravity = device.home().gravity;
  const std::vector<double> balance(gravity.data(), gravity.data() + gravity.size());
  const JointVector& q = device.home().q;
  const std::vector<double> home(q.data(), q.data() + q.size());
  using C = Causality;
  std::vector<Variable> table = {{"time", C::independent, "s", "Simulation time", {0.0}, false}};
  const auto add = [&](Variable variable) { table.push_back(std::move(variable)); };
  if (c.renderer.empty()) {
    add({"torque", C::input, torque, "Torque of the motors, held over a step", balance});
    add({"force", C::input, "N", "Force of the person on the platform at the TCP, W, held over a step", three});
    add({"moment", C::input, "N.m", "Moment of the person on the platform, W, held over a step", three});
    add({"position", C::output, "m", "Position of the TCP in W", three});
    add({"orientation", C::output, "", "Orientation of the platform in W, unit quaternion w, x, y, z", upright});
    add({"velocity", C::output, "m/s", "Velocity of the TCP, W", three});
    add({"angular_velocity", C::output, "rad/s", "Angular velocity of the platform, W", three});
    add({"q", C::output, angle, "Joint coordinates at the encoders, exact", home});
    add({"rates", C::output, rate, "Joint rates at the encoders, exact", zeros});
    add({"applied", C::output, torque, "Torque that acted during the last step", balance});
    add({"start_position", C::parameter, "m", "Position of the TCP in W at the start, at rest", three});
    add({"start_orientation", C::parameter, "", "Orientation of the platform at the start, unit quaternion w, x, y, z",
         upright});
    add({"guide",
         C::parameter,
         "",
         "Whether a hand softly holds the TCP across guide_normal and the orientation",
         {0.0},
         false,
         Type::boolean});
    add({"guide_normal",
         C::parameter,
         "",
         "Unit vector along which the hand does not hold the tool, W",
         {0.0, 0.0, 1.0}});
  } else {
    add({"q", C::input, angle, "Measured joint coordinates", home});
    add({"rates", C::input, rate, "Measured joint rates", zeros});
    add({"applied", C::input, torque, "Torque that acted since the last tick", balance});
    add({"enabled", C::input, "", "Enable switch of the user", {1.0}, false, Type::boolean});
    add({"age",
         C::input,
         "",
         "Steps since q and rates were sampled; 0: a new sample. Above 0, q and rates are ignored",
         {0.0},
         false,
         Type::integer});
    add({"torque", C::output, torque, "Torque for the motors, from the guard", balance});
    add({"requested", C::output, torque, "Torque requested by the renderer", balance});
    add({"normal_force",
         C::output,
         "N",
         "Normal force of the wall on the tool, as the renderer reports it",
         {0.0},
         false});
    add({"mode", C::output, "", "0 free, 1 contact, 2 fault", {0.0}, false, Type::integer});
    add({"saturated", C::output, "", "Whether a motor's limit reduced the torque", {0.0}, false, Type::boolean});
    add({"status", C::output, "", "Status of the tick (enamel/core/status.hpp), 0 ok", {0.0}, false, Type::integer});
    add({"guard",
         C::output,
         "",
         "Reason of the guard if torque differs from requested (enamel/render/guard.hpp), 0 none",
         {0.0},
         false,
         Type::integer});
    add({"start_position", C::parameter, "m", "Approximate position of the TCP at the first tick, W", three});
    add({"start_orientation", C::parameter, "",
         "Approximate orientation of the platform at the first tick, unit quaternion w, x, y, z", upright});
  }
  return table;
}

std::string tokenOf(const std::string& unit, const std::string& device, const std::string& scene) {
  char text[64];
  std::snprintf(text, sizeof text, "{enamel-%08x-%08x-%08x}", crc32(unit), crc32(device), crc32(scene));
  return text;
}

}  // namespace enamel::fmi
