#include "nrrd.hpp"

#include <vtk_zlib.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string_view>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "volume.hpp"

namespace enamel::app {
namespace {

constexpr double kMostVoxels = 1 << 28;  // as surfaceOf()
constexpr std::size_t kLargestFile = std::size_t{1} << 31;

// Fields that say nothing about values or places of voxels.
constexpr const char* kUnused[] = {
    "content",  "number",      "blocksize", "min",        "max",   "oldmin", "oldmax",      "axismins",
    "axismaxs", "thicknesses", "centers",   "centerings", "kinds", "labels", "sampleunits", "measurementframe"};
constexpr const char* kUsed[] = {"type",        "dimension",  "sizes",    "encoding",       "endian",
                                 "spacings",    "units",      "space",    "spacedimension", "spacedirections",
                                 "spaceorigin", "spaceunits", "datafile", "lineskip",       "byteskip"};

struct Type {
  const char* names;  // without spaces, each between two spaces
  std::size_t size;
  enum { isSigned, isUnsigned, isReal } kind;
};
constexpr Type kTypes[] = {
    {" signedchar int8 int8_t ", 1, Type::isSigned},
    {" uchar unsignedchar uint8 uint8_t ", 1, Type::isUnsigned},
    {" short shortint signedshort signedshortint int16 int16_t ", 2, Type::isSigned},
    {" ushort unsignedshort unsignedshortint uint16 uint16_t ", 2, Type::isUnsigned},
    {" int signedint int32 int32_t ", 4, Type::isSigned},
    {" uint unsignedint uint32 uint32_t ", 4, Type::isUnsigned},
    {" longlong longlongint signedlonglong signedlonglongint int64 int64_t ", 8, Type::isSigned},
    {" ulonglong unsignedlonglong unsignedlonglongint uint64 uint64_t ", 8, Type::isUnsigned},
    {" float ", 4, Type::isReal},
    {" double ", 8, Type::isReal},
};

// Signs of x, y, z in right-anterior-superior.
struct Space {
  const char* names;
  double x, y;
};
constexpr Space kSpaces[] = {{" right-anterior-superior ras scanner-xyz 3d-right-handed ", 1.0, 1.0},
                             {" left-anterior-superior las ", -1.0, 1.0},
                             {" left-posterior-superior lps ", -1.0, -1.0}};

// A text in lower case without spaces.
std::string plain(std::string_view text) {
  std::string result;
  for (const unsigned char c : text)
    if (std::isspace(c) == 0) result += static_cast<char>(std::tolower(c));
  return result;
}

template <typename Table>
const auto* find(const Table& table, const std::string& name) {
  const auto* const found = std::find_if(std::begin(table), std::end(table), [&name](const auto& row) {
    return std::strstr(row.names, (' ' + name + ' ').c_str()) != nullptr;
  });
  return found == std::end(table) ? nullptr : found;
}

class Header {
 public:
  Header(const std::string& path, std::string_view bytes) : path_(path) {
    std::size_t at = 0;
    for (int line = 1; !isComplete_ && at < bytes.size(); ++line) {
      const std::size_t end = std::min(bytes.find('\n', at), bytes.size());
      std::string_view text = bytes.substr(at, end - at);
      at = std::min(end + 1, bytes.size());
      if (!text.empty() && text.back() == '\r') text.remove_suffix(1);
      isComplete_ = text.empty();
      if (line > 1 && !isComplete_) read(text, line);
    }
    end_ = at;
  }

  [[noreturn]] void fail(const std::string& field, const std::string& problem) const {
    const auto found = fields_.find(field);
    throw ConfigurationError(path_, found == fields_.end() ? 0 : found->second.line, field, problem);
  }
  bool has(const std::string& field) const { return fields_.count(field) > 0; }
  const std::string& of(const std::string& field) const {
    const auto found = fields_.find(field);
    if (found == fields_.end()) fail(field, "is missing");
    return found->second.value;
  }
  const std::string& path() const { return path_; }
  bool isComplete() const { return isComplete_; }  // an empty line ends it
  std::size_t end() const { return end_; }         // where attached data begin

