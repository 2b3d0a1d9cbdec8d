#include "study/svg.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "study/numbers.hpp"

namespace enamel::app {
namespace {

constexpr double kFontSize = 13.0, kRow = 20.0;
constexpr const char* kAnchors[] = {"start", "middle", "end"};

std::string dash(const Style& style) {
  return fmt::format("stroke=\"{}\" stroke-width=\"{:g}\"{}", style.colour, style.width,
                     style.dashed ? " stroke-dasharray=\"6 4\"" : "");
}

bool isFinite(Place p) { return std::isfinite(p.x) && std::isfinite(p.y); }

// Return the text with the subscript in "K_z1" lowered.
std::string withIndices(const std::string& text) {
  const std::size_t mark = text.find('_');
  if (mark == std::string::npos) return escape(text);
  const std::size_t end = std::min(text.find_first_of(" ,()|/", mark), text.size());
  return escape(text.substr(0, mark)) + "<tspan dy=\"3\" font-size=\"10\">" +
         escape(text.substr(mark + 1, end - mark - 1)) + "</tspan><tspan dy=\"-3\">" + withIndices(text.substr(end)) +
         "</tspan>";
}

double niceStep(double span, int count) {
  const double raw = span / count, power = std::pow(10.0, std::floor(std::log10(raw)));
  return raw < 1.5 * power ? power : raw < 3.5 * power ? 2.0 * power : raw < 7.5 * power ? 5.0 * power : 10.0 * power;
}

// Return the labels of ticks: with the same decimals if they are evenly spaced, else each as short as possible.
std::vector<std::string> textsOf(const std::vector<double>& ticks) {
  std::vector<std::string> texts;
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 0.0;
  const bool even = ticks.size() > 1 && std::abs(ticks.back() - ticks[ticks.size() - 2] - step) < 1e-6 * step;
  for (const double tick : ticks) {
    int digits = 1;
    while (digits < 6 && std::abs(std::stod(fmt::format("{:.{}e}", tick, digits - 1)) - tick) > 1e-7 * std::abs(tick))
      ++digits;
    texts.push_back(even && step < 1e5 ? placedText(tick, static_cast<int>(std::floor(std::log10(step) + 1e-9)))
                                       : numberText(tick, digits));
  }
  return texts;
}

struct Character {
  std::size_t bytes;
  bool isXml;  // false: not UTF-8, or not allowed in XML
};

Character characterAt(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned first = byte(at);
  if (first < 0x80) return {1, first >= 0x20 || first == '\n' || first == '\t'};
  const std::size_t size = first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : first < 0xf5 ? 4 : 0;
  unsigned code = size == 0 ? 0 : first & (0x7fu >> size);
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(at + i) & 0xc0u) != 0x80u) return {1, false};
    code = code << 6 | (byte(at + i) & 0x3fu);
  }
  const bool isLong = (size == 3 && code < 0x800) || (size == 4 && code < 0x10000);
  if (size == 0 || isLong || (code >= 0xd800 && code < 0xe000) || code > 0x10ffff) return {1, false};
  return {size, (code & ~1u) != 0xfffe};
}

}  // namespace

std::string escape(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    const Character character = characterAt(text, i);
    if (!character.isXml)
      out += "\ufffd";
    else if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out.append(text, i, character.bytes);
    i += character.bytes;
  }
  return out;
}

std::string viridis(double share) {
  constexpr double kPlaces[][3] = {{68, 1, 84},    {71, 45, 123}, {59, 82, 139},  {44, 114, 142}, {33, 145, 140},
                                   {40, 174, 128}, {94, 201, 98}, {173, 220, 48}, {253, 231, 37}};
  const double at = std::clamp(share, 0.0, 1.0) * (std::size(kPlaces) - 1);
  const auto i = std::min<std::size_t>(static_cast<std::size_t>(at), std::size(kPlaces) - 2);
  std::string colour = "#";
  for (int c = 0; c < 3; ++c)
    colour +=
        fmt::format("{:02x}", static_cast<int>(std::lround(kPlaces[i][c] + (at - static_cast<double>(i)) *
                                                                               (kPlaces[i + 1][c] - kPlaces[i][c]))));
  return colour;
}

