// The driver of 3D Systems' Touch and Phantom through the functions that OpenHaptics documents (HD API, libHD, opened
// at run time). The scheduler of the vendor calls frame() in its own thread. lib/docs/touch.md has the page. Not yet
// tried on hardware. Names and values: "OpenHaptics Toolkit, API Reference Guide" and its header hdDefines.h.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <charconv>
#include <memory>
#include <stdexcept>
#include <string>

#include "../driver_functions.hpp"
#include "../vendor_library.hpp"
#include "enamel/runtime/triple_buffer.hpp"
#include "errors.hpp"

namespace enamel::openhaptics {
namespace {

using Eigen::Vector3d;

constexpr int kJoints = 6;                                          // the stylus turns without motors
constexpr unsigned kButtons = 0x2000;                               // HD_CURRENT_BUTTONS
constexpr unsigned kPosition = 0x2050, kTransform = 0x2052;         // HD_CURRENT_..., mm
constexpr unsigned kForce = 0x2700;                                 // HD_CURRENT_FORCE, N
constexpr unsigned kVersion = 0x2500, kModel = 0x2501;              // HD_VERSION, HD_DEVICE_MODEL_TYPE
constexpr unsigned kDriver = 0x2502, kSerial = 0x2504;              // HD_DEVICE_DRIVER_VERSION, ..._SERIAL_NUMBER
constexpr unsigned kFirmware = 0x2505;                              // HD_DEVICE_FIRMWARE_VERSION
constexpr unsigned kUsableWorkspace = 0x2551;                       // its lowest and highest corner, mm
constexpr unsigned kCalibrationStyle = 0x2555, kMaxForce = 0x2603;  // HD_NOMINAL_MAX_FORCE, N
constexpr unsigned kMaxStiffness = 0x2602, kMaxDamping = 0x2609;    // HD_NOMINAL_MAX_..., N/mm, N s/mm
constexpr unsigned kContinuousForce = 0x2604;                       // HD_NOMINAL_MAX_CONTINUOUS_FORCE, N
constexpr unsigned kMotorTemperature = 0x2605;                      // of each motor, 0 to 1
constexpr unsigned kForceOutput = 0x4000;                           // HD_FORCE_OUTPUT
constexpr unsigned kCalibrated = 0x5000, kNeedsUpdate = 0x5001;     // results of hdCheckCalibration()
constexpr unsigned kInvalid = 0xFFFFFFFF;                           // HD_INVALID_HANDLE
constexpr unsigned kContinue = 1;                                   // HD_CALLBACK_CONTINUE
constexpr unsigned short kHighest = 0xFFFF;                         // HD_MAX_SCHEDULER_PRIORITY
constexpr double kSilent = 0.02;    // s without a command, after which the force is zero: the vendor repeats the last
constexpr double kCut = 0.1;        // s without forces after the device refused one
constexpr double kSlow = 0.1;       // s between two readings of temperatures and calibration
constexpr std::size_t kMotors = 8;  // room for the temperatures; the devices have three or six
constexpr unsigned kRate = 1000;    // of the scheduler, Hz
constexpr double kTouchForce = 3.3, kTouchXForce = 7.9;  // N, as in the device files
constexpr const char* kName = "Default Device";

const EnamelParameter kOptions[] = {
    {"library", "auto", "file of the vendor's library; auto: libHD.so or hd.dll where the system finds it"},
    {"rate", "1000", "of the vendor's scheduler, Hz, the same as that of the ticks (--rate); few devices have others"},
};
const EnamelDescription kDescription = {"openhaptics", "0.2.0", "3D Systems Touch and Phantom through OpenHaptics",
                                        kOptions, sizeof kOptions / sizeof kOptions[0]};

const char* const kTouch =
#include <touch_device.inl>
    ;
const char* const kTouchX =
#include <touch-x_device.inl>
    ;

// The functions of the HD API that the driver uses.
struct Sdk {
  explicit Sdk(const std::string& file) : library(file, {"libHD.so.3.4", "libHD.so"}, {"hd.dll"}) {
    library.bind("hdInitDevice", init);
    library.bind("hdDisableDevice", disableDevice);
    library.bind("hdMakeCurrentDevice", makeCurrent);
    library.bind("hdGetString", text);
    library.bind("hdGetIntegerv", integers);
    library.bind("hdGetDoublev", doubles);
    library.bind("hdSetDoublev", setDoubles);
    library.bind("hdGetError", error);
    library.bind("hdCheckCalibration", checkCalibration);
    library.bind("hdUpdateCalibration", updateCalibration);
    library.bind("hdEnable", enable);
    library.bind("hdDisable", disable);
    library.bind("hdSetSchedulerRate", setRate);
    library.bind("hdScheduleAsynchronous", schedule);
    library.bind("hdUnschedule", unschedule);
    library.bind("hdStartScheduler", start);
    library.bind("hdStopScheduler", stop);
    library.bind("hdBeginFrame", beginFrame);
    library.bind("hdEndFrame", endFrame);
  }

