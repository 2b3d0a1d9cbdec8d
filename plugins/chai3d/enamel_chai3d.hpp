// Connects CHAI3D (chai3d.org, 3.2 or 3.3) and Enamel. A tool of a CHAI3D world takes its force from an Enamel
// renderer, and any device of CHAI3D becomes a HapticDevice. A program that includes this file links enamel::runtime
// and CHAI3D.
//
// SI units. In CHAI3D's device frame x points towards the user, y right, z up. In W, x points right, y up, z towards
// the user. The axes are the same in another order, so that vectors change frames without rounding.
#pragma once

#include <chai3d.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "enamel/core/error.hpp"
#include "enamel/device/cartesian/parameters.hpp"
#include "enamel/runtime/haptic_loop.hpp"

namespace enamel {

/// Convert vectors and rotations between the axes of CHAI3D and those of W. Realtime: yes.
inline Vec3 fromChai3d(const chai3d::cVector3d& v) noexcept { return {v(1), v(2), v(0)}; }
inline chai3d::cVector3d toChai3d(const Vec3& v) noexcept { return {v[2], v[0], v[1]}; }
inline Mat3 fromChai3d(const chai3d::cMatrix3d& m) noexcept {
  Mat3 result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) result(i, j) = m((i + 1) % 3, (j + 1) % 3);
  return result;
}
inline chai3d::cMatrix3d toChai3d(const Mat3& m) noexcept {
  chai3d::cMatrix3d result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) result((i + 1) % 3, (j + 1) % 3) = m(i, j);
  return result;
}

/// Return the motion from one pose to another, m and rad. Realtime: yes.
inline Vec6 motionBetween(const Pose& from, const Pose& to) noexcept {
  Vec6 motion;
  motion << to.position - from.position, rotationVector(to.rotation * from.rotation.transpose());
  return motion;
}

/// Return the Cartesian device with 3 axes that CHAI3D's specifications describe. They lack the apparent mass at the
/// tip (kg) and the smallest difference of positions (m). The workspace is a cuboid whose half widths are twice
/// m_workspaceRadius: that is the radius of a sphere inside the real workspace. For 6 axes, set axes = 6, inertia and
/// angleStep. Realtime: no.
inline CartesianParameters cartesianFor(const chai3d::cHapticDeviceInfo& specifications, double mass,
                                        double positionStep) {
  CartesianParameters parameters;
  parameters.name = specifications.m_modelName;
  parameters.mass = mass;
  parameters.positionStep = positionStep;
  parameters.halfWidths.setConstant(2.0 * specifications.m_workspaceRadius);
  parameters.maxForce = specifications.m_maxLinearForce;
  parameters.maxMoment = specifications.m_maxAngularTorque;
  return parameters;
}

struct Chai3dOptions {
  /// Cutoff of the low pass that turns differences of poses into rates, Hz. 0: use CHAI3D's getLinearVelocity() and
  /// getAngularVelocity(), for drivers whose rates are better than CHAI3D's means over 15 and 30 ms.
  double cutoff = 100.0;
  int enableSwitch = -1;          ///< user switch that must be held, 0 to 31; -1: none
  std::function<double()> clock;  ///< s, must advance; empty: std::chrono::steady_clock. Realtime: yes
};

