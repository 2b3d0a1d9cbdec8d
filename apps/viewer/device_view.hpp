// Draws a device from its bars, and the tool on its platform, with VTK.
#pragma once

#include <vtkRenderer.h>

#include <optional>
#include <vector>

#include "bur_shapes.hpp"
#include "enamel/collision/contacts.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/device/mechanism.hpp"
#include "shapes.hpp"

namespace enamel::viewer {

inline constexpr double kHandleEnd = 0.082;  ///< position of the hand along the tool, m

/// Colours of a tool's parts, and a factor for their size.
struct ToolLook {
  unsigned body, grip, tip;
  double opacity = 1.0, growth = 1.0;
};

class ToolView {
 public:
  /// `cutting`: the part of the tool that is a bur, or nullptr.
  ToolView(vtkRenderer* renderer, const Tool& tool, const Bur* cutting, const ToolLook& look);
  void place(const Pose& pose, double burAngle);
  void show(bool visible);
  void showGrip(bool handle, bool hub) { handle_.show(handle), hub_.show(hub); }
  /// As Rod::fadeBefore(), for handle and hub.
  bool fadeBefore(const Vec3& eye, const Vec3& point);
  std::vector<vtkActor*> actors() const;

 private:
  std::vector<ToolPart> parts_;
  std::vector<CapsuleSolid> solids_;  // the parts; a point is drawn as the tip of a needle
  std::vector<Rod> needle_;
  double beyond_;  // extra length at each end of a larger tool, m; it avoids coincident surfaces
  Rod handle_, hub_;
  std::optional<FlutedBur> bur_;
  ToolPart burPart_;
};

class DeviceView {
 public:
  /// `bars`: of the mechanism at any pose. `scale`: pixels per unit of layout, for the lines of the workspace.
  DeviceView(vtkRenderer* renderer, const std::vector<Bar>& bars, float scale);
  /// Place the same bars at new positions, with the platform's pose.
  void place(const std::vector<Bar>& bars, const Pose& pose);
  void show(bool visible);
  bool fadeBefore(const Vec3& eye, const Vec3& point);  ///< as Rod::fadeBefore()
  /// Return the actors of all parts that fade.
  std::vector<vtkActor*> actors() const;

 private:
  struct Link {
    Rod rod;
    Ball joint;  // at its far end
  };
  struct Arm {  // of a platform on chains, from its hub to a corner
    Rod arm, post;
  };

  std::vector<vtkActor*> all_;  // also those that never move; the renderer owns them
  std::vector<Link> links_;     // one for each bar
  std::vector<Arm> arms_;
  std::vector<Rod> axes_;  // of a platform without chains
};

}  // namespace enamel::viewer
