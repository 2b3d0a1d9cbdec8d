// Limits of the numbers of a bur, for scene files and Drill. Not of its torque: infinite is a constant speed.
#pragma once

#include <array>

#include "enamel/collision/tool.hpp"

namespace enamel {

struct BurNumber {
  const char *key, *unit;  // in a scene file
  double Bur::*value;
  double low, high;
};

inline constexpr std::array<BurNumber, 8> kBurNumbers{{
    {"wear", "", &Bur::wear, 1e-9, 1e3},
    {"turns", " 1/s", &Bur::turns, 0.0, 1e4},
    {"inertia", " kg m^2", &Bur::inertia, 1e-12, 1e-3},
    {"drag", "", &Bur::drag, 0.0, 10.0},
    {"run_out", " m", &Bur::runOut, 0.0, 1e-4},
    {"shaft_compliance", " m/N", &Bur::shaftCompliance, 0.0, 1e-3},
    {"shaft_frequency", " Hz", &Bur::shaftFrequency, 0.0, 1e5},
    {"shaft_damping", "", &Bur::shaftDamping, 0.0, 1.0},
}};
inline constexpr int kMostBlades = 100;

}  // namespace enamel
