// A substitute for CHAI3D where it is not installed: the few classes that plugins/chai3d uses. Names and signatures are
// those of CHAI3D's headers; the behaviour is what the tests need. signatures.cpp checks both headers for equal
// declarations, and real_headers.sh compiles it with CHAI3D's.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace chai3d {

const bool C_ERROR = false;
const bool C_SUCCESS = true;

struct cVector3d {
  cVector3d() {}
  cVector3d(const double x, const double y, const double z) : v_{x, y, z} {}
  void zero() { *this = cVector3d(0.0, 0.0, 0.0); }
  double length() const { return std::sqrt(v_[0] * v_[0] + v_[1] * v_[1] + v_[2] * v_[2]); }
  double& operator()(const int i) { return v_[i]; }
  const double& operator()(const int i) const { return v_[i]; }

 private:
  double v_[3];
};
inline cVector3d operator*(const double s, const cVector3d& v) { return cVector3d(s * v(0), s * v(1), s * v(2)); }
inline cVector3d operator+(const cVector3d& a, const cVector3d& b) {
  return cVector3d(a(0) + b(0), a(1) + b(1), a(2) + b(2));
}

struct cMatrix3d {
  cMatrix3d() {}
  void identity() {
    for (int i = 0; i < 9; ++i) v_[i] = i % 4 == 0 ? 1.0 : 0.0;
  }
  double& operator()(const int i, const int j) { return v_[3 * i + j]; }
  const double& operator()(const int i, const int j) const { return v_[3 * i + j]; }

 private:
  double v_[9];
};
inline cVector3d operator*(const cMatrix3d& m, const cVector3d& v) {
  cVector3d result;
  for (int i = 0; i < 3; ++i) result(i) = m(i, 0) * v(0) + m(i, 1) * v(1) + m(i, 2) * v(2);
  return result;
}
inline cMatrix3d operator*(const cMatrix3d& a, const cMatrix3d& b) {
  cMatrix3d result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) result(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
  return result;
}
inline cMatrix3d cTranspose(const cMatrix3d& m) {
  cMatrix3d result;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) result(i, j) = m(j, i);
  return result;
}

struct cTransform {
  cTransform(const cVector3d& pos, const cMatrix3d& rot) : position_(pos), rotation_(rot) {}
  cVector3d getLocalPos() const { return position_; }
  cMatrix3d getLocalRot() const { return rotation_; }

 private:
  cVector3d position_;
  cMatrix3d rotation_;
};

struct cHapticDeviceInfo {
  std::string m_modelName;
  double m_maxLinearForce = 0.1, m_maxAngularTorque = 0.1;  // CHAI3D's defaults for a device that does not report them
  double m_workspaceRadius = 0.1;
  bool m_sensedPosition = false, m_sensedRotation = false, m_actuatedPosition = false, m_actuatedRotation = false;
};

class cGenericDevice {
 public:
  cGenericDevice(unsigned int number = 0) : m_deviceNumber(static_cast<int>(number)) {}
  virtual ~cGenericDevice() {}
  virtual bool open() { return C_ERROR; }
  virtual bool close() { return C_ERROR; }
  bool isDeviceReady() { return m_deviceReady; }

 protected:
  bool m_deviceReady = false;
  int m_deviceNumber;
};

class cGenericHapticDevice;
typedef std::shared_ptr<cGenericHapticDevice> cGenericHapticDevicePtr;

class cGenericHapticDevice : public cGenericDevice {
 public:
  cGenericHapticDevice(unsigned int number = 0) : cGenericDevice(number) {}
  virtual bool open() { return C_ERROR; }
  virtual bool close() { return C_ERROR; }
  virtual bool calibrate(bool = false) { return m_deviceReady; }
  virtual bool getPosition(cVector3d& position) { return position.zero(), m_deviceReady; }
  virtual bool getLinearVelocity(cVector3d& velocity) { return velocity.zero(), m_deviceReady; }
  virtual bool getRotation(cMatrix3d& rotation) { return rotation.identity(), m_deviceReady; }
  virtual bool getAngularVelocity(cVector3d& velocity) { return velocity.zero(), m_deviceReady; }
  virtual bool getGripperAngleRad(double& angle) { return angle = 0.0, C_SUCCESS; }
  virtual bool getGripperAngularVelocity(double& velocity) { return velocity = 0.0, m_deviceReady; }
  virtual bool getUserSwitches(unsigned int& switches) { return switches = 0, m_deviceReady; }
  cHapticDeviceInfo getSpecifications() { return m_specifications; }
  virtual bool setForceAndTorqueAndGripperForce(const cVector3d&, const cVector3d&, double) { return m_deviceReady; }

  cHapticDeviceInfo m_specifications;
};

class cFrequencyCounter {
 public:
  double signal(const unsigned int = 1) { return 0.0; }
};

class cGenericType {
 public:
  virtual ~cGenericType() {}
  std::string m_name;
};