/// A device that CHAI3D drives. Its workspace is the device's own, in metres, without scale or tool. CHAI3D's drivers
/// must not throw in a tick. For one thread at a time.
class Chai3dDevice final : public HapticDevice {
 public:
  /// `mechanism`: with 3 or 6 joints (kind cartesian); must outlive the device. Throws Error: `device` is null; the
  /// device senses or moves fewer axes than the mechanism has; another number of joints; a negative or non-finite
  /// cutoff; an invalid switch.
  Chai3dDevice(chai3d::cGenericHapticDevicePtr device, const Mechanism& mechanism, Chai3dOptions options = {})
      : device_(std::move(device)), mechanism_(mechanism), options_(std::move(options)), kinematics_(mechanism.home()) {
    if (device_ == nullptr) throw Error("chai3d: the haptic device is missing");
    specifications_ = device_->getSpecifications();
    const int joints = mechanism.joints();
    if (joints != 3 && joints != 6)
      throw Error("chai3d: \"" + mechanism.name() + "\" has " + std::to_string(joints) + " joints, must have 3 or 6");
    const chai3d::cHapticDeviceInfo& s = specifications_;
    if (!s.m_sensedPosition || !s.m_actuatedPosition || (joints == 6 && !(s.m_sensedRotation && s.m_actuatedRotation)))
      throw Error("chai3d: \"" + s.m_modelName + "\" must sense and drive the " + std::to_string(joints) +
                  " axes of \"" + mechanism.name() + "\"");
    if (!(options_.cutoff >= 0.0 && std::isfinite(options_.cutoff)))
      throw Error("chai3d: the cutoff is " + std::to_string(options_.cutoff) + " Hz, must be finite and at least 0 Hz");
    if (options_.enableSwitch < -1 || options_.enableSwitch > 31)
      throw Error("chai3d: the enabling switch is " + std::to_string(options_.enableSwitch) + ", must be in -1 to 31");
  }
  ~Chai3dDevice() override { close(); }
  Chai3dDevice(const Chai3dDevice&) = delete;
  Chai3dDevice& operator=(const Chai3dDevice&) = delete;

  /// Open and calibrate the device. Throws Error: CHAI3D cannot open or calibrate it. Realtime: no.
  void open() override {
    if (opened_) return;
    if (!device_->open()) throw Error("chai3d: \"" + specifications_.m_modelName + "\" cannot be opened");
    opened_ = true;
    if (!device_->calibrate(false)) {
      close();
      throw Error("chai3d: \"" + specifications_.m_modelName + "\" cannot be calibrated");
    }
    specifications_ = device_->getSpecifications();  // some drivers know them only after opening
    started_ = false;
  }

  void close() noexcept override {
    if (!std::exchange(opened_, false)) return;
    send(chai3d::cVector3d(0.0, 0.0, 0.0), chai3d::cVector3d(0.0, 0.0, 0.0));
    device_->close();
  }

  /// Measure the pose. Statuses other than ok:
  /// - inactive: CHAI3D has not opened the device;
  /// - stale: it gave no pose, or time did not advance;
  /// - notFinite: time, pose or rates;
  /// - outOfRange: the rotation is not a rotation;
  /// - unreachable: outside the mechanism's workspace.
  /// The time is always set. All other members keep their values unless the status is ok. Realtime: yes, if CHAI3D's
  /// driver is.
  [[nodiscard]] Status measure(Measurement& measurement) noexcept override {
    const double last = time_;
    const double time = options_.clock ? options_.clock() : steady();
    measurement.time = time;
    if (!device_->isDeviceReady()) return Status::inactive;
    if (!std::isfinite(time)) return Status::notFinite;
    if (started_ && time <= last) return Status::stale;
    Pose pose;
    Vec6 twist;
    if (const Status status = read(time - last, pose, twist); status != Status::ok) return status;
    if (const Status status = mechanism_.reach(pose, twist, false, kinematics_); status != Status::ok) return status;
    time_ = time;
    started_ = true;
    measurement.q = kinematics_.q;
    measurement.rates = kinematics_.rates;
    measurement.applied.reset();  // CHAI3D's getForce() returns the sent force, not the acting one
    measurement.enabled = options_.enableSwitch < 0 || ((switches_ >> options_.enableSwitch) & 1U) != 0;
    return Status::ok;
  }

  /// Send the wrench of the command at the last measured pose. It is scaled down to m_maxLinearForce and
  /// m_maxAngularTorque; its direction is kept. Statuses other than ok:
  /// - inactive: CHAI3D has not opened the device;
  /// - outOfRange: the number of torques is not the number of joints; the motors are switched off;
  /// - notFinite: the motors are switched off;
  /// - stale: CHAI3D could not send it.
  /// Realtime: yes, if CHAI3D's driver is.
  [[nodiscard]] Status actuate(const Command& command) noexcept override {
    chai3d::cVector3d force, moment;
    const Status status = wrenchOf(command, force, moment);
    if (!device_->isDeviceReady()) return Status::inactive;
    if (!send(force, moment)) return Status::stale;
    return status;
  }

