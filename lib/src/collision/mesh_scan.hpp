// Shared by the scanners of all mesh formats: words of a text, and the mesh that they build. Scanning is strict.
// Defects that a report counts are kept: faces with repeated corners, vertices that are not manifold. Invalid files are
// rejected: a "nan", a truncated file, a header that promises too much.
#pragma once

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "enamel/collision/mesh.hpp"
#include "enamel/core/error.hpp"

namespace enamel {

inline constexpr std::int64_t kMostCorners = 255;  // of a face

/// Collects the vertices and faces of a file in their order.
class MeshBuilder {
 public:
  MeshBuilder(const std::string& path, std::size_t bytes, double scale)
      : path_(path), scale_(scale), mostTriangles_(bytes / kLeastBytes) {}

  [[noreturn]] void fail(const std::string& problem, int line = 0) const {
    throw ConfigurationError(path_, line, "", problem);
  }

  void vertex(const std::array<double, 3>& position) {
    const Vec3 v = scale_ * Vec3(position[0], position[1], position[2]);
    if (!v.allFinite()) fail("vertex " + std::to_string(vertices()) + " has a coordinate that is not a finite number");
    mesh_.vertices.push_back(v);
  }

  /// Begin a face; exactly `corners` calls of corner() must follow.
  void beginFace(std::int64_t corners) {
    if (corners < 3 || corners > kMostCorners)
      fail("face " + std::to_string(faces_) + " has " + std::to_string(corners) + " corners, must have 3 to 255");
    ++faces_;
    corners_ = 0;
  }

  void corner(std::int64_t vertex) {
    if (vertex < 0 || vertex > INT32_MAX) outOfRange(faces_ - 1, vertex);
    if (vertex > largest_) {
      largest_ = vertex;
      faceOfLargest_ = faces_ - 1;
    }
    const int number = static_cast<int>(vertex);
    if (corners_ == 0) first_ = number;
    if (corners_ > 1) {
      if (mesh_.triangles.size() >= mostTriangles_)
        fail("has more than " + std::to_string(mostTriangles_) + " triangles, one for every " +
             std::to_string(kLeastBytes) + " bytes of the file: its faces do not form a surface");
      mesh_.triangles.push_back({first_, last_, number});
    }
    last_ = number;
    ++corners_;
  }

  std::int64_t vertices() const { return static_cast<std::int64_t>(mesh_.vertices.size()); }

  /// Return the mesh. Call once, at the end.
  TriangleMesh mesh() {
    if (faces_ == 0) fail("has no faces");
    if (largest_ >= vertices()) outOfRange(faceOfLargest_, largest_);
    try {
      checkMesh(mesh_);
    } catch (const Error& error) {
      fail(error.what());
    }
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void outOfRange(std::int64_t face, std::int64_t vertex) const {
    fail("face " + std::to_string(face) + " names vertex " + std::to_string(vertex) + ", the mesh has " +
         std::to_string(vertices()));
  }

  static constexpr std::size_t kLeastBytes =
      6;  // of a file per triangle: the vertices of a closed mesh alone take as many

  std::string path_;
  double scale_;
  std::size_t mostTriangles_;
  TriangleMesh mesh_;
  std::int64_t faces_ = 0, largest_ = -1, faceOfLargest_ = 0;
  int corners_ = 0, first_ = 0, last_ = 0;  // of the last begun face
};

/// Words and lines of a text.
class Words {
 public:
  Words(std::string_view text, const MeshBuilder& out) : text_(text), out_(out) {}

  [[noreturn]] void fail(const std::string& problem) const { out_.fail(problem, line_); }

  int line() const { return line_; }
  std::string_view rest() const { return text_.substr(at_); }

  /// Return the next word of this line, empty at its end. If `comments` is set, a comment starts at '#'.
  std::string_view wordOfLine(bool comments = true) {
    while (at_ < text_.size() && text_[at_] != '\n' && isSpace(text_[at_])) ++at_;
    if (comments && at_ < text_.size() && text_[at_] == '#') skipLine();
    const std::size_t start = at_;
    while (at_ < text_.size() && text_[at_] != '\n' && !isSpace(text_[at_])) ++at_;
    return text_.substr(start, at_ - start);
  }

  void skipLine() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  }

  /// Go to the next line. Returns false at the end of the text.
  bool nextLine() {
    skipLine();
    if (at_ == text_.size()) return false;
    ++at_;
    ++line_;
    return at_ < text_.size();
  }

  /// Return the next word of any line.
  std::string_view word(const char* what) {
    for (;;) {
      const std::string_view found = wordOfLine();
      if (!found.empty()) return found;
      if (!nextLine()) fail(std::string("is truncated: ") + what + " is missing");
    }
  }

  double number(std::string_view word, const std::string& what) const {
    double value = 0.0;
    const char* start = word.data() + (!word.empty() && word.front() == '+' ? 1 : 0);
    const auto result = std::from_chars(start, word.data() + word.size(), value);
    if (result.ec == std::errc::result_out_of_range && result.ptr == word.data() + word.size()) {
      return isSmall(word) ? 0.0 : HUGE_VAL;
    }
    if (result.ec != std::errc() || result.ptr != word.data() + word.size())
      fail(what + " is \"" + std::string(word.substr(0, 40)) + "\", must be a number");
    return value;
  }

  std::int64_t integer(std::string_view word, const std::string& what) const {
    std::int64_t value = 0;
    const auto result = std::from_chars(word.data(), word.data() + word.size(), value);
    if (result.ec != std::errc() || result.ptr != word.data() + word.size())
      fail(what + " is \"" + std::string(word.substr(0, 40)) + "\", must be an integer");
    return value;
  }

  double number(const char* what) { return number(word(what), what); }
  std::int64_t integer(const char* what) { return integer(word(what), what); }

 private:
  // Return whether a decimal number that a double cannot hold is too small, rather than too large.
  static bool isSmall(std::string_view word) {
    const std::size_t mark = std::min(word.find_first_of("eE"), word.size());
    const std::size_t point = std::min(word.find('.'), mark), first = word.find_first_of("123456789");
    std::int64_t exponent = 0;
    if (mark < word.size()) {
      const char* start = word.data() + mark + (word[mark + 1] == '+' ? 2 : 1);
      if (std::from_chars(start, word.data() + word.size(), exponent).ec == std::errc::result_out_of_range)
        return *start == '-';
    }
    return exponent < static_cast<std::int64_t>(first) - static_cast<std::int64_t>(point);
  }

  static bool isSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f'; }

  std::string_view text_;
  const MeshBuilder& out_;
  std::size_t at_ = 0;
  int line_ = 1;
};

/// Check a count of a header against the least number of bytes per item.
inline std::int64_t checkedCount(std::int64_t count, std::size_t leastBytes, std::size_t remaining, const char* items,
                                 const MeshBuilder& out) {
  if (count < 0) out.fail(std::string("declares ") + std::to_string(count) + " " + items);
  if (static_cast<std::uint64_t>(count) > remaining / std::max<std::size_t>(leastBytes, 1))
    out.fail("declares " + std::to_string(count) + " " + items + ", the rest of the file has room for at most " +
             std::to_string(remaining / std::max<std::size_t>(leastBytes, 1)));
  return count;
}

/// Scan PLY in text or in bytes of either order.
void scanPly(std::string_view bytes, MeshBuilder& out);

}  // namespace enamel
