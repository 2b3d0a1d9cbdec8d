// enamel::ImpedanceRenderer, the spring wall, as a plugin.
#include "enamel/plugin/author.hpp"
#include "enamel/render/impedance.hpp"

namespace {

const EnamelParameter kParameters[] = {
    {"stiffness", "6000", "stiffness of the wall, N/m"},
    {"damping", "0", "damping of the wall, N s/m"},
};

class Impedance {
 public:
  static const EnamelDescription& describe() noexcept {
    static const EnamelDescription description = {"impedance", "0.2.0", "A wall as a spring and damper (penalty force)",
                                                  kParameters, std::size(kParameters)};
    return description;
  }

  explicit Impedance(const enamel::PluginConfiguration& configuration)
      : options_{configuration.number("stiffness", 0.0, 1e7, "N/m"),
                 configuration.number("damping", 0.0, 1e5, "N s/m")} {}

  std::unique_ptr<enamel::Renderer> activate(double) const {
    return std::make_unique<enamel::ImpedanceRenderer>(options_);
  }

 private:
  enamel::ImpedanceOptions options_;
};

}  // namespace

ENAMEL_PLUGIN(Impedance)
