// Drawings as SVG: the same bytes from the same numbers, inline in a page or files of their own.
#pragma once

#include <string>
#include <vector>

namespace enamel::app {

// Colours that the colour-blind tell apart too (M. Okabe, K. Ito 2002).
inline constexpr const char *kBlue = "#0072b2", *kVermilion = "#d55e00", *kGreen = "#009e73", *kOrange = "#e69f00",
                            *kPurple = "#cc79a7", *kSky = "#56b4e9", *kBrown = "#8c6d1f", *kMuted = "#66707c",
                            *kInk = "#1f262e", *kLine = "#d3d9e0", *kRed = "#9b2226", *kNoValue = "#bdbdbd";

/// Text as XML. What XML cannot hold, as control characters and bytes that are not UTF-8, becomes U+FFFD.
std::string escape(const std::string& text);

/// viridis (S. van der Walt, N. Smith 2015): rises evenly in lightness. share: 0 to 1.
std::string viridis(double share);

struct Place {
  double x = 0.0, y = 0.0;
};

struct Style {
  std::string colour = kInk;
  double width = 1.5;
  bool dashed = false;
};

enum class Anchor { start, middle, end };

/// A drawing, kWidth units wide, from the top left. "K_z1" in texts becomes a K with an index. What is not finite is
/// not drawn.
class Svg {
 public:
  static constexpr double kWidth = 800.0;

  void line(Place from, Place to, const Style& style);
  /// A line from place to place, interrupted where one is not finite; `closed`: an area in that colour instead.
  void path(const std::vector<Place>& places, const Style& style, bool closed = false);
  /// `title` is shown where the mouse rests.
  void box(Place corner, double width, double height, const std::string& fill, const std::string& title = "",
           const std::string& more = "");
  void disc(Place centre, double radius, const std::string& fill);
  void text(Place at, const std::string& text, Anchor anchor = Anchor::start, const std::string& colour = kInk,
            bool upwards = false);
  /// What follows is cut off outside of a rectangle, until closeGroup().
  void openWindow(Place corner, double width, double height);
  /// A group with attributes, until closeGroup().
  void openGroup(const std::string& attributes);
  void closeGroup();

  std::string whole(const std::string& label, double height) const;

 private:
  std::string body_;
  std::vector<const char*> open_;
};

/// How wide a text is, about.
double widthOf(const std::string& text);

struct Axis {
  std::string title;  ///< with its unit
  double low = 0.0, high = 1.0;
  bool logarithmic = false;
  bool numbers = true;  ///< false: those of the panel below or beside are its own

  double share(double value) const;  ///< 0 at `low`, 1 at `high`
  /// About `count` places: 1, 2 or 5 times powers of ten.
  std::vector<double> ticks(int count) const;
};

/// The range of values, widened by a share of it.
struct Extent {
  double low, high;
  Extent();
  void see(double value);
  Axis axis(const std::string& title, double margin, bool logarithmic = false) const;
};

/// A rectangle with axes.
class Panel {
 public:
  Panel(Svg& svg, Place corner, double width, double height, Axis x, Axis y, const std::string& title = "",
        bool grid = true);

  Place at(double x, double y) const;
  /// A line through (xs[i], ys[i]), cut off outside of the panel; `marks`: discs there too.
  void curve(const std::vector<double>& xs, const std::vector<double>& ys, const Style& style, bool marks = false);
  /// What lies between two curves.
  void band(const std::vector<double>& xs, const std::vector<double>& lows, const std::vector<double>& highs,
            const std::string& colour);
  void level(double y, const Style& style) { svg_.line(at(x_.low, y), at(x_.high, y), style); }

 private:
  Svg& svg_;
  Place corner_;
  double width_, height_;
  Axis x_, y_;
};

/// A bar of viridis from the axis' lowest to its highest value, with numbers to its right.
void addColourBar(Svg& svg, Place corner, double height, const Axis& axis);

struct LegendEntry {
  std::string name;
  Style style;
  bool filled = false;  ///< a box instead of a line
};

/// In rows from a corner on; returns the height of all.
double addLegend(Svg& svg, Place corner, double width, const std::vector<LegendEntry>& entries);

}  // namespace enamel::app
