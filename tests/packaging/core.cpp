// Uses only the component core: designs a servo for a shipped delta.
#include <cstdio>

#include "enamel/control/device_plant.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/device_file.hpp"

int main() {
  try {
    const auto delta = enamel::makeMechanism(enamel::loadDevice(ENAMEL_DATA_DIR "/devices/delta.toml"));
    const enamel::ServoDesign design = enamel::designServo(delta, enamel::Pose{}, 1e-3);
    std::printf("a servo for %s: K is %d x %d\n", delta->name().c_str(), static_cast<int>(design.K.rows()),
                static_cast<int>(design.K.cols()));
    return design.K.rows() == 3 && design.K.cols() == 9 && design.K.allFinite() ? 0 : 1;
  } catch (const enamel::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