  // Empty the stack, whose top is the newest error. Return the oldest one that is worse than a cut force, or a cut
  // force, or success.
  HdError takeError() const noexcept {
    HdError worst{};
    for (int i = 0; i < 64; ++i) {
      const HdError next = error();
      if (next.code == 0) break;
      if (worst.code == 0 || !isCut(next.code)) worst = next;
    }
    return worst;
  }

  VendorLibrary library;
  unsigned (*init)(const char* name);
  void (*disableDevice)(unsigned handle);
  void (*makeCurrent)(unsigned handle);
  const char* (*text)(unsigned name);
  void (*integers)(unsigned name, int* values);
  void (*doubles)(unsigned name, double* values);
  void (*setDoubles)(unsigned name, const double* values);
  HdError (*error)();
  unsigned (*checkCalibration)();
  void (*updateCalibration)(unsigned style);
  void (*enable)(unsigned capability);
  void (*disable)(unsigned capability);
  void (*setRate)(unsigned rate);
  unsigned long (*schedule)(unsigned (*call)(void*), void* user, unsigned short priority);
  void (*unschedule)(unsigned long task);
  void (*start)();
  void (*stop)();
  void (*beginFrame)(unsigned handle);
  void (*endFrame)(unsigned handle);
};

// Values that a frame read, in the axes of the HD API, which are those of W.
struct State {
  double time = 0.0;          // s
  double position[3] = {};    // mm
  double transform[16] = {};  // column by column: axes of the stylus and its position
  int buttons = 0;
  double heat = 0.0;  // share of the limit
  bool isCut = false, isLost = false, isCalibrated = true;
};

class Device {
 public:
  Device(const std::string& file, std::string name, unsigned rate) : sdk_(file), name_(std::move(name)), rate_(rate) {
    initialise();
  }
  ~Device() {
    close();
    release();
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  std::string model() const { return stringOf(kModel); }
  std::string serial() const { return stringOf(kSerial); }

  // Model, versions and the vendor's limits, for reports.
  std::string facts() const {
    sdk_.makeCurrent(handle_);
    char limits[160];
    std::snprintf(limits, sizeof limits,
                  "; at most %.3g N, %.3g N continuously; the vendor's springs up to %.3g N/m and %.3g N s/m",
                  numberOf(kMaxForce), numberOf(kContinuousForce), 1e3 * numberOf(kMaxStiffness),
                  1e3 * numberOf(kMaxDamping));
    char firmware[40];
    std::snprintf(firmware, sizeof firmware, ", firmware %g", numberOf(kFirmware));
    const std::string text = model() + ", serial number " + serial() + firmware + ", driver " + stringOf(kDriver) +
                             ", HD API " + stringOf(kVersion) + limits;
    (void)sdk_.takeError();  // an old version may not know all of them
    return text;
  }
  bool isTouchX() const {
    return model().find("Touch X") != std::string::npos || model().find("Desktop") != std::string::npos;
  }

  void open() {
    if (isLost_) initialise();
    sdk_.makeCurrent(handle_);
    calibrate();
    send(Vector3d::Zero());
    (void)state_.refresh();  // a state from before
    rates_.reset();
    cut_ = silent_ = 0;
    frames_ = 0;
    sdk_.enable(kForceOutput);
    sdk_.setRate(rate_);
    task_ = sdk_.schedule(
        [](void* user) {
          static_cast<Device*>(user)->frame();
          return kContinue;
        },
        this, kHighest);
    sdk_.start();
    isOpen_ = true;
    if (const HdError e = sdk_.takeError(); e.code != 0 && !isCut(e.code)) {
      close();
      throw std::runtime_error("the scheduler does not start: " + textOf(e));
    }
  }

  void close() noexcept {
    if (!isOpen_) return;
    send(Vector3d::Zero());
    sdk_.disable(kForceOutput);
    sdk_.stop();
    sdk_.unschedule(task_);
    isOpen_ = false;
  }

  std::int32_t measure(EnamelMeasurement& m) noexcept {
    if (!isOpen_ || isLost_) return ENAMEL_INACTIVE;
    if (!state_.refresh()) return ENAMEL_STALE;
    const State& s = state_.latest();
    isLost_ = s.isLost;
    if (isLost_) return ENAMEL_INACTIVE;
    if (!(s.time > time_)) return ENAMEL_STALE;
    std::memset(&m, 0, sizeof m);
    m.size = sizeof m;
    m.time = time_ = s.time;
    Eigen::Map<Vector3d>(m.q) = 1e-3 * (Eigen::Map<const Vector3d>(s.position) - centre_);
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(Eigen::Map<const Eigen::Matrix4d>(s.transform).topLeftCorner<3, 3>()));
    Eigen::Map<Vector3d>(m.q + 3) = turn.angle() * turn.axis();
    rates_.add(m, kJoints);
    m.enabled = s.isCut ? 0 : 1;
    m.buttons = static_cast<std::uint32_t>(s.buttons);
    m.heat = s.heat;
    m.conditions =
        (s.isCut ? std::uint32_t{ENAMEL_FORCES_CUT} : 0U) | (s.isCalibrated ? 0U : std::uint32_t{ENAMEL_UNCALIBRATED});
    return ENAMEL_OK;
  }

