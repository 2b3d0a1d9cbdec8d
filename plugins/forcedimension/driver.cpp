// The driver of Force Dimension's devices through the functions that its SDK documents (libdhd, opened at run time).
// lib/docs/force-dimension.md has the page. Not yet tried on hardware.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <memory>
#include <stdexcept>
#include <string>

#include "../driver_functions.hpp"
#include "../vendor_library.hpp"

namespace enamel::forcedimension {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kStatusTicks = 20;                                        // the status is read once in so many samples
constexpr int kTimeGuard = 1;                                           // result: called too early, nothing was read
constexpr int kPower = 0, kReset = 3, kForce = 5, kForceOffCause = 14;  // in the status
constexpr int kOffByButton = 1, kOffByProgram = 4, kOffByReleasedGrip = 6;  // causes that are not the device itself
constexpr int kMostDevices = 64;
constexpr const char* kNone = "no device is connected, or it has no power or is not accessible (udev rules)";
constexpr double kLargestGrip = 8.0;  // N, of the gripper

const EnamelParameter kOptions[] = {
    {"library", "auto",
     "file of the vendor's library; auto: libdhd.so.3, libdhd.so or dhd64.dll where the system finds it"},
};
const EnamelDescription kDescription = {"forcedimension", "0.2.0",
                                        "Force Dimension omega, delta and sigma through the vendor's library", kOptions,
                                        sizeof kOptions / sizeof kOptions[0]};

const char* const kOmega3 =
#include <omega-3_device.inl>
    ;
const char* const kOmega6 =
#include <omega-6_device.inl>
    ;
const char* const kSigma7 =
#include <sigma-7_device.inl>
    ;

// Axes of W in those of the SDK (x towards the user, y right, z up): world = kAxes * sdk.
const Matrix3d kAxes = (Matrix3d() << 0, 1, 0, 0, 0, 1, 1, 0, 0).finished();

// The functions of the SDK that the driver uses. The last parameter is the number of the device.
struct Sdk {
  explicit Sdk(const std::string& file) : library(file, {"libdhd.so.3", "libdhd.so"}, {"dhd64.dll"}) {
    library.bind("dhdGetDeviceCount", deviceCount);
    library.bind("dhdOpenID", openId);
    library.bind("dhdClose", close);
    library.bind("dhdGetSystemName", systemName);
    library.bind("dhdHasWrist", hasWrist);
    library.bind("dhdHasActiveWrist", hasActiveWrist);
    library.bind("dhdHasGripper", hasGripper);
    library.bind("dhdEnableForce", enableForce);
    library.bind("dhdGetStatus", status);
    library.bind("dhdGetPositionAndOrientationFrame", pose);
    library.bind("dhdGetGripperAngleRad", gripperAngle);
    library.bind("dhdGetButtonMask", buttonMask);
    library.bind("dhdSetForceAndTorqueAndGripperForce", setWrench);
    library.bind("dhdErrorGetLastStr", lastError);
    library.bindIfThere("dhdGetSDKVersion", sdkVersion);
    library.bindIfThere("dhdGetVersion", version);
  }

  std::string reason() const {
    const char* const text = lastError();
    return text == nullptr ? "the SDK gives no reason" : text;
  }

