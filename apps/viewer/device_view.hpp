// A device as VTK draws it, from its bars, and the tool on its platform.
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

inline constexpr double kHandleEnd = 0.082;  ///< along the tool, m: where the hand is

/// Colours of a tool's parts; times the usual size.
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
  /// Of handle and hub, as a Rod.
  bool fadeBefore(const Vec3& eye, const Vec3& point);
  std::vector<vtkActor*> actors() const;

 private:
  std::vector<ToolPart> parts_;
  std::vector<CapsuleSolid> solids_;  // of the parts; a point is drawn as the tip of a needle
  std::vector<Rod> needle_;
  double beyond_;  // that a larger one is longer at each end, or the ends would be drawn into each other, m
  Rod handle_, hub_;
  std::optional<FlutedBur> bur_;
  ToolPart burPart_;
};

class DeviceView {
 public:
  /// `bars`: of the mechanism anywhere.
  DeviceView(vtkRenderer* renderer, const std::vector<Bar>& bars);
  /// The same bars, moved, and the pose of the platform there.
  void place(const std::vector<Bar>& bars, const Pose& pose);
  bool fadeBefore(const Vec3& eye, const Vec3& point);  ///< as a Rod
  /// Of all that fades.
  std::vector<vtkActor*> actors() const;

 private:
  struct Link {
    Rod rod;
    Ball joint;  // at its far end
  };
  struct Arm {  // of a platform that chains carry, from its hub to a corner
    Rod arm, post;
  };

  std::vector<Link> links_;  // of the bars
  std::vector<Arm> arms_;
  std::vector<Rod> axes_;  // of a platform without chains
};

}  // namespace enamel::viewer
