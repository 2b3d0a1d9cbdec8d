// Limits of the numbers of a bur, for scene files and Drill.
#pragma once

#include <array>
#include <limits>

#include "enamel/collision/tool.hpp"

namespace enamel {

struct BurNumber {
  const char* key;  // in a scene file
  double Bur::*value;
  double low, high;
};

inline constexpr std::array<BurNumber, 6> kBurNumbers{{
    {"wear", &Bur::wear, 1e-9, 1e3},
    {"turns", &Bur::turns, 0.0, 1e4},
    {"torque", &Bur::torque, 1e-6, std::numeric_limits<double>::infinity()},
    {"inertia", &Bur::inertia, 1e-12, 1e-3},
    {"drag", &Bur::drag, 0.0, 10.0},
    {"run_out", &Bur::runOut, 0.0, 1e-4},
}};
inline constexpr int kMostBlades = 100;

}  // namespace enamel
