#include "enamel/study/stability.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstring>
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

// The loop, with rotors behind cables or rigid.
class LinearLoop::Loop {
 public:
  virtual ~Loop() = default;
  virtual MatrixXd matrix(const DeviceErrors& errors, std::size_t push) const = 0;
  std::vector<double> pushes;  // N
  int delay = 0;               // assumed, ticks
};

// State of the loop: mechanical states and motor of each mode at a sample; the observer's states after the sample
// before; forces commanded so far, newest first.
template <int kMech>
class LinearLoop::LoopOf final : public LinearLoop::Loop {
 public:
  LoopOf(const ControlledModes& modes, const JointVector& normal, double largest);
  MatrixXd matrix(const DeviceErrors& errors, std::size_t push) const override;

 private:
  using Observer = PushObserver<kMech>;
  static constexpr int kPlant = kMech + 1, kSeen = kMech + 3, kLink = kMech - 2;

  // What the observer computes, as matrices. One for each mode that the normal's motion contains.
  struct Mode {
    double row;      // of the normal
    double inertia;  // of the link
    Matrix<kSeen> state;
    Matrix<kSeen, 1> command, wouldBe;
    std::vector<Matrix<kSeen, 1>> gain;  // of a reading, under each push
  };

  typename Observer::State atRest(const ControlledModes& m, const Observer& observer, const Lane& row,
                                  double force) const;
  void linearise(const ControlledModes& m, Observer& observer, const Lane& row);
  MatrixXd alongWall(Eigen::Index size) const;

  ModeData data_;
  int read_ = 0;  // state that encoders read
  double compliance_ = 0.0;  // of the controller along the normal, m/N
  std::vector<Mode> modes_;
};

template <int kMech>
LinearLoop::LoopOf<kMech>::LoopOf(const ControlledModes& m, const JointVector& normal, double largest) : data_(m.data) {
  constexpr double kVisible = 1e-9;  // motions that a force along the normal does not cause, as a share
  delay = m.data.delay;
  pushes = {0.0, m.handStep, 0.5 * largest};
  Lane row{};
  for (Eigen::Index j = 0; j < normal.size(); ++j)
    for (int k = 0; k < m.count; ++k) row[k] += m.axes[j][k] * normal[j];
  Observer observer(m.data);
  read_ = observer.readState();
  double size = 0.0;
  for (int k = 0; k < m.count; ++k) size = std::max(size, row[k] * row[k] / m.inertia[k]);
  for (int k = 0; k < m.count; ++k) {
    if (row[k] * row[k] / m.inertia[k] < kVisible * size) row[k] = 0.0;
  }
  linearise(m, observer, row);
}

// The observer at rest under a push against the normal, when its covariance no longer changes; after its prediction.
template <int kMech>
typename LinearLoop::LoopOf<kMech>::Observer::State LinearLoop::LoopOf<kMech>::atRest(
    const ControlledModes& m, const Observer& observer, const Lane& row, double force) const {
  constexpr int kMostTicks = 20000;
  constexpr double kSteady = 1e-10;
  typename Observer::State s{};
  for (int k = 0; k < m.count; ++k)  // without a largest step, readings are Gaussian, and the observer is linear
    observer.describe(s, k, m.inertia[k], m.step[k], m.tremor[k], {m.readingVariance[k], 0.0});
  Observer mine = observer;
  mine.start(s, m.count, Lane{});
  Lane command{};
  for (int k = 0; k < m.count; ++k) {
    const double push = -row[k] * force;
    command[k] = s.part[0].x[Observer::kLag][k] = -push;
    s.part[0].x[Observer::kPush][k] = push;
    if (kMech == 4) s.part[0].x[0][k] = -push / data_.drive.stiffness;
  }
  std::memcpy(s.mean, s.part[0].x, sizeof s.mean);
  const auto one = [&s] {  // the hypothesis without a jump
    s.count = s.weight[0] = 1.0;
  };
  typename Observer::State before = s;
  for (int i = 0;; ++i) {
    mine.predict(s, command);
    one();
    bool isSteady = true;
    for (int k = 0; k < m.count; ++k)
      for (int j = 0; j < Observer::kScale; ++j) {
        const double now = s.P[Observer::at(j, j)][k];
        isSteady = isSteady && std::abs(now - before.P[Observer::at(j, j)][k]) <= kSteady * now;
      }
    if (isSteady || i == kMostTicks) break;
    before = s;
    Lane reading;
    for (int k = 0; k < kLanes; ++k) reading[k] = s.part[0].x[read_][k];
    mine.correct(s, reading);
    mine.merge(s);
  }
  return s;
}

