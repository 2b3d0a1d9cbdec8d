#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "mesh_scan.hpp"

namespace enamel {
namespace {

// Scalar types of PLY, in text or in bytes of either order.
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

}  // namespace

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
      if (elements.empty()) words.fail("a property precedes the first element");
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

}  // namespace enamel
