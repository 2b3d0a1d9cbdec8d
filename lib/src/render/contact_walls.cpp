#include "render/contact_walls.hpp"

#include <algorithm>
#include <cmath>

#include "enamel/render/compliance.hpp"

namespace enamel {
namespace {

constexpr double kRetreat = 50.0;  // 1 / kRetreat^2: how far contradicting walls give way to force
constexpr int kMostTangents = 8;
constexpr double kTolerance = 1e-6;          // of the depth: error of a contact with a compliant material
constexpr double kLeastCompression = 1e-12;  // m, at which a law of a high exponent has a tangent
constexpr double kFades = 0.1;               // share of the speed along a wall at which a vanished wall retreats

// Compliance of the controller along a row, m/N.
double complianceOf(const PredictedModes& modes, const Lane& row) noexcept {
  double sum = 0.0;
  for (int mode = 0; mode < modes.count; ++mode) sum += row[mode] * row[mode] / modes.law.stiffness[mode];
  return sum;
}

// Solve the contact equation with the compliances of the targets.
void solveWalls(const TickFrame& frame, const PredictedModes& modes, const Wall* walls, const Target* targets,
                int count, double* force) noexcept {
  double G[kMaxWalls][kMaxWalls], h[kMaxWalls] = {};
  const double give = 1.0 / (kRetreat * kRetreat);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j <= i; ++j) {
      double v = 0.0;
      for (int k = 0; k < modes.count; ++k) v += targets[i].row[k] * targets[j].row[k] / modes.law.stiffness[k];
      v = v / (targets[i].size * targets[j].size) + give;
      const double reach = targets[i].reach * targets[j].reach;
      if (i != j && reach > 0.0)
        v += reach * frame.yield.inverse[static_cast<int>(walls[targets[i].wall].contact)]
                                        [static_cast<int>(walls[targets[j].wall].contact)];
      G[i][j] = G[j][i] = v;
    }
    G[i][i] += targets[i].compliance;
    h[i] = -(targets[i].gap + targets[i].offset) / targets[i].size * (1.0 + give) / (1.0 - give);
  }
  solveNonNegative(G, h, count, force);
  // sum / deepest is 1 for a single wall, and 1 / s^2 for two that face each other but lean by s towards a way out.
  double sum = 0.0, deepest = 0.0, doubt = 0.0;
  for (int i = 0; i < count; ++i) {
    sum += force[i];
    doubt += force[i] * targets[i].doubt / targets[i].size;
    deepest = std::max(deepest, h[i]);
  }
  if (!(sum > 0.0)) return;
  const double retreat = std::max(2.0 * give * sum, doubt / sum * std::max(0.0, 1.0 - deepest / sum));
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) G[i][j] -= give;
    h[i] -= retreat;
  }
  solveNonNegative(G, h, count, force);
  for (int i = 0; i < count; ++i) force[i] /= targets[i].size;
}

}  // namespace

double Rebound::distance(double push, double mass, double step) const noexcept {
  const double unseen = std::sqrt(0.5 * step), late = reaction * std::sqrt(0.5 * push / mass);
  return (unseen + late) * (unseen + late);
}

double Rebound::readingStep(const JointRow& row) const noexcept {
  double square = 0.0;
  for (Eigen::Index j = 0; j < encoderStep.size(); ++j) square += row[j] * encoderStep[j] * row[j] * encoderStep[j];
  return std::sqrt(square);
}

int collectWalls(const TickFrame& frame, const PredictedModes& modes, const JointRow& lastReading, WallMemory& memory,
                 Wall* walls) noexcept {
  const Kinematics& k = frame.kinematics;
  const double T = modes.period, moves = k.twist.head<3>().norm();
  JointRow moved{};
  for (int j = 0; j < modes.count; ++j) moved[j] = k.q[j] - lastReading[j];
  for (int i = 0; i < static_cast<int>(memory.count); ++i) {  // updated to this tick
    Wall& w = memory.wall[i];
    w.contact = -1.0;
    w.gap -= w.speed * T;
    for (int j = 0; j < modes.count; ++j) w.gap += w.row[j] * moved[j];
  }
  int count = 0;
  for (int c = 0; c < frame.contacts.count; ++c) {
    const Contact& contact = frame.contacts.contacts[c];
    Wall& w = walls[count++];
    w = Wall{};
    w.row = frame.rows.row[c].normal;
    double undriven = 0.0;  // change of the gap by joints without a motor, m
    for (int j = 0; j < modes.count; ++j)
      if (!(frame.maxTorque[j] > 0.0)) {
        undriven += w.row[j] * moved[j];
        w.row[j] = 0.0;
      }
    w.gap = contact.gap;
    w.speed = w.rest = w.after = contact.normal.dot(contact.obstacleVelocity);
    if (frame.yield.isAny) {
      w.rest -= contact.normal.dot(frame.yield.velocity[c]);
      w.after = w.rest + contact.normal.dot(frame.yield.after[c]);
      if (frame.yield.inverse[c][c] > 0.0) w.movable = contact.obstacle;
    }
    w.softness = softness(contact, contact.compression, 0.0, modes.period);
    w.name = contact.key != 0 ? contact.key : -1.0 - contact.obstacle - 1e3 * contact.part;
    w.contact = c;
    // A new wall, and one that did not hold the tool, begins at the tool. A layer begins where it was pressed to.
    double was = contact.compression < kNotCompressed ? std::min(0.0, -contact.compression) : 0.0;
    const auto end = memory.wall.begin() + static_cast<int>(memory.count);
    const auto before = std::find_if(memory.wall.begin(), end, [&](const Wall& other) { return other.name == w.name; });
    if (before != end) {
      before->contact = c;
      w.holds = before->holds;
      w.force = before->force;
      was = before->holds != 0.0 ? before->gap + undriven : std::min(was, before->gap + undriven);
    }
    const double way = modes.tremor * complianceOf(modes, modes.toModes(w.row)) + (moves + std::abs(w.speed)) * T;
    w.gap = std::max(w.gap, was - way);
  }
  for (int i = 0; i < static_cast<int>(memory.count) && count < kMostWalls; ++i) {
    Wall w = memory.wall[i];
    if (w.contact >= 0.0) continue;
    // The other contacts of a movable obstacle carry its force. A wall that did not give way would add to it.
    if (w.movable >= 0.0 &&
        std::any_of(walls, walls + frame.contacts.count, [&](const Wall& other) { return other.movable == w.movable; }))
      continue;
    w.speed = w.rest = w.after =
        std::min({0.0, w.speed, w.rest});  // the obstacle is unknown from now on: it only recedes
    const Lane row = modes.toModes(w.row);
    const double soft = complianceOf(modes, row) + w.softness;
    double rate = 0.0, wouldBe = w.gap;
    for (int mode = 0; mode < modes.count; ++mode) {
      rate += row[mode] * modes.rate[mode];
      wouldBe += row[mode] * (modes.law.wouldBe[mode] - modes.now[mode]);
    }
    const double along = std::sqrt(std::max(0.0, moves * moves - rate * rate));
    const double step = modes.tremor * soft + kFades * along * T;
    w.gap += step;
    w.retreated += step;
    if (w.retreated > modes.handStep * soft && wouldBe + step > 0.0) continue;
    walls[count++] = w;
  }
  return count;
}

