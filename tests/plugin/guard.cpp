// Faults around a renderer in a plugin: the guard handles every one.
#include "enamel/plugin/host.hpp"
#include "support/guard_faults.hpp"

namespace enamel::test_guard {

TEST_CASE("guard: every injected fault, with plugins", "[plugin]") {
  for (const char* name : {"position_control", "impedance"})
    for (const test::Fault& fault : test::guardFaults()) {
      PluginSetup setup;
      setup.devicePath = test::deviceFile("tau-nominal.toml");
      if (std::string(name) == "impedance") setup.parameters = {{"stiffness", "3000"}};
      const auto plugin =
          makeRenderer(PluginLibrary::load(std::string(ENAMEL_PLUGINS "/enamel_") + name + ".so"), setup);
      test::requireGuarded(*plugin, fault, true);
    }
}

}  // namespace enamel::test_guard
