#include "enamel/collision/solid_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "solid_query.hpp"

namespace enamel {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are copied as they are: little-endian");

constexpr char kMagic[8] = {'E', 'N', 'A', 'M', 'E', 'L', 'S', '\n'};
constexpr std::uint32_t kVersion = 1;
constexpr std::size_t kPreamble = 24, kLargestSolidFile = std::size_t{1} << 30;
constexpr double kFarthestCorner = 1e9;  // m, as of meshes
constexpr std::uint8_t kVaries = 1, kHasLayers = 2, kIsCut = 4;

struct Preamble {
  char magic[8];
  std::uint32_t version, crc;  // of everything after the preamble
  std::uint64_t size;          // of everything after the preamble
};
static_assert(sizeof(Preamble) == kPreamble);

// The numbers of a layer in the order of the file; a new one needs a new version.
template <typename Layer>
auto numbersOf(Layer& l) {
  static_assert(sizeof(Material) == 11 * sizeof(double) && sizeof(Tap) == 2 * sizeof(double));
  auto& m = l.material;
  return std::array{&l.hardness,  &l.depth,     &m.stiffness,  &m.friction,      &m.slidingFriction,
                    &m.viscosity, &m.exponent,  &m.thickness,  &m.hysteresis,    &m.puncture,
                    &m.stribeck,  &m.roughness, &m.wavelength, &l.tap.frequency, &l.tap.decay};
}

template <typename Value>
void put(const Value& value, std::string& bytes) {
  static_assert(std::is_trivially_copyable_v<Value>);
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

class Reader {
 public:
  Reader(std::string_view bytes, const std::string& path) : left_(bytes), path_(path) {}

  [[noreturn]] void refuse(const std::string& problem) const { throw ConfigurationError(path_, 0, "", problem); }
  void require(bool holds, const std::string& problem) const {
    if (!holds) refuse(problem);
  }
  std::size_t left() const { return left_.size(); }
  std::string_view text(std::size_t size) {
    require(size <= left_.size(), "ends too early");
    const std::string_view some = left_.substr(0, size);
    left_.remove_prefix(size);
    return some;
  }
  template <typename Value>
  void get(Value& value) {
    std::memcpy(static_cast<void*>(&value), text(sizeof value).data(), sizeof value);
  }
  template <typename Value>
  Value next() {
    Value value;
    get(value);
    return value;
  }

 private:
  std::string_view left_;
  const std::string& path_;
};

bool isWithin(const BrickSamples& samples) {
  return std::all_of(samples.begin(), samples.end(), [](float s) { return s >= -Solid::kBand && s <= Solid::kBand; });
}

SolidLayer readLayer(Reader& reader, const std::string& what) {
  SolidLayer layer;
  layer.name = std::string(reader.text(reader.next<std::uint32_t>()));
  for (double* number : numbersOf(layer)) reader.get(*number);
  try {
    kernel::checkLayer(layer);
  } catch (const Error& error) {
    reader.refuse(what + ": " + error.what());
  }
  reader.require(layer.depth >= 0.0 && std::isfinite(layer.depth), what + ": its depth is negative or not finite");
  return layer;
}

}  // namespace

// The private parts of a solid.
struct SolidFile {
  static std::string bytesOf(const Solid& solid);
  static Solid read(Reader& reader, int undoBricks);
  static void readBrick(Reader& reader, const std::string& what, Solid& solid);
};

std::string SolidFile::bytesOf(const Solid& solid) {
  std::string bytes(kPreamble, '\0');
  put(solid.cell_, bytes);
  for (int i = 0; i < 3; ++i) put(solid.origin_[i], bytes);
  put(solid.count_, bytes);
  put(static_cast<std::uint32_t>(solid.layers_.size()), bytes);
  put(static_cast<std::uint32_t>(solid.bricks_.size()), bytes);
  for (const SolidLayer& layer : solid.layers_) {
    put(static_cast<std::uint32_t>(layer.name.size()), bytes);
    bytes += layer.name;
    for (const double* number : numbersOf(layer)) put(*number, bytes);
  }
  for (std::size_t i = 0; i < solid.bricks_.size(); ++i) {
    const Solid::Brick& brick = solid.bricks_[i];
    const BrickSamples& original = solid.original_[i];
    const bool varies = std::any_of(original.begin(), original.end(), [](float s) { return s != -Solid::kBand; });
    const bool hasLayers =
        std::any_of(brick.layer.begin(), brick.layer.end(), [&](auto layer) { return layer != brick.layer[0]; });
    const bool isCut = std::memcmp(brick.samples.data(), original.data(), sizeof original) != 0;
    put(brick.place, bytes);
    put(static_cast<std::uint8_t>((varies ? kVaries : 0) | (hasLayers ? kHasLayers : 0) | (isCut ? kIsCut : 0)), bytes);
    hasLayers ? put(brick.layer, bytes) : put(brick.layer[0], bytes);
    if (varies) put(original, bytes);
    if (isCut) put(brick.samples, bytes);
  }
  const std::string_view content = std::string_view(bytes).substr(kPreamble);
  Preamble preamble{{}, kVersion, crc32(content), content.size()};
  std::memcpy(preamble.magic, kMagic, sizeof kMagic);
  std::memcpy(bytes.data(), &preamble, sizeof preamble);
  return bytes;
}

void SolidFile::readBrick(Reader& reader, const std::string& what, Solid& solid) {
  const std::size_t number = solid.bricks_.size();
  Solid::Brick& brick = solid.bricks_.emplace_back();
  BrickSamples& original = solid.original_.emplace_back();
  reader.get(brick.place);
  for (std::size_t i = 0; i < 3; ++i)
    reader.require(brick.place[i] >= 0 && brick.place[i] < solid.count_[i], what + ": it is outside of the solid");
  std::int32_t& there = solid.index_[static_cast<std::size_t>(
      (brick.place[2] * solid.count_[1] + brick.place[1]) * solid.count_[0] + brick.place[0])];
  reader.require(there < 0, what + ": it is in the place of another brick");
  there = static_cast<std::int32_t>(number);
  const auto flags = reader.next<std::uint8_t>();
  reader.require(flags <= (kVaries | kHasLayers | kIsCut), what + ": its flags are unknown");
  if ((flags & kHasLayers) != 0)
    reader.get(brick.layer);
  else
    brick.layer.fill(reader.next<std::uint8_t>());
  reader.require(*std::max_element(brick.layer.begin(), brick.layer.end()) < solid.layers_.size(),
                 what + ": its layer does not exist");
  original.fill(-Solid::kBand);
  if ((flags & kVaries) != 0) reader.get(original);
  brick.samples = original;
  if ((flags & kIsCut) != 0) reader.get(brick.samples);
  reader.require(isWithin(original) && isWithin(brick.samples), what + ": a sample is not within 2.5 cells");
  for (std::size_t i = 0; i < original.size(); ++i)
    reader.require(brick.samples[i] >= original[i], what + ": a cut has added material");
}

Solid SolidFile::read(Reader& reader, int undoBricks) {
  Solid solid;
  reader.get(solid.cell_);
  reader.require(solid.cell_ >= Solid::kSmallestCell && std::isfinite(solid.cell_), "the cell is too small");
  for (int i = 0; i < 3; ++i) reader.get(solid.origin_[i]);
  reader.get(solid.count_);
  double places = 1.0;
  for (const int count : solid.count_) {
    reader.require(count > 0, "the number of bricks along an axis is not positive");
    places *= count;
  }
  reader.require(places <= kernel::kMostSolidPlaces, "the solid is too large for its cells");
  reader.require(solid.origin_.allFinite() && solid.origin_.cwiseAbs().maxCoeff() <= kFarthestCorner &&
                     (solid.high() - solid.low()).maxCoeff() <= kFarthestCorner,
                 "the solid is larger or farther away than 1e9 m");
  const auto layers = reader.next<std::uint32_t>(), bricks = reader.next<std::uint32_t>();
  reader.require(layers >= 1 && layers <= kMaxSolidLayers, "the number of layers is not 1 to 8");
  reader.require(bricks <= places && bricks <= reader.left() / sizeof(solid.bricks_[0].place) &&
                     bricks * (sizeof(Solid::Brick) + sizeof(BrickSamples)) <= kernel::kMostSolidBytes,
                 "the number of bricks is too large");
  for (std::uint32_t k = 0; k < layers; ++k) solid.layers_.push_back(readLayer(reader, "layer " + std::to_string(k)));
  solid.index_.assign(static_cast<std::size_t>(places), -1);
  solid.bricks_.reserve(bricks);
  solid.original_.reserve(bricks);
  for (std::uint32_t i = 0; i < bricks; ++i) readBrick(reader, "brick " + std::to_string(i), solid);
  reader.require(reader.left() == 0, "has bytes after the last brick");
  solid.prepare(undoBricks);
  return solid;
}

void saveSolid(const Solid& solid, const std::string& path) { writeFile(path, SolidFile::bytesOf(solid)); }

Solid parseSolid(std::string_view bytes, const std::string& path, int undoBricks) {
  Reader reader(bytes, path);
  Preamble preamble{};
  if (bytes.size() >= kPreamble) reader.get(preamble);
  reader.require(std::memcmp(preamble.magic, kMagic, sizeof kMagic) == 0, "is not a saved solid");
  reader.require(preamble.version == kVersion, "has the version " + std::to_string(preamble.version) +
                                                   " of saved solids, must be " + std::to_string(kVersion));
  reader.require(preamble.size == reader.left(), "is damaged: it has " + std::to_string(reader.left()) +
                                                     " bytes after its preamble, must have " +
                                                     std::to_string(preamble.size));
  reader.require(preamble.crc == crc32(bytes.substr(kPreamble)), "is damaged: its checksum is wrong");
  return SolidFile::read(reader, undoBricks);
}

Solid loadSolid(const std::string& path, int undoBricks) {
  return parseSolid(readFile(path, kLargestSolidFile), path, undoBricks);
}

}  // namespace enamel