template <int kMech>
void LinearLoop::LoopOf<kMech>::linearise(const ControlledModes& m, Observer& observer, const Lane& row) {
  std::vector<typename Observer::State> rest;
  for (const double force : pushes) rest.push_back(atRest(m, observer, row, force));
  observer.reload(rest.front());
  std::vector<Mode> all(static_cast<std::size_t>(m.count));
  Lane ones;
  ones.fill(1.0);
  typename Observer::Law law;
  const auto unit = [&](int i, auto& x) {
    std::memset(x, 0, sizeof x);
    if (i < kSeen)
      for (double& number : x[i]) number = 1.0;
  };
  for (int i = 0; i <= kSeen; ++i) {  // responses to each state, then to a command
    typename Observer::States x;
    unit(i, x);
    observer.law(x, m.count, law);
    observer.advance(i == kSeen ? ones : Lane{}, x);
    for (int k = 0; k < m.count; ++k) {
      Mode& mode = all[static_cast<std::size_t>(k)];
      for (int j = 0; j < kSeen; ++j) (i == kSeen ? mode.command[j] : mode.state(j, i)) = x[j][k];
      if (i < kSeen) mode.wouldBe[i] = law.wouldBe[k];
    }
  }
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
  for (int k = 0; k < m.count; ++k) {
    Mode& mode = all[static_cast<std::size_t>(k)];
    mode.row = row[k];
    mode.inertia = m.inertia[k];
    compliance_ += row[k] * row[k] / law.stiffness[k];
    if (row[k] != 0.0) modes_.push_back(mode);
  }
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
MatrixXd LinearLoop::LoopOf<kMech>::matrix(const DeviceErrors& errors, std::size_t push) const {
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
    x += mode.gain[push] * innovation;
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

LinearLoop::LinearLoop(const DeviceParameters& device, double period, int delay, const Vec3& normal) {
  const auto mechanism = makeMechanism(modelFor(plantOf(device), device));
  PositionControlRenderer renderer(positionControlFor(*mechanism, period, delay, delay));
  LoopSetup setup;
  setup.period = period;
  VirtualLoop loop(*mechanism, renderer, setup);
  TickRecord record;
  require(loop.tick([](double, const Pose&, const Vec6&) { return Vec6(Vec6::Zero()); }, record) == Status::ok &&
              record.status == Status::ok,
          "stability: " + mechanism->name() + " cannot rest at home");
  const Kinematics& home = loop.frame().kinematics;
  JointVector row = home.jacobian.topRows<3>().transpose() * normal;
  const JointVector& effort = mechanism->limits().effort;
  for (Eigen::Index j = 0; j < row.size(); ++j)
    if (!(effort[j] > 0.0)) row[j] = 0.0;
  const double largest = largestForce(home, effort, home.pose.position, normal);
  const ControlledModes modes = modesOf(renderer);
  if (modes.data.drive.stiffness > 0.0)
    loop_ = std::make_unique<LoopOf<4>>(modes, row, largest);
  else
    loop_ = std::make_unique<LoopOf<2>>(modes, row, largest);
}

LinearLoop::~LinearLoop() = default;
LinearLoop::LinearLoop(LinearLoop&&) noexcept = default;

const std::vector<double>& LinearLoop::pushes() const noexcept { return loop_->pushes; }

MatrixXd LinearLoop::matrix(const DeviceErrors& errors, std::size_t push) const {
  require(push < pushes().size(), "stability: there is no push " + std::to_string(push));
  const auto check = [](const char* name, double value, bool isGood, const char* limit) {
    require(isGood && std::isfinite(value),
            std::string("stability: the ") + name + " is " + formatNumber(value) + ", must be " + limit);
  };
  check("factor of the mass", errors.mass, errors.mass > 0.0, "positive");
  check("factor of the cable stiffness", errors.cable, errors.cable > 0.0, "positive");
  check("delay", loop_->delay + errors.delay, loop_->delay + errors.delay >= 0.0, "zero or positive");
  return loop_->matrix(errors, push);
}

double LinearLoop::radius(const DeviceErrors& errors) const {
  double largest = 0.0;
  for (std::size_t i = 0; i < pushes().size(); ++i) largest = std::max(largest, spectralRadius(matrix(errors, i)));
  return largest;
}

}  // namespace enamel
