// The motion of a device in recordings: the data of an identification.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "enamel/runtime/recording.hpp"

namespace enamel {

/// Ticks without a gap. Column i of a matrix belongs to tick i.
struct RecordedMotion {
  double period = 1e-3;        ///< of the ticks, s
  std::vector<double> time;    ///< of each tick, s; strictly increasing
  Eigen::MatrixXd command;     ///< one row per joint, N m or N; sent at the tick
  Eigen::MatrixXd reading;     ///< one row per joint, rad or m; interpolated at ticks without a sample
  std::vector<char> isSample;  ///< 1: the tick had a new sample; the first and the last tick have one
  bool isLimited = false;      ///< the guard limited the torque at some ticks
  double weight = 0.0;         ///< known mass that was attached at the TCP, kg

  Eigen::Index ticks() const noexcept { return reading.cols(); }
};

/// Shortest motion that is used, s.
inline constexpr double kShortestMotion = 2.0;

/// Return the motions in ticks: it ends at a missing tick, and at a tick without enable. Motions shorter than
/// kShortestMotion are left out. Throws Error if a vector does not have `joints` numbers. Realtime: no.
std::vector<RecordedMotion> motionsOf(const std::vector<RecordedTick>& ticks, double period, int joints);

/// Return the motions in a recording. Damaged chunks count as missing ticks. Throws ConfigurationError as
/// RecordingReader, and Error as above or if the recording has another number of joints. Realtime: no.
std::vector<RecordedMotion> loadMotions(const std::string& path, int joints);

}  // namespace enamel
