// Identification of a device: from recordings and a device file with wrong numbers to numbers with intervals.
//
// The recorded commands move a simulated device. The numbers of the device file change until the simulated readings
// agree with the recorded ones. Without a known force or mass the scale of all forces is unknown: the torque constants
// of the motors and all masses can be wrong by one common factor. The motors' mean is therefore taken as correct.
// Motions with a known weight at the TCP, and others without, show that factor. It does not change the device's
// numbers.
#pragma once

#include <string>
#include <vector>

#include "enamel/device/device_file.hpp"
#include "enamel/identify/excitation.hpp"
#include "enamel/identify/motion.hpp"

namespace enamel {

/// An estimated number.
struct Estimate {
  std::string key;               ///< key of the device file, such as "platform.mass", or a name in words
  std::string unit;              ///< "" for a ratio
  double before = 0.0;           ///< value of the device file, or the assumption without one
  double value = 0.0;            ///< estimate
  double low = 0.0, high = 0.0;  ///< 95 % interval
  bool isInFile = true;          ///< `key` is a key of the device file
  bool isSeen = true;            ///< false: the recording does not show it; the interval says what is still possible
};

/// Delay from the command of a tick to the motor, in ticks. It is uniform in low to high.
struct DelayEstimate {
  int low = 0, high = 0;
  bool isCertain = false;  ///< false: another delay explains the recording nearly as well
  double evidence = 0.0;   ///< difference of the log likelihood to the second best delay
  std::string second;      ///< the second best delay, such as "2" or "1..3"
};

/// The part of the data that the fit does not use, and its prediction. Column i belongs to tick i; one row per joint.
struct IdentificationTraces {
  double period = 0.0;             ///< s
  std::vector<std::string> joint;  ///< names of the rows: "joint 2", "axis y", "rotation about y"
  /// Command below 20 Hz, and the torque that gives the model the recorded motion, N m or N. Both fade in and out.
  Eigen::MatrixXd torque, explained;
  Eigen::VectorXd frequency;  ///< Hz, of the columns of `residual`
  Eigen::MatrixXd residual;   ///< reading minus prediction, rad/sqrt(Hz) or m/sqrt(Hz)
};

/// Result of an identification.
struct Identification {
  DeviceParameters device;  ///< with the estimates that are keys of the file and are seen
  std::vector<Estimate> estimates;
  DelayEstimate delay;
  double lostSamples = 0.0;  ///< share of the ticks without a sample
  Eigen::VectorXd noise;     ///< of each reading, standard deviation above 100 Hz, rad or m
  /// Share of the variance of each torque below 20 Hz that the result explains, in the last fifth of the data or more.
  /// The fit does not use that part.
  Eigen::VectorXd explained;
  IdentificationTraces traces;        ///< empty if the wiring is wrong
  std::vector<std::string> problems;  ///< in words; if there are any, `device` is not an estimate

  bool isUsable() const noexcept { return problems.empty(); }
};

struct IdentifyOptions {
  int threads = 0;  ///< 0: all processors
};

/// Estimate the numbers of a device.
///
/// - Estimates: the kinds of numbers that lib/docs/identify.md lists.
/// - Intervals hold for residuals of any spectrum. They do not cover effects that the model lacks.
/// - Problems: motors that are swapped or have a wrong sign, wrong units, motions that show nothing.
///
/// Throws Error if `motions` is empty, all of them have a weight, or they have different periods or weights.
/// Realtime: no.
Identification identifyDevice(const std::vector<RecordedMotion>& motions, const DeviceParameters& device,
                              const IdentifyOptions& options = {});

/// Return the precision that a recording of this excitation will have, before anything moves: estimates at the values
/// of the file. The device is simulated with the numbers of its file and rounded encoders. The intervals follow from
/// the Fisher information. A real device has effects that the model lacks: its intervals are wider. Throws Error if the
/// guard stops the simulated run. Realtime: no.
std::vector<Estimate> expectedPrecision(const Excitation& excitation, const DeviceParameters& device,
                                        const IdentifyOptions& options = {});

}  // namespace enamel