int placeTargets(const TickFrame& frame, const PredictedModes& modes, const Rebound& rebound, double near, Wall* walls,
                 int count, Target* targets) noexcept {
  int placed = 0;
  for (int i = 0; i < count; ++i) {
    Wall& w = walls[i];
    Target& t = targets[placed];
    w.force = 0.0;
    t.row = modes.toModes(w.row);
    double next = w.gap - w.rest * modes.seconds - w.after * modes.period, gap = w.gap - w.rest * modes.seconds,
           square = 0.0, inverse = 0.0, lead = 0.0;
    for (int k = 0; k < modes.count; ++k) {
      gap += t.row[k] * (modes.law.wouldBe[k] - modes.now[k]);
      next += t.row[k] * (modes.next[k] - modes.now[k]);
      inverse += t.row[k] * t.row[k] / modes.inertia[k];
      const double share = t.row[k] * t.row[k] / modes.law.stiffness[k];
      square += share;
      lead += share * modes.law.lead[k];
    }
    gap -= (w.after - w.rest) * lead / square;
    const double reading = rebound.readingStep(w.row);
    const double most = near + (w.holds != 0.0 ? rebound.distance(modes.handStep, 1.0 / inverse, reading) : 0.0);
    w.holds = square > 0.0 && next <= most ? 1.0 : 0.0;
    if (w.holds == 0.0) continue;
    t.gap = gap - w.rest * lead / square;
    t.size = std::sqrt(square);
    t.reach = t.apart = t.offset = 0.0;
    t.isLayer = false;
    double soft = w.softness;
    if (const int c = static_cast<int>(w.contact); c >= 0) {
      if (frame.yield.isAny) {
        t.reach = std::sqrt(modes.period * lead) / square;
        t.apart = t.reach * t.reach * frame.yield.inverse[c][c];
      }
      if (const Contact& contact = frame.contacts.contacts[c]; contact.compression >= 0.0) {
        t.isLayer = true;
        soft = softness(contact, -t.gap, square * (1.0 + t.apart), modes.period);
      }
    }
    t.compliance = soft / square + t.apart;
    t.doubt = 0.5 * reading + modes.tremor * square;
    t.wall = i;
    ++placed;
  }
  return placed;
}

void contactForces(const TickFrame& frame, const PredictedModes& modes, const Wall* walls, Target* targets, int count,
                   double* force) noexcept {
  if (count == 1) {
    force[0] = std::max(0.0, -targets[0].gap) / (targets[0].size * targets[0].size * (1.0 + targets[0].compliance));
    return;
  }
  // Newton's method for compliant layers, from their compressions at the last tick.
  for (int step = 0; step < kMostTangents; ++step) {
    double error = 0.0;
    for (int i = 0; i < count; ++i) {
      Target& t = targets[i];
      if (!t.isLayer) continue;
      const Contact& contact = frame.contacts.contacts[static_cast<int>(walls[t.wall].contact)];
      const Material& m = contact.material;
      const double square = t.size * t.size, before = contact.compression;
      double x = before;
      if (step > 0)
        x = t.offset + force[i] * square * (t.compliance - t.apart);
      else if (!(before < kNotCompressed))
        x = -t.gap * (t.compliance - t.apart) / (1.0 + t.compliance);  // as if it were alone
      if (x >= m.thickness) x = compressionUnder(m, force[i], before, modes.period);
      x = std::max(kLeastCompression, x);
      const auto [now, slope] = forceOf(m, x, before, modes.period);
      error = std::max(error, step > 0 ? square * std::abs(now - force[i]) + t.gap * kTolerance : 1.0);
      const double soft = std::min(kSoftest, 1.0 / slope);
      t.compliance = t.apart + soft / square;
      t.offset = x - now * soft;
    }
    if (step > 0 && !(error > 0.0)) return;
    solveWalls(frame, modes, walls, targets, count, force);
    if (!(error > 0.0)) return;
  }
}

}  // namespace enamel
