// The substitute and CHAI3D have the same declarations. The tests compile this file with the substitute;
// real_headers.sh compiles it with CHAI3D's headers, and checks that it covers the whole substitute.
#include <chai3d.h>

#include <type_traits>

namespace enamel::test_signatures {

using namespace chai3d;

#define SAME(what, ...) static_assert(std::is_same_v<decltype(what), __VA_ARGS__>, #what)
#define OVERLOAD(what, ...) static_assert(static_cast<__VA_ARGS__>(what) != nullptr, #what)

SAME(C_ERROR, const bool);
SAME(C_SUCCESS, const bool);
static_assert(!C_ERROR && C_SUCCESS);

static_assert(std::is_default_constructible_v<cVector3d> && std::is_copy_assignable_v<cVector3d>);
static_assert(std::is_constructible_v<cVector3d, double, double, double>);
SAME(&cVector3d::zero, void (cVector3d::*)());
SAME(&cVector3d::length, double (cVector3d::*)() const);
OVERLOAD(&cVector3d::operator(), double& (cVector3d::*)(int));
OVERLOAD(&cVector3d::operator(), const double& (cVector3d::*)(int) const);
SAME(2.0 * cVector3d(), cVector3d);
SAME(cVector3d() + cVector3d(), cVector3d);

static_assert(std::is_default_constructible_v<cMatrix3d>);
SAME(&cMatrix3d::identity, void (cMatrix3d::*)());
OVERLOAD(&cMatrix3d::operator(), double& (cMatrix3d::*)(int, int));
OVERLOAD(&cMatrix3d::operator(), const double& (cMatrix3d::*)(int, int) const);
SAME(cMatrix3d() * cVector3d(), cVector3d);
SAME(cMatrix3d() * cMatrix3d(), cMatrix3d);
SAME(cTranspose(cMatrix3d()), cMatrix3d);

static_assert(std::is_constructible_v<cTransform, const cVector3d&, const cMatrix3d&>);
SAME(&cTransform::getLocalPos, cVector3d (cTransform::*)() const);
SAME(&cTransform::getLocalRot, cMatrix3d (cTransform::*)() const);

SAME(cHapticDeviceInfo::m_modelName, std::string);
SAME(cHapticDeviceInfo::m_maxLinearForce, double);
SAME(cHapticDeviceInfo::m_maxAngularTorque, double);
SAME(cHapticDeviceInfo::m_workspaceRadius, double);
SAME(cHapticDeviceInfo::m_sensedPosition, bool);
SAME(cHapticDeviceInfo::m_sensedRotation, bool);
SAME(cHapticDeviceInfo::m_actuatedPosition, bool);
SAME(cHapticDeviceInfo::m_actuatedRotation, bool);

struct Device : cGenericDevice {
  Device() : cGenericDevice(0U) {}
  SAME(m_deviceReady, bool);
  SAME(m_deviceNumber, int);
  bool open() override;
  bool close() override;
};
SAME(&Device::isDeviceReady, bool (cGenericDevice::*)());

SAME(cGenericHapticDevicePtr(), std::shared_ptr<cGenericHapticDevice>);
static_assert(std::is_base_of_v<cGenericDevice, cGenericHapticDevice>);
static_assert(std::has_virtual_destructor_v<cGenericHapticDevice>);
struct HapticDevice : cGenericHapticDevice {
  HapticDevice() : cGenericHapticDevice(0U) {}
  bool open() override;
  bool close() override;
  bool calibrate(bool) override;
  bool getPosition(cVector3d&) override;
  bool getLinearVelocity(cVector3d&) override;
  bool getRotation(cMatrix3d&) override;
  bool getAngularVelocity(cVector3d&) override;
  bool getGripperAngleRad(double&) override;
  bool getGripperAngularVelocity(double&) override;
  bool getUserSwitches(unsigned int&) override;
  bool setForceAndTorqueAndGripperForce(const cVector3d&, const cVector3d&, double) override;
};
SAME(&HapticDevice::getSpecifications, cHapticDeviceInfo (cGenericHapticDevice::*)());
SAME(HapticDevice::m_specifications, cHapticDeviceInfo);
inline bool callable(HapticDevice& device) { return device.calibrate(false); }

SAME(&cFrequencyCounter::signal, double (cFrequencyCounter::*)(unsigned int));
SAME(cGenericObject::m_name, std::string);  // in cGenericType since 3.3

static_assert(std::is_base_of_v<cGenericType, cGenericObject> && std::has_virtual_destructor_v<cGenericType>);
struct Object : cGenericObject {
  using cGenericObject::setLocalPos;
  using cGenericObject::setLocalRot;
  void setLocalPos(const cVector3d&) override;
  void setLocalRot(const cMatrix3d&) override;
  SAME(m_localPos, cVector3d);
  SAME(m_globalPos, cVector3d);
  SAME(m_localRot, cMatrix3d);
  SAME(m_globalRot, cMatrix3d);
};
OVERLOAD(&cGenericObject::setLocalPos, void (cGenericObject::*)(double, double, double));
SAME(&cGenericObject::getLocalPos, cVector3d (cGenericObject::*)() const);
SAME(&cGenericObject::getGlobalPos, cVector3d (cGenericObject::*)() const);
SAME(&cGenericObject::getLocalRot, cMatrix3d (cGenericObject::*)() const);
SAME(&cGenericObject::getGlobalRot, cMatrix3d (cGenericObject::*)() const);
SAME(&cGenericObject::addChild, bool (cGenericObject::*)(cGenericObject*));
SAME(&cGenericObject::removeChild, bool (cGenericObject::*)(cGenericObject*));
SAME(&cGenericObject::computeGlobalPositionsFromRoot, void (cGenericObject::*)(bool));
inline void callable(cGenericObject& object) { object.computeGlobalPositionsFromRoot(); }

static_assert(std::is_base_of_v<cGenericObject, cWorld> && std::is_default_constructible_v<cWorld>);

SAME(cVertexArrayPtr(), std::shared_ptr<cVertexArray>);
SAME(cVertexArray::m_localPos, std::vector<cVector3d>);
SAME(&cVertexArray::getNumElements, unsigned int (cVertexArray::*)() const);
SAME(&cVertexArray::getLocalPos, cVector3d (cVertexArray::*)(unsigned int) const);
SAME(cTriangleArrayPtr(), std::shared_ptr<cTriangleArray>);
static_assert(std::is_base_of_v<cGenericArray, cTriangleArray>);
SAME(cGenericArray::m_indices, std::vector<unsigned int>);
SAME(cGenericArray::m_allocated, std::vector<bool>);
SAME(&cGenericArray::getNumElements, unsigned int (cGenericArray::*)());
SAME(&cGenericArray::getAllocated, bool (cGenericArray::*)(unsigned int) const);
SAME(&cGenericArray::getVertexIndex, unsigned int (cGenericArray::*)(unsigned int, unsigned int) const);
SAME(&cTriangleArray::getVertexIndex, unsigned int (cTriangleArray::*)(unsigned int, unsigned int) const);

static_assert(std::is_base_of_v<cGenericObject, cMesh> && std::is_default_constructible_v<cMesh>);
SAME(cMesh::m_vertices, cVertexArrayPtr);
SAME(cMesh::m_triangles, cTriangleArrayPtr);
OVERLOAD(&cMesh::newTriangle, unsigned int (cMesh::*)(unsigned int, unsigned int, unsigned int));
SAME(&cMesh::removeTriangle, bool (cMesh::*)(unsigned int));
inline unsigned int callable(cMesh& mesh) { return mesh.newVertex(0.0, 0.0, 0.0) + mesh.newVertex(cVector3d()); }

static_assert(std::is_base_of_v<cGenericObject, cMultiMesh> && std::is_default_constructible_v<cMultiMesh>);
SAME(&cMultiMesh::newMesh, cMesh* (cMultiMesh::*)());
SAME(&cMultiMesh::getNumMeshes, int (cMultiMesh::*)());
SAME(&cMultiMesh::getMesh, cMesh* (cMultiMesh::*)(unsigned int));

OVERLOAD(&cHapticPoint::initialize, void (cHapticPoint::*)(cVector3d));
OVERLOAD(&cHapticPoint::setRadius, void (cHapticPoint::*)(double));
SAME(&cHapticPoint::getRadiusContact, double (cHapticPoint::*)());
struct Point : cHapticPoint {
  SAME(m_radiusContact, double);
};

static_assert(std::is_base_of_v<cGenericObject, cGenericTool>);
static_assert(std::is_base_of_v<cGenericTool, cToolCursor> && std::has_virtual_destructor_v<cToolCursor>);
SAME(&cGenericTool::setHapticDevice, void (cGenericTool::*)(cGenericHapticDevicePtr));
SAME(&cGenericTool::setWorkspaceScaleFactor, bool (cGenericTool::*)(const double&));
struct Cursor : cToolCursor {
  explicit Cursor(cWorld* world) : cToolCursor(world) {}
  using cToolCursor::addDeviceGlobalForce;
  using cToolCursor::setDeviceLocalAngVel;
  using cToolCursor::setDeviceLocalForce;
  using cToolCursor::setDeviceLocalLinVel;
  using cToolCursor::setDeviceLocalTorque;
  using cToolCursor::setRadius;
  bool start() override;
  bool stop() override;
  void updateFromDevice() override;
  void computeInteractionForces() override;
  bool applyToDevice() override;
  bool setForcesON() override;
  bool setForcesOFF() override;
  unsigned int getUserSwitches() const override;
  void setGripperForce(const double&) override;
  cVector3d getDeviceLocalPos() const override;
  cVector3d getDeviceGlobalPos() const override;
  cMatrix3d getDeviceLocalRot() const override;
  cVector3d getDeviceLocalLinVel() const override;
  cVector3d getDeviceLocalAngVel() const override;
  cVector3d getDeviceLocalForce() const override;
  cVector3d getDeviceGlobalForce() const override;
  cVector3d getDeviceLocalTorque() const override;
  void setDeviceLocalTransform(const cTransform&) override;
  void setDeviceLocalLinVel(const cVector3d&) override;
  void setDeviceLocalAngVel(const cVector3d&) override;
  void setDeviceLocalForce(const cVector3d&) override;
  void setDeviceLocalTorque(const cVector3d&) override;
  void addDeviceGlobalForce(const cVector3d&) override;
  void setRadius(double) override;
  bool isInContact(cGenericObject*) override;
  SAME(m_hapticPoint, cHapticPoint*);
  SAME(m_hapticPoints, std::vector<cHapticPoint*>);
  SAME(m_hapticDevice, cGenericHapticDevicePtr);
  SAME(m_userSwitches, unsigned int);
  SAME(m_enabled, bool);
  SAME(m_forceOn, bool);
  SAME(m_workspaceScaleFactor, double);
  SAME(m_gripperAngle, double);
  SAME(m_gripperAngVel, double);
  SAME(m_deviceLocalForce, cVector3d);
  SAME(m_deviceGlobalForce, cVector3d);
  SAME(m_deviceLocalTorque, cVector3d);
  SAME(m_deviceGlobalTorque, cVector3d);
  SAME(m_deviceLocalPos, cVector3d);
  SAME(m_deviceGlobalPos, cVector3d);
  SAME(m_deviceLocalLinVel, cVector3d);
  SAME(m_deviceLocalAngVel, cVector3d);
  SAME(m_deviceLocalRot, cMatrix3d);
  SAME(m_freqRead, cFrequencyCounter);
};

}  // namespace enamel::test_signatures
