// The tour of the split screen: a test push, then motions of the hand, with texts. Independent of any window.
#pragma once

#include <cstddef>
#include <optional>

#include "enamel/collision/contacts.hpp"
#include "hand.hpp"

namespace enamel::viewer {

/// After a test push the hand presses the nearest wall, slides along it, releases it, and ends where it began.
class Tour {
 public:
  static constexpr double kLength = 20.0;  ///< s
  static constexpr std::size_t kParts = 3;
  static constexpr double kPush = 1.0;    ///< begin of the test push, s
  static constexpr double kForce = 12.0;  ///< force of its springs against a rigid wall, N

  /// `start`: of the TCP, m. `nearest`: nearest contact at that pose, at any distance. `grip`: of the hand.
  Tour(const Vec3& start, const Contact& nearest, const Grip& grip) noexcept;

  /// Return the hand's target, m. `time`: s since the beginning; times outside the tour give its ends.
  Vec3 hand(double time) const noexcept;

  /// Return the part of the tour at that time, 0 to kParts - 1.
  static std::size_t part(double time) noexcept;
  struct Words {
    const char* title;
    const char* sentence;
  };
  static const Words& words(std::size_t part) noexcept;

 private:
  Vec3 start_, pressed_, along_;
};

/// Moves the hand in place of a person: a tour, or a line of a script. Times in s of one clock.
class HandMotion {
 public:
  void startTour(const Tour& tour, double now);
  void endTour() { tour_.reset(); }
  bool isTouring() const { return tour_.has_value(); }
  /// Return the time since the tour began; negative: no tour.
  double tourTime(double now) const { return tour_ ? now - begin_ : -1.0; }

  /// Return true once, when the tour's test push is due.
  bool takePush(double now);

  /// Start a motion along a line, mm, that lasts `seconds`.
  void startLine(const Vec3& from, const Vec3& to, double seconds, double now);
  void endLine() { line_.reset(); }

  /// Return the hand's target at `now`, m, or nothing. The end of a line ends its motion.
  std::optional<Vec3> target(double now);

 private:
  struct Line {
    Vec3 from, to;
    double seconds;
  };

  std::optional<Tour> tour_;
  std::optional<Line> line_;
  double begin_ = 0.0;
  bool pushed_ = false;
};

/// Return whether this user starts the program for the first time, and remember the start. A file in $XDG_STATE_HOME
/// (or
/// /.local/state) remembers it: if the file cannot be written, no start counts as the first.
bool isFirstStart();

}  // namespace enamel::viewer
