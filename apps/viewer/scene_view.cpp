#include "scene_view.hpp"

#include <vtkCamera.h>
#include <vtkProperty.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "colours/teeth.hpp"

namespace enamel::viewer {
namespace {

// Sizes of drawn parts that no device file knows, m (radii in mm where a Rod takes them).
constexpr double kMotorHeight = 0.030, kHub = 0.020, kNeedleLength = 0.032;
constexpr double kCube = 0.025, kPane = 0.028, kPaneDepth = 0.006, kGumDepth = 0.014, kGridStep = 0.005;
constexpr double kArrowPerNewton = 0.003, kArrowHead = 0.010, kNormal = 0.025;  // m/N, m, m
constexpr double kMarkedFrom = 230.0;                         // mm: from nearer, marks of the contact are smaller
constexpr double kSmallestForce = 0.1, kLargestForce = 40.0;  // N: that the arrow shows
constexpr std::size_t kShownContacts = 3;

Vec3 inPlatform(const Pose& pose, const Vec3& local) { return pose.position + pose.rotation * local; }

bool hasChains(const std::vector<Bar>& bars) {
  return std::any_of(bars.begin(), bars.end(), [](const Bar& bar) { return bar.chain >= 0; });
}

bool isLastOfChain(const std::vector<Bar>& bars, std::size_t i) {
  return i + 1 == bars.size() || bars[i + 1].chain != bars[i].chain;
}

bool isFirstOfChain(const std::vector<Bar>& bars, std::size_t i) {
  return i == 0 || bars[i - 1].chain != bars[i].chain;
}

// What the motors of three chains stand on: a beam through the two lower ones, and a mast from it to the upper one.
void addColumn(vtkRenderer* renderer, std::vector<Vec3> bases) {
  if (bases.size() != 3) return;
  std::stable_sort(bases.begin(), bases.end(), [](const Vec3& a, const Vec3& b) { return a.y() < b.y(); });
  const Vec3 top = bases[2], foot = 0.5 * (bases[0] + bases[1]), mast(foot.x(), foot.y(), top.z());
  Rod(renderer, 6.0, {kColumn}).place(bases[0], bases[1]);
  Rod(renderer, 6.0, {kColumn}).place(foot, mast);
  Rod(renderer, 7.5, {kColumn}).place(mast - Vec3(0.0, 0.02, 0.0), top + Vec3(0.0, 0.03, 0.0));
  Ball(renderer, 7.5, {kColumn}).place(mast);
}

// A face with lines of a grid and an outline.
struct Face {
  Vec3 centre, across, up;  // the two half sides
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

// Lines of the grid are polygons of two corners: cut() works on them too.
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

// Its outline; its face in small pieces, for their shades.
Polygon roundPane(const Vec3& middle, const Vec3& across, const Vec3& up, std::vector<Polygon>& faces) {
  constexpr int around = 72, rings = 36;
  constexpr double power = 0.55, turn = 6.283185307179586 / around;  // of a superellipse
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
  // Centred on the part of the plane that is nearest to the middle of the workspace.
  const Vec3 middle = n.dot(wall.point) * n;
  const Face face{middle, kPane * across, kPane * up};
  Polygon pane{middle - face.across - face.up, middle + face.across - face.up, middle + face.across + face.up,
               middle - face.across + face.up};
  if (wall.isGum) pane = roundPane(middle, face.across, face.up, drawing.faces);
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

// Only what lies behind a plane, and of the wall's body a section in it, a little behind those of solids.
void cutOpen(Drawing& drawing, const CutPlane& plane) {
  std::vector<Polygon> shown;
  const Vec3 across = plane.normal.unitOrthogonal(), up = plane.normal.cross(across);
  const Vec3 middle = plane.point - 5e-5 * plane.normal;
  Polygon section{middle - across - up, middle + across - up, middle + across + up, middle - across + up};
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
      drawing.faces.push_back({face.centre - face.across - face.up, face.centre + face.across - face.up,
                               face.centre + face.across + face.up, face.centre - face.across + face.up});
      if (sign < 0.0) std::reverse(drawing.faces.back().begin(), drawing.faces.back().end());
      addOutline(drawing.faces.back(), drawing.edges);
      addGrid(face, {}, 5e-5 * n, drawing);
    }
}

// They tumble, and become smaller as they age.
void drawChips(const Chips& chips, Shards& shards) {
  constexpr double size = 0.4, tumble = 25.0;  // mm, rad/s
  bool any = false;
  for (std::size_t i = 0; i < Chips::kPool; ++i) {
    const Chips::Chip& chip = chips.chips()[i];
    const double left = std::max(0.0, 1.0 - chip.age / Chips::kLife), number = static_cast<double>(i);
    const Vec3 axis = Vec3(std::sin(2.4 * number), std::cos(2.4 * number), std::sin(1.7 * number)).normalized();
    const Mat3 turned = Eigen::AngleAxisd(number + tumble * chip.age, axis).toRotationMatrix();
    shards.place(i, chip.position, turned.col(0), turned.col(1), size * std::sqrt(left), layerColour(chip.layer));
    any = any || left > 0.0;
  }
  shards.show(any);
}

}  // namespace

struct SceneView::Parts {
  Parts(vtkRenderer* renderer, vtkRenderer* above, const std::vector<Bar>& bars, const SceneFile& scene);

