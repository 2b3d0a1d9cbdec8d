// A tooth is drilled: a hand presses a bur of 1 mm against a molar and goes to and fro, the servo holds it on what is
// left of the surface, and another thread has the triangles of what changed.
//
//   drill molar.ply cartesian-3.toml
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <thread>

#include "enamel/collision/mesh_file.hpp"
#include "enamel/collision/solid_changes.hpp"
#include "enamel/collision/solid_surface.hpp"
#include "enamel/core/error.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/render/drill.hpp"
#include "enamel/render/surface_servo.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/virtual_loop.hpp"

using namespace enamel;

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: drill MESH (in mm) DEVICE\n"), 1;
  try {
    const auto tooth =
        std::make_shared<Solid>(MeshModel(loadMesh(argv[1], 1e-3)),
                                std::vector<SolidLayer>{{"enamel", {}, 3.4e9, 0.0, nullptr},  // hardness, begins at
                                                        {"dentine", {}, 0.6e9, 0.4e-3, nullptr}});
    LoopSetup setup;
    setup.scene = Scene();
    setup.scene.add({"tooth", std::shared_ptr<const Solid>(tooth), Pose(), Vec6::Zero(), {}});
    setup.tool.parts[0].radius = 0.5e-3;
    setup.start.position.z() = 0.01;
    for (int i = 0; i < 20; ++i)  // down, to just above the tooth
      setup.start.position.z() -= signedDistance(*tooth, setup.start.position).distance - 0.6e-3;

    const auto device = makeMechanism(loadDevice(argv[2]));
    SurfaceServoRenderer servo(surfaceServoFor(device->limits().count, setup.period, 0, 0));
    VirtualLoop loop(*device, servo, setup);
    Drill drill(setup.tool, {tooth}, {0, 0.1, 2000.0});  // wear, turns a second
    drill.spin(true);
    loop.attach(&drill);

    // The graphics: triangles of every brick, at first of the whole tooth.
    std::vector<SolidSurface> bricks(static_cast<std::size_t>(tooth->bricks()));
    for (int i = 0; i < tooth->bricks(); ++i) appendSurface(*tooth, i, tooth->samples(i), bricks[i]);
    SolidChanges changes;
    std::atomic<bool> isOver{false};
    std::size_t extracted = 0;
    const auto draw = [&] {
      for (BrickChange change; changes.take(change); ++extracted) {
        SolidSurface& surface = bricks[static_cast<std::size_t>(change.brick)];
        surface.clear();
        appendSurface(*tooth, change.brick, change.samples, surface);
      }
    };
    std::thread graphics([&] {
      for (; !isOver.load(); std::this_thread::yield()) draw();
    });

    // Two seconds of ticks, as fast as they go.
    constexpr int kTicks = 2000;
    RemovedVolume removed{};
    TickRecord record;
    double force = 0.0, longest = 0.0;
    for (int tick = 0; tick < kTicks; ++tick) {
      Pose guide = setup.start;
      guide.position.x() += 1e-3 * std::sin(0.006 * tick);
      const auto hand = [&](double, const Pose& pose, const Vec6& twist) {
        Vec6 wrench = guidingWrench(pose, twist, guide, Vec3::UnitZ());
        wrench.z() -= 2.0 + 3.0 * twist.z();
        return wrench;
      };
      const auto start = std::chrono::steady_clock::now();
      if (loop.tick(hand, record) != Status::ok) throw Error("the device cannot go on");
      changes.publish(*tooth);
      longest = std::max(longest, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
      force += record.normalForce / kTicks;
      for (std::size_t k = 0; k < tooth->layers().size(); ++k) removed[k] += drill.removed()[k];
    }
    isOver = true;
    graphics.join();

    for (std::size_t k = 0; k < tooth->layers().size(); ++k)
      std::printf("%-8s %.4f mm^3 removed\n", tooth->layers()[k].name.c_str(), 1e9 * removed[k]);
    std::printf("force    %.2f N on average; longest tick %.0f us, with the device's simulation\n", force,
                1e6 * longest);
    for (int i = 0; i < tooth->bricks(); ++i) changes.publish(*tooth), draw();  // what waited for the graphics
    const std::size_t drawn =
        std::accumulate(bricks.begin(), bricks.end(), std::size_t{0},
                        [](std::size_t sum, const SolidSurface& s) { return sum + s.mesh.triangles.size(); });
    std::printf("graphics %zu triangles after %zu extractions of a brick\n", drawn, extracted);
    return drawn == surfaceOf(*tooth).triangles.size() && removed[0] > 0.0 ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "drill: %s\n", error.what());
    return 1;
  }
}
