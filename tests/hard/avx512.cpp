// The query loops for AVX-512 against those for AVX2, on any machine with AVX2: the intrinsics are replaced.
#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/mesh_data.hpp"
#include "support/catch.hpp"
#include "support/meshes.hpp"
#include "support/run_length.hpp"
#include "support/skip.hpp"

namespace enamel::kernel {
extern const Loops kAvx512LoopsByAvx2;
}

namespace enamel::test_avx512 {

namespace {

std::vector<int> minimaOf(const kernel::Loops& loops, const kernel::Mesh& mesh, const Vec3& p, double reach) {
  std::vector<int> slots;
  const auto keep = [](void* context, std::int32_t slot, double within) {
    static_cast<std::vector<int>*>(context)->push_back(slot);
    return within;
  };
  loops.visitMinima(mesh, p.data(), reach, keep, &slots);
  return slots;
}

}  // namespace

TEST_CASE("the loops for AVX-512 answer as those for AVX2", "[hard]") {
  if (simdLevel() == SimdLevel::baseline) return test::skipTest("this machine has no AVX2");
  const kernel::Loops &wide = kernel::kAvx512LoopsByAvx2, &known = kernel::kAvx2Loops;
  std::vector<test::NamedMesh> meshes = test::brokenMeshes();
  meshes.push_back({"ball", test::ball(5, 0.1)});
  for (const auto& [name, mesh, closed] : meshes) {
    INFO(name);
    const MeshModel model(mesh);
    const kernel::Mesh& view = kernel::Inside::of(model).view;
    const double size = test::sizeOf(mesh);
    test::Random random(512);
    kernel::Cache wideCache, knownCache;
    Vec3 p = mesh.vertices[mesh.triangles[0][0]];
    for (int i = 0; i < test::count(3000, 30000); ++i) {
      p = i % 60 == 0 ? test::queryPoint(mesh, size, random) : Vec3(p + 0.002 * size * random.direction());
      const double reach = size * std::pow(10.0, random.uniform(-4.0, 0.0));
      const double squared = i % 3 == 0 ? reach * reach : kNoLimit;
      kernel::Answer one, other;
      known.closest(view, p.data(), squared, &knownCache, &other);
      for (kernel::Cache* cache : {&wideCache, static_cast<kernel::Cache*>(nullptr)}) {
        wide.closest(view, p.data(), squared, cache, &one);
        REQUIRE(one.slot == other.slot);
        REQUIRE(one.nearest.squared == other.nearest.squared);
        REQUIRE(std::equal(one.nearest.point, one.nearest.point + 3, other.nearest.point));
      }
      const Vec3 q = p + reach * random.direction();
      kernel::SegmentAnswer onAxis, expected;
      wide.closestToSegment(view, p.data(), q.data(), reach, 2.0 * reach, -1, &onAxis);
      known.closestToSegment(view, p.data(), q.data(), reach, 2.0 * reach, -1, &expected);
      REQUIRE(onAxis.slot == expected.slot);
      if (expected.slot >= 0) {
        REQUIRE(onAxis.squared == expected.squared);
        REQUIRE(onAxis.parameter == expected.parameter);
        REQUIRE(std::equal(onAxis.point, onAxis.point + 3, expected.point));
      }
      REQUIRE(minimaOf(wide, view, p, reach) == minimaOf(known, view, p, reach));
    }
  }
}

}  // namespace enamel::test_avx512