// ---- the writer ----------------------------------------------------------------------------------------------------

void Svg::line(Place from, Place to, const Style& style) {
  if (isFinite(from) && isFinite(to))
    body_ += fmt::format("<line x1=\"{:.2f}\" y1=\"{:.2f}\" x2=\"{:.2f}\" y2=\"{:.2f}\" {}/>\n", from.x, from.y, to.x,
                         to.y, dash(style));
}

void Svg::path(const std::vector<Place>& places, const Style& style, bool closed) {
  std::string steps;
  bool begun = false;
  for (const Place& p : places) {
    if (isFinite(p)) steps += fmt::format("{}{:.2f},{:.2f}", begun ? " " : "M", p.x, p.y);
    begun = isFinite(p);
  }
  if (steps.empty()) return;
  body_ += closed
               ? fmt::format("<path d=\"{}Z\" fill=\"{}\"/>\n", steps, style.colour)
               : fmt::format("<path d=\"{}\" fill=\"none\" stroke-linejoin=\"round\" stroke-linecap=\"round\" {}/>\n",
                             steps, dash(style));
}

void Svg::box(Place corner, double width, double height, const std::string& fill, const std::string& title,
              const std::string& more) {
  if (!isFinite(corner) || !isFinite({width, height})) return;
  body_ += fmt::format("<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"{}\"{}{}", corner.x,
                       corner.y, width, height, fill, more.empty() ? "" : " ", more);
  body_ += title.empty() ? "/>\n" : "><title>" + escape(title) + "</title></rect>\n";
}

void Svg::disc(Place centre, double radius, const std::string& fill) {
  if (isFinite(centre))
    body_ +=
        fmt::format("<circle cx=\"{:.2f}\" cy=\"{:.2f}\" r=\"{:g}\" fill=\"{}\"/>\n", centre.x, centre.y, radius, fill);
}

void Svg::text(Place at, const std::string& text, Anchor anchor, const std::string& colour, bool upwards) {
  const std::string place = upwards ? fmt::format("transform=\"translate({:.2f},{:.2f}) rotate(-90)\"", at.x, at.y)
                                    : fmt::format("x=\"{:.2f}\" y=\"{:.2f}\"", at.x, at.y);
  body_ += fmt::format("<text {} text-anchor=\"{}\" fill=\"{}\">{}</text>\n", place, kAnchors[static_cast<int>(anchor)],
                       colour, withIndices(text));
}

void Svg::openWindow(Place corner, double width, double height) {
  // An inner svg element clips its contents.
  body_ += fmt::format(
      "<svg x=\"{0:.2f}\" y=\"{1:.2f}\" width=\"{2:.2f}\" height=\"{3:.2f}\" viewBox=\"{0:.2f} {1:.2f} {2:.2f} "
      "{3:.2f}\">\n",
      corner.x, corner.y, width, height);
  open_.push_back("</svg>\n");
}

void Svg::openGroup(const std::string& attributes) {
  body_ += "<g " + attributes + ">\n";
  open_.push_back("</g>\n");
}

void Svg::closeGroup() {
  body_ += open_.back();
  open_.pop_back();
}

std::string Svg::whole(const std::string& label, double height) const {
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:g} {:g}\" role=\"img\" aria-label=\"{}\" "
             "font-family=\"sans-serif\" font-size=\"{:g}\">\n",
             kWidth, std::ceil(height), escape(label), kFontSize) +
         body_ + "</svg>\n";
}

double widthOf(const std::string& text) {
  double characters = 0.0;
  for (const char c : text) characters += (static_cast<unsigned char>(c) & 0xC0) != 0x80;  // UTF-8 lead bytes
  return 0.55 * kFontSize * characters;
}

// ---- axes ----------------------------------------------------------------------------------------------------------

double Axis::share(double value) const {
  return logarithmic ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
}

