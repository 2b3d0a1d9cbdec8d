#include "import.hpp"

#include <cmath>
#include <cstdio>

#include "enamel/core/error.hpp"
#include "imported_unit.hpp"

namespace enamel::fmi {
namespace {

/// A mechanism that lives as long as the objects built on it.
struct Owner {
  std::shared_ptr<const Mechanism> mechanism;
};

class UnitPlant final : private Owner, public Plant {
 public:
  UnitPlant(std::shared_ptr<const ImportedUnit> unit, std::shared_ptr<const Mechanism> mechanism)
      : Owner{std::move(mechanism)}, Plant(*Owner::mechanism), unit_(std::move(unit)) {
    open();
  }
  ~UnitPlant() override { close(); }
  UnitPlant(const UnitPlant&) = delete;
  UnitPlant& operator=(const UnitPlant&) = delete;

  /// Throws Error: FMI restores a state only in the instance that saved it.
  [[nodiscard]] std::unique_ptr<Plant> clone() const override {
    throw Error(unit_->path() + ": a plant in another unit cannot be copied");
  }

  [[nodiscard]] enamel::Status start(const Pose& pose) override {
    if (isStarted_) {  // a second start: not every unit can be reset
      close();
      open();
    }
    Kinematics kinematics;
    if (const auto status = rest(pose, kinematics); status != enamel::Status::ok) return status;
    const auto& o = state_.orientation;
    const double orientation[4] = {o.w(), o.x(), o.y(), o.z()};
    require(unit_->enterInitialization(instance_, false, 0.0, 0.0, false, 0.0), "cannot be initialised");
    if (unit_->startPosition.size > 0)
      require(put(unit_->startPosition, pose.position.data()), "refuses its start pose");
    if (unit_->startOrientation.size > 0) require(put(unit_->startOrientation, orientation), "refuses its start pose");
    const JointVector& gravity = kinematics.gravity;
    require(put(unit_->torque, gravity.data()), "refuses a torque");
    require(unit_->exitInitialization(instance_), "cannot be initialised");
    isStarted_ = true;
    if (!look()) fail("has outputs that are not finite");
    const double off = (state_.position - pose.position).norm(),
                 turned = angleBetween(state_.pose().rotation, pose.rotation);
    if (off > 1e-6 || turned > 1e-6)
      fail("begins " + std::to_string(off) + " m and " + std::to_string(turned) +
           " rad away from the start of the push; it needs start_position and start_orientation");
    return enamel::Status::ok;
  }

  [[nodiscard]] enamel::Status advance(double time, double duration, const JointVector& torque,
                                       const ExternalWrench& load) noexcept override {
    if (!unit_->anyStep) {
      if (step_ == 0.0) step_ = duration;
      if (std::abs(duration - step_) > 1e-9 * step_) {
        tell("supports steps of one size only");
        return enamel::Status::outOfRange;
      }
    }
    const Vec6 wrench = load(time, state_.pose(), state_.twist);
    const DeviceState before = state_;
    bool eventNeeded = false, terminated = false, early = false;
    double last = time;
    const bool done =
        put(unit_->torque, torque.data()) == ok && put(unit_->force, wrench.data()) == ok &&
        (unit_->moment.size == 0 || put(unit_->moment, wrench.data() + 3) == ok) &&
        unit_->doStep(instance_, time, duration, true, &eventNeeded, &terminated, &early, &last) <= warning &&
        !terminated && !early && look();
    if (!done) {
      tell(problem_.empty() ? "cannot perform the step" : problem_.c_str());
      state_ = before;
      return enamel::Status::notConverged;
    }
    if (!isWithinSpeedLimits(state_)) {
      state_ = before;
      return enamel::Status::outOfRange;
    }
    return enamel::Status::ok;
  }

  void read(const Kinematics& truth, JointVector& q, JointVector& rates) const noexcept override {
    if (unit_->q.size == 0) return Plant::read(truth, q, rates);
    q = q_;
    rates = rates_;
  }

 private:
  void open() {
    if (unit_->onlyOne && unit_->taken.exchange(true))
      throw Error(unit_->path() + ": can be instantiated only once in a process: use --threads 1");
    instance_ = unit_->instantiate("plant", unit_->token.c_str(), unit_->resources().c_str(), false, false, false,
                                   false, nullptr, 0, this, &UnitPlant::log, nullptr);
    if (instance_ != nullptr) return;
    unit_->taken = false;
    fail("cannot be instantiated");
  }

  static void log(void* environment, Status status, const char*, const char* message) {
    if (status > warning && environment != nullptr && message != nullptr)
      static_cast<UnitPlant*>(environment)->problem_ = message;
  }

  [[noreturn]] void fail(const std::string& what) {
    const std::string reason = problem_.empty() ? "" : ": " + problem_;
    close();
    throw Error(unit_->path() + ": " + what + reason);
  }
  void require(Status status, const char* what) {
    if (status > warning) fail(what);
  }

  // Print why a step failed, because a status cannot contain the reason.
  void tell(const char* reason) const noexcept { std::fprintf(stderr, "%s: %s\n", unit_->path().c_str(), reason); }

  Status put(const FoundVariable& variable, const double* values) const noexcept {
    return unit_->set(instance_, variable.references.data(), variable.references.size(), values, variable.size);
  }
  bool take(const FoundVariable& variable, double* values) const noexcept {
    if (unit_->get(instance_, variable.references.data(), variable.references.size(), values, variable.size) > warning)
      return false;
    for (std::size_t i = 0; i < variable.size; ++i)
      if (!std::isfinite(values[i])) return false;
    return true;
  }

  // Read the unit's state.
  bool look() noexcept {
    DeviceState state;
    if (!take(unit_->position, state.position.data()) || !take(unit_->velocity, state.twist.data())) return false;
    if (unit_->orientation.size > 0) {
      double o[4];
      if (!take(unit_->orientation, o) || !take(unit_->angularVelocity, state.twist.data() + 3)) return false;
      state.orientation = Eigen::Quaternion<double>(o[0], o[1], o[2], o[3]);
      if (!(std::abs(state.orientation.norm() - 1.0) < 1e-6)) return false;
    }
    if (unit_->q.size > 0) {
      q_.resize(static_cast<Eigen::Index>(unit_->q.size));
      rates_.resize(q_.size());
      if (!take(unit_->q, q_.data()) || !take(unit_->rates, rates_.data())) return false;
    }
    state_ = state;
    return true;
  }

  void close() noexcept {
    if (instance_ == nullptr) return;
    if (isStarted_) (void)unit_->terminate(instance_);
    unit_->free(instance_);
    unit_->taken = false;
    instance_ = nullptr;
    isStarted_ = false;
  }

  std::shared_ptr<const ImportedUnit> unit_;
  Instance instance_ = nullptr;
  bool isStarted_ = false;
  double step_ = 0.0;
  std::string problem_;
  JointVector q_, rates_;
};

}  // namespace

std::function<std::unique_ptr<Plant>(std::uint32_t stream)> plantsOf(const std::string& path,
                                                                     const DeviceParameters& device) {
  const std::shared_ptr<const Mechanism> mechanism = makeMechanism(device);
  const auto unit = std::make_shared<const ImportedUnit>(path, *mechanism);
  return [unit, mechanism](std::uint32_t) { return std::make_unique<UnitPlant>(unit, mechanism); };
}

}  // namespace enamel::fmi
