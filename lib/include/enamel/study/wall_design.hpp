// Design of controllers by simulation of the loop that they will run in: the same search under the same limits for all.
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

/// What a renderer is designed for: pushes against the wall z = 0 at five points, encoders rounded, rates differenced.
struct WallDesignSetup {
  std::shared_ptr<const Mechanism> plant;
  /// Makes the plant of a run where it is not the closed form of `plant`; may be called from several threads at once.
  std::function<std::unique_ptr<Plant>(std::uint32_t stream)> makePlant = {};
  double jitter = 0.0, lostSamples = 0.0;         ///< as in VirtualDeviceSetup
  double period = 1e-3;                           ///< s
  Delay delay;                                    ///< ticks; random where low < high
  double inertiaError = 0.0;                      ///< the model's inertia is exact, or wrong by this share either way
  double halfWidth = 0.025;                       ///< the points are the centre and the corners of a square, m
  double preload = 1.0;                           ///< before a push, N
  double lowestForce = 8.0, highestForce = 15.0;  ///< of a push, uniform between, N
  double noise = 0.5;                             ///< of the person, standard deviation, N
  double ramp = 10.0;                             ///< N in 50 ms
  std::optional<SceneFile> scene = {};  ///< where it is pushed too, and must not slide off, as setScene() says
  double chatter = 0.05;                ///< allowed, N m or N
  double bounce = 1e-4;                 ///< allowed, m; twice as much after an impact
  double drift = 3e-4;                  ///< allowed in the scene across the push, m
  int runs = 24;  ///< steps of force a point and in the scene, inside ticks; a third as many ramps, impacts a speed
  std::uint64_t seed = 1;
};

/// A device as a model has it whose mass matrix is `factor` of the truth; its gravity torques are right. For a
/// renderer's view of a plant. Throws Error: no mechanism; a factor outside 0.01 to 100. Realtime: no.
std::shared_ptr<const Mechanism> withInertia(std::shared_ptr<const Mechanism> mechanism, double factor);

/// The same with forces that the motors can answer: all are made smaller together until the largest push is 0.3 of what
/// the motors can give at the worst of the points. Throws Error: as evaluateWall(). Realtime: no.
WallDesignSetup withinMotors(WallDesignSetup setup);

/// How a renderer did.
struct WallScore {
  double stiffness = 0.0;    ///< K_z1, lowest of the points' means, N/m
  double share = 0.0;        ///< of the physical limit, lowest of the points' means
  double lowestShare = 0.0;  ///< of all runs
  double chatter = 0.0;      ///< largest standard deviation of a motor's torque at rest on the wall, N m or N
  double bounce = 0.0;       ///< farthest above the rest after a step, m
  double ramp = 0.0;         ///< deepest under a ramp, m
  double impact = 0.0;       ///< farthest out after an impact at 0.05, 0.2 or 0.5 m/s (runWallTrials()), m
  double drift = 0.0;        ///< in the scene across the push, each at most 4 mm, mean, m
  double deepest = 0.0;      ///< of all runs against the wall, m
  int lost = 0;              ///< runs that left the workspace
  int unmeasured = 0;        ///< steps without a first impact stiffness
  double value = 0.0;        ///< what the design maximises
};

/// Makes a renderer; may be called from several threads at once.
using MakeRenderer = std::function<std::unique_ptr<Renderer>()>;

/// Evaluate a renderer. Throws Error: no plant or renderer; the points cannot be reached; runs outside 1 to 10 000.
/// `threads` do not change a bit of it. `trial`: which random numbers. Realtime: no.
WallScore evaluateWall(const WallDesignSetup& setup, const MakeRenderer& make, std::uint32_t trial, int threads);

/// A number that a controller leaves open, and how the search varies it.
struct ControllerParameter {
  std::string name, unit;
  double start, low, high;  ///< where the search begins, and within what it stays
  double step;              ///< of the number, or of its logarithm
  bool logarithmic;
};

/// What a controller is used on.
struct ControllerUse {
  std::shared_ptr<const Mechanism> device;  ///< as the renderer has it
  double period = 1e-3;                     ///< s
  Delay delay;                              ///< ticks
};

/// A controller with its numbers open, and the renderer that runs it.
struct ControllerSpec {
  std::string name, title;  ///< as commands and as tables have it
  std::vector<ControllerParameter> parameters;
  /// A renderer with these values, one a parameter. Throws Error: where there is no such renderer.
  std::function<MakeRenderer(const ControllerUse& use, const std::vector<double>& values)> with;
};

/// Find values by an evolution strategy (one parent, eight children a generation, all evaluated with the same new
/// random numbers), from `start` on, one a parameter. `progress`, if any, sees how the best of every generation did.
/// Throws Error: as evaluateWall(); where `start` has no renderer. Realtime: no.
std::vector<double> designController(const WallDesignSetup& setup, const ControllerSpec& spec,
                                     const std::vector<double>& start, int generations, int threads,
                                     const std::function<void(int, const WallScore&)>& progress);

}  // namespace enamel
