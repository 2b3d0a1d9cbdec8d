#include "enamel/plugin/driver_host.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <sstream>
#include <thread>

#include "enamel/device/device_file.hpp"
#include "plugin/library.hpp"
#include "plugin/own_device.hpp"

namespace enamel {
namespace {

constexpr int kLongestDelay = 63;  // ticks
constexpr std::size_t kListBytes = 16384;
constexpr std::chrono::milliseconds kLook{10};        // between two looks for a lost device
constexpr std::chrono::milliseconds kOpenAgain{250};  // before each attempt to open it again; the guard's ramp is over

void checkTable(const std::string& path, const EnamelDriver& table) {
  plugin::checkVersion(path, table.abi_version, ENAMEL_DRIVER_ABI_VERSION, ENAMEL_DRIVER_ABI_VERSION);
  plugin::checkSize(path, "EnamelDriver", table.driver_size, sizeof(EnamelDriver));
  plugin::checkSize(path, "EnamelConnected", table.connected_size, sizeof(EnamelConnected));
  plugin::checkSize(path, "EnamelMeasurement", table.measurement_size, sizeof(EnamelMeasurement));
  if (!table.describe || !table.list || !table.connect || !table.disconnect)
    throw PluginError(path + ": a function of its table is missing");
}

void checkScheme(const std::string& path, const std::string& name) {
  const bool isScheme = name.size() > 1 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
                          return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
                        });
  if (!isScheme)
    throw PluginError(path + ": its name \"" + name +
                      "\" cannot be a scheme: two or more small letters, digits or '-'");
}

// The options of a URL in the form that a driver receives. Throws PluginError for unknown and missing ones.
std::vector<EnamelParameter> parametersOf(const DriverLibrary& library,
                                          const std::map<std::string, std::string>& options) {
  const EnamelDescription& d = library.description();
  std::string known;
  for (std::size_t i = 0; i < d.parameter_count; ++i) {
    const EnamelParameter& p = d.parameters[i];
    known += (i > 0 ? ", " : "") + std::string(p.key);
    if (*p.value == 0 && options.count(p.key) == 0)
      throw PluginError(library.path() + ": option " + p.key + " is missing: " + p.meaning);
  }
  std::vector<EnamelParameter> parameters;
  for (const auto& [key, value] : options) {
    const bool isKnown = std::any_of(d.parameters, d.parameters + d.parameter_count,
                                     [&key = key](const EnamelParameter& p) { return key == p.key; });
    if (!isKnown)
      throw PluginError(library.path() + ": unknown option \"" + key + "\", " +
                        (known.empty() ? "the driver has no options" : "possible are " + known));
    parameters.push_back({key.c_str(), value.c_str(), nullptr});
  }
  return parameters;
}

// A connected device; its end disconnects. If measure() finds the device lost, a thread of its own closes it and opens
// it again until that succeeds. Until then the tick calls no function of the driver.
class ConnectedDevice final : public HapticDevice {
 public:
  ConnectedDevice(std::shared_ptr<const DriverLibrary> library, const std::string& address,
                  const std::map<std::string, std::string>& options)
      : library_(std::move(library)) {
    const std::vector<EnamelParameter> parameters = parametersOf(*library_, options);
    connected_.size = sizeof connected_;
    facts_ = plugin::requireOk(library_->path(), "connect", [&](EnamelMessage message) {
      return library_->table().connect(address.c_str(), parameters.data(), parameters.size(), &connected_, message);
    });
    try {
      check();
      device_ = makeDevice(connected_.device, connected_.joints);
    } catch (const Error& error) {
      library_->table().disconnect(&connected_);
      throw PluginError(library_->path() + ": " + error.what());
    }
  }
  ~ConnectedDevice() override {
    close();
    library_->table().disconnect(&connected_);
  }
  ConnectedDevice(const ConnectedDevice&) = delete;
  ConnectedDevice& operator=(const ConnectedDevice&) = delete;

  void open() override {
    close();
    device_->open();
    isOpen_ = true;
    watch_ = std::thread([this] { watch(); });
  }
  void close() noexcept override {
    if (!watch_.joinable()) return;
    isOpen_ = false;
    watch_.join();
    isLost_ = false;
    device_->close();
  }
  Status measure(Measurement& measurement) noexcept override {
    if (isLost_) return Status::inactive;
    const Status status = device_->measure(measurement);
    // The last access to the driver by this thread, until watch() has opened the device again.
    if (isOpen_ && status != Status::ok && status != Status::stale) isLost_ = true;
    return status;
  }
  Status actuate(const Command& command) noexcept override {
    return isLost_ ? Status::inactive : device_->actuate(command);
  }

