// Files are scanned strictly: what a report must count is kept (faces with repeated corners, vertices that are not
// manifold), what cannot be meant is refused (a "nan", a truncated file, a header that promises too much).
#include "enamel/collision/mesh_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"

namespace enamel {
namespace {

constexpr std::size_t kLargestFile = std::size_t{2} << 30;  // bytes
constexpr std::int64_t kMostCorners = 255;                  // of a face
constexpr std::size_t kLeastBytes = 6;  // of a file a triangle: the vertices alone of a closed mesh take as many

// Takes what a scan finds, in the order of the file.
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

  /// Followed by so many calls of corner().
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
        fail("promises more than " + std::to_string(mostTriangles_) + " triangles, one for every " +
             std::to_string(kLeastBytes) + " bytes: its faces are no surface");
      mesh_.triangles.push_back({first_, last_, number});
    }
    last_ = number;
    ++corners_;
  }

  std::int64_t vertices() const { return static_cast<std::int64_t>(mesh_.vertices.size()); }

  /// To be called once, at the end.
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
    fail("face " + std::to_string(face) + " names vertex " + std::to_string(vertex) + ", there are " +
         std::to_string(vertices()));
  }

  std::string path_;
  double scale_;
  std::size_t mostTriangles_;
  TriangleMesh mesh_;
  std::int64_t faces_ = 0, largest_ = -1, faceOfLargest_ = 0;
  int corners_ = 0, first_ = 0, last_ = 0;  // of the face begun last
};

// Words and lines of a text.
class Words {
 public:
  Words(std::string_view text, const MeshBuilder& out) : text_(text), out_(out) {}

  [[noreturn]] void fail(const std::string& problem) const { out_.fail(problem, line_); }

  int line() const { return line_; }
  std::string_view rest() const { return text_.substr(at_); }

  /// The next word of this line, empty at its end. Comments start at '#' where `comments` is set.
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

  /// Goes to the next line; false at the end of the text.
  bool nextLine() {
    skipLine();
    if (at_ == text_.size()) return false;
    ++at_;
    ++line_;
    return at_ < text_.size();
  }

  /// The next word, on whatever line.
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
      long double wide = HUGE_VAL;  // tells which end of the range it is
      std::from_chars(start, word.data() + word.size(), wide);
      return std::abs(wide) < 1.0L ? 0.0 : HUGE_VAL;
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
  static bool isSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\v' || c == '\f'; }

  std::string_view text_;
  const MeshBuilder& out_;
  std::size_t at_ = 0;
  int line_ = 1;
};

// A count of a header, checked against the least number of bytes that each item takes.
std::int64_t checkedCount(std::int64_t count, std::size_t leastBytes, std::size_t remaining, const char* items,
                          const MeshBuilder& out) {
  if (count < 0) out.fail(std::string("promises ") + std::to_string(count) + " " + items);
  if (static_cast<std::uint64_t>(count) > remaining / std::max<std::size_t>(leastBytes, 1))
    out.fail("promises " + std::to_string(count) + " " + items + ", there is room for at most " +
             std::to_string(remaining / std::max<std::size_t>(leastBytes, 1)));
  return count;
}

void scanOff(std::string_view bytes, MeshBuilder& out) {
  Words words(bytes, out);
  const std::string_view magic = words.word("the word OFF");
  if (magic != "OFF")
    words.fail("starts with \"" + std::string(magic.substr(0, 20)) + "\", only plain text OFF is read");
  const std::int64_t vertexCount = words.integer("number of vertices"), faceCount = words.integer("number of faces");
  words.integer("number of edges");
  checkedCount(vertexCount, 6, words.rest().size(), "vertices", out);
  checkedCount(faceCount, 2, words.rest().size(), "faces", out);
  for (std::int64_t i = 0; i < vertexCount; ++i) {
    std::array<double, 3> p{};
    for (double& x : p) x = words.number("coordinate of a vertex");
    out.vertex(p);
    words.skipLine();
  }
  for (std::int64_t f = 0; f < faceCount; ++f) {
    const std::int64_t corners = words.integer("number of corners");
    out.beginFace(corners);
    for (std::int64_t i = 0; i < corners; ++i) out.corner(words.integer("index of a face"));
    words.skipLine();
  }
}

void scanObj(std::string_view bytes, MeshBuilder& out) {
  Words words(bytes, out);
  do {
    const std::string_view key = words.wordOfLine();
    if (key == "v") {
      std::array<double, 3> p{};
      for (double& x : p) x = words.number(words.wordOfLine(), "coordinate of a vertex");
      out.vertex(p);
    } else if (key == "f") {
      std::array<std::int64_t, kMostCorners> corner{};
      std::int64_t count = 0;
      for (std::string_view word = words.wordOfLine(); !word.empty(); word = words.wordOfLine(), ++count) {
        const std::int64_t index = words.integer(word.substr(0, word.find('/')), "index of a face");
        if (index == 0) words.fail("a face names vertex 0, vertices count from 1");
        if (count < kMostCorners) corner[count] = index > 0 ? index - 1 : out.vertices() + index;
      }
      out.beginFace(count);
      for (std::int64_t i = 0; i < count; ++i) out.corner(corner[i]);
    }
  } while (words.nextLine());
}

