// Draws a solid with VTK: its surface in groups of bricks, coloured by layer, and cut open along a plane.
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

/// The drawing thread's copy of a solid; the haptic thread cuts the original.
struct SolidCopy {
  std::shared_ptr<const Solid> uncut;
  std::vector<BrickSamples> samples;        ///< present samples by brick
  std::shared_ptr<const MeshModel> target;  ///< in its frame: colours show the distance from it; null: the layers
};
SolidCopy copyOf(const Solid& solid);

/// A plane in W that cuts a solid open: the part in front of it, where its normal points, is not shown.
struct CutPlane {
  Vec3 point, normal;
};

class SolidView {
 public:
  /// Refer to `solid`, which must outlive the view. `pose`: of its frame in W. If `plane` is set, only the part behind
  /// it is shown. `hidden`: surfaces of opaque bodies; parts inside them are never shown. `scale`: of lines.
  SolidView(vtkRenderer* renderer, const SolidCopy& solid, const Pose& pose, const std::optional<CutPlane>& plane,
            const std::vector<CutPlane>& hidden, float scale);
  SolidView(const SolidView&) = delete;
  SolidView& operator=(const SolidView&) = delete;

  /// Mark a brick whose samples have changed.
  void change(int brick);
  /// Rebuild changed parts.
  void update();

 private:
  struct Group {
    std::vector<int> bricks;
    bool isChanged = true;
    bool isCut = false;               // before, its surface is smooth, and half the resolution suffices
    vtkSmartPointer<vtkActor> actor;  // may be null
  };

  Group& groupOf(int brick) { return groups_[static_cast<std::size_t>(groupOf_[static_cast<std::size_t>(brick)])]; }
  float at(const Vec3& p) const;  // value of the field, cells
  Vec3 colourAt(const Vec3& p, int layer);
  void build(Group& group);
  void buildSection();

  vtkRenderer* renderer_;
  const SolidCopy& solid_;
  Pose pose_;
  std::optional<CutPlane> plane_;
  float scale_;
  std::vector<Vec3> colours_;  // by layer
  std::vector<Group> groups_;
  std::vector<int> groupOf_;  // by brick
  SolidSurface surface_;
  ProximityCache nearest_;  // of the target
  vtkNew<vtkPlane> clip_;
  bool isSectionChanged_ = true;
  std::vector<vtkSmartPointer<vtkActor>> section_;
};

}  // namespace enamel::viewer
