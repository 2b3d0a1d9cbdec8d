// The C interface of plugins: calls in any order on several instances, with any numbers.
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "enamel/plugin/abi.h"
#include "surfaces.hpp"

// Each plugin is compiled into this program under its own name.
extern "C" const EnamelPlugin* impedance_plugin();
extern "C" const EnamelPlugin* position_control_plugin();
extern "C" const EnamelPlugin* template_plugin();

namespace enamel::attack {

namespace {

constexpr int kInstances = 3;

class Calls {
 public:
  explicit Calls(const EnamelPlugin& plugin) : plugin_(plugin) {}
  ~Calls() {
    for (Instance& instance : instances_)
      if (instance.self != nullptr) plugin_.destroy(instance.self);
  }
  Calls(const Calls&) = delete;
  Calls& operator=(const Calls&) = delete;

  void act(Numbers& numbers) {
    Instance& instance = instances_[static_cast<std::size_t>(numbers.pick(kInstances))];
    if (instance.self == nullptr) instance.self = plugin_.create();
    switch (numbers.pick(12)) {
      case 0: configure(instance, numbers); break;
      case 1: activate(instance, numbers); break;
      case 2:
        plugin_.reset(instance.self);
        instance.isChanged = false;
        break;
      case 3:
        plugin_.deactivate(instance.self);
        instance.isActive = false;
        break;
      case 4:
        plugin_.destroy(instance.self);
        instance = {};
        break;
      case 5: state(instance, numbers); break;
      default: step(instance, numbers); break;
    }
  }

 private:
  struct Instance {
    void* self = nullptr;
    bool isConfigured = false, isActive = false;
    bool isChanged = false;  // its state was changed from outside
    double time = 0.0;
  };

