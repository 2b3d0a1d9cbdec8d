#include "enamel/study/stability.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "control/dense.hpp"
#include "core/message.hpp"
#include "enamel/control/margins.hpp"
#include "enamel/core/error.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "render/controlled_modes.hpp"

namespace enamel {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

// The observer at rest under a push against the normal, when its covariance no longer changes; after its prediction.
template <int kMech>
typename PushObserver<kMech>::State atRest(PushObserver<kMech> observer, const ControlledModes& m, const Lane& row,
                                           const LinearCase& c) {
  using Observer = PushObserver<kMech>;
  constexpr int kMostTicks = 20000;
  constexpr double kSteady = 1e-10;
  typename Observer::State s{}, before{};
  for (int k = 0; k < m.count; ++k)  // without a largest step, readings are Gaussian, and the observer is linear
    observer.describe(s, k, m.inertia[k], m.step[k], m.tremor[k],
                      {m.readingVariance[k], 0.0, static_cast<int>(m.joint[k])});
  observer.start(s, m.count, Lane{});
  Lane command{};
  for (int k = 0; k < m.count; ++k) {
    command[k] = s.part[0].x[Observer::kLag][k] = row[k] * c.push;
    s.part[0].x[Observer::kPush][k] = -command[k];
    if (kMech == 4) s.part[0].x[0][k] = command[k] / m.data.drive.stiffness;
  }
  std::memcpy(s.mean, s.part[0].x, sizeof s.mean);
  for (int tick = 0;; ++tick) {
    observer.predict(s, command);
    if (c.jumps) {  // all weight goes to the new hypotheses, as if they were old enough to be merged
      s.weight[0] = std::numeric_limits<double>::min();
      for (int b = 1; b <= kBins; ++b) {
        s.weight[b] = 1.0 / kBins;
        s.age[b] = 1.0;
      }
      observer.merge(s);
    }
    s.count = s.weight[0] = 1.0;
    bool isSteady = true;
    for (int i = 0; i < Observer::kScale; ++i)
      for (int k = 0; k < m.count; ++k) {
        const double now = s.P[Observer::at(i, i)][k];
        isSteady = isSteady && std::abs(now - before.P[Observer::at(i, i)][k]) <= kSteady * now;
      }
    if (isSteady || tick == kMostTicks) return s;
    before = s;
    Lane reading;
    for (int k = 0; k < kLanes; ++k) reading[k] = s.part[0].x[observer.readState()][k];
    observer.correct(s, reading);
    observer.merge(s);
  }
}

// x(t + seconds) = state x(t) + command u, of a mode's rotor, link and motor.
struct Motion {
  MatrixXd state, command;
};

template <int kMech>
Motion motionOf(const Drive& drive, double inertia, double seconds) {
  const ModeMotion<kMech> m = modeMotion<kMech>(drive, inertia, seconds);
  Motion motion{MatrixXd(kMech + 1, kMech + 1), MatrixXd(kMech + 1, 1)};
  for (int i = 0; i <= kMech; ++i) {
    for (int j = 0; j <= kMech; ++j) motion.state(i, j) = m.state[i][j];
    motion.command(i, 0) = m.command[i];
  }
  return motion;
}

// x = state x + command u.
void move(const MatrixXd& state, const MatrixXd& command, const MatrixXd& u, MatrixXd& x) {
  x = product(state, x) + product(command, u);
}

// Orthonormal columns: first a basis of the given ones, then one of the rest.
MatrixXd basisOf(const MatrixXd& columns) { return Eigen::HouseholderQR<MatrixXd>(columns).householderQ(); }

}  // namespace

// The loop at one wall. Its state: mechanical states and motor of each mode at a sample; the observer's states after
// the sample before; forces commanded so far, newest first.
class LinearLoop::Wall {
 public:
  Wall(const ControlledModes& m, const JointVector& normal, const std::vector<LinearCase>& cases);
  MatrixXd matrix(const DeviceErrors& errors, std::size_t index) const;
  const Drive& drive() const noexcept { return data_.drive; }

 private:
  // Observer and law of a mode that the normal's motion contains, as matrices.
  struct Mode {
    double row, inertia;         // of the normal; of the link
    MatrixXd state, command;     // of the observer, a tick later; under a unit force along the normal
    MatrixXd wouldBe;            // a row: of the law
    std::vector<MatrixXd> gain;  // of a reading, in each case
  };

