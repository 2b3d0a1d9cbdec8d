// Mesh files: valid ones load exactly, invalid ones are refused with file and place, mutations included.
#include "enamel/collision/mesh_file.hpp"

#include <cstring>
#include <sstream>

#include "enamel/core/error.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"
#include "support/temporary_folder.hpp"

namespace enamel::test_mesh_file {

using test::ContainsSubstring;

namespace {

template <typename T>
void put(std::string& bytes, T value, bool swap = false) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  if (swap) std::reverse(raw, raw + sizeof value);
  bytes.append(raw, sizeof value);
}

std::string off(const TriangleMesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  text << "OFF\n# a comment\n" << mesh.vertices.size() << ' ' << mesh.triangles.size() << " 0\n";
  for (const Vec3& v : mesh.vertices) text << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
  for (const auto& t : mesh.triangles) text << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  return text.str();
}

std::string obj(const TriangleMesh& mesh, bool negative = false) {
  std::ostringstream text;
  text.precision(17);
  text << "# a comment\nmtllib nowhere.mtl\no thing\n";
  for (const Vec3& v : mesh.vertices) text << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << "\nvn 0 0 1\n";
  const int n = static_cast<int>(mesh.vertices.size());
  for (const auto& t : mesh.triangles) {
    text << 'f';
    for (const int v : t) text << ' ' << (negative ? v - n : v + 1) << "//1";
    text << '\n';
  }
  return text.str();
}

std::string stlText(const TriangleMesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  text << "solid thing\n";
  for (const auto& t : mesh.triangles) {
    text << "facet normal 0 0 1\n outer loop\n";
    for (const int v : t)
      text << "  vertex " << mesh.vertices[v].x() << ' ' << mesh.vertices[v].y() << ' ' << mesh.vertices[v].z() << '\n';
    text << " endloop\nendfacet\n";
  }
  return text.str() + "endsolid thing\n";
}

std::string stlBinary(const TriangleMesh& mesh) {
  std::string bytes = "solid but binary";
  bytes.resize(80, ' ');
  put(bytes, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const auto& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) put(bytes, 0.0f);
    for (const int v : t)
      for (int k = 0; k < 3; ++k) put(bytes, static_cast<float>(mesh.vertices[v][k]));
    put(bytes, std::uint16_t{0});
  }
  return bytes;
}

// With further properties besides positions and indices, and another element in between.
std::string ply(const TriangleMesh& mesh, const std::string& format) {
  std::ostringstream header;
  header << "ply\nformat " << format << " 1.0\ncomment made by a test\nelement vertex " << mesh.vertices.size()
         << "\nproperty uchar red\nproperty double x\nproperty float y\nproperty float z\nelement extra 2\n"
         << "property list uchar short values\nelement face " << mesh.triangles.size()
         << "\nproperty list uint uint vertex_index\nproperty float quality\nend_header\n";
  std::string bytes = header.str();
  const bool swap = format == "binary_big_endian";
  if (format == "ascii") {
    std::ostringstream text;
    text.precision(17);
    for (const Vec3& v : mesh.vertices) text << "255 " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
    text << "2 -1 5\n0\n";
    for (const auto& t : mesh.triangles) text << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << " 0.5\n";
    return bytes + text.str();
  }
  for (const Vec3& v : mesh.vertices) {
    put(bytes, std::uint8_t{255});
    put(bytes, v.x(), swap);
    put(bytes, static_cast<float>(v.y()), swap);
    put(bytes, static_cast<float>(v.z()), swap);
  }
  put(bytes, std::uint8_t{2});
  put(bytes, std::int16_t{-1}, swap);
  put(bytes, std::int16_t{5}, swap);
  put(bytes, std::uint8_t{0});
  for (const auto& t : mesh.triangles) {
    put(bytes, std::uint32_t{3}, swap);
    for (const int v : t) put(bytes, static_cast<std::uint32_t>(v), swap);
    put(bytes, 0.5f, swap);
  }
  return bytes;
}

std::vector<std::pair<std::string, std::string>> allFormats(const TriangleMesh& mesh) {
  return {{"a.off", off(mesh)},
          {"b.obj", obj(mesh)},
          {"c.OBJ", obj(mesh, true)},
          {"d.stl", stlText(mesh)},
          {"e.stl", stlBinary(mesh)},
          {"f.ply", ply(mesh, "ascii")},
          {"g.ply", ply(mesh, "binary_little_endian")},
          {"h.ply", ply(mesh, "binary_big_endian")}};
}

