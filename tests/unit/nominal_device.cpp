// The built-in device is the shipped file.
#include "enamel/device/nominal_device.hpp"

#include "enamel/device/device_file.hpp"
#include "support/catch.hpp"
#include "support/temporary_folder.hpp"

namespace enamel::test_nominal_device {

TEST_CASE("the built-in device is data/devices/tau-nominal.toml", "[device]") {
  CHECK(nominalDeviceText() == test::readFile(ENAMEL_SOURCE_DIR "/data/devices/tau-nominal.toml"));
  CHECK(nominalDevice().name == "TAU nominal");
  CHECK(makeMechanism(nominalDevice())->joints() == 6);
}

}  // namespace enamel::test_nominal_device
