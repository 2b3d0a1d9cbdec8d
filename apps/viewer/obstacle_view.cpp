#include "obstacle_view.hpp"

#include <vtkActorCollection.h>
#include <vtkNew.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "colours/tooth_colours.hpp"

namespace enamel::viewer {
namespace {

// m
constexpr double kCube = 0.025, kPane = 0.028, kPaneDepth = 0.006, kGumDepth = 0.014, kGridStep = 0.005;
constexpr Finish kEnamelFinish{kEnamel, 1.0, 0.1};

// A face with grid lines and an outline.
struct Face {
  Vec3 centre, across, up;  // half sides
  Polygon polygon() const { return parallelogram(centre, across, up); }
};

struct Wall : CutPlane {
  bool isGum;
};

struct Drawing {
  std::vector<Polygon> faces, backs;
  std::vector<std::array<Vec3, 2>> grid, edges;
};

void addOutline(const Polygon& polygon, std::vector<std::array<Vec3, 2>>& lines) {
  for (std::size_t i = 0; i < polygon.size(); ++i) lines.push_back({polygon[i], polygon[(i + 1) % polygon.size()]});
}

// Grid lines are polygons with two corners, so that cut() works for them.
void addGrid(const Face& face, const std::vector<Wall>& others, const Vec3& lift, Drawing& drawing) {
  for (const bool turned : {false, true}) {
    const Vec3 along = turned ? face.up : face.across, step = turned ? face.across : face.up;
    const double reach = step.norm();
    const int count = static_cast<int>(reach / kGridStep + 1e-9);
    for (int i = -count; i <= count; ++i) {
      const Vec3 middle = face.centre + i * kGridStep / reach * step + lift;
      Polygon line{middle - along, middle + along};
      for (const Wall& other : others) line = cut(line, other.point, other.normal);
      if (line.size() >= 2) drawing.grid.push_back({line[0], line[1]});
    }
  }
}

// Return the outline of a gum pane, and append its face in small pieces for shading.
Polygon roundPane(const Vec3& middle, const Vec3& across, const Vec3& up, std::vector<Polygon>& faces) {
  constexpr int around = 72, rings = 36;
  constexpr double power = 0.55, turn = 6.283185307179586 / around;  // exponent of a superellipse
  const auto squared = [](double x) { return std::copysign(std::pow(std::abs(x), power), x); };
  const auto at = [&](int i, int ring) {
    const double share = static_cast<double>(ring) / rings;
    return Vec3(middle + share * (squared(std::cos(i * turn)) * across + squared(std::sin(i * turn)) * up));
  };
  Polygon outline;
  for (int i = 0; i < around; ++i) {
    outline.push_back(at(i, rings));
    for (int ring = 0; ring < rings; ++ring)
      faces.push_back({at(i, ring + 1), at(i + 1, ring + 1), at(i + 1, ring), at(i, ring)});
  }
  return outline;
}

void drawWall(const Wall& wall, const std::vector<Wall>& others, Drawing& drawing) {
  const Vec3 n = wall.normal;
  const Vec3 vertical = std::abs(n.y()) < 0.95 ? Vec3(0.0, 1.0, 0.0) : Vec3(0.0, 0.0, -1.0);
  const Vec3 across = vertical.cross(n).normalized(), up = n.cross(across);
  // Centre it on the point of the plane nearest to the middle of the workspace.
  const Vec3 middle = n.dot(wall.point) * n;
  const Face face{middle, kPane * across, kPane * up};
  Polygon pane = wall.isGum ? roundPane(middle, face.across, face.up, drawing.faces) : face.polygon();
  for (const Wall& other : others) pane = cut(pane, other.point, other.normal);
  if (!wall.isGum) drawing.faces.push_back(pane);
  addOutline(pane, drawing.edges);
  if (!wall.isGum) addGrid(face, others, 5e-5 * n, drawing);
  const double depth = wall.isGum ? kGumDepth : kPaneDepth;
  for (std::size_t i = 0; i < pane.size(); ++i) {
    const Vec3 &a = pane[i], &b = pane[(i + 1) % pane.size()];
    drawing.backs.push_back({b, a, a - depth * n, b - depth * n});
  }
  Polygon back;
  for (const Vec3& corner : pane) back.push_back(corner - depth * n);
  std::reverse(back.begin(), back.end());
  drawing.backs.push_back(back);
}

// Keep only the part behind a plane, and add a section of the wall's body slightly behind the sections of solids.
void cutOpen(Drawing& drawing, const CutPlane& plane) {
  const Vec3 across = plane.normal.unitOrthogonal(), up = plane.normal.cross(across);
  const Vec3 middle = plane.point - 5e-5 * plane.normal;
  Polygon section = parallelogram(middle, across, up);
  for (std::vector<Polygon>* list : {&drawing.faces, &drawing.backs})
    for (Polygon& polygon : *list) {
      if (polygon.size() < 3) continue;
      section = cut(section, polygon[0], (polygon[2] - polygon[0]).cross(polygon[1] - polygon[0]).normalized());
      polygon = cut(polygon, plane.point, -plane.normal);
    }
  std::vector<std::array<Vec3, 2>> edges;
  for (const auto& edge : drawing.edges)
    if (const Polygon left = cut({edge[0], edge[1]}, plane.point, -plane.normal); left.size() >= 2)
      edges.push_back({left[0], left[1]});
  drawing.edges = edges;
  if (section.size() >= 3) drawing.backs.push_back(section);
}

void drawBox(const Box& box, const Pose& pose, Drawing& drawing) {
  const Mat3& r = pose.rotation;
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      const int i = (axis + 1) % 3, j = (axis + 2) % 3;
      const Vec3 n = sign * r.col(axis);
      const Face face{pose.position + box.half[axis] * n, box.half[i] * r.col(i), box.half[j] * r.col(j)};
      drawing.faces.push_back(face.polygon());
      if (sign < 0.0) std::reverse(drawing.faces.back().begin(), drawing.faces.back().end());
      addOutline(drawing.faces.back(), drawing.edges);
      addGrid(face, {}, 5e-5 * n, drawing);
    }
}

std::vector<Wall> wallsOf(const Scene& scene) {
  std::vector<Wall> walls;
  for (const Obstacle& obstacle : scene.obstacles())
    if (std::holds_alternative<HalfSpace>(obstacle.shape))
      walls.push_back({{obstacle.pose.position, obstacle.pose.rotation.col(2)}, obstacle.name == "gum"});
  return walls;
}

// Draw spheres, capsules and meshes.
void addShape(vtkRenderer* renderer, const Obstacle& obstacle) {
  const Pose& pose = obstacle.pose;
  if (const auto* sphere = std::get_if<Sphere>(&obstacle.shape))
    Ball(renderer, kMillimetres * sphere->radius, kEnamelFinish).place(pose.position);
  if (const auto* capsule = std::get_if<Capsule>(&obstacle.shape)) {
    const Vec3 half = capsule->halfLength * pose.rotation.col(2);
    CapsuleSolid(renderer, kMillimetres * capsule->radius, kEnamelFinish)
        .place(pose.position - half, pose.position + half);
  }
  if (const auto* mesh = std::get_if<std::shared_ptr<const MeshModel>>(&obstacle.shape))
    addMesh(renderer, (*mesh)->mesh(), pose, {kEnamel, 1.0, 0.35},
            toothColours((*mesh)->mesh(), obstacle.name == "arch" ? kGumLine : kNoGum));
}

// Draw the lines of guides and, at the corners of a tube, balls of its radius. Planes are as large as walls.
void addGuides(vtkRenderer* renderer, const std::vector<Guide>& guides, float scale) {
  std::vector<std::array<Vec3, 2>> lines;
  for (const Guide& guide : guides) {
    const auto draw = [&](Polygon polygon) {
      for (Vec3& corner : polygon) corner = guide.pose.position + guide.pose.rotation * corner;
      addOutline(polygon, lines);
    };
    if (const auto* box = std::get_if<Box>(&guide.shape)) {
      const Vec3 x = box->half.x() * Vec3::UnitX(), y = box->half.y() * Vec3::UnitY(),
                 z = box->half.z() * Vec3::UnitZ();
      for (const double sign : {-1.0, 1.0}) {
        draw(parallelogram(sign * z, x, y));
        draw(parallelogram(sign * x, y, z));
      }
    } else if (const auto* line = std::get_if<Polyline>(&guide.shape)) {
      for (std::size_t i = 0; i < line->points.size(); ++i) {
        if (i > 0) draw({line->points[i - 1], line->points[i]});
        for (int axis = 0; axis < 3 && line->radius > 0.0; ++axis) {
          constexpr int kCorners = 24;
          Polygon circle;
          for (int k = 0; k < kCorners; ++k) {
            Vec3 corner = line->points[i];
            corner[axis] += line->radius * std::cos(2.0 * M_PI * k / kCorners);
            corner[(axis + 1) % 3] += line->radius * std::sin(2.0 * M_PI * k / kCorners);
            circle.push_back(corner);
          }
          draw(circle);
        }
      }
    } else {
      draw(parallelogram(Vec3::Zero(), kPane * Vec3::UnitX(), kPane * Vec3::UnitY()));
    }
  }
  addLines(renderer, lines, kGuide, 2.0f * scale);
}

void addDrawing(vtkRenderer* renderer, const Drawing& drawing, float scale) {
  addFaces(renderer, drawing.faces, kEnamelFinish);
  addFaces(renderer, drawing.backs, {kEnamelGrid, 1.0, 0.0});
  addLines(renderer, drawing.grid, kEnamelGrid, scale);
  addLines(renderer, drawing.edges, kEnamelEdge, 2.0f * scale);
}

// Return the actors of a renderer from number `first` on.
std::vector<vtkActor*> actorsFrom(vtkRenderer* renderer, int first) {
  std::vector<vtkActor*> actors;
  for (int i = first; i < renderer->GetActors()->GetNumberOfItems(); ++i)
    actors.push_back(vtkActor::SafeDownCast(renderer->GetActors()->GetItemAsObject(i)));
  return actors;
}

// Return the distance to the nearest mesh or solid, m.
double distanceToTeeth(const Vec3& point, const Scene& scene, const std::vector<SolidCopy>& solids) {
  double nearest = 1.0;
  for (std::size_t i = 0; i < scene.obstacles().size(); ++i) {
    const Obstacle& obstacle = scene.obstacles()[i];
    const Vec3 local = obstacle.pose.rotation.transpose() * (point - obstacle.pose.position);
    if (const auto* mesh = std::get_if<std::shared_ptr<const MeshModel>>(&obstacle.shape))
      nearest = std::min(nearest, std::abs(signedDistance(**mesh, local).distance));
    else if (i < solids.size() && solids[i].uncut)
      nearest = std::min(nearest, std::abs(signedDistance(*solids[i].uncut, local).distance));
  }
  return nearest;
}

}  // namespace

