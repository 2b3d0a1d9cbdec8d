#include "enamel/collision/tool.hpp"

#include <algorithm>
#include <initializer_list>

#include "enamel/core/error.hpp"

namespace enamel {
namespace {

constexpr int kSmallestHead = 3, kLargestHead = 100, kLongestHead = 200;  // 0.1 mm
constexpr double kShank = 0.8e-3, kShankLength = 4e-3;                    // radius of a friction grip shank, m
constexpr double kNeckShare = 0.6, kNeckLength = 3e-3;                    // of the head's radius

// A capsule along z from its lowest to its highest point.
struct Piece {
  double low, high, radius;
};

Tool along(std::initializer_list<Piece> pieces) {
  Tool tool;
  tool.count = 0;
  for (const Piece& piece : pieces)
    tool.parts[static_cast<std::size_t>(tool.count++)] = {Vec3(0.0, 0.0, piece.low + piece.radius),
                                                          Vec3(0.0, 0.0, piece.high - piece.radius), piece.radius};
  return tool;
}

// The neck begins inside the head. The round end of the shank may reach into the neck.
Tool bur(int size, int length) {
  const double radius = 0.5e-4 * size, top = 1e-4 * length, neck = std::min(kNeckShare * radius, kShank);
  const double shank = top + kNeckLength;
  return along(
      {{0.0, top, radius}, {top - radius - neck, shank + kShank, neck}, {shank, shank + kShankLength, kShank}});
}

// Three digits of a name; -1: other characters are there.
int numberAt(const std::string& name, std::size_t at) {
  int number = 0;
  for (std::size_t i = at; i < at + 3; ++i) {
    if (i >= name.size() || name[i] < '0' || name[i] > '9') return -1;
    number = 10 * number + name[i] - '0';
  }
  return number;
}

}  // namespace

Tool toolOf(const std::string& name) {
  const std::string round = "round-", cylinder = "cylinder-";
  if (name == "cpi-probe") return along({{0.0, 0.5e-3, 0.25e-3}, {0.1e-3, 12e-3, 0.2e-3}});
  if (name == "explorer") return along({{0.0, 1.5e-3, 0.1e-3}, {0.5e-3, 4e-3, 0.2e-3}, {2e-3, 10e-3, 0.35e-3}});
  if (name == "bur-245") return bur(8, 30);
  if (name.rfind(round, 0) == 0 && name.size() == round.size() + 3)
    if (const int size = numberAt(name, round.size()); size >= kSmallestHead && size <= kLargestHead)
      return bur(size, size);
  if (name.rfind(cylinder, 0) == 0 && name.size() == cylinder.size() + 7 && name[cylinder.size() + 3] == '-') {
    const int size = numberAt(name, cylinder.size()), length = numberAt(name, cylinder.size() + 4);
    if (size >= kSmallestHead && size <= kLargestHead && length >= size && length <= kLongestHead)
      return bur(size, length);
  }
  throw Error("\"" + name +
              "\" is not a tool: it must be \"round-D\", \"cylinder-D-L\", \"bur-245\", \"cpi-probe\" or \"explorer\", "
              "with a diameter D of 003 to 100 and a length L of D to 200, three digits each, in 0.1 mm");
}

}  // namespace enamel