  // Return three numbers; vectors in parentheses.
  Vec3 numbers(const std::string& field, const std::string& text) const {
    std::istringstream stream(text);
    Vec3 numbers;
    std::string rest;
    for (double& number : numbers)
      if (!(stream >> number)) fail(field, "is \"" + of(field) + "\", must have three numbers");
    if (stream >> rest) fail(field, "is \"" + of(field) + "\", must have three numbers");
    return numbers;
  }
  std::vector<Vec3> vectors(const std::string& field, std::size_t count) const {
    std::vector<Vec3> vectors;
    std::string text = plain(of(field));
    while (!text.empty() && text.front() == '(') {
      const std::size_t end = text.find(')');
      std::string inner = text.substr(1, end - 1);
      if (end == std::string::npos || std::count(inner.begin(), inner.end(), ',') != 2) break;
      std::replace(inner.begin(), inner.end(), ',', ' ');
      vectors.push_back(numbers(field, inner));
      text.erase(0, end + 1);
    }
    if (!text.empty() || vectors.size() != count)
      fail(field, "is \"" + of(field) + "\", must have " + std::to_string(count) + " of (x,y,z)");
    return vectors;
  }

 private:
  struct Field {
    std::string value;
    int line;
  };

  void read(std::string_view text, int line) {
    const std::size_t colon = text.find(':');
    if (text.front() == '#' || (colon != std::string_view::npos && text.substr(colon, 2) == ":=")) return;
    if (colon == std::string_view::npos) throw ConfigurationError(path_, line, "", "has neither a field nor a comment");
    const std::string name = plain(text.substr(0, colon));
    const auto isName = [&name](const char* known) { return name == known; };
    const bool isUsed = std::any_of(std::begin(kUsed), std::end(kUsed), isName);
    if (!isUsed && std::none_of(std::begin(kUnused), std::end(kUnused), isName))
      throw ConfigurationError(path_, line, name, "is not a field of NRRD");
    std::string_view value = text.substr(colon + 1);
    while (!value.empty() && value.front() == ' ') value.remove_prefix(1);
    while (!value.empty() && value.back() == ' ') value.remove_suffix(1);
    if (!fields_.insert({name, {std::string(value), line}}).second)
      throw ConfigurationError(path_, line, name, "appears twice");
  }

