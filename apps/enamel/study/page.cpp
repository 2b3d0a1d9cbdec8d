#include "study/page.hpp"

#include <algorithm>
#include <cctype>

namespace enamel::app {
namespace {

constexpr const char* kStyle = R"(
body { font: 16px/1.5 sans-serif; color: #1f262e; max-width: 58rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; line-height: 1.25; margin-bottom: 0.2rem; } h2 { font-size: 1.25rem; margin-top: 2.4rem; }
table { border-collapse: collapse; width: 100%; margin: 0.8rem 0; font-size: 0.875rem; line-height: 1.35; }
caption { text-align: left; color: #4a535e; padding-bottom: 0.4rem; }
th, td { padding: 0.3rem 0.8rem 0.3rem 0; border-bottom: 1px solid #d3d9e0; text-align: right; vertical-align: top; }
th:first-child, td:first-child { text-align: left; min-width: 7rem; } th { border-bottom: 2px solid #66707c; font-weight: 600; }
td { overflow-wrap: break-word; } td small { display: block; color: #4a535e; font-size: 0.8rem; }
code { font: inherit; font-style: italic; white-space: nowrap; } sub { line-height: 0; }
td.yes { color: #00684d; } td.no { color: #a84300; font-weight: 600; }
dt { font-weight: 600; margin-top: 0.5rem; } dd { margin-left: 1.5rem; }
figure { margin: 1.6rem 0; } figure > svg { width: 100%; height: auto; display: block; }
figcaption { color: #4a535e; font-size: 0.92rem; margin-top: 0.4rem; }
p.note, li.note { color: #4a535e; font-size: 0.92rem; }
@media print { body { max-width: none; margin: 0; } figure, tr { break-inside: avoid; } h2 { break-after: avoid; } }
)";

bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }
bool isWord(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

// Return whether the space between `before` and `rest` is inside a number, or between a number and its unit.
bool sticks(const std::string& before, const std::string& rest) {
  static const char* const kUnits[] = {"N",  "N/m", "kN/m", "m",  "mm", "mm/N", "µm",  "µm/N", "m/N", "s",     "ms",
                                       "kg", "%",   "rad",  "Hz", "J",  "mJ",   "m/s", "kHz",  "deg", "ticks", "tick"};
  const auto starts = [&](const char* text) { return rest.rfind(text, 0) == 0; };
  const auto ends = [&](const char* text) {
    const std::string end(text);
    return before.size() >= end.size() && before.compare(before.size() - end.size(), end.size(), end) == 0;
  };
  if (before.empty() || rest.empty()) return false;
  for (const char* sign : {"±", "×", "="})
    if (starts(sign) || ends(sign)) return true;
  const bool number = isDigit(rest[0]) || starts("−") || (rest[0] == '-' && rest.size() > 1 && isDigit(rest[1]));
  const std::string word = rest.substr(0, std::min(rest.find_first_of(" ,;:.()<|&\n"), rest.size()));
  const bool unit = std::find(std::begin(kUnits), std::end(kUnits), word) != std::end(kUnits);
  if (isDigit(before.back())) return (number && isDigit(rest[0])) || unit;
  if (before.back() == ')') return unit;                                                               // (5, 5) mm
  if (before.back() == ',') return before.size() > 1 && isDigit(before[before.size() - 2]) && number;  // (5, 5)
  // N m, N s/m
  return before.back() == 'N' && (word == "m" || word == "s/m") &&
         (before.size() == 1 || !isWord(before[before.size() - 2]));
}

std::string typeset(const std::string& html) {
  std::string out;
  out.reserve(html.size() + html.size() / 16);
  bool tag = false;
  for (std::size_t i = 0; i < html.size(); ++i) {
    const char c = html[i];
    tag = c == '<' || (tag && c != '>');
    const char before = i > 0 ? html[i - 1] : ' ', after = i + 1 < html.size() ? html[i + 1] : ' ';
    if (tag || c == '>') {
      out += c;
    } else if (c == ' ') {
      const std::size_t back = std::min<std::size_t>(i, 4);
      out += sticks(html.substr(i - back, back), html.substr(i + 1, 8)) ? "\u00a0" : " ";
    } else if (c == '-' && isDigit(after) && !isWord(before) && before != '-') {
      out += "−";
    } else if (c == '_' && std::isalpha(static_cast<unsigned char>(before)) != 0 && (i < 2 || !isWord(html[i - 2])) &&
               isWord(after)) {
      std::size_t end = i + 1;
      while (end < html.size() && isWord(html[end])) ++end;
      out += "<sub>" + html.substr(i + 1, end - i - 1) + "</sub>";
      i = end - 1;
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

void Page::list(const std::vector<std::string>& items) {
  html_ += "<ul>\n";
  for (const std::string& item : items) html_ += "<li>" + item + "</li>\n";
  html_ += "</ul>\n";
}

void Page::terms(const std::vector<std::pair<std::string, std::string>>& items) {
  html_ += "<dl>\n";
  for (const auto& [term, text] : items) html_ += "<dt>" + term + "</dt><dd>" + text + "</dd>\n";
  html_ += "</dl>\n";
}

void Page::table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
                 const std::string& caption) {
  html_ += "<table>\n";
  if (!caption.empty()) html_ += "<caption>Table " + std::to_string(++tables_) + ". " + caption + "</caption>\n";
  html_ += "<tr>";
  for (const std::string& cell : head) html_ += "<th>" + cell + "</th>";
  html_ += "</tr>\n";
  for (const auto& row : rows) {
    html_ += "<tr>";
    for (const std::string& cell : row) {
      const bool yes = cell == "met" || cell == "holds", no = cell == "not met" || cell == "does not hold";
      html_ += yes ? "<td class=\"yes\">" : no ? "<td class=\"no\">" : "<td>";
      html_ += cell + "</td>";
    }
    html_ += "</tr>\n";
  }
  html_ += "</table>\n";
}

void Page::figure(const std::string& svg, const std::string& caption) {
  html_ += "<figure>" + svg + "<figcaption>Figure " + std::to_string(++figures_) + ". " + caption +
           "</figcaption></figure>\n";
}

std::string Page::whole(const std::string& title, const std::string& under) const {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
         "<meta name=\"viewport\" content=\"width=device-width\"/>\n<title>" +
         title + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n" +
         typeset("<h1>" + title + "</h1>\n<p class=\"note\">" + under + "</p>\n" + html_) + "</body>\n</html>\n";
}

}  // namespace enamel::app
