#include "study/page.hpp"

namespace enamel::app {
namespace {

constexpr const char* kStyle = R"(
body { font: 16px/1.5 system-ui, sans-serif; color: #1f262e; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; margin-bottom: 0.2rem; } h2 { font-size: 1.25rem; margin-top: 2.4rem; }
table { border-collapse: collapse; margin: 0.8rem 0; font-size: 0.92rem; }
th, td { padding: 0.25rem 0.8rem 0.25rem 0; border-bottom: 1px solid #d3d9e0; text-align: right; }
th:first-child, td:first-child { text-align: left; } th { border-bottom: 2px solid #66707c; font-weight: 600; }
td.yes { color: #00684d; } td.no { color: #a84300; font-weight: 600; }
figure { margin: 1.6rem 0; } figure img { max-width: 100%; height: auto; display: block; }
figcaption { color: #4a535e; font-size: 0.92rem; margin-top: 0.4rem; }
p.note, li.note { color: #4a535e; font-size: 0.92rem; }
)";

}  // namespace

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve(4 * (bytes.size() + 2) / 3);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t j = 0; j < 3; ++j)
      bits = bits << 8 | (i + j < bytes.size() ? static_cast<unsigned char>(bytes[i + j]) : 0u);
    for (std::size_t j = 0; j < 4; ++j) out += i + j <= bytes.size() ? kDigits[bits >> (18 - 6 * j) & 63] : '=';
  }
  return out;
}

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else
      out += c;
  }
  return out;
}

void Page::list(const std::vector<std::string>& items) {
  html_ += "<ul>\n";
  for (const std::string& item : items) html_ += "<li>" + item + "</li>\n";
  html_ += "</ul>\n";
}

void Page::table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows) {
  html_ += "<table>\n<tr>";
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

void Page::figure(const std::string& png, const std::string& name, const std::string& caption) {
  html_ += "<figure><img alt=\"" + name + "\" src=\"data:image/png;base64," + base64(png) + "\">\n<figcaption>" +
           caption + "</figcaption></figure>\n";
}

void Page::drawing(const std::string& svg, const std::string& caption) {
  html_ += "<figure>" + svg + "\n<figcaption>" + caption + "</figcaption></figure>\n";
}

std::string Page::whole(const std::string& title, const std::string& under) const {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
         "<meta name=\"viewport\" content=\"width=device-width\">\n<title>" +
         title + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n<h1>" + title +
         "</h1>\n<p class=\"note\">" + under + "</p>\n" + html_ + "</body>\n</html>\n";
}

}  // namespace enamel::app
