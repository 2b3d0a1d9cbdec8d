#include "enamel/study/stability.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "core/message.hpp"
#include "enamel/control/margins.hpp"
#include "enamel/core/error.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/sim/virtual_loop.hpp"
#include "render/controlled_modes.hpp"
#include "render/exponential.hpp"

namespace enamel {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The loop at one wall, with rotors behind cables or rigid.
class LinearLoop::Loop {
 public:
  virtual ~Loop() = default;
  virtual MatrixXd matrix(const DeviceErrors& errors, std::size_t index) const = 0;
  virtual const Drive& drive() const noexcept = 0;
};

// State of the loop: mechanical states and motor of each mode at a sample; the observer's states after the sample
// before; forces commanded so far, newest first.
template <int kMech>
class LinearLoop::LoopOf final : public LinearLoop::Loop {
 public:
  LoopOf(const ControlledModes& modes, const JointVector& normal, const std::vector<LinearCase>& cases);
  MatrixXd matrix(const DeviceErrors& errors, std::size_t index) const override;
  const Drive& drive() const noexcept override { return data_.drive; }

 private:
  using Observer = PushObserver<kMech>;
  static constexpr int kPlant = kMech + 1, kSeen = kMech + 3, kLink = kMech - 2;

  // The computation of the observer, as matrices. One for each mode that the normal's motion contains.
  struct Mode {
    double row;      // of the normal
    double inertia;  // of the link
    Matrix<kSeen> state;
    Matrix<kSeen, 1> command, wouldBe;
    std::vector<Matrix<kSeen, 1>> gain;  // of a reading, in each case
  };

  typename Observer::State atRest(const ControlledModes& m, Observer observer, const Lane& row,
                                  const LinearCase& c) const;
  std::vector<Mode> modesOf(const ControlledModes& m, Observer& observer, const Lane& row);
  MatrixXd alongWall(Eigen::Index size) const;

