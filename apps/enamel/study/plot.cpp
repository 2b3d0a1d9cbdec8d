#include "study/plot.hpp"

#include <fmt/core.h>

#include <cmath>
#include <cstdlib>

namespace enamel::app {

std::string colourText(unsigned rgb) { return fmt::format("#{:06x}", rgb); }

Json numbers(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double v : values) list.push_back(std::isfinite(v) ? Json(std::stod(fmt::format("{:.5g}", v))) : Json());
  return list;
}

Json axis(const std::string& title, bool logarithmic) { return {{"title", title}, {"log", logarithmic}}; }

Json axis(const std::string& title, double low, double high, bool logarithmic) {
  return {{"title", title}, {"log", logarithmic}, {"low", low}, {"high", high}};
}

Json line(const std::string& name, Json x, const std::vector<double>& y, const Style& style) {
  return {{"type", "line"},
          {"name", name},
          {"x", std::move(x)},
          {"y", numbers(y)},
          {"colour", colourText(style.colour)},
          {"width", style.width},
          {"dash", style.dash}};
}

Json level(double y, const Style& style) {
  return {
      {"type", "level"}, {"y", y}, {"colour", colourText(style.colour)}, {"width", style.width}, {"dash", style.dash}};
}

Json boxOf(const std::string& group, const std::string& series, const Style& style, const std::vector<double>& values) {
  return {{"group", group},
          {"series", series},
          {"colour", colourText(style.colour)},
          {"dash", style.dash},
          {"values", numbers(values)}};
}

Json rectangle(double x0, double x1, double y0, double y1) {
  const Json ends = numbers({x0, x1, y0, y1});
  return {{"x0", ends[0]}, {"x1", ends[1]}, {"y0", ends[2]}, {"y1", ends[3]}};
}

Json panel(const std::string& title, double width, double height, Json x, Json y, Json layers) {
  return {{"title", title},    {"width", width},    {"height", height},
          {"x", std::move(x)}, {"y", std::move(y)}, {"layers", std::move(layers)}};
}

Json figure(const std::string& label, int columns, Json legend, Json panels) {
  return {{"label", label}, {"columns", columns}, {"legend", std::move(legend)}, {"panels", std::move(panels)}};
}

Json entry(const std::string& name, const Style& style, bool filled) {
  return {{"name", name}, {"colour", colourText(style.colour)}, {"dash", style.dash}, {"filled", filled}};
}

}  // namespace enamel::app