  const EnamelConnected& connected() const noexcept { return connected_; }
  const std::shared_ptr<const Mechanism>& mechanism() const noexcept { return mechanism_; }
  const std::string& facts() const noexcept { return facts_; }

 private:
  void check() {
    if (connected_.device_file == nullptr) throw Error("connect() gave no device file");
    mechanism_ = makeMechanism(parseDevice(connected_.device_file, "device file of the driver"));
    if (mechanism_->joints() != connected_.joints)
      throw Error("the device file of the driver has " + std::to_string(mechanism_->joints()) +
                  " joints, connect() gave " + std::to_string(connected_.joints));
    if (connected_.delay_low < 0 || connected_.delay_low > connected_.delay_high ||
        connected_.delay_high > kLongestDelay)
      throw Error("the delay of the driver is " + std::to_string(connected_.delay_low) + " to " +
                  std::to_string(connected_.delay_high) + " ticks, must be in 0 to " + std::to_string(kLongestDelay));
  }

  void watch() noexcept {
    for (auto before = std::chrono::steady_clock::now(); isOpen_; std::this_thread::sleep_for(kLook)) {
      const auto now = std::chrono::steady_clock::now();
      if (!isLost_) before = now;
      if (now - before < kOpenAgain) continue;
      before = now;
      device_->close();
      try {
        device_->open();
        isLost_ = false;
      } catch (const Error&) {  // still unplugged
      }
    }
  }

  std::shared_ptr<const DriverLibrary> library_;
  EnamelConnected connected_{};
  std::string facts_;
  std::shared_ptr<const Mechanism> mechanism_;
  std::unique_ptr<HapticDevice> device_;
  std::atomic<bool> isOpen_{false}, isLost_{false};
  std::thread watch_;  // while open
};

}  // namespace

void DriverLibrary::use(const EnamelDriver& table) {
  checkTable(path_, table);
  table_ = &table;
  description_ = plugin::guarded(path_, "describe", table.describe);
  plugin::checkDescription(path_, description_);
  checkScheme(path_, description_->name);
}

std::shared_ptr<const DriverLibrary> DriverLibrary::of(const EnamelDriver& table, const std::string& name) {
  std::shared_ptr<DriverLibrary> library(new DriverLibrary);
  library->path_ = name;
  library->use(table);
  return library;
}

std::shared_ptr<const DriverLibrary> DriverLibrary::load(const std::string& path) {
  std::shared_ptr<DriverLibrary> library(new DriverLibrary);
  library->path_ = path;
  library->handle_ = plugin::loadShared(path);
  library->use(plugin::tableOf<EnamelDriver>(path, library->handle_.get(), ENAMEL_DRIVER_SYMBOL));
  return library;
}

DriverDevice connectDriver(std::shared_ptr<const DriverLibrary> library, const std::string& address,
                           const std::map<std::string, std::string>& options) {
  auto device = std::make_unique<ConnectedDevice>(std::move(library), address, options);
  const EnamelConnected& c = device->connected();
  DriverDevice result;
  result.text = c.device_file;
  result.mechanism = device->mechanism();
  result.facts = device->facts();
  result.delayLow = c.delay_low;
  result.delayHigh = c.delay_high;
  result.hasOwnClock = c.has_own_clock != 0;
  result.device = std::move(device);
  return result;
}

std::vector<DriverListing> listDriver(const DriverLibrary& library) {
  std::string text(kListBytes, '\0');
  (void)plugin::requireOk(library.path(), "list", [&](EnamelMessage message) {
    return library.table().list({text.data(), text.size()}, message);
  });
  text.back() = 0;
  std::istringstream lines(text.c_str());  // up to the first 0
  std::vector<DriverListing> rows;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t tab = line.find('\t');
    rows.push_back({line.substr(0, tab), tab == std::string::npos ? std::string() : printable(line.substr(tab + 1))});
  }
  return rows;
}

std::shared_ptr<const DriverLibrary> findDriver(const std::string& nameOrPath, const std::string& folder) {
  return plugin::find<DriverLibrary>("driver", nameOrPath, folder);
}

bool isDriver(const std::string& path) {
  return system::symbolOf(plugin::loadShared(path).get(), ENAMEL_DRIVER_SYMBOL) != nullptr;
}

}  // namespace enamel