  ModeData data_;
  int read_ = 0;             // state that encoders read
  double compliance_ = 0.0;  // of the controller along the normal, m/N
  std::vector<Mode> modes_;
};

template <int kMech>
LinearLoop::LoopOf<kMech>::LoopOf(const ControlledModes& m, const JointVector& normal,
                                  const std::vector<LinearCase>& cases)
    : data_(m.data) {
  constexpr double kMoves = 1e-9;  // share of the motion of a mode that rounding explains
  Lane row{};
  double most = 0.0;
  for (int k = 0; k < m.count; ++k) {
    for (Eigen::Index j = 0; j < normal.size(); ++j) row[k] += m.axes[j][k] * normal[j];
    most = std::max(most, row[k] * row[k] / m.inertia[k]);
  }
  Observer observer(m.data);
  read_ = observer.readState();
  std::vector<typename Observer::State> rest;
  for (const LinearCase& c : cases) rest.push_back(atRest(m, observer, row, c));
  observer.reload(rest.front());
  std::vector<Mode> all = modesOf(m, observer, row);
  for (typename Observer::State& s : rest) {
    const typename Observer::State before = s;
    Lane reading;
    for (int k = 0; k < kLanes; ++k) reading[k] = s.part[0].x[read_][k] + 1.0;
    observer.correct(s, reading);
    for (int k = 0; k < m.count; ++k) {
      Matrix<kSeen, 1> gain;
      for (int i = 0; i < kSeen; ++i) gain[i] = s.part[0].x[i][k] - before.part[0].x[i][k];
      all[static_cast<std::size_t>(k)].gain.push_back(gain);
    }
  }
  for (const Mode& mode : all)
    if (mode.row * mode.row / mode.inertia > kMoves * most) modes_.push_back(mode);
}

// The observer at rest under a push against the normal, when its covariance no longer changes; after its prediction.
template <int kMech>
typename LinearLoop::LoopOf<kMech>::Observer::State LinearLoop::LoopOf<kMech>::atRest(const ControlledModes& m,
                                                                                      Observer observer,
                                                                                      const Lane& row,
                                                                                      const LinearCase& c) const {
  constexpr int kMostTicks = 20000;
  constexpr double kSteady = 1e-10;
  typename Observer::State s{}, before{};
  for (int k = 0; k < m.count; ++k)  // without a largest step, readings are Gaussian, and the observer is linear
    observer.describe(s, k, m.inertia[k], m.step[k], m.tremor[k], {m.readingVariance[k], 0.0});
  observer.start(s, m.count, Lane{});
  Lane command{};
  for (int k = 0; k < m.count; ++k) {
    command[k] = s.part[0].x[Observer::kLag][k] = row[k] * c.push;
    s.part[0].x[Observer::kPush][k] = -command[k];
    if (kMech == 4) s.part[0].x[0][k] = command[k] / data_.drive.stiffness;
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
    for (int k = 0; k < kLanes; ++k) reading[k] = s.part[0].x[read_][k];
    observer.correct(s, reading);
    observer.merge(s);
  }
}

// Responses of the observer and of the law to each state, and to a command.
template <int kMech>
std::vector<typename LinearLoop::LoopOf<kMech>::Mode> LinearLoop::LoopOf<kMech>::modesOf(const ControlledModes& m,
                                                                                         Observer& observer,
                                                                                         const Lane& row) {
  std::vector<Mode> all(static_cast<std::size_t>(m.count));
  typename Observer::Law law;
  for (int i = 0; i <= kSeen; ++i) {
    typename Observer::States x = {};
    Lane command{};
    for (int k = 0; k < kLanes; ++k) (i < kSeen ? x[i][k] : command[k]) = 1.0;
    observer.law(x, m.count, law);
    observer.advance(command, x);
    for (int k = 0; k < m.count; ++k) {
      Mode& mode = all[static_cast<std::size_t>(k)];
      for (int j = 0; j < kSeen; ++j) (i < kSeen ? mode.state(j, i) : mode.command[j]) = x[j][k];
      if (i < kSeen) mode.wouldBe[i] = law.wouldBe[k];
    }
  }
  for (int k = 0; k < m.count; ++k) {
    all[static_cast<std::size_t>(k)].row = row[k];
    all[static_cast<std::size_t>(k)].inertia = m.inertia[k];
    compliance_ += row[k] * row[k] / law.stiffness[k];
  }
  return all;
}

// Motions along the wall at constant speed: they cause no force, so their eigenvalues are 1 with every controller that
// lets the tool slide. Columns: positions, then speeds. Modes differ in the seconds of speed by which the controller
// looks ahead, so the tool slides at a constant height.
template <int kMech>
MatrixXd LinearLoop::LoopOf<kMech>::alongWall(Eigen::Index size) const {
  const auto n = static_cast<Eigen::Index>(modes_.size());
  VectorXd row(n), lead(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Mode& mode = modes_[static_cast<std::size_t>(k)];
    row[k] = mode.row;
    lead[k] = 0.0;
    for (int i = 1; i < kMech; i += 2) lead[k] += mode.wouldBe[i];
  }
  const MatrixXd across = row.householderQr().householderQ() * MatrixXd::Identity(n, n);
  MatrixXd motions = MatrixXd::Zero(size, 2 * (n - 1));
  for (Eigen::Index c = 1; c < n; ++c) {
    const VectorXd along = across.col(c), height = -row * row.cwiseProduct(lead).dot(along) / row.squaredNorm();
    for (Eigen::Index k = 0; k < n; ++k)
      for (int i = 0; i < kMech; i += 2) {
        const Eigen::Index plant = k * kPlant + i, seen = n * kPlant + k * kSeen + i;
        motions(plant, c - 1) = motions(seen, c - 1) = along[k];
        motions(plant, n - 2 + c) = height[k];
        motions(seen, n - 2 + c) = height[k] - data_.period * along[k];
        motions(plant + 1, n - 2 + c) = motions(seen + 1, n - 2 + c) = along[k];
      }
  }
  return motions;
}

template <int kMech>
MatrixXd LinearLoop::LoopOf<kMech>::matrix(const DeviceErrors& errors, std::size_t index) const {
  const double late = data_.delay + errors.delay, T = data_.period;
  const int whole = static_cast<int>(std::floor(late)), assumed = data_.delay;
  const double part = late - whole;
  const auto n = static_cast<Eigen::Index>(modes_.size());
  const Eigen::Index seenAt = n * kPlant, sentAt = seenAt + n * kSeen, size = sentAt + std::max(assumed + 1, whole + 2);
  const auto sent = [&](int ticks) {  // the force commanded some ticks ago, as a row of the states
    Eigen::RowVectorXd r = Eigen::RowVectorXd::Zero(size);
    r[sentAt + ticks - 1] = 1.0;
    return r;
  };
  MatrixXd next = MatrixXd::Zero(size, size);
  Eigen::RowVectorXd force = Eigen::RowVectorXd::Zero(size);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Mode& mode = modes_[static_cast<std::size_t>(k)];
    MatrixXd x = MatrixXd::Zero(kSeen, size);
    x.middleCols(seenAt + k * kSeen, kSeen) = mode.state;
    x += mode.row * mode.command * sent(assumed + 1);
    Eigen::RowVectorXd innovation = -x.row(read_);
    innovation[k * kPlant + read_] += 1.0;
    x += mode.gain[index] * innovation;
    next.middleRows(seenAt + k * kSeen, kSeen) = x;
    for (int d = assumed; d > 0; --d) x = (mode.state * x + mode.row * mode.command * sent(d)).eval();
    force -= mode.row / compliance_ * mode.wouldBe.transpose() * x;
  }
  next.row(sentAt) = force;
  for (Eigen::Index i = sentAt + 1; i < size; ++i) next(i, i - 1) = 1.0;
  Drive drive = data_.drive;
  drive.stiffness *= errors.cable;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Mode& mode = modes_[static_cast<std::size_t>(k)];
    MatrixXd x = MatrixXd::Zero(kPlant, size);
    x.middleCols(k * kPlant, kPlant).setIdentity();
    const auto move = [&](double seconds, const Eigen::RowVectorXd& under) {
      const ModeMotion<kMech> m = modeMotion<kMech>(drive, mode.inertia * errors.mass, seconds);
      const Eigen::Map<const Eigen::Matrix<double, kPlant, kPlant, Eigen::RowMajor>> state(&m.state[0][0]);
      const Eigen::Map<const Matrix<kPlant, 1>> command(m.command);
      x = (state * x + mode.row * command * under).eval();
    };
    if (part > 0.0) move(part * T, sent(whole + 1));
    move((1.0 - part) * T, whole == 0 ? force : sent(whole));
    next.middleRows(k * kPlant, kPlant) = x;
  }
  if (n == 1) return next;
  const MatrixXd motions = alongWall(size);
  const MatrixXd basis = motions.householderQr().householderQ() * MatrixXd::Identity(size, size);
  const MatrixXd rest = basis.rightCols(size - motions.cols());
  return rest.transpose() * next * rest;
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
    if (modes.data.drive.stiffness > 0.0)
      loops_.push_back(std::make_unique<LoopOf<4>>(modes, row, cases));
    else
      loops_.push_back(std::make_unique<LoopOf<2>>(modes, row, cases));
  }
}

LinearLoop::~LinearLoop() = default;
LinearLoop::LinearLoop(LinearLoop&&) noexcept = default;

const Drive& LinearLoop::drive() const noexcept { return loops_.front()->drive(); }

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
  const std::size_t each = cases_.size() / loops_.size();
  return loops_[index / each]->matrix(errors, index % each);
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
  constexpr int kBisections = 10;
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
    for (int i = 0; i < kBisections; ++i) {
      const double middle = 0.5 * (inside + outside);
      (isStable(middle) ? inside : outside) = middle;
    }
    return inside;
  };
  return {end(false), end(true)};
}

}  // namespace enamel
