// servo.json: `enamel design --output` writes it and loadServo() reads it.
#pragma once

#include <string>
#include <vector>

#include "enamel/control/device_plant.hpp"
#include "enamel/control/margins.hpp"
#include "enamel/control/servo_simulation.hpp"

namespace enamel::app {

/// A servo with everything that was measured on it.
struct DesignedServo {
  std::string model;           ///< name of the device file
  Vec3 position;               ///< operating point, m
  double deviceDamping = 0.0;  ///< in addition to the damping of the device file, N s/m
  double linearisationError = 0.0;
  DevicePlant plant;
  ServoDesign design;
  std::vector<std::complex<double>> poles;  ///< rad/s, fastest first
  double spectralRadius = 0.0;
  Margins margins;
  std::vector<Requirement> requirements;  ///< Table II
};

std::string jsonOf(const DesignedServo& servo);

}  // namespace enamel::app
