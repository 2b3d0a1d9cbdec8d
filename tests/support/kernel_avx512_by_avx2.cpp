// The query loops for AVX-512, compiled for AVX2.
#include "support/avx512_by_avx2.hpp"

#define kAvx512Loops kAvx512LoopsByAvx2
#include "collision/kernel_avx512.cpp"
