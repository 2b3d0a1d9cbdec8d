// What changed in a solid, on its way from the thread that cuts it to one that draws it; neither waits for the other.
#pragma once

#include <cstdint>
#include <memory>

#include "enamel/collision/solid.hpp"
#include "enamel/core/spsc_ring.hpp"

namespace enamel {

/// A brick as it was at some moment.
struct BrickChange {
  int brick = -1;
  std::uint64_t revision = 0;  ///< number of the publish() that sent it
  BrickSamples samples;
};

/// One thread cuts and publishes, one takes. Bricks that find no room wait in the solid, where each waits once however
/// often it changes: none is lost. What the solid was before the first cut the reader takes from the solid itself.
/// Memory: 0.75 MB.
class SolidChanges {
 public:
  /// Realtime: no.
  SolidChanges() : ring_(std::make_unique<Ring>()) {}

  /// Sends bricks that have changed, at most `most`; what is left is for the next call. Returns the number of this
  /// call, from 1 on. Cutting thread. Realtime: yes, 0.2 us a brick.
  std::uint64_t publish(Solid& solid, int most = 16) noexcept;

  /// The oldest brick that was sent and not yet taken; false: there is none. Reading thread. Realtime: yes.
  bool take(BrickChange& change) noexcept { return ring_->pop(change); }

 private:
  using Ring = SpscRing<BrickChange, 256>;
  std::unique_ptr<Ring> ring_;
  BrickChange next_;  // its brick was taken from the solid's list and not yet sent
  std::uint64_t calls_ = 0;
};

}  // namespace enamel
