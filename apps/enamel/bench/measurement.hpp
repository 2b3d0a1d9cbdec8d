// The one registry of measurements: `enamel bench` prints it, the timing tests check it. Every row has the error
// beside the time, because a fast wrong answer is worth nothing.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace enamel::bench {

/// Measurement::goal_us of a row without one.
inline constexpr double kNoGoal = std::numeric_limits<double>::quiet_NaN();

/// One row of the table. Times are per call; NaN stands for "does not apply".
struct Measurement {
  std::string group;                                               ///< module, for example "device"
  std::string name;                                                ///< what was done
  double median_us = 0.0;                                          ///< over batches of calls, or over single calls
  double p99_us = 0.0;                                             ///< likewise
  double error = 0.0;                                              ///< largest error seen
  std::string errorOf;                                             ///< what the error is, its unit, and against what
  double goal_us = std::numeric_limits<double>::quiet_NaN();       ///< stated goal
  double reference_us = std::numeric_limits<double>::quiet_NaN();  ///< the same job done conventionally, same run
  double p999_us = std::numeric_limits<double>::quiet_NaN();       ///< where every call was timed on its own
};

struct Timing {
  double median_us;
  double p99_us;
};

/// Of sorted times. A clock that goes in steps, of 10 ns on some machines, gives many equal ones: they are taken as
/// spread evenly over the step.
double percentile(const std::vector<double>& times_us, double part);

/// A row for single calls that were timed each: its median, p99 and p99.9.
Measurement rowOf(const std::string& name, std::vector<double> times_us, double error, const std::string& errorOf);

/// Times batches of calls: `run(first, count)` makes `count` calls, numbered from `first`. One warm-up batch first.
Timing timeCalls(int batches, int callsPerBatch, const std::function<void(int first, int count)>& run);

/// Times single calls, for work whose cost varies from call to call: `run(i)` makes call i. What reading the clock
/// costs is subtracted. The calls before `first` only warm up.
Timing timeEachCall(int calls, int first, const std::function<void(int i)>& run);

/// The same for several that are to be compared: they take turns of 1000 calls, five times from the first to the last
/// one, so that all see the same machine. The first 20 calls of a turn, which find the other ones' data in the caches,
/// do not count. `between` is done before every call and not timed.
std::vector<Timing> timeInTurns(int calls, int first, const std::vector<std::function<void(int i)>>& runs,
                                const std::function<void()>& between = {});

/// Time of one call, the clock included (0.03 us), us.
template <typename Call>
double timeOnce(const Call& call) {
  const auto start = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

/// The same random numbers at every run.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed = 7) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  Eigen::Vector3d vector() {  // in -1 to 1
    const double x = (*this)(-1, 1), y = (*this)(-1, 1), z = (*this)(-1, 1);
    return {x, y, z};
  }

 private:
  std::mt19937_64 engine_;
};

/// Keeps the compiler from dropping a result that is not used otherwise.
template <typename T>
inline void keep(const T& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

/// Largest |value - reference| over the largest |reference|; absolute where the reference is zero.
double relativeError(const Eigen::MatrixXd& value, const Eigen::MatrixXd& reference);

/// Runs every measurement whose group or name contains `filter`. `scale` multiplies the number of batches or calls.
std::vector<Measurement> measureAll(const std::string& filter, double scale);

std::vector<Measurement> measureDevice(double scale);
std::vector<Measurement> measureControl(double scale);
std::vector<Measurement> measureTick(double scale);
std::vector<Measurement> measureCollision(double scale);
std::vector<Measurement> measureScene(double scale);
std::vector<Measurement> measureSolid(double scale);
std::vector<Measurement> measurePlant(double scale);

}  // namespace enamel::bench
