// ENAMEL_ASSERT checks an assumption of the developer. It is active without NDEBUG: in Debug and in the CI preset.
#pragma once

#include <cassert>

#define ENAMEL_ASSERT(condition) assert(condition)
