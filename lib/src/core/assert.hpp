// ENAMEL_ASSERT: check an assumption of the developer in Debug and in the CI preset (if NDEBUG is not set).
#pragma once

#include <cassert>

#define ENAMEL_ASSERT(condition) assert(condition)