  /// Compute the wrench that actuate() sends, N and N m, in the axes of CHAI3D; zero unless the status is ok. Realtime:
  /// yes.
  [[nodiscard]] Status wrenchOf(const Command& command, chai3d::cVector3d& force,
                                chai3d::cVector3d& moment) const noexcept {
    const bool fits = command.effort.size() == mechanism_.joints();
    const bool isFinite = fits && command.effort.allFinite();
    Vec6 wrench = isFinite ? enamel::wrenchOf(kinematics_, command.effort) : Vec6(Vec6::Zero());
    if (mechanism_.joints() < 6) wrench.tail<3>().setZero();
    force = toChai3d(limited(wrench.head<3>(), specifications_.m_maxLinearForce));
    moment = toChai3d(limited(wrench.tail<3>(), specifications_.m_maxAngularTorque));
    return isFinite ? Status::ok : fits ? Status::notFinite : Status::outOfRange;
  }

  /// Kinematics at the last measurement with status ok; then the user switches, one bit each. Realtime: yes.
  const Kinematics& kinematics() const noexcept { return kinematics_; }
  unsigned int switches() const noexcept { return switches_; }

  const chai3d::cHapticDeviceInfo& specifications() const noexcept { return specifications_; }

 private:
  static double steady() noexcept {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
  }
  static Vec3 limited(const Vec3& v, double limit) noexcept {
    const double length = v.norm();
    if (length <= limit) return v;
    return limit > 0.0 ? Vec3(v * (limit / length)) : Vec3(Vec3::Zero());
  }

  bool send(const chai3d::cVector3d& force, const chai3d::cVector3d& moment) noexcept {
    return device_->setForceAndTorqueAndGripperForce(force, moment, 0.0);
  }

  Status read(double passed, Pose& pose, Vec6& twist) noexcept {
    const bool turns = mechanism_.joints() == 6;
    chai3d::cVector3d position(0.0, 0.0, 0.0), speed(0.0, 0.0, 0.0), turning(0.0, 0.0, 0.0);
    chai3d::cMatrix3d rotation;
    rotation.identity();
    if (!device_->getPosition(position) || (turns && !device_->getRotation(rotation))) return Status::stale;
    if (options_.cutoff == 0.0)
      if (!device_->getLinearVelocity(speed) || (turns && !device_->getAngularVelocity(turning))) return Status::stale;
    unsigned int switches = 0;
    if (!device_->getUserSwitches(switches)) switches = 0;  // unknown switches count as released
    pose = {fromChai3d(position), fromChai3d(rotation)};
    if (options_.cutoff == 0.0) {
      twist << fromChai3d(speed), fromChai3d(turning);
    } else if (started_) {
      const double share = -std::expm1(-2.0 * M_PI * options_.cutoff * passed);
      twist = kinematics_.twist + share * (motionBetween(kinematics_.pose, pose) / passed - kinematics_.twist);
    } else {
      twist.setZero();
    }
    if (!pose.position.allFinite() || !pose.rotation.allFinite() || !twist.allFinite()) return Status::notFinite;
    if (!isRotation(pose.rotation)) return Status::outOfRange;
    switches_ = switches;
    return Status::ok;
  }

  chai3d::cGenericHapticDevicePtr device_;
  const Mechanism& mechanism_;
  Chai3dOptions options_;
  chai3d::cHapticDeviceInfo specifications_;
  Kinematics kinematics_;  // at the last measurement
  double time_ = 0.0;      // of the last measurement, s
  bool opened_ = false, started_ = false;
  unsigned int switches_ = 0;
};

