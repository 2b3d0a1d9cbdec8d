// enamel-labels as a user runs it: a segmented tooth in NIfTI or NRRD becomes a solid, with its position and unit.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "enamel/collision/solid_file.hpp"
#include "enamel/core/file.hpp"
#include "support/catch.hpp"
#include "support/command.hpp"
#include "support/skip.hpp"

namespace enamel::test_labels_command {

using test::ContainsSubstring;

namespace {

constexpr int kVoxels = 40;
constexpr double kVoxel = 0.1, kRadius = 1.5, kInner = 0.8;  // mm
constexpr std::size_t kHeader = 352;

template <typename Value>
void put(std::string& bytes, std::size_t at, Value value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

// A ball of label 1 with a ball of label 2 inside.
std::string ballOfLabels() {
  std::string labels;
  for (int z = 0; z < kVoxels; ++z)
    for (int y = 0; y < kVoxels; ++y)
      for (int x = 0; x < kVoxels; ++x) {
        const double middle = 0.5 * (kVoxels - 1);
        const double r = kVoxel * Vec3(x - middle, y - middle, z - middle).norm();
        labels += static_cast<char>(r < kInner ? 2 : r < kRadius ? 1 : 0);
      }
  return labels;
}

// The S-form turns the axes and moves the first voxel to (10, 20, 30).
std::string niftiOf(int units) {
  std::string bytes(kHeader, '\0');
  put(bytes, 0, 348);
  const std::int16_t dimensions[] = {3, kVoxels, kVoxels, kVoxels, 1, 1, 1, 1};
  for (std::size_t i = 0; i < 8; ++i) {
    put(bytes, 40 + 2 * i, dimensions[i]);
    put(bytes, 76 + 4 * i, i == 0 ? 1.0f : i < 4 ? static_cast<float>(kVoxel) : 0.0f);
  }
  put(bytes, 70, std::int16_t{2});  // unsigned bytes
  put(bytes, 72, std::int16_t{8});
  put(bytes, 108, static_cast<float>(kHeader));
  put(bytes, 112, 1.0f);  // slope
  put(bytes, 123, static_cast<char>(units));
  put(bytes, 254, std::int16_t{1});
  const float v = static_cast<float>(kVoxel);
  const float rows[] = {0.0f, -v, 0.0f, 10.0f, v, 0.0f, 0.0f, 20.0f, 0.0f, 0.0f, v, 30.0f};
  std::memcpy(bytes.data() + 280, rows, sizeof rows);
  std::memcpy(bytes.data() + 344, "n+1", 4);
  return bytes + ballOfLabels();
}

// The same labels in NRRD. Positions are in left-posterior-superior: x and y have the other sign.
const std::string kNrrd =
    "NRRD0004\n# a comment\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: 40 40 40\n"
    "space directions: (0,-0.1,0) (0.1,0,0) (0,0,0.1)\nkinds: domain domain domain\nencoding: raw\n"
    "space origin: (-10,-20,30)\nsegment:=tooth\n";

std::string nrrdOf(const std::vector<std::pair<std::string, std::string>>& changes = {}) {
  std::string header = kNrrd;
  for (const auto& [from, to] : changes) {
    const std::size_t at = header.find(from);
    REQUIRE(at != std::string::npos);
    header.replace(at, from.size(), to);
  }
  return header;
}

// Compressed by gzip, in stored blocks.
std::string gzipOf(const std::string& bytes) {
  constexpr std::size_t kBlock = 65535;
  std::string out("\x1f\x8b\x08\0\0\0\0\0\0\x03", 10);
  const auto add = [&out](std::uint32_t number, int count) {
    for (int i = 0; i < count; ++i) out += static_cast<char>(number >> (8 * i));
  };
  for (std::size_t at = 0; at < bytes.size(); at += kBlock) {
    const std::string block = bytes.substr(at, kBlock);
    const auto length = static_cast<std::uint32_t>(block.size());
    add(at + kBlock < bytes.size() ? 0 : 1, 1);
    add(length, 2);
    add(~length, 2);
    out += block;
  }
  add(crc32(bytes), 4);
  add(static_cast<std::uint32_t>(bytes.size()), 4);
  return out;
}

test::CommandResult run(const std::string& arguments) {
  return test::runCommand(std::string("'") + ENAMEL_LABELS + "' " + arguments);
}

double ballVolume(double radius) { return 4.0 / 3.0 * 3.141592653589793 * std::pow(radius, 3); }

}  // namespace

TEST_CASE("a NIfTI file of labels becomes a solid at its place", "[unit]") {
  if (std::string(ENAMEL_LABELS).empty()) return test::skipTest("VTK is not installed");
  const test::TemporaryFolder folder;
  const std::string file = folder / "tooth.nii", output = folder / "tooth.solid";
  const std::string layers = " --layer enamel=1@3.4e9 --layer dentine=2,7@0.6e9 ";
  for (const int units : {2, 0, 1}) {  // mm, unknown, m
    CAPTURE(units);
    const double unit = units == 1 ? 1.0 : 1e-3;
    const std::string nifti = niftiOf(units), cell = units == 1 ? "--cell 100 " : "--cell 0.1 ";
    test::writeFile(file, nifti);
    const test::CommandResult result = run(file + layers + cell + "--overwrite --output " + output);
    INFO(result.output);
    REQUIRE(result.status == 0);
    CHECK_THAT(result.output, ContainsSubstring("enamel ") && ContainsSubstring("dentine "));
    const Solid solid = loadSolid(output);
    REQUIRE(solid.layers().size() == 2);
    CHECK(solid.layers()[0].name == "enamel");
    CHECK(solid.layers()[0].hardness == 3.4e9);
    CHECK(solid.layers()[1].hardness == 0.6e9);
    // The smoothing of a voxel moves the surface inwards by 0.1^2 / R mm.
    const double inner = kInner - kVoxel * kVoxel / kInner, outer = kRadius - kVoxel * kVoxel / kRadius;
    const double voxels = static_cast<double>(std::count_if(nifti.begin() + static_cast<std::ptrdiff_t>(kHeader),
                                                            nifti.end(), [](char label) { return label != 0; }));
    const RemovedVolume volume = solid.volume();
    const double whole = (volume[0] + volume[1]) / std::pow(unit, 3);
    CHECK(whole == Approx(voxels * std::pow(kVoxel, 3) - ballVolume(kRadius) + ballVolume(outer)).epsilon(0.005));
    CHECK(volume[1] / std::pow(unit, 3) == Approx(ballVolume(inner)).epsilon(0.1));  // layers lie at cells
    const double middle = 0.5 * (kVoxels - 1) * kVoxel;
    const Vec3 centre = unit * Vec3(10.0 - middle, 20.0 + middle, 30.0 + middle);
    for (const Vec3& way : {Vec3(1.0, 0.0, 0.0), Vec3(0.0, -1.0, 0.0), Vec3(0.0, 0.6, 0.8)})
      CHECK(signedDistance(solid, centre + 2.0 * unit * way).distance ==
            Approx(unit * (2.0 - outer)).margin(0.5 * unit * kVoxel));
  }
}

TEST_CASE("NRRD files become the same solid, whatever their encoding, type, space and unit", "[unit]") {
  if (std::string(ENAMEL_LABELS).empty()) return test::skipTest("VTK is not installed");
  const test::TemporaryFolder folder;
  const std::string file = folder / "tooth.nrrd", data = folder / "voxels.gz", output = folder / "tooth.solid";
  const std::string labels = ballOfLabels();
  std::string wide, real;  // big-endian 16 bits; float
  for (const char label : labels) {
    wide += std::string({'\0', label});
    const float value = static_cast<float>(label);
    real.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  const auto solidOfFile = [&](const std::string& bytes) {
    test::writeFile(file, bytes);
    const test::CommandResult result =
        run(file + " --layer enamel=1@3.4e9 --layer dentine=2@0.6e9 --overwrite --output " + output);
    INFO(result.output);
    REQUIRE(result.status == 0);
    return readFile(output, std::size_t{1} << 30);
  };
  const std::string plain = solidOfFile(nrrdOf() + "\n" + labels);
  const Solid solid = loadSolid(output);
  const double outer = kRadius - kVoxel * kVoxel / kRadius, middle = 0.5 * (kVoxels - 1) * kVoxel;
  const Vec3 centre = 1e-3 * Vec3(10.0 - middle, 20.0 + middle, 30.0 + middle);  // as in the NIfTI file
  for (const Vec3& way : {Vec3(1.0, 0.0, 0.0), Vec3(0.0, -1.0, 0.0), Vec3(0.0, 0.6, 0.8)})
    CHECK(signedDistance(solid, centre + 2e-3 * way).distance == Approx(1e-3 * (2.0 - outer)).margin(5e-4 * kVoxel));

  CHECK(solidOfFile(nrrdOf({{"raw", "gzip"}}) + "\n" + gzipOf(labels)) == plain);
  CHECK(solidOfFile(nrrdOf({{"unsigned char", "short"}, {"kinds", "endian: big\nkinds"}}) + "\n" + wide) == plain);
  CHECK(solidOfFile(nrrdOf({{"unsigned char", "float"}, {"kinds", "endian: little\nkinds"}}) + "\n" + real) == plain);
  CHECK(solidOfFile(nrrdOf({{"left-posterior-superior", "RAS"},
                            {"(0,-0.1,0) (0.1,0,0)", "( 0, 0.1, 0 ) (-0.1,0,0)"},
                            {"(-10,-20,30)", "(10,20,30)"}}) +
                    "\r\n" + labels) == plain);
  CHECK(solidOfFile(nrrdOf({{"encoding", "space units: \"mm\" \"mm\" \"mm\"\nencoding"}}) + "\n" + labels) == plain);
  test::writeFile(data, gzipOf(labels));
  CHECK(solidOfFile(nrrdOf({{"raw", "gzip"}}) + "data file: voxels.gz\n") == plain);  // detached
}

TEST_CASE("damaged NRRD files are refused, in one line", "[unit]") {
  if (std::string(ENAMEL_LABELS).empty()) return test::skipTest("VTK is not installed");
  const test::TemporaryFolder folder;
  const std::string file = folder / "tooth.nrrd", output = folder / "tooth.solid", labels = ballOfLabels();
  const auto refused = [&](const std::string& bytes, const std::string& why) {
    test::writeFile(file, bytes);
    const test::CommandResult result = run(file + " --layer enamel=1,2@3.4e9 --output " + output);
    INFO(bytes.substr(0, 400) << "\n" << result.output);
    CHECK(result.status == 1);
    CHECK_THAT(result.output, ContainsSubstring(".nrrd") && ContainsSubstring(why));
    CHECK(result.output.find('\n') == result.output.size() - 1);
    CHECK_FALSE(std::filesystem::exists(output));
  };
  const std::string whole = "\n" + labels, zipped = gzipOf(labels);
  for (std::size_t size = 4; size < kNrrd.size(); size += 23) refused(kNrrd.substr(0, size), "");
  refused(kNrrd, "no empty line ends its header");
  refused(kNrrd + "\n", "must have 64000 bytes of voxels");
  refused(kNrrd + whole.substr(0, 60000), "must have 64000 bytes");
  refused(kNrrd + whole + "x", "must have 64000 bytes");
  const std::string gzip = nrrdOf({{"raw", "gzip"}}) + "\n";
  for (const std::size_t size : {std::size_t{0}, std::size_t{5}, zipped.size() / 2, zipped.size() - 1})
    refused(gzip + zipped.substr(0, size), "must have 64000 bytes");
  refused(gzip + zipped + "x", "must have 64000 bytes");
  refused(gzip + gzipOf(labels + "x"), "must have 64000 bytes");
  std::string changed = zipped;
  changed[zipped.size() / 2] ^= 1;  // its checksum is wrong then
  refused(gzip + changed, "is damaged");
  for (const char* field : {"type", "dimension", "space", "sizes", "encoding"})
    refused(nrrdOf({{std::string("\n") + field + ":", "\n# "}}) + whole, "");
  const std::tuple<const char*, const char*, const char*> wrong[] = {
      {"kinds", "colour", "colour: is not a field of NRRD"},
      {"kinds", "sizes", "sizes: appears twice"},
      {"# a comment", "comment", ":2: has neither a field nor a comment"},
      {"dimension: 3", "dimension: 4", ":4: dimension: is 4, must be 3"},
      {"40 40 40", "40 40", "must have three numbers"},
      {"40 40 40", "40 40 40 40", "must have three numbers"},
      {"40 40 40", "40 -40 40", "three whole numbers whose product is 1 to 2^28"},
      {"40 40 40", "40 1.5 40", "three whole numbers"},
      {"40 40 40", "40 1e5 1e5", "three whole numbers"},
      {"unsigned char", "block", "must be an integer type, float or double"},
      {"unsigned char", "short", "endian: is missing"},
      {"unsigned char\n", "short\nendian: middle\n", "must be little or big"},
      {"raw", "ascii", "encoding: is ascii, must be raw or gzip"},
      {"left-posterior-superior", "3D-left-handed", "space: is \"3D-left-handed\""},
      {"space: left-posterior-superior", "space dimension: 2", "must be 3"},
      {"kinds", "space dimension: 3\nkinds", "needs either space or space dimension"},
      {"kinds", "spacings: 1 1 1\nkinds", "excludes space directions"},
      {"(0,0,0.1)", "none", "must have 3 of (x,y,z)"},
      {"(0,0,0.1)", "(0,0)", "must have 3 of (x,y,z)"},
      {"(0,0,0.1)", "(0,0,nan)", "must have three numbers"},
      {"(0,0,0.1)", "(0,0,0)", "spacing"},
      {"(0,0,0.1)", "(0,0.05,0.1)", "must be orthonormal"},
      {"(-10,-20,30)", "(-10,-20,30", "must have 1 of (x,y,z)"},
      {"encoding", "space units: \"mm\" \"mm\" \"in\"\nencoding", "must be \"mm\", \"m\" or \"um\""},
      {"encoding", "byte skip: 3\nencoding", "must be 0"},
      {"encoding", "data file: LIST\nencoding", "names several files"},
      {"encoding", "data file: slice%03d.raw 1 40 1\nencoding", "names several files"},
  };
  for (const auto& [from, to, why] : wrong) refused(nrrdOf({{from, to}}) + whole, why);
  refused(nrrdOf({{"encoding", "data file: absent.nrrd\nencoding"}}), "absent.nrrd");
  refused(nrrdOf({{"unsigned char", "signed char"}}) + "\n" + std::string(64000, '\xff'), "has the value -1.0");
}

TEST_CASE("files and options that enamel-labels refuses, in one line", "[unit]") {
  if (std::string(ENAMEL_LABELS).empty()) return test::skipTest("VTK is not installed");
  const test::TemporaryFolder folder;
  const std::string file = folder / "tooth.nii", output = folder / "tooth.solid";
  const std::string good = niftiOf(2), layer = " --layer enamel=1@3.4e9";
  const auto refused = [&](const std::string& bytes, const std::string& options, const std::string& why) {
    test::writeFile(file, bytes);
    const test::CommandResult result = run(file + options + " --output " + output);
    INFO(result.output);
    CHECK(result.status != 0);
    CHECK_THAT(result.output, ContainsSubstring(why));
    CHECK(result.output.find('\n') == result.output.size() - 1);
    CHECK_FALSE(std::filesystem::exists(output));
  };
  refused("", layer, "tooth.nii: is missing, or is neither a NIfTI nor an NRRD file");
  refused("NRRD0004\n", layer, "dimension: is missing");
  for (const std::size_t size : {std::size_t{100}, kHeader, kHeader + 5000, good.size() - 1})
    refused(good.substr(0, size), layer, "tooth.nii: is ");
  std::string other = good;
  put(other, 112, 2.0f);
  refused(other, layer, "has scaled values");
  other = good;
  put(other, 70, std::int16_t{256});  // signed bytes
  other[kHeader] = -1;
  refused(other, layer, "labels must be whole numbers");
  refused(good, " --layer enamel=9@3.4e9", "layer \"enamel\": no voxels");
  for (const char* text : {"enamel", "enamel=1", "=1@3e9", "enamel=@3e9", "enamel=1,@3e9", "enamel=1@", "enamel=1@3e9x",
                           "enamel=a@3e9", "enamel@3e9=1"})
    refused(good, std::string(" --layer ") + text, "must be NAME=LABEL,LABEL...@HARDNESS");
  refused(good, " --layer enamel=1@-1", "hardness");
}

}  // namespace enamel::test_labels_command