// Round to multiples of 2^-20, which single precision can represent.
TriangleMesh inSinglePrecision(TriangleMesh mesh) {
  for (Vec3& v : mesh.vertices)
    for (double& x : v) x = std::round(x * 0x1p20) * 0x1p-20;
  return mesh;
}

void checkRefused(const std::string& bytes, const std::string& path, const std::string& reason) {
  INFO(path << " must be refused: " << reason);
  CHECK_THROWS_AS(parseMesh(bytes, path), ConfigurationError);
  CHECK_THROWS_WITH(parseMesh(bytes, path), ContainsSubstring(path + ":") && ContainsSubstring(reason));
}

}  // namespace

TEST_CASE("every format gives the same triangles, in the order of the file", "[unit]") {
  TriangleMesh mesh = inSinglePrecision(test::ball(2, 0.1));
  mesh.triangles.push_back({3, 3, 5});  // readers may drop, split or turn these
  mesh.triangles.push_back({0, 1, 2});
  mesh.triangles.push_back({0, 1, 2});
  for (const auto& [path, bytes] : allFormats(mesh)) {
    INFO(path);
    const TriangleMesh read = parseMesh(bytes, path);
    REQUIRE(read.triangles.size() == mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (int i = 0; i < 3; ++i) REQUIRE(read.vertices[read.triangles[t][i]] == mesh.vertices[mesh.triangles[t][i]]);
    const TriangleMesh scaled = parseMesh(bytes, path, 1e-3);
    CHECK(scaled.vertices.back() == 1e-3 * read.vertices.back());
  }
}

TEST_CASE("coordinates in double stay so", "[unit]") {
  const double third = 1.0 / 3.0;
  std::ostringstream text;
  text.precision(17);
  text << "v " << third << " 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  CHECK(parseMesh(text.str(), "a.obj").vertices[0].x() == third);
  TriangleMesh mesh = test::boxMesh({1, 1, 1});
  for (Vec3& v : mesh.vertices) v.x() *= third;
  CHECK(parseMesh(ply(mesh, "binary_big_endian"), "a.ply").vertices[7].x() == third);
}

TEST_CASE("polygons become fans", "[unit]") {
  const TriangleMesh mesh = parseMesh("OFF 4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 0.5 0.5 0.5\n", "quad.off");
  CHECK(mesh.triangles == std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}});
}

TEST_CASE("a text of as many bytes as a binary STL's head is a text", "[unit]") {
  std::string text = "solid\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendsolid";
  text.resize(84, '\n');
  CHECK(parseMesh(text, "a.stl").triangles.size() == 1);
}

TEST_CASE("a number too small for a double is zero, one too large is refused", "[unit]") {
  const auto file = [](const std::string& z) { return "OFF 3 1 0\n0 0 0\n1 0 " + z + "\n0 1 0\n3 0 1 2\n"; };
  const std::string zeros(400, '0');
  for (const std::string& z : {std::string("1e-400"), std::string("-9.9E-5000"), std::string("1e-99999999999999999999"),
                               "0." + zeros + "1", "0." + zeros + "1e10", "1" + zeros + "e-900"})
    CHECK(parseMesh(file(z), "a.off").vertices[1].z() == 0.0);
  for (const std::string& z : {std::string("1e400"), std::string("1E+5000"), std::string("1e99999999999999999999"),
                               "1" + zeros + ".5", "-1" + zeros + "e10", "0." + zeros + "1e900"})
    checkRefused(file(z), "a.off", "vertex 1");
}