std::vector<double> Axis::ticks(int count) const {
  std::vector<double> places;
  if (logarithmic) {
    const double decades = std::log10(high / low);
    const int every = std::max(1, static_cast<int>(std::ceil(decades / (1.5 * count))));
    for (int decade = static_cast<int>(std::floor(std::log10(low))); std::pow(10.0, decade) <= high; ++decade)
      for (const double factor : {1.0, 2.0, 5.0}) {
        const double place = factor * std::pow(10.0, decade);
        if (place >= low * (1.0 - 1e-9) && place <= high * (1.0 + 1e-9) &&
            (decades < 2.2 || (factor == 1.0 && decade % every == 0)))
          places.push_back(place);
      }
    if (places.size() > 1) return places;
    places.clear();
  }
  for (; places.size() < 2; ++count) {  // one tick shows no scale
    places.clear();
    const double step = niceStep(high - low, count);
    for (auto i = std::llround(std::ceil(low / step - 1e-9)); static_cast<double>(i) * step <= high + 1e-9 * step; ++i)
      places.push_back(static_cast<double>(i) * step);
  }
  return places;
}

Extent::Extent() : low(HUGE_VAL), high(-HUGE_VAL) {}

void Extent::see(double value) {
  if (std::isfinite(value)) low = std::min(low, value), high = std::max(high, value);
}

Axis Extent::axis(const std::string& title, double margin, bool logarithmic) const {
  if (!(low <= high)) return {title, logarithmic ? 0.1 : 0.0, 1.0, logarithmic};
  if (logarithmic) {
    const double factor = high > low ? std::pow(high / low, margin) : 1.05;
    return {title, low / factor, high * factor, true};
  }
  const double more = high > low ? margin * (high - low) : high == 0.0 ? 1.0 : 0.05 * std::abs(high);
  return {title, low - more, high + more};
}

Panel::Panel(Svg& svg, Place corner, double width, double height, Axis x, Axis y, const std::string& title, bool grid)
    : svg_(svg), corner_(corner), width_(width), height_(height), x_(std::move(x)), y_(std::move(y)) {
  svg_.openGroup(fmt::format("data-x=\"{:.6g} {:.6g}\" data-y=\"{:.6g} {:.6g}\"", x_.low, x_.high, y_.low, y_.high));
  const double bottom = corner.y + height, right = corner.x + width;
  const Style thin{kLine, 1.0};
  const std::vector<double> xTicks = x_.ticks(std::max(2, static_cast<int>(width / 70.0))),
                            yTicks = y_.ticks(std::max(2, static_cast<int>(height / 40.0)));
  const std::vector<std::string> xTexts = textsOf(xTicks), yTexts = textsOf(yTicks);
  for (std::size_t i = 0; i < xTicks.size(); ++i) {
    const double at = corner.x + width * x_.share(xTicks[i]);
    if (grid) svg_.line({at, corner.y}, {at, bottom}, thin);
    if (x_.numbers) {
      svg_.line({at, bottom}, {at, bottom + 4.0}, {kMuted, 1.0});
      svg_.text({at, bottom + 18.0}, xTexts[i], Anchor::middle, kMuted);
    }
  }
  double longest = 0.0;
  for (std::size_t i = 0; i < yTicks.size(); ++i) {
    const double at = bottom - height * y_.share(yTicks[i]);
    if (grid) svg_.line({corner.x, at}, {right, at}, thin);
    if (y_.numbers) {
      svg_.line({corner.x - 4.0, at}, {corner.x, at}, {kMuted, 1.0});
      svg_.text({corner.x - 7.0, at + 4.5}, yTexts[i], Anchor::end, kMuted);
      longest = std::max(longest, widthOf(yTexts[i]));
    }
  }
  svg_.box(corner, width, height, "none", "", fmt::format("stroke=\"{}\"", kMuted));
  if (x_.numbers && !x_.title.empty()) svg_.text({corner.x + 0.5 * width, bottom + 38.0}, x_.title, Anchor::middle);
  if (y_.numbers && !y_.title.empty())
    svg_.text({corner.x - 18.0 - longest, corner.y + 0.5 * height}, y_.title, Anchor::middle, kInk, true);
  std::string line = title;
  if (widthOf(title) > width)
    if (const std::size_t space = title.rfind(' ', (title.size() + 1) / 2); space != std::string::npos) {
      svg_.text({corner.x + 0.5 * width, corner.y - 7.0 - 0.8 * kRow}, title.substr(0, space), Anchor::middle);
      line = title.substr(space + 1);
    }
  if (!line.empty()) svg_.text({corner.x + 0.5 * width, corner.y - 7.0}, line, Anchor::middle);
  svg_.closeGroup();
}