  struct Link {
    Rod rod;
    Ball joint;  // at its far end
  };
  struct Arm {  // of a platform that chains carry, from its hub to a corner
    Rod arm, post;
  };
  struct DrawnTool {
    DrawnTool(vtkRenderer* renderer, const Tool& tool, const Bur* cutting, unsigned body, unsigned grip, unsigned tip,
              double opacity, double growth);
    void place(const Pose& pose, double burAngle);
    void show(bool visible);
    std::vector<vtkActor*> actors() const;
    std::vector<ToolPart> parts;
    std::vector<CapsuleSolid> solids;  // of the parts; a point is drawn as the tip of a needle
    std::vector<Rod> needle;
    double beyond;  // that a larger one is longer at each end, or the ends would be drawn into each other, m
    Rod handle, hub;
    std::optional<FlutedBur> bur;
    ToolPart burPart;
  };

  // Draws what shines through last, the reference pose behind all else of it.
  void raiseFaded(vtkRenderer* renderer);

  std::vector<Link> links;  // of the bars
  std::vector<Arm> arms;
  std::vector<Rod> axes;  // of a platform without chains
  DrawnTool tool, ghost;
  Rod arrow, arrowHead, pull;
  Ball hand;
  std::vector<Rod> normals;
  std::vector<Ball> contacts;
  std::optional<Shards> chips;
};

SceneView::Parts::DrawnTool::DrawnTool(vtkRenderer* renderer, const Tool& tool, const Bur* cutting, unsigned body,
                                       unsigned grip, unsigned tip, double opacity, double growth)
    : parts(tool.parts.begin(), tool.parts.begin() + tool.count),
      beyond(1e-3 * (growth - 1.0)),
      handle(renderer, 5.0 * growth, {grip, opacity, 0.35}),
      hub(renderer, 8.5 * growth, {body, opacity}) {
  if (cutting != nullptr) {
    burPart = parts[static_cast<std::size_t>(cutting->part)];
    parts.erase(parts.begin() + cutting->part);
    bur.emplace(renderer, kMillimetres * burPart.radius, kMillimetres * (burPart.b - burPart.a).norm());
  }
  parts.erase(std::remove_if(parts.begin(), parts.end(), [](const ToolPart& part) { return part.radius == 0.0; }),
              parts.end());
  for (const ToolPart& part : parts)
    solids.emplace_back(renderer, kMillimetres * part.radius * growth, Finish{tip, opacity, 0.4});
  if (parts.empty() && !bur) needle.emplace_back(renderer, 2.6 * growth, Finish{tip, opacity}, true);
}

void SceneView::Parts::DrawnTool::place(const Pose& pose, double burAngle) {
  if (bur) {
    const Vec3 along = burPart.b - burPart.a;
    const Vec3 axis = along.norm() > 0.0 ? Vec3(along.normalized()) : Vec3::UnitZ();
    const Mat3 turned = Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), axis).toRotationMatrix();
    bur->place(inPlatform(pose, burPart.a), pose.rotation * turned, burAngle);
  }
  for (std::size_t i = 0; i < parts.size(); ++i)
    solids[i].place(inPlatform(pose, parts[i].a), inPlatform(pose, parts[i].b));
  for (Rod& rod : needle) rod.place(pose.position, inPlatform(pose, {0.0, 0.0, kNeedleLength}));
  const auto from = [&](double low, double high, Rod& rod) {
    rod.place(inPlatform(pose, {0.0, 0.0, low - beyond}), inPlatform(pose, {0.0, 0.0, high + beyond}));
  };
  from(kHub, kHandleEnd, handle);
  from(kHub - 0.003, kHub + 0.004, hub);
}

