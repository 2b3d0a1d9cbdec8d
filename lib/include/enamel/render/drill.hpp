// A bur that removes a little of the material that it is pressed against at every tick.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "enamel/collision/contacts.hpp"

namespace enamel {

/// A call of Solid::cut().
struct SolidCut {
  int obstacle = -1;    ///< number in the scene; -1: nothing was cut
  Segment from, to;     ///< axis of the bur in the frame of the solid, m
  double radius = 0.0;  ///< m
};

/// A spinning bur that cuts solids. Pressed with force F against material of hardness H, it removes the volume
///
///   V' = K F v / H,   v = 2 pi r n: speed of its surface
///
/// Source: Archard, "Contact and rubbing of flat surfaces", 1953. Per area this is Preston's law ("The theory and
/// design of plate glass polishing machines", 1927) with K / H as his coefficient.
///
/// The motor slows down under the torque of the cut, T = drag F r. Its own torque falls linearly from that at rest,
/// T_s, to zero at its free speed (Dyson and Darvell, "Torque, power and efficiency characterization of dental air
/// turbine handpieces", 1999). Above T = T_s it stalls, and cuts nothing:
///
///   2 pi J n' = T_s (1 - n / n_free) - T
///
/// The surface recedes against the force. Per tick it recedes by the volume over the area of the whole bur. If the bur
/// touches with less than its whole area, it cuts less, and the rest follows at the next tick. If the tool penetrates
/// the surface, the model puts the bur back on the surface. The drill therefore removes only material swept by a bur
/// that rests on the surface. A bur that starts within a layer that it compresses stays there, until the surface has
/// receded to it (Contact::sunk).
///
/// The shaft of the bur is a spring of stiffness k with the natural frequency f and the damping ratio z. A blade cuts a
/// chip of the feed per blade, h, and the wave that the last blade left. The cut thereby resists with F / h. It excites
/// itself (regenerative chatter) at the frequency f sqrt(1 + 2 z) above the limit of Tlusty,
///
///   F / h > 2 k z (1 + z)
///
/// until the blades leave the surface, at the amplitude h / sqrt(2). Source: lib/docs/bur.md.
///
/// The bur is the head of the tool (Tool::head). Its parts move, cut and vibrate together, and the contacts of each
/// part count.
class Drill {
 public:
  /// `solids` has one entry per obstacle of the scene, null for an obstacle that cannot be cut. Throws Error if the
  /// tool does not have the parts, if a part's radius is outside 0 to Solid::kLargestBur, or for a number of the bur
  /// outside its limits (lib/docs/files.md). Realtime: no.
  Drill(const Tool& tool, std::vector<std::shared_ptr<Solid>> solids, const Bur& bur = {});

  /// Switch the motor of the bur on or off. It is off at first. Realtime: yes.
  void spin(bool on) noexcept;
  bool spins() const noexcept { return isOn_; }

  /// Return the present speed, turns per second, and the torque of the last cut on the motor, N m. Realtime: yes.
  double turns() const noexcept { return speed_ * bur_.turns; }
  double load() const noexcept { return load_; }
  /// Return amplitude, m, and frequency, Hz, of the chatter. Realtime: yes.
  double chatter() const noexcept { return chatter_; }
  double chatterFrequency() const noexcept { return chatterFrequency_; }
  /// Return the obstacle that the last tick cut; -1: none. hold() returns the stiffness, N/m, with which its pit holds
  /// the bur across the force F. The pit has the shape of the bur to within the height u of a cut surface over its
  /// samples. So its radius exceeds that of the bur by 2 u, and the normal turns by a sideways way over 2 u: F / (2 u).
  /// Realtime: yes.
  int obstacle() const noexcept { return obstacle_; }
  double hold() const noexcept { return obstacle_ < 0 ? 0.0 : 0.5 * force_.norm() / rough_; }
  /// Return the parts that cut. Realtime: yes.
  const PartRange& parts() const noexcept { return parts_; }

  /// Correct the contacts before the renderer reads them, to account for the cut under way. Change gaps and the
  /// velocity at which the surface recedes. Limit the stiffness of contacts more than 26 deg off the force to 20 N/mm.
  /// Realtime: yes.
  void correct(ContactSnapshot& contacts) noexcept;

