// Checks of a guard's options.
#pragma once

#include "enamel/render/guard.hpp"

namespace enamel {

/// Check the options and return them. Throws Error as Guard's constructor does.
const GuardOptions& checked(const Mechanism& device, const GuardOptions& options);

}  // namespace enamel