class cGenericObject : public cGenericType {
 public:
  cGenericObject() {
    m_localPos.zero();
    m_globalPos.zero();
    m_localRot.identity();
    m_globalRot.identity();
  }
  ~cGenericObject() override {
    for (const cGenericObject* child : children_) delete child;
  }
  virtual void setLocalPos(const cVector3d& position) { m_localPos = position; }
  void setLocalPos(const double x = 0.0, const double y = 0.0, const double z = 0.0) {
    setLocalPos(cVector3d(x, y, z));
  }
  virtual void setLocalRot(const cMatrix3d& rotation) { m_localRot = rotation; }
  cVector3d getLocalPos() const { return m_localPos; }
  cVector3d getGlobalPos() const { return m_globalPos; }
  cMatrix3d getLocalRot() const { return m_localRot; }
  cMatrix3d getGlobalRot() const { return m_globalRot; }
  bool addChild(cGenericObject* object) {
    object->parent_ = this;
    children_.push_back(object);
    return C_SUCCESS;
  }
  bool removeChild(cGenericObject* object) {
    object->parent_ = nullptr;
    children_.erase(std::remove(children_.begin(), children_.end(), object), children_.end());
    return C_SUCCESS;
  }
  void computeGlobalPositionsFromRoot(const bool = true) {
    if (parent_ != nullptr) parent_->computeGlobalPositionsFromRoot();
    m_globalPos = parent_ != nullptr ? parent_->m_globalPos + parent_->m_globalRot * m_localPos : m_localPos;
    m_globalRot = parent_ != nullptr ? parent_->m_globalRot * m_localRot : m_localRot;
  }

 protected:
  cVector3d m_localPos, m_globalPos;
  cMatrix3d m_localRot, m_globalRot;

 private:
  cGenericObject* parent_ = nullptr;
  std::vector<cGenericObject*> children_;  // it owns them, as in CHAI3D
};

class cWorld : public cGenericObject {
 public:
  cWorld() {}
};

class cVertexArray {
 public:
  unsigned int getNumElements() const { return static_cast<unsigned int>(m_localPos.size()); }
  cVector3d getLocalPos(const unsigned int i) const { return m_localPos[i]; }
  std::vector<cVector3d> m_localPos;
};
typedef std::shared_ptr<cVertexArray> cVertexArrayPtr;

class cGenericArray {
 public:
  virtual ~cGenericArray() {}
  virtual unsigned int getNumElements() { return static_cast<unsigned int>(m_allocated.size()); }
  bool getAllocated(const unsigned int i) const { return m_allocated[i]; }
  virtual unsigned int getVertexIndex(const unsigned int, const unsigned int) const { return 0; }
  std::vector<unsigned int> m_indices;
  std::vector<bool> m_allocated;
};

class cTriangleArray : public cGenericArray {
 public:
  virtual unsigned int getVertexIndex(const unsigned int i, const unsigned int k) const { return m_indices[3 * i + k]; }
};
typedef std::shared_ptr<cTriangleArray> cTriangleArrayPtr;

class cMesh : public cGenericObject {
 public:
  unsigned int newVertex(const cVector3d& position) {
    m_vertices->m_localPos.push_back(position);
    return m_vertices->getNumElements() - 1;
  }
  unsigned int newVertex(const double x = 0.0, const double y = 0.0, const double z = 0.0) {
    return newVertex(cVector3d(x, y, z));
  }
  unsigned int newTriangle(const unsigned int a, const unsigned int b, const unsigned int c) {
    for (const unsigned int corner : {a, b, c}) m_triangles->m_indices.push_back(corner);
    m_triangles->m_allocated.push_back(true);
    return m_triangles->getNumElements() - 1;
  }
  bool removeTriangle(const unsigned int i) {
    m_triangles->m_allocated[i] = false;
    for (unsigned int k = 0; k < 3; ++k) m_triangles->m_indices[3 * i + k] = 0;
    return C_SUCCESS;
  }

  cVertexArrayPtr m_vertices = std::make_shared<cVertexArray>();
  cTriangleArrayPtr m_triangles = std::make_shared<cTriangleArray>();
};

class cMultiMesh : public cGenericObject {
 public:
  ~cMultiMesh() override {
    for (const cMesh* mesh : meshes_) delete mesh;
  }
  cMesh* newMesh() {
    meshes_.push_back(new cMesh);
    return meshes_.back();
  }
  int getNumMeshes() { return static_cast<int>(meshes_.size()); }
  cMesh* getMesh(unsigned int i) { return meshes_[i]; }

 private:
  std::vector<cMesh*> meshes_;
};

class cHapticPoint {
 public:
  void initialize(cVector3d) {}
  void setRadius(double radius) { m_radiusContact = radius; }
  double getRadiusContact() { return m_radiusContact; }

 protected:
  double m_radiusContact = 0.01;  // CHAI3D's default
};

