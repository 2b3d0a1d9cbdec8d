// Slide over a tooth, then drill it. A hand presses a bur of 1 mm against a molar and moves to and fro; after 1 s the
// bur spins. Another thread makes triangles of the changed bricks.
//
//   slide_and_drill molar.ply cartesian-3.toml
#include <atomic>
#include <cmath>
#include <cstdio>
#include <enamel/collision/mesh_file.hpp>
#include <enamel/collision/solid_changes.hpp>
#include <enamel/collision/solid_surface.hpp>
#include <enamel/core/error.hpp>
#include <enamel/device/device_file.hpp>
#include <enamel/render/drill.hpp>
#include <enamel/render/position_control.hpp>
#include <enamel/sim/hand.hpp>
#include <enamel/sim/virtual_loop.hpp>
#include <thread>

using namespace enamel;

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: slide_and_drill MESH (closed, in mm) DEVICE\n"), 2;
  try {
    const Material slippery{kUnlimited, 0.1, 0.1, 0.0};  // rigid; static and sliding friction
    const auto tooth = std::make_shared<Solid>(          // layers: hardness (Pa), depth where they begin (m)
        MeshModel(loadMesh(argv[1], 1e-3)), std::vector<SolidLayer>{{"enamel", slippery, 3.4e9, 0.0, nullptr},
                                                                    {"dentine", slippery, 0.6e9, 0.4e-3, nullptr}});
    LoopSetup setup;
    setup.scene = Scene();
    setup.scene.add({"tooth", std::shared_ptr<const Solid>(tooth), Pose(), Vec6::Zero(), {}, 0.0});
    setup.tool.parts[0].radius = 0.5e-3;
    setup.start.position = {2.6e-3, 1.0e-3, 0.01};  // over a cusp
    for (int i = 0; i < 20; ++i)                    // down, to just above the tooth
      setup.start.position.z() -= signedDistance(*tooth, setup.start.position).distance - 0.6e-3;
    const auto device = makeMechanism(idealOf(loadDevice(argv[2])));
    PositionControlRenderer servo(positionControlFor(*device, setup.period, 0, 0));
    VirtualLoop loop(*device, servo, setup);
    Drill drill(setup.tool, {tooth}, {0, 0.1, 2000.0});  // part of the tool, wear, revolutions per second
    loop.attach(&drill);

    // The graphics thread: receives copies of changed bricks and triangulates them.
    SolidChanges changes;
    std::atomic<bool> isOver{false};
    int redrawn = 0;
    std::thread graphics([&, surface = SolidSurface()]() mutable {
      BrickChange change;
      for (bool isLast = false; !isLast; std::this_thread::yield())
        for (isLast = isOver; changes.take(change); ++redrawn)
          surface.clear(), appendSurface(*tooth, change.brick, change.samples, surface);
    });

    RemovedVolume removed{};
    TickRecord tick;
    for (int i = 0; i < 3000; ++i) {  // 3000 ticks, as fast as possible
      drill.spin(i >= 1000);          // the pedal
      Pose guide = setup.start;
      guide.position.x() += 1e-3 * std::sin(0.006 * i);
      const auto hand = [&](double, const Pose& pose, const Vec6& twist) {
        Vec6 wrench = guidingWrench(pose, twist, guide, Vec3::UnitZ());
        wrench.head<2>() *= 10.0;             // a firm hand: 1 kN/m
        wrench.z() -= 1.0 + 3.0 * twist.z();  // N
        return wrench;
      };
      if (loop.tick(hand, tick) != Status::ok) break;
      changes.publish(*tooth);
      for (std::size_t k = 0; k < tooth->layers().size(); ++k) removed[k] += drill.removed()[k];
      if (i % 200 == 199)
        std::printf("%.1f s  %-5s x %6.3f  z %7.3f mm  wall %5.2f N, across %5.2f N  removed %.4f + %.4f mm^3\n",
                    tick.time, drill.spins() ? "spins" : "", 1e3 * tick.pose.position.x(), 1e3 * tick.pose.position.z(),
                    tick.normalForce, tick.rendered.head<2>().norm(), 1e9 * removed[0], 1e9 * removed[1]);
    }
    isOver = true;
    graphics.join();
    std::printf("%d bricks were redrawn\n", redrawn);
    return tick.tick == 2999 && removed[0] > 0.0 && redrawn > 0 ? 0 : 1;
  } catch (const Error& error) {
    return std::fprintf(stderr, "slide_and_drill: %s\n", error.what()), 1;
  }
}