void SceneView::Parts::DrawnTool::show(bool visible) {
  for (CapsuleSolid& solid : solids) solid.show(visible);
  for (Rod& rod : needle) rod.show(visible);
  for (Rod* rod : {&handle, &hub}) rod->show(visible);
}

std::vector<vtkActor*> SceneView::Parts::DrawnTool::actors() const {
  std::vector<vtkActor*> all{handle.actor(), hub.actor()};
  for (const CapsuleSolid& solid : solids)
    for (vtkActor* actor : solid.actors()) all.push_back(actor);
  for (const Rod& rod : needle) all.push_back(rod.actor());
  return all;
}

void SceneView::Parts::raiseFaded(vtkRenderer* renderer) {
  for (vtkActor* actor : ghost.actors()) drawLast(renderer, actor);
  std::vector<vtkActor*> fading = tool.actors();
  for (const Link& link : links) fading.insert(fading.end(), {link.rod.actor(), link.joint.actor()});
  for (const Arm& arm : arms) fading.insert(fading.end(), {arm.arm.actor(), arm.post.actor()});
  for (vtkActor* actor : fading)
    if (actor->GetForceOpaque() != 0) drawLast(renderer, actor);
}

SceneView::Parts::Parts(vtkRenderer* renderer, vtkRenderer* above, const std::vector<Bar>& bars, const SceneFile& scene)
    : tool(renderer, scene.tool, scene.bur ? &*scene.bur : nullptr, kPlatform, kHandle, kNeedle, 1.0, 1.0),
      ghost(renderer, scene.tool, nullptr, kReference, kReference, kReference, 0.25, 1.3),
      arrow(above, 1.5, {kForce, 1.0, 0.1}),
      arrowHead(above, 3.8, {kForce, 1.0, 0.1}, true),
      pull(above, 1.0, {kHand, 1.0, 0.0}),
      hand(above, 6.0, {kHand, 1.0, 0.2}) {
  std::vector<Vec3> bases;
  const bool chains = hasChains(bars);
  for (std::size_t i = 0; i < bars.size(); ++i) {
    if (bars[i].chain < 0) {
      if (chains)
        arms.push_back({Rod(renderer, 2.6, {kPlatform}), Rod(renderer, 2.6, {kPlatform})});
      else
        axes.emplace_back(renderer, 1.2, Finish{kLink2});
      continue;
    }
    const bool first = isFirstOfChain(bars, i), last = isLastOfChain(bars, i);
    links.push_back({Rod(renderer, first ? 5.0 : 3.6, {first ? kLink1 : kLink2}),
                     last ? Ball(renderer, 5.2, {kMotor, 1.0, 0.4}) : Ball(renderer, 6.5, {kMotor})});
    if (!first) continue;
    const Vec3 base = bars[i].from, y(0.0, 0.5 * kMotorHeight, 0.0);
    Rod(renderer, 11.5, {kMotor}).place(base - y, base + y);
    Rod(renderer, 8.0, {kLink1}).place(base + y, base + y + Vec3(0.0, 0.005, 0.0));
    bases.push_back(base);
  }
  for (std::size_t i = 0; i < kShownContacts; ++i) {
    normals.emplace_back(above, 0.5, Finish{kInk, 1.0, 0.0});
    contacts.emplace_back(above, 2.2, Finish{kForce, 1.0, 0.1});
  }
  addColumn(renderer, bases);
  if (scene.bur) chips.emplace(renderer, Chips::kPool);
  raiseFaded(renderer);
}

