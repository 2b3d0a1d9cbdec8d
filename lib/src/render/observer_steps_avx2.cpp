// Compiled for AVX2, without fused products, like the baseline.
#include <immintrin.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "render/observer_steps.hpp"

namespace enamel {
namespace {
#include "observer_steps.inl"
}  // namespace

const ObserverSteps<2> kRigidStepsAvx2 = kSteps<2>;
const ObserverSteps<4> kCableStepsAvx2 = kSteps<4>;

}  // namespace enamel
