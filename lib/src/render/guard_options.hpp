// What a guard is configured with is checked here.
#pragma once

#include "enamel/render/guard.hpp"

namespace enamel {

/// Throws Error: as Guard's constructor.
void checkGuardOptions(const Mechanism& device, const GuardOptions& options);

}  // namespace enamel