  template <int kMech>
  std::vector<Mode> modesOf(const ControlledModes& m, const Lane& row, const std::vector<LinearCase>& cases);
  MatrixXd alongWall(Index size) const;

  ModeData data_;
  Index mechanical_;         // states of a mode: 4 behind cables, otherwise 2
  int read_ = 0;             // state that encoders read
  double compliance_ = 0.0;  // of the controller along the normal, m/N
  std::vector<Mode> modes_;
};

LinearLoop::Wall::Wall(const ControlledModes& m, const JointVector& normal, const std::vector<LinearCase>& cases)
    : data_(m.data), mechanical_(m.data.drive.stiffness > 0.0 ? 4 : 2) {
  constexpr double kMoves = 1e-9;  // share of the motion of a mode that rounding explains
  Lane row{};
  double most = 0.0;
  for (int k = 0; k < m.count; ++k) {
    for (Index j = 0; j < normal.size(); ++j) row[k] += m.axes[j][k] * normal[j];
    most = std::max(most, row[k] * row[k] / m.inertia[k]);
  }
  for (const Mode& mode : mechanical_ == 4 ? modesOf<4>(m, row, cases) : modesOf<2>(m, row, cases))
    if (mode.row * mode.row / mode.inertia > kMoves * most) modes_.push_back(mode);
}

// Responses of the observer and of the law to each state, to a command, and to a reading.
template <int kMech>
std::vector<LinearLoop::Wall::Mode> LinearLoop::Wall::modesOf(const ControlledModes& m, const Lane& row,
                                                              const std::vector<LinearCase>& cases) {
  using Observer = PushObserver<kMech>;
  constexpr int kSeen = kMech + 3;
  Observer observer({m.data}, m.unseen);
  read_ = observer.readState();
  std::vector<typename Observer::State> rest;
  for (const LinearCase& c : cases) rest.push_back(atRest<kMech>(observer, m, row, c));
  observer.reload(rest.front());
  const Mode none{0.0, 0.0, MatrixXd(kSeen, kSeen), MatrixXd(kSeen, 1), MatrixXd(1, kSeen), {}};
  std::vector<Mode> modes(static_cast<std::size_t>(m.count), none);
  ControlLaw law;
  for (int i = 0; i <= kSeen; ++i) {
    typename Observer::States x = {};
    Lane command{};
    for (int k = 0; k < kLanes; ++k) (i < kSeen ? x[i][k] : command[k]) = i < kSeen ? 1.0 : row[k];
    observer.law(rest.front(), x, nullptr, law);
    observer.advance(command, x);
    for (int k = 0; k < m.count; ++k) {
      Mode& mode = modes[static_cast<std::size_t>(k)];
      for (int j = 0; j < kSeen; ++j) (i < kSeen ? mode.state(j, i) : mode.command(j, 0)) = x[j][k];
      if (i < kSeen) mode.wouldBe(0, i) = law.wouldBe[k];
    }
  }
  for (int k = 0; k < m.count; ++k) {
    Mode& mode = modes[static_cast<std::size_t>(k)];
    mode.row = row[k];
    mode.inertia = m.inertia[k];
    compliance_ += row[k] * row[k] / law.stiffness[k];
  }
  for (typename Observer::State& s : rest) {
    const typename Observer::State before = s;
    Lane reading;
    for (int k = 0; k < kLanes; ++k) reading[k] = s.part[0].x[read_][k] + 1.0;
    observer.correct(s, reading);
    for (int k = 0; k < m.count; ++k) {
      MatrixXd gain(kSeen, 1);
      for (int i = 0; i < kSeen; ++i) gain(i, 0) = s.part[0].x[i][k] - before.part[0].x[i][k];
      modes[static_cast<std::size_t>(k)].gain.push_back(gain);
    }
  }
  return modes;
}