SceneView::SceneView(vtkRenderer* renderer, vtkRenderer* above) : renderer_(renderer), above_(above) {
  const Colour ground = colour(kGround);
  renderer->SetBackground(ground.r, ground.g, ground.b);
  renderer->SetAutomaticLightCreation(false);
  above->SetAutomaticLightCreation(false);
  above->SetActiveCamera(renderer->GetActiveCamera());
  for (vtkRenderer* lit : {renderer, above}) {
    addLight(lit, -0.9, 0.6, 1.0, 0.8);
    addLight(lit, 1.0, 0.5, 0.5, 0.6);
    addLight(lit, 0.0, 0.0, 1.0, 0.15);
  }
}

SceneView::~SceneView() = default;

void SceneView::build(const std::vector<Bar>& bars, const SceneFile& file, const std::vector<SolidCopy>& solids,
                      const std::optional<CutPlane>& plane, float scale) {
  const Scene& scene = file.scene;
  renderer_->RemoveAllViewProps();
  above_->RemoveAllViewProps();
  Drawing drawing, gum;
  std::vector<Wall> walls;
  for (const Obstacle& obstacle : scene.obstacles())
    if (std::holds_alternative<HalfSpace>(obstacle.shape))
      walls.push_back({{obstacle.pose.position, obstacle.pose.rotation.col(2)}, obstacle.name == "gum"});
  for (std::size_t i = 0; i < walls.size(); ++i) {
    std::vector<Wall> others = walls;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    drawWall(walls[i], others, walls[i].isGum ? gum : drawing);
  }
  const Finish enamel{kEnamel, 1.0, 0.1};
  for (const Obstacle& obstacle : scene.obstacles()) {
    const Pose& pose = obstacle.pose;
    if (const auto* box = std::get_if<Box>(&obstacle.shape)) drawBox(*box, pose, drawing);
    if (const auto* sphere = std::get_if<Sphere>(&obstacle.shape))
      Ball(renderer_, kMillimetres * sphere->radius, enamel).place(pose.position);
    if (const auto* capsule = std::get_if<Capsule>(&obstacle.shape)) {
      const Vec3 half = capsule->halfLength * pose.rotation.col(2);
      CapsuleSolid(renderer_, kMillimetres * capsule->radius, enamel).place(pose.position - half, pose.position + half);
    }
    if (const auto* mesh = std::get_if<std::shared_ptr<const MeshModel>>(&obstacle.shape))
      addMesh(renderer_, (*mesh)->mesh(), pose, {kEnamel, 1.0, 0.35},
              toothColours((*mesh)->mesh(), obstacle.name == "arch" ? kGumLine : kNoGum));
  }
  solids_.clear();
  std::vector<CutPlane> hidden;
  for (const Wall& wall : walls)
    if (wall.isGum) hidden.push_back(wall);
  for (std::size_t i = 0; i < scene.obstacles().size(); ++i) {
    const Pose& pose = scene.obstacles()[i].pose;
    const bool has = i < solids.size() && solids[i].uncut;
    solids_.push_back(has ? std::make_unique<SolidView>(renderer_, solids[i], pose, plane, hidden, scale) : nullptr);
  }
  if (plane && !gum.faces.empty()) cutOpen(gum, *plane);
  const auto toTeeth = [&](const Vec3& point) {
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
  };
  addFaces(renderer_, gum.faces, {kGum, 1.0, 0.3}, [&](const Vec3& corner) { return gumColour(toTeeth(corner)); });
  addFaces(renderer_, gum.backs, {kGumBack, 1.0, 0.0});
  addLines(renderer_, gum.edges, kGumEdge, 1.5f * scale);
  addFaces(renderer_, drawing.faces, enamel);
  addFaces(renderer_, drawing.backs, {kEnamelGrid, 1.0, 0.0});
  addLines(renderer_, drawing.grid, kEnamelGrid, scale);
  addLines(renderer_, drawing.edges, kEnamelEdge, 2.0f * scale);

  std::vector<std::array<Vec3, 2>> cube;  // not through the view of what is drilled
  for (int axis = 0; axis < 3 && !file.bur; ++axis)
    for (int corner = 0; corner < 4; ++corner) {
      Vec3 from;
      from[axis] = -kCube;
      from[(axis + 1) % 3] = (corner & 1) != 0 ? kCube : -kCube;
      from[(axis + 2) % 3] = (corner & 2) != 0 ? kCube : -kCube;
      Vec3 to = from;
      to[axis] = kCube;
      cube.push_back({from, to});
    }
  addLines(renderer_, cube, kCubeLine, scale);
  parts_ = std::make_unique<Parts>(renderer_, above_, bars, file);
}

