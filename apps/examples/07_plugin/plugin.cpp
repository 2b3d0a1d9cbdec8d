// A renderer plugin: a spring whose force is smoothed over 0.5 ms. The lag generates energy, like a negative damping of
// stiffness times (smoothing + half a period). With a smoothing of 2 ms the guard stops it.
//
//   enamel check-plugin ./smooth_wall.so
//   enamel push --device tau-nominal.toml --device-damping 4 --renderer ./smooth_wall.so --set stiffness=5000
#include <algorithm>
#include <cmath>
#include <enamel/plugin/author.hpp>

class SmoothWall final : public enamel::Renderer {
 public:
  SmoothWall(double stiffness, double smoothing) : stiffness_(stiffness), smoothing_(smoothing) {}

 private:
  void prepare(double period) override {  // not in the tick: may allocate and throw enamel::Error
    share_ = -std::expm1(-period / smoothing_);
  }

  enamel::Status render(const enamel::TickFrame& in, enamel::TickOutput& out) noexcept override {
    const bool inside = in.contacts.count > 0 && in.contacts.contacts[0].gap < 0.0;  // contacts are sorted by gap
    const enamel::Contact& contact = in.contacts.contacts[0];
    const double spring = inside ? -stiffness_ * contact.gap : 0.0;
    force_ = inside ? force_ + share_ * (spring - force_) : 0.0;
    enamel::Vec6 wrench = enamel::Vec6::Zero();  // at the TCP, in W
    if (inside) {
      const enamel::Vec3 push = force_ * contact.normal;
      wrench << push, enamel::crossMatrix(contact.point - in.kinematics.pose.position) * push;
    }
    out.mode = inside ? enamel::RenderMode::contact : enamel::RenderMode::free;
    out.normalForce = force_;
    out.torque = enamel::staticTorque(in.kinematics, wrench);  // gravity + J^T wrench
    return enamel::Status::ok;
  }

  void resetState() noexcept override { force_ = 0.0; }
  StateBlock stateBlock() noexcept override { return {&force_, sizeof force_}; }  // all state between ticks

  double stiffness_, smoothing_, share_ = 0.0;
  double force_ = 0.0;
};

class SmoothWallPlugin {
 public:
  static const EnamelDescription& describe() noexcept {
    static const EnamelParameter parameters[] = {{"stiffness", "3000", "of the wall, N/m"},
                                                 {"smoothing", "0.0005", "time constant of the force, s"}};
    static const EnamelDescription description = {"smooth-wall", "1.0.0", "A spring with a smoothed force", parameters,
                                                  2};
    return description;
  }
  explicit SmoothWallPlugin(const enamel::PluginConfiguration& given)  // throws enamel::Error for invalid parameters
      : stiffness_(given.number("stiffness", 0.0, 1e5, "N/m")), smoothing_(given.number("smoothing", 1e-4, 0.1, "s")) {}
  std::unique_ptr<enamel::Renderer> activate(double) const {
    return std::make_unique<SmoothWall>(stiffness_, smoothing_);
  }

 private:
  double stiffness_, smoothing_;
};
ENAMEL_PLUGIN(SmoothWallPlugin)