// Motions along the wall at constant speed: they cause no force, so their eigenvalues are 1 with every controller that
// lets the tool slide. Columns: positions, then speeds. Modes differ in the seconds of speed by which the controller
// looks ahead, so the tool slides at a constant height.
MatrixXd LinearLoop::Wall::alongWall(Index size) const {
  const auto n = static_cast<Index>(modes_.size());
  const Index plantStates = mechanical_ + 1, seenStates = mechanical_ + 3;
  MatrixXd row(n, 1), lead = MatrixXd::Zero(n, 1);
  double square = 0.0;
  for (Index k = 0; k < n; ++k) {
    const Mode& mode = modes_[static_cast<std::size_t>(k)];
    row(k, 0) = mode.row;
    square += mode.row * mode.row;
    for (Index i = 1; i < mechanical_; i += 2) lead(k, 0) += mode.wouldBe(0, i);
  }
  const MatrixXd across = basisOf(row);
  MatrixXd motions = MatrixXd::Zero(size, 2 * (n - 1));
  for (Index c = 1; c < n; ++c) {
    double ahead = 0.0;
    for (Index k = 0; k < n; ++k) ahead += row(k, 0) * lead(k, 0) * across(k, c);
    for (Index k = 0; k < n; ++k)
      for (Index i = 0; i < mechanical_; i += 2) {
        const Index plant = k * plantStates + i, seen = n * plantStates + k * seenStates + i;
        const double along = across(k, c), height = -row(k, 0) * ahead / square;
        motions(plant, c - 1) = motions(seen, c - 1) = along;
        motions(plant, n - 2 + c) = height;
        motions(seen, n - 2 + c) = height - data_.period * along;
        motions(plant + 1, n - 2 + c) = motions(seen + 1, n - 2 + c) = along;
      }
  }
  return motions;
}

MatrixXd LinearLoop::Wall::matrix(const DeviceErrors& errors, std::size_t index) const {
  const double late = data_.delayLow + errors.delay, T = data_.period;
  const int whole = static_cast<int>(std::floor(late)), assumed = data_.delayLow;
  const double part = late - whole;
  const auto n = static_cast<Index>(modes_.size());
  const Index plantStates = mechanical_ + 1, seenStates = mechanical_ + 3, seenAt = n * plantStates,
              sentAt = seenAt + n * seenStates, size = sentAt + std::max(assumed + 1, whole + 2);
  const auto sent = [&](int ticks) {  // the force commanded some ticks ago, as a row of the states
    MatrixXd r = MatrixXd::Zero(1, size);
    r(0, sentAt + ticks - 1) = 1.0;
    return r;
  };
  MatrixXd next = MatrixXd::Zero(size, size), force = MatrixXd::Zero(1, size);
  for (Index k = 0; k < n; ++k) {
    const Mode& mode = modes_[static_cast<std::size_t>(k)];
    MatrixXd x = MatrixXd::Zero(seenStates, size);
    x.middleCols(seenAt + k * seenStates, seenStates) = mode.state;
    x += product(mode.command, sent(assumed + 1));
    MatrixXd innovation = -x.middleRows(read_, 1);
    innovation(0, k * plantStates + read_) += 1.0;
    x += product(mode.gain[index], innovation);
    next.middleRows(seenAt + k * seenStates, seenStates) = x;
    for (int d = assumed; d > 0; --d) move(mode.state, mode.command, sent(d), x);
    force -= mode.row / compliance_ * product(mode.wouldBe, x);
  }
  next.middleRows(sentAt, 1) = force;
  for (Index i = sentAt + 1; i < size; ++i) next(i, i - 1) = 1.0;
  Drive drive = data_.drive;
  drive.stiffness *= errors.cable;
  for (Index k = 0; k < n; ++k) {
    const Mode& mode = modes_[static_cast<std::size_t>(k)];
    MatrixXd x = MatrixXd::Zero(plantStates, size);
    for (Index i = 0; i < plantStates; ++i) x(i, k * plantStates + i) = 1.0;
    const auto moveFor = [&](double seconds, const MatrixXd& under) {
      const double inertia = mode.inertia * errors.mass;
      const Motion m = mechanical_ == 4 ? motionOf<4>(drive, inertia, seconds) : motionOf<2>(drive, inertia, seconds);
      move(m.state, m.command, mode.row * under, x);
    };
    if (part > 0.0) moveFor(part * T, sent(whole + 1));
    moveFor((1.0 - part) * T, whole == 0 ? force : sent(whole));
    next.middleRows(k * plantStates, plantStates) = x;
  }
  if (n == 1) return next;
  const MatrixXd motions = alongWall(size), rest = basisOf(motions).rightCols(size - motions.cols());
  return product(rest.transpose(), product(next, rest));
}

