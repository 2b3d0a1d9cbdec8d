// For AVX-512; without fused products, as the baseline.
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

const ObserverSteps<2> kRigidStepsAvx512 = kSteps<2>;
const ObserverSteps<4> kCableStepsAvx512 = kSteps<4>;

}  // namespace enamel