  std::string path_;
  std::map<std::string, Field> fields_;
  bool isComplete_ = false;
  std::size_t end_ = 0;
};

// Return metres a unit of the file.
double scaleOf(const Header& header, const std::string& field) {
  if (!header.has(field)) return 1e-3;
  const std::string units = plain(header.of(field));
  for (const auto& [unit, scale] : {std::pair{"\"mm\"", 1e-3}, {"\"m\"", 1.0}, {"\"um\"", 1e-6}})
    if (units == std::string(unit) + unit + unit) return scale;
  header.fail(field, "is " + header.of(field) + ", must be \"mm\", \"m\" or \"um\" for each axis");
}

void readPlace(const Header& header, LabelVolume& volume) {
  if (!header.has("spacedirections")) {
    volume.spacing = scaleOf(header, "units") * header.numbers("spacings", header.of("spacings"));
    if (header.has("spaceorigin")) header.fail("spaceorigin", "needs space directions");
    return;
  }
  if (header.has("spacings")) header.fail("spacings", "excludes space directions");
  if (header.has("space") == header.has("spacedimension"))
    header.fail("spacedirections", "needs either space or space dimension");
  Vec3 signs = Vec3::Ones();
  if (header.has("space")) {
    const Space* const space = find(kSpaces, plain(header.of("space")));
    if (space == nullptr)
      header.fail("space", "is \"" + header.of("space") +
                               "\", must be right-anterior-superior, left-anterior-superior, left-posterior-superior, "
                               "scanner-xyz or 3D-right-handed");
    signs = {space->x, space->y, 1.0};
  } else if (header.of("spacedimension") != "3") {
    header.fail("spacedimension", "is " + header.of("spacedimension") + ", must be 3");
  }
  const double scale = scaleOf(header, "spaceunits");
  const std::vector<Vec3> directions = header.vectors("spacedirections", 3);
  for (int i = 0; i < 3; ++i) {
    const Vec3& direction = directions[static_cast<std::size_t>(i)];
    volume.spacing[i] = scale * direction.norm();
    volume.axes.col(i) = direction.normalized().cwiseProduct(signs);
  }
  if (header.has("spaceorigin")) volume.origin = scale * header.vectors("spaceorigin", 1)[0].cwiseProduct(signs);
}

// Return the bytes of the voxels, which must be `size` bytes.
std::string dataOf(const Header& header, const std::string& file, std::size_t size) {
  for (const char* field : {"lineskip", "byteskip"})
    if (header.has(field) && header.of(field) != "0") header.fail(field, "must be 0: write the file again without it");
  std::string data;
  if (header.has("datafile")) {
    const std::string name = header.of("datafile");
    if (plain(name).substr(0, 4) == "list" || name.find('%') != std::string::npos)
      header.fail("datafile", "names several files, must be one");
    data = readFile((std::filesystem::u8path(header.path()).parent_path() / std::filesystem::u8path(name)).u8string(),
                    kLargestFile);
  } else {
    if (!header.isComplete()) header.fail("", "is truncated: no empty line ends its header");
    data = file.substr(header.end());
  }
  const std::string encoding = plain(header.of("encoding"));
  const std::string wrong = "is damaged or truncated: it must have " + std::to_string(size) + " bytes of voxels";
  if (encoding == "raw") {
    if (data.size() != size) header.fail("", wrong);
    return data;
  }
  if (encoding != "gzip" && encoding != "gz")
    header.fail("encoding", "is " + header.of("encoding") + ", must be raw or gzip");
  std::string voxels(size, '\0');
  z_stream stream{};
  stream.next_in = reinterpret_cast<Bytef*>(data.data());
  stream.avail_in = static_cast<uInt>(data.size());
  stream.next_out = reinterpret_cast<Bytef*>(voxels.data());
  stream.avail_out = static_cast<uInt>(size);
  constexpr int kGzip = 16;  // with its checksum
  const bool isWhole = inflateInit2(&stream, kGzip + MAX_WBITS) == Z_OK && inflate(&stream, Z_FINISH) == Z_STREAM_END;
  inflateEnd(&stream);
  if (!isWhole || stream.avail_in > 0 || stream.avail_out > 0) header.fail("", wrong);
  return voxels;
}

// Return the number in the bytes of a voxel.
double valueOf(const char* bytes, const Type& type, bool isBig) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < type.size; ++i)
    bits = bits << 8 | static_cast<unsigned char>(bytes[isBig ? i : type.size - 1 - i]);
  const auto as = [&bits](auto value) {
    std::memcpy(&value, &bits, sizeof value);
    return static_cast<double>(value);
  };
  if (type.kind == Type::isReal && type.size == 4) {
    const auto half = static_cast<std::uint32_t>(bits);
    float value = 0.0f;
    std::memcpy(&value, &half, sizeof value);
    return static_cast<double>(value);
  }
  if (type.kind == Type::isReal) return as(0.0);
  if (type.kind == Type::isUnsigned) return static_cast<double>(bits);
  const std::uint64_t sign = std::uint64_t{1} << (8 * type.size - 1);
  bits = (bits ^ sign) - sign;  // the sign in all higher bits
  return as(std::int64_t{0});
}

}  // namespace

bool isNrrd(const std::string& path) {
  std::ifstream file(std::filesystem::u8path(path), std::ios::binary);
  std::string magic(4, '\0');
  return file.read(magic.data(), 4) && magic == "NRRD";
}

LabelVolume loadNrrd(const std::string& path) {
  const std::string file = readFile(path, kLargestFile);
  const Header header(path, file);
  if (header.of("dimension") != "3") header.fail("dimension", "is " + header.of("dimension") + ", must be 3");
  LabelVolume volume;
  double voxels = 1.0;
  const Vec3 sizes = header.numbers("sizes", header.of("sizes"));
  for (int i = 0; i < 3; ++i) {
    voxels *= sizes[i];
    if (!(sizes[i] >= 1.0 && sizes[i] <= kMostVoxels && voxels <= kMostVoxels && sizes[i] == std::floor(sizes[i])))
      header.fail("sizes", "is " + header.of("sizes") + ", must be three whole numbers whose product is 1 to 2^28");
    volume.size[static_cast<std::size_t>(i)] = static_cast<int>(sizes[i]);
  }
  const Type* const type = find(kTypes, plain(header.of("type")));
  if (type == nullptr)
    header.fail("type", "is \"" + header.of("type") + "\", must be an integer type, float or double");
  const std::string endian = type->size > 1 ? plain(header.of("endian")) : "little";
  if (endian != "little" && endian != "big") header.fail("endian", "is \"" + endian + "\", must be little or big");
  readPlace(header, volume);
  const std::string data = dataOf(header, file, type->size * static_cast<std::size_t>(voxels));
  volume.labels.reserve(static_cast<std::size_t>(voxels));
  for (std::size_t at = 0; at < data.size(); at += type->size)
    volume.labels.push_back(labelOf(valueOf(data.data() + at, *type, endian == "big"), path));
  return volume;
}

}  // namespace enamel::app
