// A study of your renderer: many noisy pushes against a wall, compared with known renderers on the same random numbers.
// The renderer is a spring with a damper: replace it by yours.
//
//   study tau-nominal.toml
#include <algorithm>
#include <cstdio>
#include <enamel/core/error.hpp>
#include <enamel/device/device_file.hpp>
#include <enamel/render/position_control.hpp>
#include <enamel/study/monte_carlo.hpp>
#include <enamel/study/parallel.hpp>
#include <memory>
#include <vector>

using namespace enamel;

namespace {

// A renderer without state. 07_plugin shows one with state.
class MyWall final : public Renderer {
  void prepare(double) override {}
  void resetState() noexcept override {}
  StateBlock stateBlock() noexcept override { return {nullptr, 0}; }
  Status render(const TickFrame& in, TickOutput& out) noexcept override {
    Vec6 wrench = Vec6::Zero();
    if (in.contacts.count > 0 && in.contacts.contacts[0].gap < 0.0) {
      const Contact& contact = in.contacts.contacts[0];
      const double speed = contact.normal.dot(contactVelocity(in.kinematics, contact));
      out.normalForce = std::max(0.0, -6000.0 * contact.gap - 20.0 * speed);  // N/m, N s/m
      const Vec3 force = out.normalForce * contact.normal;
      wrench << force, crossMatrix(contact.point - in.kinematics.pose.position) * force;
      out.mode = RenderMode::contact;
    } else {
      out.mode = RenderMode::free;
      out.normalForce = 0.0;
    }
    out.torque = staticTorque(in.kinematics, wrench);
    return Status::ok;
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: study DEVICE.toml\n"), 2;
  try {
    const auto device = makeMechanism(idealOf(loadDevice(argv[1])));
    const PositionControlOptions options = positionControlFor(*device, 1e-3, 0, 0);
    StudyPlan plan;
    plan.scenarios = {1};  // a step of 8 to 15 N
    plan.columns = {
        {"mine", device, [](std::size_t) { return std::make_unique<MyWall>(); }},
        {"position control", device, [&](std::size_t) { return std::make_unique<PositionControlRenderer>(options); }}};
    plan.grid = 3;  // query points along x, and along y
    plan.runs = 4;  // runs at each query point
    plan.insideTick = true;
    plan.setup.encoders = {true, RateSource::difference};
    plan.setup.hand.preload = 1.0;  // N
    checkStudy(plan);

    std::vector<StudyResult> results(plan.size());  // the results do not depend on the number of threads
    parallelFor(plan.size(), availableThreads(), [&](std::size_t i) { results[i] = performRun(plan, runAt(plan, i)); });

    std::printf("%zu runs on %s      K_z1 [kN/m]   deepest [mm]   chatter [N m]   lost or unstable\n", plan.size(),
                device->name().c_str());
    double lowest[2] = {};
    for (const WallSummary& wall : summarise(plan, pointStatistics(plan, results))) {
      lowest[wall.column] = wall.lowestFirst ? wall.lowestFirst->value : 0.0;
      std::printf("%-27s  %13.2f  %13.3f  %14.3f   %s\n", plan.columns[wall.column].name.c_str(),
                  1e-3 * lowest[wall.column], 1e3 * wall.largestDepth, wall.chatter, wall.stable() ? "none" : "yes");
    }
    return lowest[0] > 0.0 && lowest[1] > lowest[0] ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "study: %s\n", error.what());
    return 1;
  }
}
