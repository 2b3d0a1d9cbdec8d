// enamel-labels as a user runs it: a segmented tooth in NIfTI becomes a solid, with its position and unit.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "enamel/collision/solid_file.hpp"
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

// A ball of label 1 with a ball of label 2 inside. An S-form turns the axes and moves the first voxel to (10, 20, 30).
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
  for (int z = 0; z < kVoxels; ++z)
    for (int y = 0; y < kVoxels; ++y)
      for (int x = 0; x < kVoxels; ++x) {
        const double middle = 0.5 * (kVoxels - 1);
        const double r = kVoxel * Vec3(x - middle, y - middle, z - middle).norm();
        bytes += static_cast<char>(r < kInner ? 2 : r < kRadius ? 1 : 0);
      }
  return bytes;
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
  refused("", layer, "tooth.nii: is missing, or is not a NIfTI file");
  refused("NRRD0004\n", layer, "is not a NIfTI file");
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
