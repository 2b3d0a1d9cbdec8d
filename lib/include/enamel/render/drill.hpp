// A bur that takes away what it is pressed against, a little every tick.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "enamel/collision/contacts.hpp"

namespace enamel {

/// Cuts solids. While the bur spins and is pressed with F against material of hardness H, it removes the volume
///   V' = K F v / H,   v = 2 pi r n: speed of its surface
/// (Archard, "Contact and rubbing of flat surfaces", 1953; per area it is Preston's law, "The theory and design of
/// plate glass polishing machines", 1927, with K / H for his coefficient). The surface recedes against the force, every
/// tick by the volume over the area of the whole bur: where less of it touches, less is cut, and the rest is cut at the
/// next tick. Where the renderer lets the device go in, the bur is taken to be at the surface; so only what a bur has
/// swept that rests on the surface is ever removed.
class Drill {
 public:
  /// `solids` by obstacle of the scene, null where it cannot be cut. Throws Error: a part that the tool does not have
  /// or whose radius is not in 0 to Solid::kLargestBur; a wear that is not positive and finite; turns outside 0 to
  /// 10 000 a second. Realtime: no.
  Drill(const Tool& tool, std::vector<std::shared_ptr<Solid>> solids, const Bur& bur = {});

  /// Whether the bur spins; at first it does not. Realtime: yes.
  void spin(bool on) noexcept { isOn_ = on; }
  bool spins() const noexcept { return isOn_; }

  /// Before the renderer: corrects the contacts for the cut that goes on: gaps, the velocity at which the surface
  /// recedes, and a stiffness of at most 20 N/mm more than 26 deg beside the force. Realtime: yes.
  void correct(ContactSnapshot& contacts) noexcept;

  /// The last stage of a tick: cuts with the force of the wall on the tool, W, N; its mean over some 20 ticks counts.
  /// `contacts` are those that correct() was given; `elapsed` since the last cut, s. Realtime: yes.
  void cut(const Scene& scene, const Pose& pose, const Vec3& force, double elapsed,
           const ContactSnapshot& contacts) noexcept;

  /// What the last tick took away, m^3, by layer; how fast it let the surface recede, m/s. Realtime: yes.
  const RemovedVolume& removed() const noexcept { return removed_; }
  double feed() const noexcept { return feed_; }

 private:
  ToolPart part_;
  int number_;
  double removal_;  // K v, m^3 s^-1 Pa / N
  double area_;     // of the bur, m^2
  bool isOn_ = false;
  std::vector<std::shared_ptr<Solid>> solids_;
  int obstacle_ = -1;                        // that was cut at the last tick
  Vec3 way_ = Vec3::Zero();                  // against which the surface recedes, W
  double rough_ = 0.0;                       // so far a surface that was cut may be above its samples, m
  std::array<double, kMaxContacts> gaps_{};  // of this tick's contacts, before they were corrected, m
  double advance_ = 0.0;                     // of the surface in a tick, by Archard's law, m
  Segment last_;                             // the bur then, in the obstacle's frame
  Vec3 force_ = Vec3::Zero();                // W
  double owed_ = 0.0;                        // that could not be cut, m^3
  double hardness_ = 0.0;
  RemovedVolume removed_{};
  double feed_ = 0.0;
};

}  // namespace enamel