  std::int32_t actuate(const double* effort, std::int32_t count) noexcept {
    if (!isOpen_ || isLost_) return ENAMEL_INACTIVE;
    if (const std::int32_t checked = checkEfforts(effort, count, kJoints); checked != ENAMEL_OK) return checked;
    const Vector3d force = Eigen::Map<const Vector3d>(effort);
    const double length = force.norm();  // the vendor refuses a longer force as a whole
    send(length > largest_ ? Vector3d(largest_ / length * force) : force);
    return ENAMEL_OK;
  }

 private:
  std::string stringOf(unsigned name) const {
    const char* const text = sdk_.text(name);
    return text == nullptr ? "unknown" : text;
  }
  double numberOf(unsigned name) const {
    double value = 0.0;
    sdk_.doubles(name, &value);
    return value;
  }

  void initialise() {
    release();
    (void)sdk_.takeError();
    handle_ = sdk_.init(name_.empty() ? nullptr : name_.c_str());
    const HdError e = sdk_.takeError();
    if (handle_ == kInvalid || (e.code != 0 && !isCut(e.code))) {
      release();
      throw std::runtime_error("the device \"" + (name_.empty() ? kName : name_) + "\" does not open: " + textOf(e));
    }
    isLost_ = false;
    double corners[6] = {};
    sdk_.doubles(kUsableWorkspace, corners);
    centre_ = 0.5 * (Eigen::Map<const Vector3d>(corners) + Eigen::Map<const Vector3d>(corners + 3));
    const double nominal = numberOf(kMaxForce);
    largest_ = isTouchX() ? kTouchXForce : kTouchForce;
    if (nominal > 0.0) largest_ = std::min(largest_, nominal);
    (void)sdk_.takeError();
  }

  void release() noexcept {
    if (handle_ != kInvalid) sdk_.disableDevice(handle_);
    handle_ = kInvalid;
  }

  // Positions would jump during contact if a calibration came later.
  void calibrate() {
    int style = 0;
    sdk_.integers(kCalibrationStyle, &style);
    if (sdk_.checkCalibration() == kNeedsUpdate) sdk_.updateCalibration(static_cast<unsigned>(style));
    const HdError e = sdk_.takeError();
    if (sdk_.checkCalibration() == kCalibrated) return;
    throw std::runtime_error("the " + model() +
                             " is not calibrated: put the stylus into its inkwell and take it out, or run the vendor's "
                             "diagnostic program" +
                             (e.code == 0 ? std::string() : "; " + textOf(e)));
  }

