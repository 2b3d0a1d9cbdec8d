// A self-contained page of HTML with headings, tables and figures. It is also well-formed XML.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "study/plot.hpp"

namespace enamel::app {

/// Escape a text for XML. Characters that XML does not allow and bytes that are not UTF-8 become U+FFFD.
std::string escape(const std::string& text);

std::string base64(const std::string& bytes);

/// Texts are HTML. "K_z1" becomes K with a subscript, and a minus before a digit becomes a typographic minus. Lines do
/// not break inside a number or between a number and its unit.
class Page {
 public:
  void heading(const std::string& text) { html_ += "<h2>" + text + "</h2>\n"; }
  void paragraph(const std::string& text) { html_ += "<p>" + text + "</p>\n"; }
  void note(const std::string& text) { html_ += "<p class=\"note\">" + text + "</p>\n"; }
  void list(const std::vector<std::string>& items);
  /// Add a list of terms and their meanings.
  void terms(const std::vector<std::pair<std::string, std::string>>& items);
  /// Add a table. Cells "met" and "holds" and their opposites are coloured. A table with a caption is numbered.
  void table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
             const std::string& caption = "");
  /// Add a numbered figure; its name identifies it on the page and names its exports.
  void figure(const std::string& name, const Json& plot, const std::string& caption);
  /// Add a link that saves a text as a file.
  void download(const std::string& name, const std::string& text);
  std::string whole(const std::string& title, const std::string& under) const;

 private:
  std::string html_;
  std::string scripts_;  // data of figures
  int figures_ = 0, tables_ = 0;
};

}  // namespace enamel::app