  VendorLibrary library;
  int (*deviceCount)();
  int (*openId)(char index);
  int (*close)(char id);
  const char* (*systemName)(char id);
  bool (*hasWrist)(char id);
  bool (*hasActiveWrist)(char id);
  bool (*hasGripper)(char id);
  int (*enableForce)(unsigned char on, char id);
  int (*status)(int* values, char id);
  int (*pose)(double* x, double* y, double* z, double rotation[3][3], char id);
  int (*gripperAngle)(double* angle, char id);
  unsigned (*buttonMask)(char id);
  int (*setWrench)(double fx, double fy, double fz, double tx, double ty, double tz, double gripper, char id);
  const char* (*lastError)();
  void (*sdkVersion)(int* major, int* minor, int* release, int* revision);  // these two: null if missing
  int (*version)(double* firmware, char id);
};

// The inverse transpose of E(v) of device/cartesian/mechanism.hpp: the moment is this times the last three efforts.
// E^-1 = 1 - [v]x / 2 + c [v]x^2, c = 1/t^2 - (1 + cos t) / (2 t sin t) (T. D. Barfoot 2017, eq. 7.77b).
Vector3d momentOf(const Vector3d& turn, const Vector3d& effort) noexcept {
  const double t = turn.norm();
  const double c = t < 1e-3 ? 1.0 / 12.0 : 1.0 / (t * t) - (1.0 + std::cos(t)) / (2.0 * t * std::sin(t));
  return effort + 0.5 * turn.cross(effort) + c * turn.cross(turn.cross(effort));
}

class Device {
 public:
  Device(const std::string& file, int index) : sdk_(file), index_(index) {
    connect();
    hasWrist_ = sdk_.hasWrist(id_);
    isActive_ = hasWrist_ && sdk_.hasActiveWrist(id_);
    hasGripper_ = sdk_.hasGripper(id_);
  }
  ~Device() { disconnect(); }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  std::string name() const {
    const char* const name = sdk_.systemName(id_);
    return name == nullptr ? "unknown device" : name;
  }
  // For reports.
  std::string facts() const {
    std::string text = name();
    if (double firmware = 0.0; sdk_.version != nullptr && sdk_.version(&firmware, id_) >= 0) {
      char digits[32];
      std::snprintf(digits, sizeof digits, "%g", firmware);
      text += std::string(", firmware ") + digits;
    }
    if (sdk_.sdkVersion == nullptr) return text;
    std::array<int, 4> v{};
    sdk_.sdkVersion(&v[0], &v[1], &v[2], &v[3]);
    text += ", SDK";
    for (std::size_t i = 0; i < v.size(); ++i) text += (i == 0 ? " " : ".") + std::to_string(v[i]);
    return text;
  }
  int joints() const noexcept { return hasWrist_ ? 6 : 3; }
  const char* deviceFile() const noexcept { return isActive_ ? kSigma7 : hasWrist_ ? kOmega6 : kOmega3; }

  void open() {
    if (isLost_) {
      disconnect();  // its number is no longer valid
      connect();
      if (sdk_.hasWrist(id_) != hasWrist_ || (hasWrist_ && sdk_.hasActiveWrist(id_) != isActive_))
        throw std::runtime_error("another device is connected now: the " + name());
      isLost_ = false;
    }
    if (sdk_.setWrench(0, 0, 0, 0, 0, 0, 0, id_) < 0 || sdk_.enableForce(1, id_) < 0)
      throw std::runtime_error("the " + name() + " does not switch its forces on: " + sdk_.reason());
    isOpen_ = true;
    samples_ = 0;
    grip_ = 0.0;
    rates_.reset();
  }
  void close() noexcept {
    isOpen_ = false;
    if (id_ < 0) return;
    (void)sdk_.setWrench(0, 0, 0, 0, 0, 0, 0, id_);
    (void)sdk_.enableForce(0, id_);
  }

  std::int32_t measure(EnamelMeasurement& m) noexcept {
    if (!isOpen_) return ENAMEL_INACTIVE;
    Vector3d position;
    double rotation[3][3];
    const int result = sdk_.pose(&position[0], &position[1], &position[2], rotation, id_);
    if (result < 0) return lost();
    const double time = driverClock();
    if (result == kTimeGuard || !(time > time_)) return ENAMEL_STALE;
    std::memset(&m, 0, sizeof m);
    m.size = sizeof m;
    m.time = time_ = time;
    Eigen::Map<Vector3d>(m.q) = kAxes * position;
    if (hasWrist_) {
      const Matrix3d frame = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rotation[0]);
      const Eigen::AngleAxisd turn(Matrix3d(kAxes * frame * kAxes.transpose()));
      turn_ = turn.angle() * turn.axis();
      Eigen::Map<Vector3d>(m.q + 3) = turn_;
    }
    rates_.add(m, joints());
    if (samples_++ % kStatusTicks == 0) {
      std::array<int, 64> status{};
      if (sdk_.status(status.data(), id_) < 0) return lost();
      isEnabled_ = status[kForce] != 0 && status[kPower] != 0;
      const int cause = status[kForceOffCause];
      const bool isOffByUser = cause == kOffByButton || cause == kOffByProgram || cause == kOffByReleasedGrip;
      conditions_ = (status[kReset] != 0 ? std::uint32_t{ENAMEL_UNCALIBRATED} : 0U) |
                    (!isEnabled_ && !isOffByUser ? std::uint32_t{ENAMEL_FORCES_CUT} : 0U);
    }
    m.enabled = isEnabled_ ? 1 : 0;
    m.buttons = sdk_.buttonMask(id_);
    m.conditions = conditions_;
    if (hasGripper_) m.has_gripper = sdk_.gripperAngle(&m.gripper, id_) >= 0 ? 1 : 0;
    return ENAMEL_OK;
  }

