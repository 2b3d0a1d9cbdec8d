// Work on several cores whose result does not depend on how many there are (oneTBB behind a plain interface).
#pragma once

#include <cstddef>
#include <functional>

namespace enamel {

/// Most threads that can be asked for.
inline constexpr int kMaxThreads = 256;

/// How many threads this process may keep busy. Realtime: no.
int availableThreads();

/// Calls body(0) ... body(count - 1), each once, on `threads` threads. The first exception of a body is passed on.
/// Throws Error: threads outside 1 to kMaxThreads. Realtime: no.
void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

/// Calls work(i) on `threads` threads and then done(i) on one thread at a time in the order of i, for i = first, ...,
/// count - 1. At most 4 indices a thread are worked on ahead of done(). Once stop() is true no further index is begun;
/// those under way are finished. Returns the first index that was not done. The first exception is passed on.
/// Throws Error: as parallelFor(). Realtime: no.
std::size_t parallelInOrder(std::size_t first, std::size_t count, int threads,
                            const std::function<void(std::size_t)>& work, const std::function<void(std::size_t)>& done,
                            const std::function<bool()>& stop);

}  // namespace enamel
