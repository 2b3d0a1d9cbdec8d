// Compliant materials: the force over the compression, and what lasts from tick to tick. Equations and sources:
// lib/docs/compliant.md.
//
// A compliant material is in series with the wall of a renderer. Both carry the same force, and their ways add up. The
// force never falls if the compression grows. So the series is never stiffer than the renderer's rigid wall, however
// stiff the material is.
//
// Contacts within the radii of their parts share one layer, by their depths and by the cosine between their normals.
// Others have a layer each.
#pragma once

#include <array>
#include <cstddef>

#include "enamel/render/frame.hpp"

namespace enamel {

class Scene;
class ToolTrack;
struct Tool;
struct PartRange;

/// Largest compliance of a material, instead of infinity, m/N.
inline constexpr double kSoftest = 1e12;

/// Compression before a contact was known, m. The speed of the compression then counts as zero.
inline constexpr double kNotCompressed = 1e9;

/// Force of a material, N, and its derivative by the compression, N/m.
struct MaterialForce {
  double force, slope;
};

/// Return the force at a compression of x m below the thickness, `period` s after a compression of `before` m. The
/// speed in it is (x - before) / period, so a cycle of compressions never gives energy. Realtime: yes.
MaterialForce forceOf(const Material& material, double x, double before, double period) noexcept;

/// Return the compression x of a material in series with a spring of compliance `soft`, m/N, which both give way by
/// `depth` m: x + soft F(x) = depth. `before` and `period` as above. Realtime: yes.
double compressionInSeries(const Material& material, double depth, double soft, double before, double period) noexcept;

/// Return the compliance of the contact's material, m/N, at the compression in series with a spring: 0 if rigid.
/// Realtime: yes.
double softness(const Contact& contact, double depth, double soft, double period) noexcept;

/// Return the compression, m, at which a material has a force, N. Realtime: yes.
double compressionUnder(const Material& material, double force, double before, double period) noexcept;

/// Compressions of the last tick, and layers that the tool has pierced. A layer breaks where the sum of the forces of
/// the tool on the layers of an obstacle exceeds Material::puncture. The tool then meets only the ground below it, one
/// thickness deeper and rigid, until it has left the obstacle.
class ComplianceMemory {
 public:
  /// Realtime: no.
  explicit ComplianceMemory(const Scene& scene);

  /// Let a tool that has pierced a layer go on inside the obstacle. Call it before followContacts(). Realtime: yes.
  void letIn(const Tool& tool, ToolTrack& track) const noexcept;

  /// Enter compressions and punctures into the contacts of a new sample. A layer of a solid is at most as thick as its
  /// material is now below the contact, in whole cells. `bur`: the parts that spin. A solid is rigid for them: they cut
  /// what they would compress. They stay in a layer that they had compressed before, and cut it in place: `cut` m in
  /// this tick (Contact::sunk). Realtime: yes.
  void enter(const Scene& scene, const Tool& tool, const PartRange& bur, double cut,
             ContactSnapshot& contacts) noexcept;

  /// Store how the renderer's forces compress the materials, and pierce the layers that break. Realtime: yes.
  void press(const TickOutput& output, double period, ContactSnapshot& contacts) noexcept;

  /// Forget everything. Realtime: yes.
  void reset() noexcept { last_ = {}; }

  /// Save and load the state as stateSize() numbers; 0 for a scene without compliant layers. Realtime: yes.
  std::size_t stateSize() const noexcept { return isAny_ ? 5 * last_.size() : 0; }
  void saveState(double* state) const noexcept;
  void loadState(const double* state) noexcept;

  /// Continue from `old` at the obstacles that both scenes have (isSameObstacle()). Realtime: yes.
  void takeOver(const ComplianceMemory& old, const Scene& before, const Scene& now) noexcept;

 private:
  struct Pressed {  // a contact of the last tick, in its order
    double obstacle = -1.0, part = -1.0, key = 0.0;
    double compression = 0.0;  // m
    double isPunctured = 0.0;
  };
  bool isAny_ = false;
  std::array<Pressed, kMaxContacts> last_{};
};

}  // namespace enamel
