// The registry of all measurements: `enamel bench` prints it, and the timing tests check it. Every row has an error
// beside its time, so that a fast but wrong result shows.
#pragma once

#include <Eigen/Core>
#include <chrono>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace enamel::bench {

/// Value of Measurement::goal_us in a row without a goal.
inline constexpr double kNoGoal = std::numeric_limits<double>::quiet_NaN();

/// One row of the table. Times are per call; NaN means "does not apply".
struct Measurement {
  std::string group;                                               ///< module, for example "device"
  std::string name;                                                ///< operation that is measured
  double median_us = 0.0;                                          ///< over batches of calls, or over single calls
  double p99_us = 0.0;                                             ///< likewise
  double error = 0.0;                                              ///< largest error of all calls
  std::string errorOf;                                             ///< quantity, unit and reference of the error
  double goal_us = std::numeric_limits<double>::quiet_NaN();       ///< goal
  double reference_us = std::numeric_limits<double>::quiet_NaN();  ///< same result in the conventional way, same run
  double p999_us = std::numeric_limits<double>::quiet_NaN();       ///< only if every call was timed alone
};

struct Timing {
  double median_us;
  double p99_us;
};

/// Return a percentile of sorted times. Clocks with coarse steps (10 ns on some machines) give many equal times; they
/// count as spread evenly over the step.
double percentile(const std::vector<double>& times_us, double part);

/// Make a row from the times of single calls: median, p99 and p99.9.
Measurement rowOf(const std::string& name, std::vector<double> times_us, double error, const std::string& errorOf);

/// Time batches of calls: `run(first, count)` makes `count` calls, numbered from `first`. The first batch is a warm-up.
Timing timeCalls(int batches, int callsPerBatch, const std::function<void(int first, int count)>& run);

/// Time single calls, for work whose cost varies from call to call: `run(i)` makes call i. The time to read the clock
/// is subtracted. The calls before `first` only warm up.
Timing timeEachCall(int calls, int first, const std::function<void(int i)>& run);

/// Time several functions for a comparison. They take turns of 1000 calls and repeat the whole series five times, so
/// that all see the same state of the machine. The first 20 calls of a turn do not count, because the caches then hold
/// the data of the other functions. `between` runs before every call and is not timed.
std::vector<Timing> timeInTurns(int calls, int first, const std::vector<std::function<void(int i)>>& runs,
                                const std::function<void()>& between = {});

/// Return the time of one call in us, including the clock (0.03 us).
template <typename Call>
double timeOnce(const Call& call) {
  const auto start = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

/// Random numbers that are the same in every run.
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

/// Keep the compiler from removing an unused result.
template <typename T>
inline void keep(const T& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

/// Return the largest |value - reference|, divided by the largest |reference|; the absolute error if that is zero.
double relativeError(const Eigen::MatrixXd& value, const Eigen::MatrixXd& reference);

/// Run every measurement whose group or name contains `filter`. `scale` multiplies the number of batches or calls.
std::vector<Measurement> measureAll(const std::string& filter, double scale);

std::vector<Measurement> measureDevice(double scale);
std::vector<Measurement> measureControl(double scale);
std::vector<Measurement> measureTick(double scale);
std::vector<Measurement> measureCollision(double scale);
std::vector<Measurement> measureScene(double scale);
std::vector<Measurement> measureSession(double scale);
std::vector<Measurement> measureSolid(double scale);
std::vector<Measurement> measurePlant(double scale);

}  // namespace enamel::bench
