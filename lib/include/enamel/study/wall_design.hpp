// Design of controllers by simulation of their closed loop. All controllers get the same search and the same limits.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enamel/collision/scene_file.hpp"
#include "enamel/render/position_control.hpp"
#include "enamel/sim/virtual_device.hpp"

namespace enamel {

/// Setup of a design: pushes against the wall z = 0 at five points. Encoders are rounded, and rates are their
/// differences.
struct WallDesignSetup {
  std::shared_ptr<const Mechanism> plant;
  /// Make the plant of a run, if it is not the closed form of `plant`. Several threads may call it at the same time.
  std::function<std::unique_ptr<Plant>(std::uint32_t stream)> makePlant = {};
  double jitter = 0.0, lostSamples = 0.0;  ///< as in VirtualDeviceSetup
  double period = 1e-3;                    ///< s
  Delay delay;                             ///< ticks; random if low < high
  double inertiaError = 0.0;               ///< relative error of the model's inertia: tested at 0 and at both signs
  double halfWidth = 0.025;                ///< half side of a square, m; the points are its centre and corners
  double preload = 1.0;                    ///< force before a push, N
  double lowestForce = 8.0, highestForce = 15.0;  ///< of a push, uniform in between, N
  double noise = 0.5;                             ///< standard deviation of the person's force, N
  double ramp = 10.0;                             ///< N in 50 ms
  /// Scene of further pushes, as set by setScene(). There the tool must not slide off.
  std::optional<SceneFile> scene = {};
  double chatter = 0.05;  ///< largest allowed chatter, N m or N
  double bounce = 1e-4;   ///< largest allowed bounce, m; twice as much after an impact
  double drift = 3e-4;    ///< largest allowed drift in the scene across the push, m
  /// Steps of force per point and in the scene, within ticks. A third as many ramps, and impacts per speed.
  int runs = 24;
  std::uint64_t seed = 1;
};

/// Return a device with the mass matrix `factor` times the true one. Its gravity torques are correct. Use it as a
/// renderer's model of a plant. Throws Error if the mechanism is null or the factor is outside 0.01 to 100. Realtime:
/// no.
std::shared_ptr<const Mechanism> withInertia(std::shared_ptr<const Mechanism> mechanism, double factor);

/// Return the setup with forces that the motors can hold. One factor reduces all forces until the largest push is 0.3
/// of the motors' force at the worst point. Throws Error as evaluateWall(). Realtime: no.
WallDesignSetup withinMotors(WallDesignSetup setup);

/// Results of a renderer.
struct WallScore {
  double stiffness = 0.0;    ///< K_z1, lowest of the points' means, N/m
  double share = 0.0;        ///< of the physical limit, lowest of the points' means
  double lowestShare = 0.0;  ///< of all runs
  /// Standard deviation of a motor's torque at rest on the wall, the largest, N m or N.
  double chatter = 0.0;
  double bounce = 0.0;  ///< largest distance above the rest after a step, m
  double ramp = 0.0;    ///< largest depth under a ramp, m
  /// Largest distance outside after an impact at 0.05, 0.2 or 0.5 m/s (runWallTrials()), m.
  double impact = 0.0;
  double drift = 0.0;    ///< mean drift in the scene across the push, each at most 4 mm, m
  double deepest = 0.0;  ///< largest depth of all runs against the wall, m
  int lost = 0;          ///< runs that left the workspace
  int unmeasured = 0;    ///< steps without a first impact stiffness
  double value = 0.0;    ///< objective that the design maximises
};

/// A function that makes a renderer. Several threads may call it at the same time.
using MakeRenderer = std::function<std::unique_ptr<Renderer>()>;

/// Evaluate a renderer. `trial` selects the random numbers. The result does not depend on `threads`, bit for bit.
/// Throws Error if the plant or renderer is null, the points cannot be reached, or runs are outside 1 to 10 000.
/// Realtime: no.
WallScore evaluateWall(const WallDesignSetup& setup, const MakeRenderer& make, std::uint32_t trial, int threads);

/// An open number of a controller, and how the search varies it.
struct ControllerParameter {
  std::string name, unit;
  double start, low, high;  ///< start and limits of the search
  double step;              ///< of the number, or of its logarithm
  bool logarithmic;
};

/// The conditions in which a controller is used.
struct ControllerUse {
  std::shared_ptr<const Mechanism> device;  ///< as the renderer knows it
  double period = 1e-3;                     ///< s
  Delay delay;                              ///< ticks
};

/// A controller with open numbers, and the renderer that runs it.
struct ControllerSpec {
  std::string name, title;  ///< in commands; in tables
  std::vector<ControllerParameter> parameters;
  /// Return a maker of renderers with these values, one per parameter. Throws Error if such a renderer does not exist.
  std::function<MakeRenderer(const ControllerUse& use, const std::vector<double>& values)> with;
};

/// Find values by an evolution strategy, starting from `start`, one value per parameter. Each generation has one parent
/// and eight children, evaluated with the same new random numbers. `progress`, if given, receives the best result of
/// each generation. Throws Error as evaluateWall(), and if `start` does not give a renderer. Realtime: no.
std::vector<double> designController(const WallDesignSetup& setup, const ControllerSpec& spec,
                                     const std::vector<double>& start, int generations, int threads,
                                     const std::function<void(int, const WallScore&)>& progress);

}  // namespace enamel
