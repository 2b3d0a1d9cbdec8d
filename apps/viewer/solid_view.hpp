// A solid as VTK draws it: its surface in groups of bricks, coloured by layer, and cut open along a plane.
#pragma once

#include <vtkActor.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <memory>
#include <optional>
#include <vector>

#include "enamel/collision/solid.hpp"
#include "enamel/collision/solid_surface.hpp"
#include "polygons.hpp"

namespace enamel::viewer {

/// What the drawing thread has of a solid: never the one that is cut.
struct SolidCopy {
  std::shared_ptr<const Solid> uncut;
  std::vector<BrickSamples> samples;  ///< by brick, as they are now
};
SolidCopy copyOf(const Solid& solid);

/// A plane in W that a solid is cut open along: what lies before it, where its normal points to, is not shown.
struct CutPlane {
  Vec3 point, normal;
};

class SolidView {
 public:
  /// Refers to `solid`, whose frame is at `pose` in W; shows what lies behind a plane, if any. What is in one of the
  /// opaque bodies that begin at `hidden` planes is never seen. `scale`: of lines.
  SolidView(vtkRenderer* renderer, const SolidCopy& solid, const Pose& pose, const std::optional<CutPlane>& plane,
            const std::vector<CutPlane>& hidden, float scale);
  SolidView(const SolidView&) = delete;
  SolidView& operator=(const SolidView&) = delete;

  /// The samples of this brick are others now.
  void change(int brick);
  /// Builds again what has changed.
  void update();

 private:
  struct Group {
    std::vector<int> bricks;
    bool isChanged = true;
    bool isCut = false;               // before, it is smooth: every second sample will do
    vtkSmartPointer<vtkActor> actor;  // or none
  };

  Group& groupOf(int brick) { return groups_[static_cast<std::size_t>(groupOf_[static_cast<std::size_t>(brick)])]; }
  float at(const Vec3& p) const;  // of the field, cells
  void build(Group& group);
  void buildSection();

  vtkRenderer* renderer_;
  const SolidCopy& solid_;
  Pose pose_;
  std::optional<CutPlane> plane_;
  float scale_;
  std::vector<Group> groups_;
  std::vector<int> groupOf_;  // by brick
  SolidSurface surface_;
  vtkNew<vtkPlane> clip_;
  bool isSectionChanged_ = true;
  std::vector<vtkSmartPointer<vtkActor>> section_;
};

}  // namespace enamel::viewer
