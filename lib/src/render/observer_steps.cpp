#include "render/observer_steps.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace enamel {
namespace {
#include "observer_steps.inl"
}  // namespace

const ObserverSteps<2> kRigidSteps = kSteps<2>;
const ObserverSteps<4> kCableSteps = kSteps<4>;

}  // namespace enamel
