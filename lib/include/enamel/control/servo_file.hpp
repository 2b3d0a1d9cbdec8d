// The file of a designed servo: `enamel design --output` writes it, `--gain` reads it.
#pragma once

#include <Eigen/Core>
#include <string>

namespace enamel {

/// The part of a servo design that a renderer needs.
struct ServoFile {
  std::string model;     ///< name of the device file of the design
  double period = 0.0;   ///< Ts, s
  Eigen::MatrixXd gain;  ///< (K_c | K_i), n x 3n
};

/// Read a servo design from JSON with the keys "model", "period" (s) and "K" (a list for each row). Other keys are
/// ignored. Realtime: no.
/// Throws ConfigurationError:
/// - the file cannot be read or is not JSON;
/// - its "kind" is "surface", of an earlier version;
/// - a key is missing or of the wrong type;
/// - the period is outside 1e-5 to 0.1 s;
/// - the gain is not n x 3n with n in 1 to kMaxJoints.
ServoFile loadServo(const std::string& path);

}  // namespace enamel