std::vector<CutPlane> opaquePlanes(const Scene& scene) {
  std::vector<CutPlane> planes;
  for (const Wall& wall : wallsOf(scene))
    if (wall.isGum) planes.push_back(wall);
  return planes;
}

MovableView::MovableView(const Pose& pose, const std::vector<vtkActor*>& drawn) : pose_(pose) {
  for (vtkActor* const actor : drawn) {
    bodies_.push_back({actor, vtkSmartPointer<vtkMatrix4x4>::New()});
    if (actor->GetUserMatrix() != nullptr) bodies_.back().drawn->DeepCopy(actor->GetUserMatrix());
  }
}

void MovableView::place(const Pose& pose) {
  const Mat3 turn = pose.rotation * pose_.rotation.transpose();
  const Vec3 way = kMillimetres * (pose.position - turn * pose_.position);
  vtkNew<vtkMatrix4x4> moved;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) moved->SetElement(i, j, turn(i, j));
    moved->SetElement(i, 3, way[i]);
  }
  for (const Body& body : bodies_) {
    vtkNew<vtkMatrix4x4> matrix;
    vtkMatrix4x4::Multiply4x4(moved, body.drawn, matrix);
    body.actor->SetUserMatrix(matrix);
  }
}

std::vector<MovableView> addObstacles(vtkRenderer* renderer, const SceneFile& file,
                                      const std::vector<SolidCopy>& solids, const std::optional<CutPlane>& plane,
                                      float scale) {
  const Scene& scene = file.scene;
  Drawing drawing, gum;
  const std::vector<Wall> walls = wallsOf(scene);
  for (std::size_t i = 0; i < walls.size(); ++i) {
    std::vector<Wall> others = walls;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    drawWall(walls[i], others, walls[i].isGum ? gum : drawing);
  }
  std::vector<MovableView> movable;
  for (const Obstacle& obstacle : scene.obstacles()) {
    const int before = renderer->GetActors()->GetNumberOfItems();
    Drawing own;
    if (const auto* box = std::get_if<Box>(&obstacle.shape))
      drawBox(*box, obstacle.pose, obstacle.suspension ? own : drawing);
    addShape(renderer, obstacle);
    if (!obstacle.suspension) continue;
    if (!own.faces.empty()) addDrawing(renderer, own, scale);
    movable.emplace_back(obstacle.pose, actorsFrom(renderer, before));
  }
  if (plane && !gum.faces.empty()) cutOpen(gum, *plane);
  addFaces(renderer, gum.faces, {kGum, 1.0, 0.3},
           [&](const Vec3& corner) { return gumColour(distanceToTeeth(corner, scene, solids)); });
  addFaces(renderer, gum.backs, {kGumBack, 1.0, 0.0});
  addLines(renderer, gum.edges, kGumEdge, 1.5f * scale);
  addDrawing(renderer, drawing, scale);
  if (scene.guides()) addGuides(renderer, *scene.guides(), scale);
  return movable;
}

void addWorkspace(vtkRenderer* renderer, float scale) {
  std::vector<std::array<Vec3, 2>> cube;
  for (int axis = 0; axis < 3; ++axis)
    for (int corner = 0; corner < 4; ++corner) {
      Vec3 from;
      from[axis] = -kCube;
      from[(axis + 1) % 3] = (corner & 1) != 0 ? kCube : -kCube;
      from[(axis + 2) % 3] = (corner & 2) != 0 ? kCube : -kCube;
      Vec3 to = from;
      to[axis] = kCube;
      cube.push_back({from, to});
    }
  addLines(renderer, cube, kCubeLine, scale);
}

}  // namespace enamel::viewer
