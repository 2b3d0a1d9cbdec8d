// Touch your own tooth: a mesh file in, contacts out. At 21 places along x a bur moves down until it touches. The
// program prints one line with the contact for each place.
//
//   own_tooth molar.ply [mm per unit of the file]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <enamel/collision/contacts.hpp>
#include <enamel/collision/mesh_file.hpp>
#include <enamel/core/error.hpp>

using namespace enamel;

int main(int argc, char** argv) {
  if (argc < 2) return std::fprintf(stderr, "usage: own_tooth MESH.ply|obj|stl|off [mm per unit of the file]\n"), 2;
  try {
    const auto tooth =
        std::make_shared<const MeshModel>(loadMesh(argv[1], 1e-3 * (argc > 2 ? std::atof(argv[2]) : 1.0)));
    std::printf("%s\n", describe(*tooth).c_str());  // whether the mesh has an inside, or why not
    Vec3 low = tooth->mesh().vertices[0], high = low;
    for (const Vec3& v : tooth->mesh().vertices) low = low.cwiseMin(v), high = high.cwiseMax(v);
    std::printf("%.2f x %.2f x %.2f mm\n", 1e3 * (high - low).x(), 1e3 * (high - low).y(), 1e3 * (high - low).z());

    Scene scene;
    Obstacle obstacle{"tooth", tooth, Pose{}, Vec6::Zero(), Material{}, 0.0};
    obstacle.pose.position = -0.5 * (low + high);  // its middle comes to the origin
    obstacle.material.friction = obstacle.material.slidingFriction = 0.2;
    scene.add(obstacle);

    Tool bur;  // a ball of 1.2 mm on a shaft of 0.8 mm; the lowest point is the TCP
    bur.count = 2;
    bur.parts[0] = {{0.0, 0.0, 0.6e-3}, {0.0, 0.0, 0.6e-3}, 0.6e-3};
    bur.parts[1] = {{0.0, 0.0, 1.2e-3}, {0.0, 0.0, 20e-3}, 0.4e-3};

    // These are separate places. A moving tool uses followContacts(), as HapticTick does: it cannot tunnel through thin
    // walls. Both functions are fast because they keep a cache or a track from the last tick.
    ToolCache cache = makeToolCache(scene, bur);
    ContactSnapshot contacts;
    const double half = 0.5 * (high - low).x();
    int touching = 0;
    std::printf("  x [mm]    z [mm]  contacts  gap [mm]  normal              triangle, part of the tool\n");
    for (int i = 0; i <= 20; ++i) {
      Pose pose;
      pose.position = {half * (0.1 * i - 1.0), 0.0, 0.5 * (high - low).z() + 1e-3};
      for (int k = 0; k < 100; ++k)  // steps that are certainly free, until 10 um inside
        pose.position.z() -= std::min(1e-3, nearestContact(scene, bur, pose, &cache).gap + 10e-6);
      if (findContacts(scene, bur, pose, 50e-6, &cache, contacts) != Status::ok) return 1;  // gaps of 50 um at most
      const Contact& deepest = contacts.contacts[0];                                        // sorted by gap
      if (contacts.count == 0 || deepest.gap >= 0.0) continue;
      ++touching;
      std::printf("%8.2f  %8.3f  %8d  %8.4f  %5.2f %5.2f %5.2f  %8d, %d  %*c\n", 1e3 * pose.position.x(),
                  1e3 * pose.position.z(), contacts.count, 1e3 * deepest.gap, deepest.normal.x(), deepest.normal.y(),
                  deepest.normal.z(), deepest.triangle, deepest.part,
                  static_cast<int>(1.0 + 40.0 * std::max(0.0, 0.5 + pose.position.z() / (high - low).z())), 'o');
    }
    return touching > 0 ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "own_tooth: %s\n", error.what());
    return 1;
  }
}