class cGenericTool : public cGenericObject {
 public:
  cGenericTool(cWorld*) {
    for (cVector3d* v : {&m_deviceLocalForce, &m_deviceGlobalForce, &m_deviceLocalTorque, &m_deviceGlobalTorque,
                         &m_deviceLocalPos, &m_deviceGlobalPos, &m_deviceLocalLinVel, &m_deviceLocalAngVel})
      v->zero();
    m_deviceLocalRot.identity();
  }
  void setHapticDevice(cGenericHapticDevicePtr device) {
    if (device != nullptr) m_hapticDevice = device;
  }
  virtual bool start() {
    m_enabled = m_hapticDevice != nullptr && m_hapticDevice->open();
    if (!m_enabled) return C_ERROR;
    m_hapticDevice->calibrate(false);
    updateFromDevice();
    return C_SUCCESS;
  }
  virtual bool stop() { return m_enabled && m_hapticDevice->close(); }
  virtual void updateFromDevice() {}
  virtual void computeInteractionForces() {}
  virtual bool applyToDevice() {
    if (m_hapticDevice == nullptr || !m_enabled) return C_ERROR;
    const cVector3d none(0.0, 0.0, 0.0);
    m_hapticDevice->setForceAndTorqueAndGripperForce(m_forceOn ? m_deviceLocalForce : none,
                                                     m_forceOn ? m_deviceLocalTorque : none, 0.0);
    return C_SUCCESS;
  }
  virtual bool setForcesON() { return m_forceOn = true; }
  virtual bool setForcesOFF() { return m_forceOn = false, applyToDevice(); }
  virtual unsigned int getUserSwitches() const { return m_userSwitches; }
  virtual void setGripperForce(const double&) {}
  virtual cVector3d getDeviceLocalPos() const { return m_deviceLocalPos; }
  virtual cVector3d getDeviceGlobalPos() const { return m_deviceGlobalPos; }
  virtual cMatrix3d getDeviceLocalRot() const { return m_deviceLocalRot; }
  virtual void setDeviceLocalTransform(const cTransform& transform) {
    m_deviceLocalPos = transform.getLocalPos();
    m_deviceLocalRot = transform.getLocalRot();
    m_deviceGlobalPos = m_globalPos + m_globalRot * m_deviceLocalPos;
  }
  virtual cVector3d getDeviceLocalLinVel() const { return m_deviceLocalLinVel; }
  virtual void setDeviceLocalLinVel(const cVector3d& velocity) { m_deviceLocalLinVel = velocity; }
  virtual cVector3d getDeviceLocalAngVel() const { return m_deviceLocalAngVel; }
  virtual void setDeviceLocalAngVel(const cVector3d& velocity) { m_deviceLocalAngVel = velocity; }
  virtual cVector3d getDeviceLocalForce() const { return m_deviceLocalForce; }
  virtual void setDeviceLocalForce(const cVector3d& force) {
    m_deviceLocalForce = force;
    m_deviceGlobalForce = m_globalRot * force;
  }
  virtual cVector3d getDeviceGlobalForce() const { return m_deviceGlobalForce; }
  virtual void addDeviceGlobalForce(const cVector3d& force) {
    m_deviceGlobalForce = m_deviceGlobalForce + force;
    m_deviceLocalForce = cTranspose(m_globalRot) * m_deviceGlobalForce;
  }
  virtual cVector3d getDeviceLocalTorque() const { return m_deviceLocalTorque; }
  virtual void setDeviceLocalTorque(const cVector3d& torque) {
    m_deviceLocalTorque = torque;
    m_deviceGlobalTorque = m_globalRot * torque;
  }
  bool setWorkspaceScaleFactor(const double& factor) {
    if (m_hapticDevice == nullptr || factor == 0.0) return C_ERROR;
    m_workspaceScaleFactor = std::abs(factor);
    updateFromDevice();
    return C_SUCCESS;
  }
  virtual void setRadius(double radius) {
    for (cHapticPoint* point : m_hapticPoints) point->setRadius(radius);
  }
  virtual bool isInContact(cGenericObject*) { return false; }

 protected:
  std::vector<cHapticPoint*> m_hapticPoints;
  cGenericHapticDevicePtr m_hapticDevice;
  unsigned int m_userSwitches = 0;
  bool m_enabled = false, m_forceOn = true;
  double m_workspaceScaleFactor = 1.0, m_gripperAngle = 0.0, m_gripperAngVel = 0.0;
  cVector3d m_deviceLocalForce, m_deviceGlobalForce, m_deviceLocalTorque, m_deviceGlobalTorque;
  cVector3d m_deviceLocalPos, m_deviceGlobalPos, m_deviceLocalLinVel, m_deviceLocalAngVel;
  cMatrix3d m_deviceLocalRot;
  cFrequencyCounter m_freqRead;
};

class cToolCursor : public cGenericTool {
 public:
  cToolCursor(cWorld* world) : cGenericTool(world), m_hapticPoint(new cHapticPoint) {
    m_hapticPoints.push_back(m_hapticPoint);
  }
  virtual ~cToolCursor() { delete m_hapticPoint; }
  cHapticPoint* m_hapticPoint;
};

}  // namespace chai3d
