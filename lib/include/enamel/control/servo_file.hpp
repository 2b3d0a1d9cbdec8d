// A designed servo as a file: what `enamel design --output` writes and `--gain` reads.
#pragma once

#include <Eigen/Core>
#include <string>

namespace enamel {

/// What a renderer needs of a design.
struct ServoFile {
  std::string model;     ///< name of the device file that it was designed on
  double period = 0.0;   ///< Ts, s
  Eigen::MatrixXd gain;  ///< (K_c | K_i), n x 3n
};

/// Reads a design (JSON: the keys "model", "period" in s and "K", a list a row; others are ignored).
/// Throws ConfigurationError: the file cannot be read or is not JSON; a key is missing or of the wrong type; a period
/// outside 1e-5 to 0.1 s; a gain that is not n x 3n with n in 1 to kMaxJoints. Realtime: no.
ServoFile loadServo(const std::string& path);

}  // namespace enamel