Place Panel::at(double x, double y) const {
  return {corner_.x + width_ * x_.share(x), corner_.y + height_ * (1.0 - y_.share(y))};
}

void Panel::curve(const std::vector<double>& xs, const std::vector<double>& ys, const Style& style, bool marks) {
  std::vector<Place> places;
  for (std::size_t i = 0; i < xs.size(); ++i) places.push_back(at(xs[i], ys[i]));
  svg_.openWindow(corner_, width_, height_);
  svg_.path(places, style);
  if (marks)
    for (const Place& p : places) svg_.disc(p, 3.5, style.colour);
  svg_.closeGroup();
}

void Panel::band(const std::vector<double>& xs, const std::vector<double>& lows, const std::vector<double>& highs,
                 const std::string& colour) {
  std::vector<Place> places;
  for (std::size_t i = 0; i < xs.size(); ++i) places.push_back(at(xs[i], lows[i]));
  for (std::size_t i = xs.size(); i-- > 0;) places.push_back(at(xs[i], highs[i]));
  svg_.openWindow(corner_, width_, height_);
  svg_.openGroup("opacity=\"0.25\"");
  svg_.path(places, {colour}, true);
  svg_.closeGroup();
  svg_.closeGroup();
}

void addColourBar(Svg& svg, Place corner, double height, const Axis& axis) {
  constexpr int kSteps = 64;
  constexpr double kWidth = 14.0;
  // Each box overlaps the next one, so that no gaps show.
  for (int i = 0; i < kSteps; ++i)
    svg.box({corner.x, corner.y + height * i / kSteps}, kWidth, height * (i + 1 < kSteps ? 1.5 : 1.0) / kSteps,
            viridis(1.0 - (i + 0.5) / kSteps));
  double longest = 0.0;
  const std::vector<double> ticks = axis.ticks(std::max(2, static_cast<int>(height / 40.0)));
  const std::vector<std::string> texts = textsOf(ticks);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double at = corner.y + height * (1.0 - axis.share(ticks[i]));
    svg.line({corner.x + kWidth, at}, {corner.x + kWidth + 4.0, at}, {kMuted, 1.0});
    svg.text({corner.x + kWidth + 7.0, at + 4.5}, texts[i], Anchor::start, kMuted);
    longest = std::max(longest, widthOf(texts[i]));
  }
  svg.text({corner.x + kWidth + longest + 28.0, corner.y + 0.5 * height}, axis.title, Anchor::middle, kInk, true);
}

double addLegend(Svg& svg, Place corner, double width, const std::vector<LegendEntry>& entries) {
  constexpr double kSample = 26.0, kGap = 7.0, kBetween = 24.0;
  double x = corner.x, y = corner.y;
  for (const LegendEntry& entry : entries) {
    const double wide = kSample + kGap + widthOf(entry.name);
    if (x > corner.x && x + wide > corner.x + width) x = corner.x, y += kRow;
    if (entry.filled)
      svg.box({x + 7.0, y + 4.0}, 12.0, 12.0, entry.style.colour);
    else
      svg.line({x, y + 10.0}, {x + kSample, y + 10.0}, entry.style);
    svg.text({x + kSample + kGap, y + 14.5}, entry.name);
    x += wide + kBetween;
  }
  return entries.empty() ? 0.0 : y + kRow - corner.y;
}

}  // namespace enamel::app
