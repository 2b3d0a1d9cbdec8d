// Work on several cores. The result does not depend on their number.
#pragma once

#include <cstddef>
#include <functional>

namespace enamel {

/// Largest number of threads.
inline constexpr int kMaxThreads = 256;

/// Return the number of threads that this process may use. Realtime: no.
int availableThreads();

/// Call body(0) ... body(count - 1), each once, on `threads` threads. The first exception of a body is rethrown. Throws
/// Error if threads are outside 1 to kMaxThreads. Realtime: no.
void parallelFor(std::size_t count, int threads, const std::function<void(std::size_t)>& body);

/// Call work(i) for i = first, ..., count - 1 on `threads` threads. Then call done(i) on one thread at a time, in the
/// order of i. Work is at most 4 indices per thread ahead of done(). After stop() is true, no further index begins;
/// those under way finish. Return the first index without done(). The first exception is rethrown. Throws Error as
/// parallelFor(). Realtime: no.
std::size_t parallelInOrder(std::size_t first, std::size_t count, int threads,
                            const std::function<void(std::size_t)>& work, const std::function<void(std::size_t)>& done,
                            const std::function<bool()>& stop);

}  // namespace enamel
