// Drawings as SVG, inline in a page or as files. The same numbers give the same bytes.
#pragma once

#include <string>
#include <vector>

namespace enamel::app {

// Colours that colour-blind people can distinguish (M. Okabe, K. Ito 2002).
inline constexpr const char *kBlue = "#0072b2", *kVermilion = "#d55e00", *kGreen = "#009e73", *kOrange = "#e69f00",
                            *kPurple = "#cc79a7", *kSky = "#56b4e9", *kBrown = "#8c6d1f", *kMuted = "#66707c",
                            *kInk = "#1f262e", *kLine = "#d3d9e0", *kRed = "#9b2226", *kNoValue = "#bdbdbd";

/// Escape a text for XML. Characters that XML does not allow and bytes that are not UTF-8 become U+FFFD.
std::string escape(const std::string& text);

/// Return a colour of viridis (S. van der Walt, N. Smith 2015), whose lightness rises evenly. share: 0 to 1.
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

/// A drawing that is kWidth units wide, with the origin at the top left. "K_z1" in texts becomes K with a subscript.
/// Values that are not finite are not drawn.
class Svg {
 public:
  static constexpr double kWidth = 800.0;

  void line(Place from, Place to, const Style& style);
  /// Draw a polyline with gaps at places that are not finite; `closed`: fill an area with that colour instead.
  void path(const std::vector<Place>& places, const Style& style, bool closed = false);
  /// `title` is the tooltip.
  void box(Place corner, double width, double height, const std::string& fill, const std::string& title = "",
           const std::string& more = "");
  void disc(Place centre, double radius, const std::string& fill);
  void text(Place at, const std::string& text, Anchor anchor = Anchor::start, const std::string& colour = kInk,
            bool upwards = false);
  /// Clip everything that follows to a rectangle, until closeGroup().
  void openWindow(Place corner, double width, double height);
  /// Open a group with attributes, until closeGroup().
  void openGroup(const std::string& attributes);
  void closeGroup();

  std::string whole(const std::string& label, double height) const;

 private:
  std::string body_;
  std::vector<const char*> open_;
};

/// Return the approximate width of a text.
double widthOf(const std::string& text);

struct Axis {
  std::string title;  ///< with unit
  double low = 0.0, high = 1.0;
  bool logarithmic = false;
  bool numbers = true;  ///< false: the neighbouring panel has the numbers

  double share(double value) const;  ///< 0 at `low`, 1 at `high`
  /// Return about `count` ticks, at least two: 1, 2 or 5 times a power of ten.
  std::vector<double> ticks(int count) const;
};

/// The range of values, widened by a fraction of its width.
struct Extent {
  double low, high;
  Extent();
  void see(double value);
  Axis axis(const std::string& title, double margin, bool logarithmic = false) const;
};

/// A rectangular plot with axes.
class Panel {
 public:
  Panel(Svg& svg, Place corner, double width, double height, Axis x, Axis y, const std::string& title = "",
        bool grid = true);

  Place at(double x, double y) const;
  /// Draw a line through (xs[i], ys[i]), clipped to the panel; `marks`: with discs at the points.
  void curve(const std::vector<double>& xs, const std::vector<double>& ys, const Style& style, bool marks = false);
  /// Fill the area between two curves.
  void band(const std::vector<double>& xs, const std::vector<double>& lows, const std::vector<double>& highs,
            const std::string& colour);
  void level(double y, const Style& style) { svg_.line(at(x_.low, y), at(x_.high, y), style); }

 private:
  Svg& svg_;
  Place corner_;
  double width_, height_;
  Axis x_, y_;
};

/// Draw a viridis bar from the axis' lowest to its highest value, with numbers to its right.
void addColourBar(Svg& svg, Place corner, double height, const Axis& axis);

struct LegendEntry {
  std::string name;
  Style style;
  bool filled = false;  ///< draw a box instead of a line
};

/// Draw a legend in rows from a corner. Return its height.
double addLegend(Svg& svg, Place corner, double width, const std::vector<LegendEntry>& entries);

}  // namespace enamel::app