void scanStlBinary(std::string_view bytes, MeshBuilder& out) {
  std::uint32_t count = 0;
  if (bytes.size() < 84) out.fail("is truncated: a binary STL file has at least 84 bytes");
  std::memcpy(&count, bytes.data() + 80, 4);
  checkedCount(count, 50, bytes.size() - 84, "triangles", out);
  for (std::uint32_t t = 0; t < count; ++t) {
    out.beginFace(3);
    for (int i = 0; i < 3; ++i) {
      float p[3];
      std::memcpy(p, bytes.data() + 84 + 50 * std::size_t{t} + 12 * (i + 1u), sizeof p);
      out.corner(out.vertices());
      out.vertex({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
    }
  }
}

void scanStlText(std::string_view bytes, MeshBuilder& out) {
  Words words(bytes, out);
  words.nextLine();
  for (;;) {
    const std::string_view key = words.word("the line endsolid");
    if (key == "endsolid") return;
    if (key == "outer") {
      out.beginFace(3);
      words.skipLine();
      for (int i = 0; i < 3; ++i) {
        if (words.word("a vertex") != "vertex") words.fail("a loop must have three vertices");
        std::array<double, 3> p{};
        for (double& x : p) x = words.number("coordinate of a vertex");
        out.corner(out.vertices());
        out.vertex(p);
      }
      if (words.word("the line endloop") != "endloop") words.fail("a loop must have three vertices");
    } else if (key != "facet" && key != "endfacet") {
      words.fail("\"" + std::string(key.substr(0, 20)) + "\" is not a word of STL");
    }
    words.skipLine();
  }
}

void scanStl(std::string_view bytes, MeshBuilder& out) {
  std::uint32_t count = 0;
  if (bytes.size() >= 84) std::memcpy(&count, bytes.data() + 80, 4);
  const bool fits = bytes.size() >= 84 && bytes.size() == 84 + 50 * std::size_t{count};
  if (!fits && bytes.substr(0, 5) == "solid") {
    scanStlText(bytes, out);
  } else {
    scanStlBinary(bytes, out);
  }
}

// Scalars of PLY, in text or in bytes of either order.
enum class Scalar { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  std::string name;
  Scalar type{}, countType{};
  bool list = false;
};

struct Element {
  std::string name;
  std::int64_t count = 0;
  std::vector<Property> properties;
};

Scalar scalarOf(std::string_view word, const Words& words) {
  static constexpr std::array<std::array<const char*, 2>, 8> kNames = {{{"char", "int8"},
                                                                        {"uchar", "uint8"},
                                                                        {"short", "int16"},
                                                                        {"ushort", "uint16"},
                                                                        {"int", "int32"},
                                                                        {"uint", "uint32"},
                                                                        {"float", "float32"},
                                                                        {"double", "float64"}}};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (word == kNames[i][0] || word == kNames[i][1]) return static_cast<Scalar>(i);
  words.fail("\"" + std::string(word.substr(0, 20)) + "\" is not a type of PLY");
}

std::size_t sizeOf(Scalar type) {
  static constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<int>(type)];
}

class PlyBody {
 public:
  PlyBody(std::string_view bytes, bool text, bool bigEndian, Words words, const MeshBuilder& out)
      : bytes_(bytes), text_(text), bigEndian_(bigEndian), words_(words), out_(out) {}

  std::size_t remaining() const { return text_ ? words_.rest().size() : bytes_.size() - at_; }
  std::size_t leastBytes(const Element& element) const {
    std::size_t sum = 0;
    for (const Property& p : element.properties) sum += text_ ? 1 : sizeOf(p.list ? p.countType : p.type);
    return sum;
  }

  double read(Scalar type) {
    if (text_) return words_.number("a value");
    const std::size_t size = sizeOf(type);
    if (size > bytes_.size() - at_) out_.fail("is truncated after " + std::to_string(bytes_.size()) + " bytes");
    char raw[8];
    std::memcpy(raw, bytes_.data() + at_, size);
    at_ += size;
    if (bigEndian_) std::reverse(raw, raw + size);
    switch (type) {
      case Scalar::int8: return static_cast<double>(as<std::int8_t>(raw));
      case Scalar::uint8: return static_cast<double>(as<std::uint8_t>(raw));
      case Scalar::int16: return static_cast<double>(as<std::int16_t>(raw));
      case Scalar::uint16: return static_cast<double>(as<std::uint16_t>(raw));
      case Scalar::int32: return static_cast<double>(as<std::int32_t>(raw));
      case Scalar::uint32: return static_cast<double>(as<std::uint32_t>(raw));
      case Scalar::float32: return static_cast<double>(as<float>(raw));
      case Scalar::float64: break;
    }
    return as<double>(raw);
  }

  std::int64_t readInteger(Scalar type) {
    const double value = read(type);
    if (!(std::abs(value) < 1e15) || value != std::floor(value)) out_.fail("an index or count is not an integer");
    return static_cast<std::int64_t>(value);
  }

  void skip(const Property& property) {
    if (!property.list) {
      read(property.type);
      return;
    }
    for (std::int64_t n = listLength(property); n > 0; --n) read(property.type);
  }

  std::int64_t listLength(const Property& property) {
    return checkedCount(readInteger(property.countType), text_ ? 1 : sizeOf(property.type), remaining(),
                        "entries of a list", out_);
  }

 private:
  template <typename T>
  static T as(const char* raw) {
    T value;
    std::memcpy(&value, raw, sizeof value);
    return value;
  }

  std::string_view bytes_;
  bool text_, bigEndian_;
  Words words_;
  const MeshBuilder& out_;
  std::size_t at_ = 0;
};

void scanPly(std::string_view bytes, MeshBuilder& out) {
  Words words(bytes, out);
  if (words.wordOfLine(false) != "ply") words.fail("does not start with the word ply");
  std::string format;
  std::vector<Element> elements;
  for (;;) {
    if (!words.nextLine()) words.fail("is truncated: the line end_header is missing");
    const std::string_view key = words.wordOfLine(false);
    if (key == "end_header") break;
    if (key == "format") {
      format = words.wordOfLine(false);
    } else if (key == "element") {
      Element element;
      element.name = words.wordOfLine(false);
      element.count = words.integer(words.wordOfLine(false), "count of an element");
      elements.push_back(element);
    } else if (key == "property") {
      if (elements.empty()) words.fail("a property stands before the first element");
      Property property;
      std::string_view type = words.wordOfLine(false);
      property.list = type == "list";
      if (property.list) {
        property.countType = scalarOf(words.wordOfLine(false), words);
        type = words.wordOfLine(false);
      }
      property.type = scalarOf(type, words);
      property.name = words.wordOfLine(false);
      elements.back().properties.push_back(property);
    } else if (key != "comment" && key != "obj_info" && !key.empty()) {
      words.fail("\"" + std::string(key.substr(0, 20)) + "\" is not a key of a PLY header");
    }
  }
  if (!words.nextLine()) words.fail("is truncated: nothing follows the header");
  if (format != "ascii" && format != "binary_little_endian" && format != "binary_big_endian")
    words.fail("format is \"" + format.substr(0, 20) + "\", must be ascii, binary_little_endian or binary_big_endian");

  PlyBody body(words.rest(), format == "ascii", format == "binary_big_endian", words, out);
  bool haveVertices = false, haveFaces = false;
  for (const Element& element : elements) {
    checkedCount(element.count, body.leastBytes(element), body.remaining(), element.name.c_str(), out);
    if (element.properties.empty()) continue;
    const bool isVertex = element.name == "vertex" && !haveVertices, isFace = element.name == "face" && !haveFaces;
    haveVertices = haveVertices || isVertex;
    haveFaces = haveFaces || isFace;
    if (isVertex)
      for (const char* axis : {"x", "y", "z"})
        if (std::none_of(element.properties.begin(), element.properties.end(),
                         [&](const Property& p) { return p.name == axis && !p.list; }))
          out.fail(std::string("vertices have no property ") + axis);
    for (std::int64_t i = 0; i < element.count; ++i) {
      std::array<double, 3> p{};
      for (const Property& property : element.properties) {
        const bool isIndices =
            isFace && property.list && (property.name == "vertex_indices" || property.name == "vertex_index");
        if (isVertex && !property.list && property.name.size() == 1 && property.name[0] >= 'x' &&
            property.name[0] <= 'z') {
          p[static_cast<std::size_t>(property.name[0] - 'x')] = body.read(property.type);
        } else if (isIndices) {
          const std::int64_t corners = body.listLength(property);
          out.beginFace(corners);
          for (std::int64_t c = 0; c < corners; ++c) out.corner(body.readInteger(property.type));
        } else {
          body.skip(property);
        }
      }
      if (isVertex) out.vertex(p);
    }
    if (haveVertices && haveFaces) break;
  }
}

std::string extensionOf(const std::string& path) {
  const std::size_t dot = path.find_last_of('.');
  std::string extension = dot == std::string::npos ? "" : path.substr(dot + 1);
  for (char& c : extension) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return extension;
}

}  // namespace

TriangleMesh parseMesh(std::string_view bytes, const std::string& path, double scale) {
  if (!(scale > 0.0) || !std::isfinite(scale))
    throw ConfigurationError(path, 0, "scale", "must be a positive number of metres per unit");
  MeshBuilder out(path, bytes.size(), scale);
  if (bytes.empty()) out.fail("is empty");
  const std::string extension = extensionOf(path);
  if (extension == "ply") {
    scanPly(bytes, out);
  } else if (extension == "obj") {
    scanObj(bytes, out);
  } else if (extension == "stl") {
    scanStl(bytes, out);
  } else if (extension == "off") {
    scanOff(bytes, out);
  } else {
    out.fail("has the extension \"" + extension + "\", must be ply, obj, stl or off");
  }
  return out.mesh();
}

TriangleMesh loadMesh(const std::string& path, double scale) {
  return parseMesh(readFile(path, kLargestFile), path, scale);
}

}  // namespace enamel