void SceneView::change(std::size_t obstacle, int brick) {
  if (obstacle < solids_.size() && solids_[obstacle]) solids_[obstacle]->change(brick);
}

void SceneView::update(const SceneState& state) {
  Parts& p = *parts_;
  const Pose& pose = state.pose;
  std::size_t link = 0, arm = 0, axis = 0;
  for (const Bar& bar : state.bars) {
    if (bar.chain >= 0) {
      p.links[link].rod.place(bar.from, bar.to);
      p.links[link++].joint.place(bar.to);
    } else if (p.arms.empty()) {
      p.axes[axis++].place(bar.from, bar.to);
    } else {
      const Vec3 corner = pose.rotation.transpose() * (bar.from - pose.position);
      const Vec3 bend = inPlatform(pose, {corner.x(), corner.y(), kHub});
      p.arms[arm].arm.place(inPlatform(pose, {0.0, 0.0, kHub}), bend);
      p.arms[arm++].post.place(bend, bar.from);
    }
  }
  p.tool.place(pose, state.burAngle);
  bool changes = false;
  const auto fade = [&](auto& one) { changes |= one.fadeBefore(state.eye, state.watched); };
  for (Parts::Link& one : p.links) {
    fade(one.rod);
    fade(one.joint);
  }
  for (Parts::Arm& one : p.arms) {
    fade(one.arm);
    fade(one.post);
  }
  fade(p.tool.handle);
  fade(p.tool.hub);
  if (changes) p.raiseFaded(renderer_);
  for (const auto& solid : solids_)
    if (solid) solid->update();
  p.ghost.show(state.ghost.has_value());
  if (state.ghost) p.ghost.place(*state.ghost, 0.0);

  const Vec3 grip = pose.rotation * Vec3(0.0, 0.0, kHandleEnd);
  p.hand.show(state.hand.has_value());
  p.pull.show(state.hand.has_value());
  if (state.hand) {
    p.hand.place(*state.hand + grip);
    p.pull.place(pose.position + grip, *state.hand + grip);
  }

  if (p.chips && state.chips != nullptr) drawChips(*state.chips, *p.chips);

  const double size = std::pow(std::min(1.0, state.distance / kMarkedFrom), 1.4);
  for (std::size_t i = 0; i < kShownContacts; ++i) {
    const bool touching = i < state.touching.size();
    p.contacts[i].show(touching);
    p.normals[i].show(touching);
    if (!touching) continue;
    const Contact& contact = state.touching[i];
    const Vec3 surface = contact.point - contact.gap * contact.normal;
    p.contacts[i].place(surface, size);
    p.normals[i].place(surface, surface + size * kNormal * contact.normal, size);
  }
  const double force = state.force.norm();
  const bool arrow = !state.touching.empty() && force > kSmallestForce;
  p.arrow.show(arrow);
  p.arrowHead.show(arrow);
  if (arrow) {
    const Vec3 along = state.force / force;
    const Vec3 neck = pose.position + size * kArrowPerNewton * std::min(force, kLargestForce) * along;
    p.arrow.place(pose.position, neck, size);
    p.arrowHead.place(neck + size * kArrowHead * along, neck, size);
  }
}

void SceneView::look(const Camera& camera, double aspect) {
  vtkCamera* c = renderer_->GetActiveCamera();
  const glm::dvec3 eye = camera.eye();
  c->SetPosition(eye.x, eye.y, eye.z);
  c->SetFocalPoint(camera.focus.x, camera.focus.y, camera.focus.z);
  c->SetViewUp(0.0, 1.0, 0.0);
  c->SetViewAngle(glm::degrees(camera.height(aspect)));
  renderer_->ResetCameraClippingRange();
}

}  // namespace enamel::viewer
