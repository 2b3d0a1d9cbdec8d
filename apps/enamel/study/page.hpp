// A page of HTML that needs nothing else: headings, tables, figures.
#pragma once

#include <string>
#include <vector>

namespace enamel::app {

/// Base64 of bytes (RFC 4648).
std::string base64(const std::string& bytes);

/// Text as HTML.
std::string escape(const std::string& text);

class Page {
 public:
  void heading(const std::string& text) { html_ += "<h2>" + text + "</h2>\n"; }
  void paragraph(const std::string& text) { html_ += "<p>" + text + "</p>\n"; }
  void note(const std::string& text) { html_ += "<p class=\"note\">" + text + "</p>\n"; }
  void list(const std::vector<std::string>& items);
  /// Cells are HTML; "met", "holds" and their contraries get a colour.
  void table(const std::vector<std::string>& head, const std::vector<std::vector<std::string>>& rows);
  /// `png`: the bytes of a picture.
  void figure(const std::string& png, const std::string& name, const std::string& caption);
  void drawing(const std::string& svg, const std::string& caption);
  std::string whole(const std::string& title, const std::string& under) const;

 private:
  std::string html_;
};

}  // namespace enamel::app