TEST_CASE("unusable files are refused with the file, the place and the reason", "[unit]") {
  checkRefused("", "a.ply", "empty");
  checkRefused("OFF 0 0 0\n", "a.off", "no faces");
  checkRefused("x", "a.vtk", "extension");
  checkRefused("OFF 3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n", "a.off", "vertex 1");
  checkRefused("OFF 3 1 0\n0 0 0\n1 0 1e40\n0 1 0\n3 0 1 2\n", "a.off", "vertex 1");
  checkRefused("OFF 3 1 0\n0 0 0\n1 0 1e400\n0 1 0\n3 0 1 2\n", "a.off", "vertex 1");
  checkRefused("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "a.off", "face 0 names vertex 3");
  checkRefused("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -2\n", "a.off", "face 0 names vertex -2");
  checkRefused("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "a.off", "2 corners");
  checkRefused("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1", "a.off", "truncated");
  checkRefused("OFF 3 1 0\n0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n", "a.off", "a.off:3: coordinate of a vertex is \"zero\"");
  checkRefused("OFF 2000000000 1 0\n0 0 0\n", "a.off", "declares 2000000000 vertices");
  checkRefused("OFF 3 2000000000 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "a.off", "declares 2000000000 faces");
  checkRefused("v 0 0 0\nv 1 0 0\nv 0 1 nan\nf 1 2 3\n", "a.obj", "vertex 2");
  checkRefused("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "a.obj", "face 0 names vertex 3");
  checkRefused("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "a.obj", "a.obj:4: a face names vertex 0");
  const TriangleMesh mesh = test::boxMesh({1, 1, 1});
  const std::string binary = stlBinary(mesh);
  // Its size is no longer that of a binary file: it is read as text.
  checkRefused(binary.substr(0, binary.size() - 1), "a.stl", "endsolid is missing");
  std::string bare = binary;
  bare.replace(0, 5, "SOLID");
  checkRefused(bare.substr(0, bare.size() - 1), "a.stl",
               "declares 12 triangles, the rest of the file has room for at most 11");
  std::string huge = bare;
  huge.replace(80, 4, "\xff\xff\xff\x7f");
  checkRefused(huge, "a.stl", "declares 2147483647 triangles");
  std::string infinite = bare;
  infinite.replace(84 + 50 * 2 + 12, 4, std::string("\x00\x00\x80\x7f", 4));
  checkRefused(infinite, "a.stl", "vertex 6");
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const std::string bytes = ply(mesh, format);
    for (std::size_t cut = 1; cut < bytes.size() - 5; cut += 7)
      CHECK_THROWS_AS(parseMesh(bytes.substr(0, cut), "a.ply"), ConfigurationError);
    std::string counts = bytes;
    counts.replace(counts.find("vertex 8"), 8, "vertex 4000000000");
    checkRefused(counts, "a.ply", "declares 4000000000 vertex");
  }
  checkRefused("ply\nformat #1 1.0\nend_header\n0\n", "a.ply",
               "format is \"#1\"");  // PLY's remarks are separate lines
  CHECK_THROWS_WITH(loadMesh("/nonexistent/mesh.ply"),
                    ContainsSubstring("/nonexistent/mesh.ply") && ContainsSubstring("cannot open"));
  CHECK_THROWS_AS(parseMesh(off(mesh), "a.off", 0.0), ConfigurationError);
}

TEST_CASE("mutated files load or are refused", "[unit]") {
  test::Random random(21);
  const auto formats = allFormats(inSinglePrecision(test::ball(1, 0.1)));
  const auto pick = [&random](std::size_t n) {
    return std::min(static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(n))), n - 1);
  };
  const std::vector<std::string> words = {"nan",
                                          "-1",
                                          "1e999",
                                          "4294967295",
                                          "99999999999999999999",
                                          "\n",
                                          " ",
                                          "list",
                                          "inf",
                                          "3",
                                          "0",
                                          "element face 7\n",
                                          std::string(1, '\0'),
                                          "\xff\xff\xff\xff"};
  int loaded = 0, refused = 0;
  for (int i = 0; i < test::count(4000, 100000); ++i) {
    auto [path, bytes] = formats[pick(formats.size())];
    for (std::size_t changes = 1 + pick(4); changes > 0 && !bytes.empty(); --changes) {
      const std::size_t at = pick(bytes.size());
      switch (pick(5)) {
        case 0: bytes[at] = static_cast<char>(pick(256)); break;
        case 1: bytes.erase(at, 1 + pick(20)); break;
        case 2: bytes.insert(at, words[pick(words.size())]); break;
        case 3: bytes.replace(at, words[0].size(), words[pick(words.size())]); break;
        default: bytes.resize(at); break;
      }
    }
    try {
      const TriangleMesh mesh = parseMesh(bytes, path);
      checkMesh(mesh);
      ++loaded;
    } catch (const ConfigurationError&) {
      ++refused;
    }
  }
  CHECK(loaded > 0);
  CHECK(refused > 0);
}

TEST_CASE("files on disk load with their scale", "[unit]") {
  const test::TemporaryFolder folder;
  const TriangleMesh mesh = test::boxMesh({1, 1, 1});
  test::writeFile(folder / "box.off", off(mesh));
  CHECK(loadMesh(folder / "box.off", 1e-3).vertices[7] == Vec3(1e-3, 1e-3, 1e-3));
  CHECK_THROWS_WITH(loadMesh(folder / ""), test::ContainsSubstring("is a folder"));
  CHECK_THROWS_AS(loadMesh(folder / std::string(5000, 'x')), ConfigurationError);
}

}  // namespace enamel::test_mesh_file