/// A cursor whose force comes from an Enamel renderer behind the guard. It replaces a cToolCursor:
///   setHapticDevice(), setWorkspaceRadius() or its scale, setRadius() -> addMesh() ... -> start() -> in the haptic
///   thread updateFromDevice(), computeInteractionForces(), applyToDevice() -> stop().
/// The wall is rendered in the device's own metres, whatever the scale of the world: shapes are divided by the scale
/// once. In the haptic thread, objects and the tool may move: obstacles follow the global poses of their objects.
///
/// Errors before and in start() are thrown as Error, with the cause. Later errors are in status() and latest(); the
/// guard ramps the force out. Threads: the three functions of a tick, latest(), status() and reset() belong to the
/// haptic thread. All other functions may be called from any one thread while the haptic thread does not run.
class Chai3dTool : public chai3d::cToolCursor, private HapticDevice {
 public:
  /// Refer to mechanism (as Chai3dDevice) and renderer, which must outlive the tool. `guard`: guardFor(mechanism,
  /// period) or tighter; the force is also limited to the device's specifications. Realtime: no.
  Chai3dTool(chai3d::cWorld* world, const Mechanism& mechanism, Renderer& renderer, GuardOptions guard,
             Chai3dOptions options = {})
      : cToolCursor(world),
        mechanism_(mechanism),
        renderer_(renderer),
        guard_(std::move(guard)),
        options_(std::move(options)) {}

  /// End the ticks; CHAI3D's stop() closes the device.
  ~Chai3dTool() override { end(); }

  /// Add a mesh in W of the device. Its triangles are copied now; its pose is read at every tick, so the object must
  /// outlive the tool's ticks. Return the obstacle's number. `thickness` (in the world's unit): as in Obstacle, for a
  /// mesh that encloses nothing. Realtime: no. Throws Error:
  /// - the object is null;
  /// - the tool has no device yet, or the scale has changed since the first mesh;
  /// - a mesh without triangles, a missing or non-finite vertex;
  /// - as MeshModel and Scene::add().
  int addMesh(chai3d::cMesh* mesh, const Material& material = {}, double thickness = 0.0) {
    if (mesh == nullptr) throw Error("chai3d: the mesh to add is missing");
    TriangleMesh triangles;
    append(*mesh, Pose(), triangles);
    return follow(*mesh, std::move(triangles), material, thickness);
  }

  /// Add all meshes of an object as one obstacle.
  int addMesh(chai3d::cMultiMesh* object, const Material& material = {}, double thickness = 0.0) {
    if (object == nullptr) throw Error("chai3d: the mesh to add is missing");
    TriangleMesh triangles;
    for (int i = 0; i < object->getNumMeshes(); ++i) {
      const chai3d::cMesh& mesh = *object->getMesh(static_cast<unsigned int>(i));
      append(mesh, {fromChai3d(mesh.getLocalPos()), fromChai3d(mesh.getLocalRot())}, triangles);
    }
    return follow(*object, std::move(triangles), material, thickness);
  }

  /// Add any other obstacle, at rest in W of the device, m. Throws as Scene::add(). Realtime: no.
  int addObstacle(Obstacle obstacle) {
    const int number = scene_.add(std::move(obstacle));
    if (body_) begin();
    return number;
  }

  /// Set the parts that touch, in the platform's frame, m. Default: a ball of getHapticPoint(0)->getRadiusContact().
  void setTool(const Tool& tool) {
    shape_ = tool;
    if (body_) begin();
  }

  /// Open the device and prepare everything. Return false if CHAI3D cannot. Throws Error, with the device closed: as
  /// Chai3dDevice, HapticTick and LoopBody; the device's first pose is invalid. Realtime: no.
  bool start() override {
    end();
    if (!cToolCursor::start()) return chai3d::C_ERROR;
    try {
      begin();
    } catch (...) {
      stop();
      throw;
    }
    return chai3d::C_SUCCESS;
  }

  bool stop() override {
    end();
    const chai3d::cVector3d none(0.0, 0.0, 0.0);
    if (m_enabled) m_hapticDevice->setForceAndTorqueAndGripperForce(none, none, 0.0);
    return cToolCursor::stop();
  }

