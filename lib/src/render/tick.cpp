#include "enamel/render/tick.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "enamel/render/roughness.hpp"

namespace enamel {
namespace {

constexpr double kLongestStep = 0.1;  // s, of movable obstacles between two samples
constexpr double kLeastStep = 1e-3;   // periods, of a tick whose sample is older than the prediction before it

// The start of forward kinematics. The inertia is computed again.
template <typename AnyKinematics, typename Visit>
void forEachMatrix(AnyKinematics& k, const Visit& visit) {
  visit(k.pose.position);
  visit(k.pose.rotation);
  visit(k.twist);
  visit(k.q);
  visit(k.rates);
  visit(k.gravity);
  visit(k.jacobian);
  visit(k.inverseTransposed);
}

// Size of a saved frame, with the last command, the sample's time and age, the tick's time, and the guard's reason.
std::size_t frameSize(int joints) noexcept { return 18 + 16 * static_cast<std::size_t>(joints) + 4; }

}  // namespace

HapticTick::HapticTick(const Mechanism& mechanism, const Scene& scene, const Tool& tool, Renderer& renderer,
                       const GuardOptions& guard, const Pose& start)
    : mechanism_(mechanism),
      scene_(scene, tool),
      renderer_(&renderer),
      guard_(mechanism, guard),
      guidance_(mechanism, guard.period) {
  placeAt(start);
  frame_.maxTorque = guard.on ? guard.torque : mechanism.limits().effort;
  frame_.output.torque.setZero(mechanism.joints());
  renderer.activate(guard.period);
}

Status HapticTick::operator()(const Measurement& measurement, Command& command) noexcept {
  const bool isNext = measurement.age == 0 && measurement.time > sampleTime_ && measurement.time > frame_.time;
  const Status status = isNext ? tick(measurement) : tick(adjusted(measurement));
  if (measurement.age == 0 && sampleTime_ != kNever) sampleTime_ = measurement.time;  // also if it was moved
  command.effort = frame_.command;
  command.gripper = guard_.fault() == GuardReason::none ? guard_.weight() * gripper_ : 0.0;
  return status;
}

// A sample that repeats its time stamp counts as lost while the guard bridges lost samples. A sample that is older than
// the prediction before it is moved to shortly after it. A lost one then follows by a period.
Measurement HapticTick::adjusted(const Measurement& measurement) const noexcept {
  const double period = guard_.options().period;
  Measurement m = measurement;
  const bool isBridged = guard_.fault() == GuardReason::none && frame_.age < guard_.options().longestGap;
  const bool isRepeated = m.age == 0 && m.time == sampleTime_ && isBridged;
  if (isRepeated) m.age = frame_.age + 1;
  const bool isNewer = m.time > sampleTime_ && (sampleTime_ != kNever || frame_.age > 0);
  if ((isRepeated || isNewer) && m.time < frame_.time + kLeastStep * period)
    m.time = frame_.time + (m.age > 0 ? 1.0 : kLeastStep) * period;
  if (m.age > 0) {  // no sample from the device
    m.q = frame_.kinematics.q;
    m.rates = frame_.kinematics.rates;
    m.applied.reset();
  }
  return m;
}

// The stages, one per line. They pass the frame along.
Status HapticTick::tick(const Measurement& measurement) noexcept {
  const int lost = frame_.age;  // periods without a sample before this tick
  const bool isSample = measurement.age == 0;
  const double elapsed = sampleTime_ == kNever ? 0.0 : std::min(measurement.time - sampleTime_, kLongestStep);
  Status status = sense(measurement);
  if (status == Status::ok && isSample) status = findContacts(measurement.time, elapsed);
  if (status == Status::ok && isSample && needsInertia()) status = fillContactRows(frame_);
  status = render(status);
  guard_.step(measurement, status, frame_);
  if (scene_.hasTaps() && status == Status::ok) tap_.sent(frame_);
  if (hasGuides()) guidance_.sent(status == Status::ok ? share() : 0.0);
  const bool isStopped = guard_.fault() != GuardReason::none;
  scene_.motion().scaleForces(status == Status::ok ? frame_.age / (frame_.age + 1.0) : 0.0);
  if (status == Status::ok && frame_.yield.isAny) react();
  if (status == Status::ok) scene_.compliance().press(frame_.output, guard_.options().period, frame_.contacts);
  if (status == Status::ok && isSample) cut((1 + lost) * guard_.options().period, isStopped);
  if (guard_.options().on && !isStopped && !guard_.engaged()) {
    renderer_->reset();
    tap_.reset();
    guidance_.reset();
  }
  return status == Status::ok && isStopped ? Status::stopped : status;
}

Status HapticTick::sense(const Measurement& m) noexcept {
  const bool isSample = m.age == 0;
  if (!isSample && sampleTime_ == kNever) return Status::stale;
  if (isSample) {
    sampleTime_ = kNever;  // until the configuration is known
    const Status status = mechanism_.track(m.q, m.rates, needsInertia(), frame_.kinematics);
    if (status != Status::ok) return status;
  }
  frame_.time = m.time;
  frame_.age = m.age;
  frame_.applied.reset();
  if (m.applied && m.applied->size() == mechanism_.joints() && guard_.believes(*m.applied)) frame_.applied = m.applied;
  return Status::ok;
}

Status HapticTick::findContacts(double time, double elapsed) noexcept {
  const Status status = scene_.findContacts(frame_.kinematics.pose, time, elapsed, bur(),
                                            drill_ == nullptr ? 0.0 : drill_->recession(), frame_.contacts);
  if (status != Status::ok) return status;
  if (scene_.isRough())  // a bur removes what it would feel
    roughen(scene_.scene(), scene_.tool(), frame_.kinematics, mechanism_.limits().encoderStep, guard_.options().period,
            bur(), frame_.contacts);
  if (const double scale = mechanism_.scale(); scale != 1.0)  // materials are stated for forces at the hand
    for (int i = 0; i < frame_.contacts.count; ++i) {
      scaleForces(frame_.contacts.contacts[i].material, 1.0 / scale);
      frame_.contacts.contacts[i].grip /= scale;
    }
  if (drill_ != nullptr) {
    drill_->vibrate(frame_.kinematics.pose, guard_.options().period, frame_.contacts);
    drill_->correct(frame_.contacts);
  }
  scene_.motion().yieldAt(frame_.contacts, guard_.options().period, mechanism_.scale(), frame_.yield);
  sampleTime_ = time;
  return Status::ok;
}

Status HapticTick::render(Status status) noexcept {
  added_ = effect_;
  frame_.guide.resize(0);
  if (status == Status::ok && hasGuides()) {
    Vec6 wrench = Vec6::Zero();
    wrench.head<3>() = guidance_.step(*scene_.scene().guides(), frame_);
    frame_.guide = torqueOf(frame_.kinematics.jacobian, wrench);
    added_ += wrench;
  }
  if (status == Status::ok) {
    if (scene_.hasTaps())
      tap_.move(frame_, scene_.scene(), renderer_->delay(), guard_.options().period, mechanism_.limits());
    status = renderer_->step(frame_, frame_.output);
    if (scene_.hasTaps()) tap_.push(frame_);
  } else {
    frame_.output = TickOutput{};
    frame_.output.torque.setZero(mechanism_.joints());
  }
  if (status == Status::ok && !added_.isZero(0.0)) frame_.output.torque += torqueOf(frame_.kinematics.jacobian, added_);
  return status;
}

// Share of the rendered torque that the guard lets pass.
double HapticTick::share() const noexcept {
  const JointVector &gravity = frame_.kinematics.gravity, rendered = frame_.output.torque - gravity,
                    commanded = frame_.command - gravity;
  const double square = rendered.squaredNorm();
  return square > 0.0 ? commanded.dot(rendered) / square : 0.0;
}

// Force of the command on the tool, without effect and guides, W, N.
Vec3 HapticTick::wallForce() const noexcept {
  const Kinematics& k = frame_.kinematics;
  const Vec3 force = wrenchOf(k, frame_.command - k.gravity).head<3>();
  return added_.isZero(0.0) ? force : Vec3(force - share() * added_.head<3>());
}

// The force of the walls on the tool acts on the obstacles. The renderer's forces say how it divides
// between the contacts. Ticks without a sample count until the next sample, by their mean.
void HapticTick::react() noexcept {
  const TickOutput& output = frame_.output;
  Vec3 rest = wallForce();  // not yet given to a contact
  double sum = 0.0;
  for (int i = 0; i < frame_.contacts.count; ++i) {
    sum += output.normalForces[static_cast<std::size_t>(i)];
    rest -=
        output.normalForces[static_cast<std::size_t>(i)] * frame_.contacts.contacts[static_cast<std::size_t>(i)].normal;
  }
  SceneMotion& motion = scene_.motion();
  const double share = 1.0 / (frame_.age + 1);
  if (output.mode != RenderMode::contact) return;
  for (int i = 0; i < frame_.contacts.count; ++i) {
    const Contact& contact = frame_.contacts.contacts[static_cast<std::size_t>(i)];
    const double force = output.normalForces[static_cast<std::size_t>(i)];
    const double part = sum > 0.0 ? force / sum : i == 0 ? 1.0 : 0.0;
    motion.push(contact.obstacle, contact.point, -share * mechanism_.scale() * (force * contact.normal + part * rest));
  }
  if (drill_ == nullptr || frame_.age > 0) return;
  for (int i = 0; i < frame_.contacts.count; ++i) {
    const Contact& contact = frame_.contacts.contacts[static_cast<std::size_t>(i)];
    if (!drill_->parts().has(contact.part) || contact.obstacle != drill_->obstacle()) continue;
    return motion.hold(contact.obstacle, contact.point, contact.normal, drill_->hold(), guard_.options().period);
  }
}

// A stopped loop does not hold the tool. Material that the tool then passes through remains.
void HapticTick::cut(double elapsed, bool isStopped) noexcept {
  if (drill_ == nullptr) return;
  if (isStopped) return drill_->lift();
  Vec3 force = Vec3::Zero();  // of the wall on the tool, W, N
  if (frame_.output.mode == RenderMode::contact) force = mechanism_.scale() * wallForce();
  drill_->cut(scene_.scene(), frame_.kinematics.pose, force, elapsed, frame_.contacts);
}

void HapticTick::placeAt(const Pose& start) noexcept {
  frame_.kinematics = Kinematics();
  if (!isRotation(start.rotation) || mechanism_.reach(start, Vec6::Zero(), false, frame_.kinematics) != Status::ok)
    frame_.kinematics = mechanism_.home();
}

void HapticTick::exchange(TickScene& other) noexcept {
  other.takeOver(scene_);
  if (other.scene().guides() != scene_.scene().guides()) {
    guidance_.reset();
    frame_.guided.setZero();
  }
  if (!other.hasTaps()) {
    tap_.reset();
    frame_.added = JointVector();
  }
  std::swap(scene_, other);
}

void HapticTick::select(Renderer& renderer) noexcept {
  renderer_ = &renderer;
  renderer_->reset();
}

void HapticTick::reset() noexcept {
  guard_.reset();
  renderer_->reset();
  scene_.reset();
  tap_.reset();
  guidance_.reset();
  sampleTime_ = kNever;
  frame_.age = 0;  // the time may begin again at 0
}

void HapticTick::restart(const Pose& start) noexcept {
  guard_.restart();
  renderer_->reset();
  tap_.reset();
  guidance_.reset();
  sampleTime_ = kNever;
  placeAt(start);
  scene_.reset();
  scene_.forgetPath();
  frame_.output = TickOutput{};
  frame_.output.torque.setZero(mechanism_.joints());
  frame_.command = JointVector();
  frame_.reason = GuardReason::none;
}

std::size_t HapticTick::numbers() const noexcept {
  return frameSize(mechanism_.joints()) + scene_.stateSize() + (scene_.hasTaps() ? TapTransient::kNumbers : 0) +
         (hasGuides() ? Guidance::kNumbers : 0) + Guard::stateSize();
}

void HapticTick::saveState(void* state) const noexcept {
  double* at = static_cast<double*>(state);
  forEachMatrix(frame_.kinematics, [&at](const auto& matrix) { at = std::copy_n(matrix.data(), matrix.size(), at); });
  std::fill_n(at, mechanism_.joints(), 0.0);
  std::copy_n(frame_.command.data(), frame_.command.size(), at);
  at += mechanism_.joints();
  for (const double number :
       {sampleTime_, frame_.time, static_cast<double>(frame_.age), static_cast<double>(frame_.reason)})
    *at++ = number;
  scene_.saveState(at);
  at += scene_.stateSize();
  if (scene_.hasTaps()) {
    tap_.saveState(at);
    at += TapTransient::kNumbers;
  }
  if (hasGuides()) {
    guidance_.saveState(at);
    at += Guidance::kNumbers;
  }
  guard_.saveState(at);
  renderer_->saveState(at + Guard::stateSize());
}

void HapticTick::loadState(const void* state) noexcept {
  const double* at = static_cast<const double*>(state);
  const double* const reason = at + frameSize(mechanism_.joints()) - 1;
  bool isSound = isRotation(Eigen::Map<const Mat3>(at + 3)) && *reason >= 0.0 &&
                 *reason < static_cast<double>(kGuardReasons) && *reason == std::floor(*reason);
  for (const double* number = at; number < reason; ++number) isSound = isSound && std::isfinite(*number);
  if (!isSound) {
    reset();
    return;
  }
  forEachMatrix(frame_.kinematics, [&at](auto& matrix) {
    std::copy_n(at, matrix.size(), matrix.data());
    at += matrix.size();
  });
  frame_.command = Eigen::Map<const JointVector>(at, mechanism_.joints());
  sampleTime_ = reason[-3];
  frame_.time = reason[-2];
  frame_.age = static_cast<int>(std::clamp(reason[-1], 0.0, 1e6));
  frame_.reason = static_cast<GuardReason>(*reason);
  at = reason + 1;
  scene_.loadState(at);
  at += scene_.stateSize();
  if (scene_.hasTaps()) {
    tap_.loadState(at);
    at += TapTransient::kNumbers;
  }
  if (hasGuides()) {
    guidance_.loadState(at);
    at += Guidance::kNumbers;
  }
  guard_.loadState(at);
  renderer_->loadState(at + Guard::stateSize());
}

}  // namespace enamel
