// A page of HTML that needs nothing else: headings, tables, figures. Well-formed XML, too.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "study/svg.hpp"

namespace enamel::app {

/// Texts are HTML in which "K_z1" becomes a K with an index, a minus before a digit is a true one, and no line breaks
/// inside a number or between a number and its unit.
class Page {
 public:
  void heading(const std::string& text) { html_ += "<h2>" + text + "</h2>\n"; }
  void paragraph(const std::string& text) { html_ += "<p>" + text + "</p>\n"; }
  void note(const std::string& text) { html_ += "<p class=\"note\">" + text + "</p>\n"; }
  void list(const std::vector<std::string>& items);
  /// Terms and what they are.
  void terms(const std::vector<std::pair<std::string, std::string>>& items);
  /// Cells "met", "holds" and their contraries get a colour. With a caption the table is numbered.
  void table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows,
             const std::string& caption = "");
  /// Numbered.
  void figure(const std::string& svg, const std::string& caption);
  std::string whole(const std::string& title, const std::string& under) const;

 private:
  std::string html_;
  int figures_ = 0, tables_ = 0;
};

}  // namespace enamel::app
