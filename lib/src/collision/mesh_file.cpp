#include "enamel/collision/mesh_file.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "mesh_scan.hpp"

namespace enamel {
namespace {

constexpr std::size_t kLargestFile = std::size_t{2} << 30;  // bytes

void scanOff(std::string_view bytes, MeshBuilder& out) {
  Words words(bytes, out);
  const std::string_view magic = words.word("the word OFF");
  if (magic != "OFF")
    words.fail("starts with \"" + std::string(magic.substr(0, 20)) +
               "\", must start with OFF (only text files are read)");
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
        if (index == 0) words.fail("a face names vertex 0, the first vertex is 1");
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