  std::int32_t actuate(const double* effort, std::int32_t count) noexcept {
    if (!isOpen_) return ENAMEL_INACTIVE;
    if (const std::int32_t checked = checkEfforts(effort, count, joints()); checked != ENAMEL_OK) return checked;
    const double largest = isActive_ ? 20.0 : 12.0, largestMoment = 0.4;  // N, N m, as in the device files
    const Vector3d force = Eigen::Map<const Vector3d>(effort).cwiseMax(-largest).cwiseMin(largest);
    Vector3d moment = Vector3d::Zero();
    if (isActive_)
      moment = momentOf(turn_, Eigen::Map<const Vector3d>(effort + 3).cwiseMax(-largestMoment).cwiseMin(largestMoment));
    const Vector3d f = kAxes.transpose() * force, t = kAxes.transpose() * moment;
    return sdk_.setWrench(f[0], f[1], f[2], t[0], t[1], t[2], grip_, id_) < 0 ? ENAMEL_INACTIVE : ENAMEL_OK;
  }

  std::int32_t grip(double force) noexcept {
    if (!std::isfinite(force)) return ENAMEL_NOT_FINITE;
    grip_ = hasGripper_ ? std::clamp(force, -kLargestGrip, kLargestGrip) : 0.0;
    return ENAMEL_OK;
  }

 private:
  void connect() {
    const int count = sdk_.deviceCount();
    if (count <= 0) throw std::runtime_error(kNone);
    if (index_ >= count)
      throw std::runtime_error("device " + std::to_string(index_) + " is missing: " + std::to_string(count) +
                               " connected");
    const int opened = sdk_.openId(static_cast<char>(index_));
    if (opened < 0) throw std::runtime_error("device " + std::to_string(index_) + " does not open: " + sdk_.reason());
    id_ = static_cast<char>(opened);
    std::array<int, 64> status{};  // the SDK writes up to 17 numbers, depending on its version
    if (sdk_.status(status.data(), id_) >= 0 && status[kPower] != 0) return;
    const std::string reason = "the " + name() + " has no power";
    disconnect();
    throw std::runtime_error(reason);
  }
  void disconnect() noexcept {
    if (id_ >= 0) (void)sdk_.close(id_);
    id_ = -1;
  }
  std::int32_t lost() noexcept {
    isLost_ = true;
    return ENAMEL_INACTIVE;
  }

  Sdk sdk_;
  int index_;
  char id_ = -1;
  bool hasWrist_ = false, isActive_ = false, hasGripper_ = false, isOpen_ = false, isEnabled_ = true, isLost_ = false;
  std::uint64_t samples_ = 0;  // since open()
  double time_ = 0.0;          // of the last sample, s
  double grip_ = 0.0;          // N
  std::uint32_t conditions_ = 0;
  Vector3d turn_ = Vector3d::Zero();
  DriverRates rates_;
};

std::int32_t list(EnamelMessage devices, EnamelMessage message) noexcept {
  return guardedSetup(message, [&] {
    const int count = std::min(Sdk("auto").deviceCount(), kMostDevices);
    if (count <= 0) throw std::runtime_error(kNone);
    std::string lines;
    for (int i = 0; i < count; ++i) {
      std::string text;  // one without power, or of another program, does not hide the others
      try {
        text = Device("auto", i).name();
      } catch (const std::runtime_error& reason) {
        text = std::string("cannot be opened: ") + reason.what();
      }
      lines += std::to_string(i) + "\t" + text + "\n";
    }
    std::snprintf(devices.text, devices.size, "%s", lines.c_str());
  });
}

std::int32_t connect(const char* address, const EnamelParameter* options, std::size_t count, EnamelConnected* connected,
                     EnamelMessage message) noexcept {
  return guardedSetup(message, [&] {
    const std::string text = *address == 0 ? "0" : address;
    int index = -1;
    const char* const end = text.data() + text.size();
    if (std::from_chars(text.data(), end, index).ptr != end || index < 0 || index >= kMostDevices)
      throw std::runtime_error("the address \"" + text + "\" must be the number of a device, 0 to 63");
    auto device = std::make_unique<Device>(optionOf(kOptions[0], options, count), index);
    connected->joints = device->joints();
    connected->device_file = device->deviceFile();
    connected->delay_low = 0;
    connected->delay_high = 1;  // estimated: the command goes over USB
    connected->has_own_clock = 0;
    std::snprintf(message.text, message.size, "%s", device->facts().c_str());
    connected->device =
        deviceTable(device.release(), [](void* user, double force) { return static_cast<Device*>(user)->grip(force); });
  });
}

}  // namespace
}  // namespace enamel::forcedimension

extern "C" const EnamelDriver* enamel_driver(void) {
  using namespace enamel::forcedimension;
  static const EnamelDriver table = enamel::driverTable<Device>([] { return &kDescription; }, list, connect);
  return &table;
}