  /// Measure. Realtime: yes, if CHAI3D's driver is.
  void updateFromDevice() override {
    if (!device_) {  // CHAI3D calls it during its start
      cToolCursor::updateFromDevice();
      return;
    }
    status_ = device_->measure(measurement_);
    measurement_.enabled = measurement_.enabled && m_forceOn;
    if (status_ == Status::ok && m_workspaceScaleFactor != scale_) status_ = Status::outOfRange;
    if (status_ != Status::ok) return;
    const Kinematics& k = device_->kinematics();
    chai3d::cMatrix3d rotation = toChai3d(k.pose.rotation);
    if (mechanism_.joints() < 6) m_hapticDevice->getRotation(rotation);  // shown, not rendered
    setDeviceLocalTransform({scale_ * toChai3d(k.pose.position), rotation});
    setDeviceLocalLinVel(scale_ * toChai3d(Vec3(k.twist.head<3>())));
    setDeviceLocalAngVel(toChai3d(Vec3(k.twist.tail<3>())));
    m_hapticDevice->getGripperAngleRad(m_gripperAngle);
    m_hapticDevice->getGripperAngularVelocity(m_gripperAngVel);
    m_userSwitches = device_->switches();
    m_hapticPoint->initialize(m_deviceGlobalPos);  // position of the drawn ball
    m_freqRead.signal(1);
  }

  /// Run one tick per period, however often it is called; the force is constant in between. Forces that the application
  /// adds afterwards also reach the device, without check by renderer or guard. Realtime: yes.
  void computeInteractionForces() override {
    const bool timed = std::isfinite(measurement_.time);  // otherwise the guard must see the invalid time
    if (body_ && (!timed || measurement_.time >= due_ - 0.5 * guard_.period)) {
      if (timed) due_ = std::max(due_, measurement_.time) + guard_.period;
      moveObstacles();
      body_->step();
    }
    setDeviceLocalForce(force_);
    setDeviceLocalTorque(moment_);
    setGripperForce(0.0);
  }

  /// Return whether the tool touches an object that was added. Realtime: yes.
  bool isInContact(chai3d::cGenericObject* object) override {
    if (!haptics_) return false;
    const ContactSnapshot& contacts = haptics_->frame().contacts;
    for (int i = 0; i < contacts.count; ++i)
      for (const Followed& f : followed_)
        if (f.object == object && f.obstacle == contacts.contacts[i].obstacle && contacts.contacts[i].gap <= 0.0)
          return true;
    return false;
  }

  /// Continue after a fault of the guard, at the next tick. Realtime: yes.
  void reset() noexcept {
    if (body_) body_->reset();
  }

  /// Return the status of the last updateFromDevice(): as Chai3dDevice::measure(). Also: inactive before start();
  /// outOfRange if the scale has changed since start(), or if an object's rotation is invalid. Realtime: yes.
  Status status() const noexcept { return status_; }

  /// Return the added obstacles, in W of the device.
  const Scene& scene() const noexcept { return scene_; }

  /// Return the last tick with the guard's result; then the input of renderer and guard. Null before start(). Realtime:
  /// yes.
  const LoopTick* latest() const noexcept { return body_ ? &body_->tick() : nullptr; }
  const HapticTick* haptics() const noexcept { return haptics_ ? &*haptics_ : nullptr; }

 private:
  struct Followed {
    chai3d::cGenericObject* object;
    int obstacle;
  };

  // The device of LoopBody: values are measured before its step and sent after it.
  [[nodiscard]] Status measure(Measurement& measurement) noexcept override {
    if (status_ == Status::ok) measurement = measurement_;
    return status_;
  }
  [[nodiscard]] Status actuate(const Command& command) noexcept override {
    return device_->wrenchOf(command, force_, moment_);
  }

  double scaleOfMeshes() {
    if (m_hapticDevice == nullptr)
      throw Error("chai3d: call setHapticDevice() before adding meshes: it sets the scale");
    if (!followed_.empty() && m_workspaceScaleFactor != scale_)
      throw Error("chai3d: the workspace's scale is " + std::to_string(m_workspaceScaleFactor) + ", it was " +
                  std::to_string(scale_) + " when the first mesh was added: set it before that");
    return m_workspaceScaleFactor;
  }

