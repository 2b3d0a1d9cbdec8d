// Deltas for the tests: the shipped one, and random ones with other lengths, unequal spacing of the legs and tilted
// gravity.
#pragma once

#include "enamel/device/delta/kinematics.hpp"
#include "support/devices.hpp"

namespace enamel::test {

DeltaParameters desktopDelta();

/// Return a variation of the shipped delta that is regular in a cube of 40 mm.
DeltaParameters randomDelta(std::uint64_t seed);

/// A delta, and the half width of a cube within its reach, m.
struct SomeDelta {
  DeltaParameters device;
  double cube;
};

std::vector<SomeDelta> someDeltas();

}  // namespace enamel::test
