// The host of plugins in a haptic tick, with a plugin that returns arbitrary results (any_plugin.c).
#include <cstdio>
#include <cstdlib>

#include "enamel/device/device_file.hpp"
#include "enamel/plugin/host.hpp"
#include "enamel/render/tick.hpp"
#include "support/devices.hpp"
#include "surfaces.hpp"

namespace enamel::attack {

namespace {

void useRenderer(Renderer& renderer) {
  static const std::shared_ptr<const Mechanism> device =
      makeMechanism(loadDevice(test::deviceFile("cartesian-3.toml")));
  static const Scene wall = flatWall();
  HapticTick tick(*device, wall, Tool(), renderer, 1e-3);
  Measurement m;
  m.q = m.rates = JointVector::Zero(3);
  m.rates[2] = -0.02;
  m.q[2] = 1e-4;
  std::vector<double> state(tick.stateSize() / sizeof(double) + 1);
  for (int i = 0; i < 30; ++i) {
    m.time += 1e-3;
    m.q += 1e-3 * m.rates;
    Command command;
    const Status status = tick(m, command);
    requireWithin(command.effort, device->limits().effort);
    require(tick.guard().fault() == GuardReason::none || status != Status::ok, "a fault is no ok");
    if (i % 7 == 6) {
      tick.saveState(state.data());
      tick.loadState(state.data());
    }
  }
}

void attackHost(std::string_view bytes) {
  char where[64];
  std::snprintf(where, sizeof where, "%p %zu", static_cast<const void*>(bytes.data()), bytes.size());
  setenv("ENAMEL_ATTACK_BYTES", where, 1);
  try {
    const std::shared_ptr<const PluginLibrary> library = PluginLibrary::load(ENAMEL_ANY_PLUGIN);
    const EnamelDescription& description = library->description();
    require(description.name != nullptr && description.version != nullptr && description.summary != nullptr,
            "a description is whole");
    const std::unique_ptr<Renderer> renderer = makeRenderer(library, {});
    useRenderer(*renderer);
  } catch (const Error& error) {
    for (const char* c = error.what(); *c != 0; ++c)
      require(static_cast<unsigned char>(*c) >= ' ', "messages are one line without control characters");
  }
}

const Registration kHost{"host", attackHost};

}  // namespace

}  // namespace enamel::attack
