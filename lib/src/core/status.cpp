#include "enamel/core/status.hpp"

namespace enamel {

const char* toString(Status status) noexcept {
  switch (status) {
    case Status::ok: return "ok";
    case Status::notFinite: return "not finite";
    case Status::unreachable: return "unreachable";
    case Status::singular: return "singular";
    case Status::notConverged: return "not converged";
    case Status::outOfRange: return "out of range";
    case Status::stale: return "stale";
    case Status::inactive: return "inactive";
    case Status::stopped: return "stopped by the guard";
  }
  return "unknown status";
}

}  // namespace enamel
