// The tour of the split screen: what the hand does for 20 s, and what is said meanwhile. Knows no window.
#pragma once

#include <cstddef>
#include <optional>

#include "enamel/collision/contacts.hpp"
#include "hand.hpp"

namespace enamel::viewer {

/// The hand pushes into the nearest wall, slides along it and lets go, and is where it began at the end.
class Tour {
 public:
  static constexpr double kLength = 20.0;  ///< s
  static constexpr std::size_t kParts = 3;
  static constexpr double kForce =
      12.0;  ///< with which it presses, of its springs against a wall that does not give way, N

  /// `start`: of the TCP, m. `nearest`: its contact there, near or far. `grip`: of the hand.
  Tour(const Vec3& start, const Contact& nearest, const Grip& grip) noexcept;

  /// The hand's target so long after the beginning, m; `time` in s, at the ends where it is outside.
  Vec3 hand(double time) const noexcept;

  /// Which part it is then, 0 to kParts - 1.
  static std::size_t part(double time) noexcept;
  struct Words {
    const char* title;
    const char* sentence;
  };
  static const Words& words(std::size_t part) noexcept;

 private:
  Vec3 start_, pressed_, along_;
};

/// What moves the hand when no person does: a tour, or a script along a line. Times in s, of one clock.
class HandMotion {
 public:
  void startTour(const Tour& tour, double now);
  void endTour() { tour_.reset(); }
  bool isTouring() const { return tour_.has_value(); }
  /// Since the tour began; negative: no tour.
  double tourTime(double now) const { return tour_ ? now - begin_ : -1.0; }

  /// Along a line, mm, for so many seconds.
  void startLine(const Vec3& from, const Vec3& to, double seconds, double now);
  void endLine() { line_.reset(); }

  /// Where the hand is at `now`, m, or nothing. A line ends here.
  std::optional<Vec3> target(double now);

 private:
  struct Line {
    Vec3 from, to;
    double seconds;
  };

  std::optional<Tour> tour_;
  std::optional<Line> line_;
  double begin_ = 0.0;
};

/// Whether the program was never started before by this user; from now on it was. A file in $XDG_STATE_HOME (or
/// ~/.local/state) remembers it: where none can be written, no start is the first.
bool isFirstStart();

}  // namespace enamel::viewer