  void append(const chai3d::cMesh& mesh, const Pose& pose, TriangleMesh& result) {
    const double scale = scaleOfMeshes();
    const int first = static_cast<int>(result.vertices.size());
    const unsigned int vertices = mesh.m_vertices->getNumElements();
    for (unsigned int i = 0; i < vertices; ++i)
      result.vertices.push_back((pose.position + pose.rotation * fromChai3d(mesh.m_vertices->getLocalPos(i))) / scale);
    const chai3d::cTriangleArray& all = *mesh.m_triangles;
    for (unsigned int i = 0; i < mesh.m_triangles->getNumElements(); ++i) {
      if (!all.getAllocated(i)) continue;  // removed triangle
      std::array<int, 3> corners{};
      for (unsigned int k = 0; k < 3; ++k) {
        const unsigned int corner = all.getVertexIndex(i, k);
        if (corner >= vertices)
          throw Error("chai3d: \"" + mesh.m_name + "\": triangle " + std::to_string(i) + " names vertex " +
                      std::to_string(corner) + ", the mesh has " + std::to_string(vertices));
        corners[k] = first + static_cast<int>(corner);
      }
      result.triangles.push_back(corners);
    }
  }

  int follow(chai3d::cGenericObject& object, TriangleMesh triangles, const Material& material, double thickness) {
    const double scale = scaleOfMeshes();
    Obstacle obstacle;
    obstacle.name = object.m_name + " #" + std::to_string(scene_.obstacles().size());
    try {
      obstacle.shape = std::make_shared<const MeshModel>(std::move(triangles));
      object.computeGlobalPositionsFromRoot();
      computeGlobalPositionsFromRoot();
      scale_ = scale;
      obstacle.pose = poseOf(object);
      obstacle.material = material;
      obstacle.thickness = thickness / scale;
      const int number = scene_.add(std::move(obstacle));
      followed_.push_back({&object, number});
    } catch (const Error& error) {
      throw Error("chai3d: \"" + object.m_name + "\": " + error.what());
    }
    if (body_) begin();
    return followed_.back().obstacle;
  }

  // Return a pose in W of the device: the world relative to the tool, without its scale.
  Pose poseOf(const chai3d::cGenericObject& object) const noexcept {
    const Mat3 toTool = fromChai3d(m_globalRot).transpose();
    return {toTool * (fromChai3d(object.getGlobalPos()) - fromChai3d(m_globalPos)) / scale_,
            toTool * fromChai3d(object.getGlobalRot())};
  }

  void moveObstacles() noexcept {
    for (const Followed& f : followed_) {
      const Status moved = scene_.move(f.obstacle, poseOf(*f.object), Vec6::Zero());  // the tick derives the velocity
      if (moved != Status::ok) status_ = moved;
    }
  }

  void begin() {
    end();
    scale_ = scaleOfMeshes();
    device_.emplace(m_hapticDevice, mechanism_, options_);
    try {
      updateFromDevice();
      if (status_ != Status::ok)
        throw Error("chai3d: the first pose of \"" + device_->specifications().m_modelName +
                    "\" cannot be used: " + toString(status_));
      GuardOptions guard = guard_;
      guard.force = std::min(guard.force, device_->specifications().m_maxLinearForce);
      if (mechanism_.joints() == 6) guard.moment = std::min(guard.moment, device_->specifications().m_maxAngularTorque);
      Tool ball;
      ball.parts[0].radius = m_hapticPoint->getRadiusContact() / scale_;
      haptics_.emplace(mechanism_, scene_, shape_ ? *shape_ : ball, renderer_, guard, device_->kinematics().pose);
      HapticLoopOptions options;
      options.firstMeasurement = 0.0;
      body_.emplace(static_cast<HapticDevice&>(*this), *haptics_, options);
    } catch (...) {
      end();
      throw;
    }
    due_ = measurement_.time;
  }

  void end() noexcept {
    body_.reset();
    haptics_.reset();
    device_.reset();
    force_.zero();
    moment_.zero();
    status_ = Status::inactive;
  }

  const Mechanism& mechanism_;
  Renderer& renderer_;
  GuardOptions guard_;
  Chai3dOptions options_;
  Scene scene_;
  std::vector<Followed> followed_;
  std::optional<Tool> shape_;
  double scale_ = 1.0;  // unit of the world / unit of the device, for the meshes
  std::optional<Chai3dDevice> device_;
  std::optional<HapticTick> haptics_;
  std::optional<LoopBody> body_;
  Measurement measurement_;
  Status status_ = Status::inactive;
  double due_ = 0.0;                  // time of the next tick, s
  chai3d::cVector3d force_, moment_;  // of the last tick, N, N m
};

}  // namespace enamel