  void send(const Vector3d& force) noexcept {
    command_.next() = {force[0], force[1], force[2]};
    command_.publish();
  }

  int framesIn(double time) const noexcept { return static_cast<int>(time * rate_); }

  // One frame, in the thread of the vendor.
  void frame() noexcept {
    State& s = state_.next();
    sdk_.beginFrame(handle_);
    s.time = driverClock();
    sdk_.doubles(kPosition, s.position);
    sdk_.doubles(kTransform, s.transform);
    sdk_.integers(kButtons, &s.buttons);
    if (frames_ == 0) {
      std::array<double, kMotors> heat{};
      sdk_.doubles(kMotorTemperature, heat.data());
      heat_ = *std::max_element(heat.begin(), heat.end());
      isCalibrated_ = sdk_.checkCalibration() == kCalibrated;
    }
    frames_ = (frames_ + 1) % framesIn(kSlow);
    s.heat = heat_;
    s.isCalibrated = isCalibrated_;
    const HdError e = sdk_.takeError();  // of this frame, and of the end of the frame before
    cut_ = isCut(e.code) ? framesIn(kCut) : std::max(cut_ - 1, 0);
    s.isCut = cut_ > 0;
    s.isLost = e.code != 0 && !isCut(e.code);
    state_.publish();
    silent_ = command_.refresh() ? 0 : silent_ + 1;
    const std::array<double, 3> none{};
    sdk_.setDoubles(kForce, silent_ < framesIn(kSilent) ? command_.latest().data() : none.data());
    sdk_.endFrame(handle_);
  }

  Sdk sdk_;
  std::string name_;  // "": the default
  unsigned rate_;     // of the scheduler, Hz
  unsigned handle_ = kInvalid;
  unsigned long task_ = 0;
  bool isOpen_ = false, isLost_ = false;
  Vector3d centre_ = Vector3d::Zero();  // of the usable workspace, mm
  double largest_ = 0.0;                // N
  double time_ = 0.0;                   // of the last sample, s
  DriverRates rates_;
  // Of the vendor's thread:
  int cut_ = 0, silent_ = 0;
  int frames_ = 0;
  double heat_ = 0.0;  // share of the limit
  bool isCalibrated_ = true;
  TripleBuffer<State> state_;
  TripleBuffer<std::array<double, 3>> command_;
};

std::int32_t list(EnamelMessage devices, EnamelMessage message) noexcept {
  return guardedSetup(message, [&] {
    const Device device("auto", "", kRate);
    std::snprintf(devices.text, devices.size, "%s\t%s %s\n", kName, device.model().c_str(), device.serial().c_str());
  });
}

std::int32_t connect(const char* address, const EnamelParameter* options, std::size_t count, EnamelConnected* connected,
                     EnamelMessage message) noexcept {
  return guardedSetup(message, [&] {
    const std::string rate = optionOf(kOptions[1], options, count);
    const char* const end = rate.data() + rate.size();
    unsigned hertz = 0;
    if (std::from_chars(rate.data(), end, hertz).ptr != end || hertz < 500 || hertz > 10000)
      throw std::runtime_error("rate is \"" + rate + "\", must be 500 to 10000 Hz");
    auto device = std::make_unique<Device>(optionOf(kOptions[0], options, count), address, hertz);
    connected->joints = kJoints;
    connected->device_file = device->isTouchX() ? kTouchX : kTouch;
    connected->delay_low = 1;  // a force leaves with the next frame, or the one after
    connected->delay_high = 2;
    connected->has_own_clock = 1;
    std::snprintf(message.text, message.size, "%s", device->facts().c_str());
    connected->device = deviceTable(device.release());
  });
}

}  // namespace
}  // namespace enamel::openhaptics

extern "C" const EnamelDriver* enamel_driver(void) {
  using namespace enamel::openhaptics;
  static const EnamelDriver table = enamel::driverTable<Device>([] { return &kDescription; }, list, connect);
  return &table;
}