LinearLoop::LinearLoop(const DeviceParameters& device, double period, int delay) : delay_(delay) {
  const auto mechanism = makeMechanism(modelFor(plantOf(device), device));
  PositionControlRenderer renderer(positionControlFor(*mechanism, period, delay, delay));
  LoopSetup setup;
  setup.period = period;
  VirtualLoop loop(*mechanism, renderer, setup);
  TickRecord record;
  const auto nothing = [](double, const Pose&, const Vec6&) -> Vec6 { return Vec6::Zero(); };
  require(loop.tick(nothing, record) == Status::ok && record.status == Status::ok,
          "stability: " + mechanism->name() + " cannot rest at home");
  const ControlledModes modes = modesOf(renderer);
  const Kinematics& home = loop.frame().kinematics;
  const JointVector& effort = mechanism->limits().effort;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 normal = Vec3::Unit(axis);
    JointVector row = home.jacobian.topRows<3>().transpose() * normal;
    for (Eigen::Index j = 0; j < row.size(); ++j)
      if (!(effort[j] > 0.0)) row[j] = 0.0;
    const double half = 0.5 * largestForce(home, effort, home.pose.position, normal);
    std::vector<LinearCase> cases;
    for (const bool jumps : {true, false})
      for (const double push : {0.0, modes.handStep, std::max(modes.handStep, half)})
        cases.push_back({normal, push, jumps});
    cases_.insert(cases_.end(), cases.begin(), cases.end());
    walls_.emplace_back(modes, row, cases);
  }
}

LinearLoop::~LinearLoop() = default;
LinearLoop::LinearLoop(LinearLoop&&) noexcept = default;

const Drive& LinearLoop::drive() const noexcept { return walls_.front().drive(); }

MatrixXd LinearLoop::matrix(const DeviceErrors& errors, std::size_t index) const {
  constexpr double kLatest = 16.0;  // ticks
  require(index < cases_.size(),
          "stability: case " + std::to_string(index) + " is unknown, must be below " + std::to_string(cases_.size()));
  for (const double factor : {errors.mass, errors.cable})
    require(factor > 0.0 && std::isfinite(factor),
            "stability: the factor of a mass or a cable is " + formatNumber(factor) + ", must be positive");
  const double late = delay_ + errors.delay;
  require(late >= 0.0 && late <= kLatest,
          "stability: the delay is " + formatNumber(late) + " ticks, must be in 0 to " + formatNumber(kLatest));
  const std::size_t each = cases_.size() / walls_.size();
  return walls_[index / each].matrix(errors, index % each);
}

double LinearLoop::radius(const DeviceErrors& errors, Scope scope) const {
  double largest = 0.0;
  for (std::size_t i = 0; i < cases_.size(); ++i)
    if (scope == Scope::all || !cases_[i].jumps) largest = std::max(largest, spectralRadius(matrix(errors, i)));
  return largest;
}

bool LinearLoop::isStable(const DeviceErrors& errors, Scope scope) const {
  for (std::size_t i = 0; i < cases_.size(); ++i)
    if ((scope == Scope::all || !cases_[i].jumps) && !(spectralRadius(matrix(errors, i)) <= kStableRadius))
      return false;
  return true;
}

StableRange stableRange(const LinearLoop& loop, double DeviceErrors::*error, Scope scope) {
  constexpr double kMost = 5.0, kFactor = 1.05, kTicks = 0.05, kMostTicks = 2.0;
  constexpr int kHalvings = 10;
  const bool isDelay = error == &DeviceErrors::delay;
  const double nominal = DeviceErrors().*error;
  const auto isStable = [&](double value) {
    DeviceErrors errors;
    errors.*error = value;
    return loop.isStable(errors, scope);
  };
  if (!isStable(nominal)) return {nominal, nominal - 1.0};
  const auto end = [&](bool up) {
    const double limit = isDelay ? (up ? kMostTicks : -loop.delay()) : (up ? kMost : 1.0 / kMost);
    double inside = nominal, outside = nominal;
    do {
      inside = outside;
      if (inside == limit) return limit;
      outside = isDelay ? inside + (up ? kTicks : -kTicks) : inside * (up ? kFactor : 1.0 / kFactor);
      if (up == (outside > limit)) outside = limit;
    } while (isStable(outside));
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (inside + outside);
      (isStable(middle) ? inside : outside) = middle;
    }
    return inside;
  };
  return {end(false), end(true)};
}

}  // namespace enamel
