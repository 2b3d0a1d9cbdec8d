// Changes of a solid, passed from the thread that cuts it to one that draws it. Neither thread waits.
#pragma once

#include <cstdint>
#include <memory>

#include "enamel/collision/solid.hpp"
#include "enamel/core/spsc_ring.hpp"

namespace enamel {

/// A copy of a brick at one moment.
struct BrickChange {
  int brick = -1;
  std::uint64_t revision = 0;  ///< number of the publish() that sent it
  BrickSamples samples;
};

/// A queue of changed bricks: one thread cuts and publishes, another takes. Bricks without room in the queue wait in
/// the solid, each once even if it changes often. Nothing is lost. The reader gets the initial state from the solid
/// itself, before the first cut. Memory: 0.75 MB.
class SolidChanges {
 public:
  /// Allocate the queue. Realtime: no.
  SolidChanges() : ring_(std::make_unique<Ring>()) {}

  /// Send at most `most` changed bricks; the rest stays for the next call. Return the number of this call, from 1.
  /// Cutting thread. Realtime: yes, 0.2 us a brick.
  std::uint64_t publish(Solid& solid, int most = 16) noexcept;

  /// Take the oldest brick in the queue; return false if the queue is empty. Reading thread. Realtime: yes.
  bool take(BrickChange& change) noexcept { return ring_->pop(change); }

 private:
  using Ring = SpscRing<BrickChange, 256>;
  std::unique_ptr<Ring> ring_;
  BrickChange next_;  // if its number is valid, it left the solid's list and was not sent
  std::uint64_t calls_ = 0;
};

}  // namespace enamel
