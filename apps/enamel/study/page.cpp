#include "study/page.hpp"

#include <algorithm>
#include <cctype>

#include "page_text.hpp"

namespace enamel::app {
namespace {

constexpr const char* kStyle = R"(
body { font: 16px/1.5 sans-serif; color: #1f262e; max-width: 58rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; line-height: 1.25; margin-bottom: 0.2rem; } h2 { font-size: 1.25rem; margin-top: 2.4rem; }
table { border-collapse: collapse; width: 100%; margin: 0.8rem 0; font-size: 0.875rem; line-height: 1.35; }
table.wide { font-size: 0.75rem; } table.wide :is(th, td) { padding-right: 0.45rem; min-width: 0; }
caption { text-align: left; color: #4a535e; padding-bottom: 0.4rem; }
th, td { padding: 0.3rem 0.8rem 0.3rem 0; border-bottom: 1px solid #d3d9e0; text-align: right; vertical-align: top; }
th:first-child, td:first-child { text-align: left; min-width: 7rem; } th { border-bottom: 2px solid #66707c; font-weight: 600; }
td { overflow-wrap: break-word; } td small { display: block; color: #4a535e; font-size: 0.8rem; }
code { font: inherit; font-style: italic; white-space: nowrap; } code.command { white-space: normal; overflow-wrap: anywhere; } sub { line-height: 0; }
td.yes { color: #00684d; } td.no { color: #a84300; font-weight: 600; }
dt { font-weight: 600; margin-top: 0.5rem; } dd { margin-left: 1.5rem; }
figure { margin: 1.6rem 0; } .plot svg { max-width: 100%; height: auto; display: block; }
.exports button { font: inherit; font-size: 0.75rem; color: #4a535e; background: none; border: 1px solid #d3d9e0; border-radius: 3px;
  margin-right: 0.4rem; cursor: pointer; }
.tooltip { display: none; position: fixed; z-index: 1; max-width: 26rem; padding: 0.3rem 0.6rem; white-space: pre-line; pointer-events: none;
  background: #1f262e; color: #fff; font-size: 0.85rem; border-radius: 4px; }
figcaption { color: #4a535e; font-size: 0.92rem; margin-top: 0.4rem; }
p.note, li.note { color: #4a535e; font-size: 0.92rem; }
@media print { .exports, .tooltip { display: none !important; } body { max-width: none; margin: 0; } figure, tr { break-inside: avoid; } h2 { break-after: avoid; } }
)";

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
  bool tag = false, code = false;
  for (std::size_t i = 0; i < html.size(); ++i) {
    const char c = html[i];
    tag = c == '<' || (tag && c != '>');
    if (c == '<') code = html.compare(i, 5, "<code") == 0;
    const char before = i > 0 ? html[i - 1] : ' ', after = i + 1 < html.size() ? html[i + 1] : ' ';
    if (tag || code || c == '>') {
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

std::string base64(const std::string& bytes) {
  static const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(bytes.size() / 3 * 4 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) { return k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0u; };
    const unsigned word = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    for (int k = 0; k < 4; ++k)
      text += i + static_cast<std::size_t>(k) <= bytes.size() ? digits[word >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

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
  constexpr std::size_t kManyColumns = 9;
  html_ += head.size() > kManyColumns ? "<table class=\"wide\">\n" : "<table>\n";
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

#ifdef ENAMEL_FIGURES

void Page::figure(const std::string& name, const Json& plot, const std::string& caption) {
  html_ += "<figure><div class=\"plot\" id=\"" + name + "\">This figure needs JavaScript.</div><figcaption>Figure " +
           std::to_string(++figures_) + ". " + caption + "</figcaption></figure>\n";
  std::string json = plot.dump(-1, ' ', true, Json::error_handler_t::replace);
  for (std::size_t at = 0; (at = json.find_first_of("<&", at)) != std::string::npos;)
    json.replace(at, 1, json[at] == '<' ? "\\u003c" : "\\u0026");
  scripts_ += "<script type=\"application/json\" id=\"" + name + "-data\">" + json + "</script>\n";
}

namespace {
std::string drawing() { return std::string("<script>//<![CDATA[\n") + kVega + kFigures + "//]]></script>\n"; }
}  // namespace

#else

void Page::figure(const std::string&, const Json&, const std::string& caption) {
  html_ += "<p class=\"note\">Figure " + std::to_string(++figures_) +
           " is missing: this enamel was built without Vega (Debian: libjs-vega). " + caption + "</p>\n";
}

namespace {
std::string drawing() { return ""; }
}  // namespace

#endif

void Page::download(const std::string& name, const std::string& text) {
  html_ += "<p class=\"note\">Data: <a download=\"" + name + "\" href=\"data:text/csv;base64," + base64(text) + "\">" +
           name + "</a></p>\n";
}

std::string Page::whole(const std::string& title, const std::string& under) const {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
         "<meta name=\"viewport\" content=\"width=device-width\"/>\n<title>" +
         title + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n" +
         typeset("<h1>" + title + "</h1>\n<p class=\"note\">" + under + "</p>\n" + html_) + scripts_ +
         (scripts_.empty() ? "" : drawing()) + "</body>\n</html>\n";
}

}  // namespace enamel::app
