// ENAMEL_ASSERT: an assumption of the developer, checked in Debug and in the CI preset (if NDEBUG is not set).
#pragma once

#include <cassert>

#define ENAMEL_ASSERT(condition) assert(condition)