  static void check(std::int32_t result, const std::array<char, 64>& text) {
    require(result >= ENAMEL_OK && result <= ENAMEL_BAD_CONFIGURATION, "results are those of the interface");
    require(std::memchr(text.data(), 0, text.size()) != nullptr, "messages end");
  }
  void configure(Instance& instance, Numbers& numbers) {
    const std::string device = ENAMEL_SOURCE_DIR "/data/devices/cartesian-3.toml";
    const EnamelDescription& description = *plugin_.describe();
    const std::string text(numbers.text(24)), key(numbers.text(12));
    EnamelParameter parameter{key.c_str(), text.c_str(), nullptr};
    if (description.parameter_count > 0 && numbers.pick(4) != 0)
      parameter.key = description.parameters[numbers.next<unsigned char>() % description.parameter_count].key;
    EnamelConfiguration configuration{};
    if (numbers.pick(8) != 0) configuration.device_path = device.c_str();
    if (numbers.pick(8) == 0) configuration.device_text = text.c_str();
    if (numbers.pick(8) == 0) configuration.scene_text = text.c_str();
    configuration.parameters = &parameter;
    configuration.parameter_count = static_cast<std::size_t>(numbers.pick(2));
    std::array<char, 64> message{};
    message.fill('x');
    message[0] = 0;
    const std::int32_t result = plugin_.configure(instance.self, &configuration, {message.data(), message.size()});
    check(result, message);
    if (instance.isActive) require(result != ENAMEL_OK, "an active instance is not configured");
    if (result == ENAMEL_OK) instance.isConfigured = true;
  }
  void activate(Instance& instance, Numbers& numbers) {
    std::array<char, 64> message{};
    const double period = numbers.pick(4) == 0 ? numbers.next<double>() : 1e-3;
    const std::int32_t result = plugin_.activate(instance.self, period, {message.data(), message.size()});
    check(result, message);
    if (result != ENAMEL_OK) return;
    require(instance.isConfigured && period >= 1e-5 && period <= 0.1, "what is not ready is not activated");
    instance.isActive = true;
    instance.isChanged = false;
    instance.time = 0.0;
  }
  void state(Instance& instance, Numbers& numbers) {
    if (!instance.isActive) return;
    std::vector<double> bytes(plugin_.state_size(instance.self) / sizeof(double) + 1), again = bytes;
    plugin_.save_state(instance.self, bytes.data());
    plugin_.load_state(instance.self, bytes.data());
    plugin_.save_state(instance.self, again.data());
    if (!instance.isChanged)
      require(std::memcmp(bytes.data(), again.data(), plugin_.state_size(instance.self)) == 0, "a state comes back");
    if (numbers.pick(2) == 0) {
      bytes[numbers.next<std::uint16_t>() % bytes.size()] = numbers.next<double>();
      plugin_.load_state(instance.self, bytes.data());
      instance.isChanged = true;
    }
  }
  void step(Instance& instance, Numbers& numbers) {
    EnamelTickInput input = good(instance, numbers);
    if (numbers.pick(3) == 0) {  // replace some bytes by arbitrary ones
      auto* const bytes = reinterpret_cast<unsigned char*>(&input);
      for (int changes = 1 + numbers.pick(4); changes > 0; --changes) {
        const std::size_t at = numbers.next<std::uint16_t>() % (sizeof(input) / 8);
        const double value = numbers.next<double>();
        std::memcpy(bytes + 8 * at, &value, 8);
      }
    }
    EnamelTickOutput output;
    std::memset(&output, 0xff, sizeof(output));  // NaN
    const std::int32_t result = plugin_.step(instance.self, &input, &output);
    require(result >= ENAMEL_OK && result < ENAMEL_BAD_CONFIGURATION, "results are those of the interface");
    if (!instance.isActive) require(result != ENAMEL_OK, "what is not active does not step");
    if (result == ENAMEL_OK) instance.time = input.time;
    for (int i = 0; i < ENAMEL_MAX_JOINTS; ++i) {
      require(std::isfinite(output.torque[i]), "torques are finite");
      if (result != ENAMEL_OK) require(output.torque[i] == 0.0, "a fault has no torque");
      if (result == ENAMEL_OK && i < input.joint_count)
        require(std::abs(output.torque[i]) <= (input.max_torque[i] > 0.0 ? input.max_torque[i] : 0.0),
                "torques are within the limits");
    }
    for (const double value : output.wrench) {
      require(std::isfinite(value), "wrenches are finite");
      if (result != ENAMEL_OK) require(value == 0.0, "a fault has no wrench");
    }
    require((output.mode == ENAMEL_FAULT) == (result != ENAMEL_OK), "the mode is fault where there is one");
  }
  static EnamelTickInput good(const Instance& instance, Numbers& numbers) {
    EnamelTickInput input{};
    input.time = instance.time + 1e-3;
    input.joint_count = 3;
    input.rotation[0] = input.rotation[4] = input.rotation[8] = 1.0;
    for (int i = 0; i < 3; ++i) {
      input.q[i] = input.position[i] = 1e-5 * numbers.next<signed char>();
      input.rates[i] = input.twist[i] = 1e-3 * numbers.next<signed char>();
      input.jacobian[i][i] = input.inverse[i][i] = 1.0;
      input.inertia[i][i] = 0.05;
      input.max_torque[i] = 4.0;
    }
    input.applied_known = numbers.pick(3);
    input.age = numbers.pick(8) == 0 ? 1 : 0;
    input.contact_count = numbers.pick(3);
    for (int i = 0; i < input.contact_count; ++i) {
      EnamelContact& contact = input.contacts[i];
      contact.normal[i == 0 ? 2 : 0] = 1.0;
      contact.gap = input.position[2];
      contact.stiffness = numbers.pick(2) == 0 ? HUGE_VAL : 2000.0;
      contact.friction = contact.sliding_friction = numbers.pick(2) * 0.3;
      contact.triangle = contact.feature_index = -1;
      contact.key = static_cast<std::uint32_t>(i + 1);
    }
    return input;
  }

  const EnamelPlugin& plugin_;
  std::array<Instance, kInstances> instances_{};
};

void attackPlugin(std::string_view bytes) {
  Numbers numbers(bytes);
  const int which = numbers.pick(3);
  Calls calls(which == 0 ? *impedance_plugin() : which == 1 ? *position_control_plugin() : *template_plugin());
  for (int i = 0; i < 200 && !numbers.empty(); ++i) calls.act(numbers);
}

const Registration kPlugin{"plugin", attackPlugin};

}  // namespace

}  // namespace enamel::attack
