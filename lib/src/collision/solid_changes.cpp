#include "enamel/collision/solid_changes.hpp"

namespace enamel {

std::uint64_t SolidChanges::publish(Solid& solid, int most) noexcept {
  next_.revision = ++calls_;
  for (int sent = 0; sent < most; ++sent) {
    if (next_.brick < 0) next_.brick = solid.takeChanged();
    if (next_.brick < 0) break;
    next_.samples = solid.samples(next_.brick);
    if (!ring_->push(next_)) break;
    next_.brick = -1;
  }
  return calls_;
}

}  // namespace enamel
