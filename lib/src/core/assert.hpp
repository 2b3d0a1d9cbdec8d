// ENAMEL_ASSERT: a developer's assumption, armed in Debug and in the CI preset (wherever NDEBUG is not set).
#pragma once

#include <cassert>

#define ENAMEL_ASSERT(condition) assert(condition)
