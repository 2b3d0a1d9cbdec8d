// Checks of a guard's options.
#pragma once

#include "enamel/render/guard.hpp"

namespace enamel {

/// Return the options, checked. Throws Error: as Guard's constructor.
const GuardOptions& checked(const Mechanism& device, const GuardOptions& options);

}  // namespace enamel
