#include "enamel/device/nominal_device.hpp"

namespace enamel {
namespace {

constexpr char kText[] =
#include <nominal_device.inl>  // the file as a raw string, generated when the build is configured
    ;

}  // namespace

const char* nominalDeviceText() noexcept { return kText; }

TauParameters nominalDevice() { return parseTau(kText, "tau-nominal.toml (built in)"); }

}  // namespace enamel
