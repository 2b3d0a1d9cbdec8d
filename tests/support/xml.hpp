// Checks whether a text is XML.
#pragma once

#include <cctype>
#include <cstring>
#include <set>
#include <string>
#include <vector>

namespace enamel::test {

/// Return the first XML error of a text, or "". It checks nesting of tags, quoted and unique attributes, and entities
/// that every parser knows. CDATA is skipped. Comments are not supported, because our pages have none.
inline std::string xmlProblem(const std::string& text) {
  std::vector<std::string> open;
  std::size_t i = text.rfind("<!DOCTYPE html>\n", 0) == 0 ? std::strlen("<!DOCTYPE html>\n") : 0;
  const auto problem = [&](const std::string& what) { return what + ": " + text.substr(i, 60); };
  const auto name = [&](std::size_t& at) {
    const std::size_t begin = at;
    while (at < text.size() && (std::isalnum(static_cast<unsigned char>(text[at])) != 0 || text[at] == '-')) ++at;
    return text.substr(begin, at - begin);
  };
  const auto entity = [&](std::size_t at) {
    for (const char* known : {"&amp;", "&lt;", "&gt;", "&quot;"})
      if (text.compare(at, std::strlen(known), known) == 0) return true;
    return false;
  };
  for (; i < text.size(); ++i) {
    if (text[i] == '&' && !entity(i)) return problem("a bare &");
    if (text[i] != '<') {
      if (open.empty() && std::isspace(static_cast<unsigned char>(text[i])) == 0) return problem("text outside");
      continue;
    }
    if (text.compare(i, 9, "<![CDATA[") == 0) {
      const std::size_t end = text.find("]]>", i);
      if (end == std::string::npos) return problem("CDATA that does not end");
      i = end + 2;
      continue;
    }
    std::size_t at = i + 1;
    if (text[at] == '/') {
      const std::string closed = name(++at);
      if (open.empty() || open.back() != closed || text[at] != '>') return problem("closes nothing");
      open.pop_back();
      i = at;
      continue;
    }
    const std::string tag = name(at);
    if (tag.empty()) return problem("a bare <");
    std::set<std::string> attributes;
    while (at < text.size() && text[at] == ' ') {
      const std::string attribute = name(++at);
      if (attribute.empty() || !attributes.insert(attribute).second)
        return problem("an attribute twice or without name");
      if (text.compare(at, 2, "=\"") != 0) return problem("an attribute without quotes");
      for (at += 2; at < text.size() && text[at] != '"'; ++at)
        if (text[at] == '<' || (text[at] == '&' && !entity(at))) return problem("an attribute's value");
      ++at;
    }
    const bool empty = text.compare(at, 2, "/>") == 0;
    if (!empty && text[at] != '>') return problem("a tag that does not end");
    if (!empty) open.push_back(tag);
    i = at + empty;
  }
  return open.empty() ? "" : "<" + open.back() + "> is not closed";
}

}  // namespace enamel::test