  /// Move the contacts as the head of the bur vibrates; cut() then cuts with the moved head. Its run-out turns with the
  /// bur. The feed of a blade has the frequency of the blades, against the force, and so acts the chatter. A vibration
  /// with fewer than 8 ticks of `period` s a wave is reduced, with 4 it is left out. Call it before correct().
  /// Realtime: yes.
  void vibrate(const Pose& pose, double period, ContactSnapshot& contacts) noexcept;

  /// Cut material; the last stage of a tick. `force` is the force of the wall on the tool, W, N; a mean over about 20
  /// ticks counts. `contacts` are those passed to correct(). `elapsed` is the time since the last cut, s. Realtime:
  /// yes.
  void cut(const Scene& scene, const Pose& pose, const Vec3& force, double elapsed,
           const ContactSnapshot& contacts) noexcept;

  /// Instead of cut(): the bur touches nothing in this tick. Realtime: yes.
  void lift() noexcept;

  /// Exchange the solids, after the scene was exchanged. The work of the bur continues. Realtime: yes.
  void exchangeSolids(std::vector<std::shared_ptr<Solid>>& solids) noexcept { solids_.swap(solids); }

  /// Return what each part of the head cut at the last tick, so that a copy of the solid can be cut in the same way.
  /// Realtime: yes.
  const std::array<SolidCut, kMaxToolParts>& lastCuts() const noexcept { return lastCuts_; }

  /// Return the volume that the last tick removed, per layer, m^3. feed() returns the speed at which the surface
  /// receded, m/s, and recession() that by Archard's law for a bur that cuts with its whole area. Realtime: yes.
  const RemovedVolume& removed() const noexcept { return removed_; }
  double feed() const noexcept { return feed_; }
  double recession() const noexcept { return recession_; }

 private:
  void turn(double elapsed) noexcept;
  void swing(double pressed, double elapsed) noexcept;
  RemovedVolume cutTo(Solid& solid, int number, const std::array<Segment, kMaxToolParts>& axes) noexcept;
  void follow(const Vec3& moved, double back, double elapsed) noexcept;

  Bur bur_;
  PartRange parts_;
  std::array<ToolPart, kMaxToolParts> head_{};  // the parts
  double radius_, thinnest_;                    // largest and smallest of the parts, m
  Mat3 axes_;                                   // of the bur, in P; z is its axis
  double chatterFrequency_;                     // Hz
  double removal_;                              // K v at the free speed, m^3 s^-1 Pa / N
  double area_;                                 // of the bur, m^2: of a cylinder with round ends around it
  double follow_;  // rate at which the motor approaches its speed, 1/s; 0: the speed is constant
  bool isOn_ = false;
  double speed_ = 0.0;         // over the free one
  double phase_ = 0.0;         // of the rotation, turns
  double load_ = 0.0;          // N m
  double chatter_ = 0.0;       // amplitude, m
  double wave_ = 0.0;          // phase of the chatter, in waves
  Vec3 shake_ = Vec3::Zero();  // displacement of the head by its vibration, W, m
  std::vector<std::shared_ptr<Solid>> solids_;
  int obstacle_ = -1;                        // cut at the last tick
  Vec3 way_ = Vec3::Zero();                  // direction against which the surface recedes, W
  double rough_ = 0.0;                       // height of a cut surface above its samples, at most, m
  std::array<double, kMaxContacts> gaps_{};  // of this tick's contacts, before the correction, m
  double advance_ = 0.0;                     // of the surface per tick, by Archard's law, m
  std::array<Segment, kMaxToolParts> last_;  // the parts at the last tick, in the obstacle's frame
  bool rests_ = false;                       // on the surface, at the last tick
  Vec3 force_ = Vec3::Zero();                // W
  double owed_ = 0.0;                        // volume not yet cut, m^3
  double hardness_ = 0.0;
  RemovedVolume removed_{};
  std::array<SolidCut, kMaxToolParts> lastCuts_;
  double feed_ = 0.0, recession_ = 0.0;
};

}  // namespace enamel
