#include "enamel/session/open_device.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <iterator>
#include <thread>

#include "core/message.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "enamel/device/nominal_device.hpp"
#include "enamel/plugin/driver_host.hpp"
#include "enamel/runtime/udp_device.hpp"

namespace enamel {
namespace {

constexpr double kRateCutoff = 100.0;   // Hz
constexpr double kShortestPoll = 1e-4;  // s

[[noreturn]] void refuse(const DeviceUrl& url, const std::string& why) {
  throw Error("device URL \"" + url.text + "\": " + why);
}

// Run `work`, and put the URL before the reason of its errors.
template <typename Work>
auto naming(const DeviceUrl& url, const Work& work) {
  try {
    return work();
  } catch (const Error& error) {
    refuse(url, error.what());
  }
}

// Return the number of characters before the first ":", if they can be a scheme; otherwise 0.
std::size_t schemeLength(const std::string& text) noexcept {
  const auto end = std::find_if_not(text.begin(), text.end(), [](unsigned char c) {
    return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
  });
  // A single letter is a drive of Windows.
  return end != text.end() && *end == ':' && end - text.begin() > 1 ? static_cast<std::size_t>(end - text.begin()) : 0;
}

void requireOptions(const DeviceUrl& url, const std::vector<std::string>& known) {
  std::string list;
  for (const std::string& key : known) list += (list.empty() ? "" : ", ") + key;
  for (const auto& [key, value] : url.options)
    if (std::find(known.begin(), known.end(), key) == known.end())
      refuse(url, "unknown option \"" + key + "\", " +
                      (known.empty() ? url.scheme + " has no options" : "possible are " + list));
}

// Return the value of an option; empty if it is missing.
std::string optionOf(const DeviceUrl& url, const char* key) {
  const auto found = url.options.find(key);
  return found == url.options.end() ? std::string() : found->second;
}

Delay delayOf(const std::string& text) {
  const std::optional<Delay> delay = readDelay(text);
  require(delay && delay->low >= 0 && delay->low <= delay->high && delay->high <= kMaxDelay,
          "delay is \"" + text + "\", must be N or LOW..HIGH in 0 to " + std::to_string(kMaxDelay) + " ticks");
  return *delay;
}

// Read the device file, or the nominal TAU if `file` is empty.
OpenedDevice describe(const std::string& file) {
  OpenedDevice opened;
  opened.file = file;
  opened.text = file.empty() ? std::string(nominalDeviceText()) : readFile(file);
  opened.mechanism = makeMechanism(parseDevice(opened.text, file));
  return opened;
}

OpenedDevice openVirtual(const DeviceUrl& url, const OpenDeviceOptions& options) {
  requireOptions(url, {});
  OpenedDevice opened = describe(url.address);
  VirtualDeviceSetup setup;
  setup.start = options.start.value_or(opened.mechanism->home().pose);
  setup.period = options.period;
  setup.encoders = {true, RateSource::difference, kRateCutoff};
  opened.device = std::make_unique<SimulatedDevice>(*opened.mechanism, setup,
                                                    options.hand ? options.hand : pressingHand(setup.start), true);
  return opened;
}

// Wait for the first measurement, so that nothing starts without a server.
void awaitServer(HapticDevice& device) {
  Measurement measurement;
  for (int ms = 0; device.measure(measurement) != Status::ok; ++ms) {
    if (ms == 1000)
      throw Error("no measurement within 1 s; the server needs the same key and device file, and no other client");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

// How often to measure a device with its own clock, s.
double pollOf(const OpenDeviceOptions& options) { return std::max(kShortestPoll, 0.25 * options.period); }

OpenedDevice openUdp(const DeviceUrl& url, const OpenDeviceOptions& options) {
  requireOptions(url, {"delay", "device", "key"});
  const std::size_t colon = url.address.rfind(':');
  const std::string host = url.address.substr(0, colon);
  std::uint16_t port = kDevicePort;
  if (colon != std::string::npos) {
    const char *at = url.address.data() + colon + 1, *end = url.address.data() + url.address.size();
    const auto [rest, error] = std::from_chars(at, end, port);
    if (error != std::errc{} || rest != end || port == 0)
      throw Error("the address must be HOST or HOST:PORT with a port in 1 to 65535");
  }
  OpenedDevice opened = describe(optionOf(url, "device"));
  opened.delay = {1, 2};  // a command acts one or two ticks after its measurement
  opened.poll = pollOf(options);
  LinkOptions link;
  link.joints = opened.mechanism->joints();
  if (const std::string key = optionOf(url, "key"); !key.empty()) link.key = readKey(key);
  opened.device = std::make_unique<UdpDevice>(host, port, link);
  awaitServer(*opened.device);
  return opened;
}

struct Scheme {
  const char *name, *form, *summary;
  OpenedDevice (*open)(const DeviceUrl& url, const OpenDeviceOptions& options);
};
constexpr Scheme kSchemes[] = {
    {kVirtualScheme, "virtual:FILE",
     "simulated device of a device file, held by a simulated hand; without FILE, the nominal TAU", openVirtual},
    {"udp", "udp://HOST:PORT?device=FILE&key=FILE&delay=N",
     "driver in another process, language or machine, such as enamel device --serve", openUdp},
};

std::string possibleForms() {
  std::string list = "possible are ";
  for (const Scheme& scheme : kSchemes) list += std::string(scheme.form) + ", ";
  return list + "and NAME://ADDRESS of a driver";
}

std::shared_ptr<const DriverLibrary> driverOf(const DeviceUrl& url, const std::string& folder) {
  try {
    return findDriver(url.scheme, folder);
  } catch (const PluginError& error) {
    throw Error(std::string(error.what()) + "; " + possibleForms());
  }
}

OpenedDevice openWithDriver(DeviceUrl url, const OpenDeviceOptions& options) {
  const auto library = driverOf(url, options.pluginFolder);
  const std::string file = optionOf(url, "device");
  url.options.erase("device");
  url.options.erase("delay");
  DriverDevice driver = connectDriver(library, url.address, url.options);
  OpenedDevice opened;
  if (file.empty()) {
    opened.text = driver.text;
    opened.mechanism = driver.mechanism;
  } else {
    opened = describe(file);
    require(opened.mechanism->joints() == driver.mechanism->joints(),
            file + " has " + std::to_string(opened.mechanism->joints()) + " joints, the connected device has " +
                std::to_string(driver.mechanism->joints()));
  }
  opened.facts = driver.facts;
  opened.delay = {driver.delayLow, driver.delayHigh};
  if (driver.hasOwnClock) opened.poll = pollOf(options);
  opened.device = std::move(driver.device);
  return opened;
}

}  // namespace

bool isDeviceUrl(const std::string& text) noexcept { return schemeLength(text) > 0; }

DeviceUrl parseDeviceUrl(const std::string& text) {
  DeviceUrl url;
  url.text = text;
  const std::size_t colon = schemeLength(text);
  if (colon == 0) refuse(url, "it must begin with a scheme in small letters and ':'; " + possibleForms());
  url.scheme = text.substr(0, colon);
  const std::size_t question = text.find('?');
  const std::size_t begin = text.compare(colon, 3, "://") == 0 ? colon + 3 : colon + 1;
  url.address = text.substr(begin, question == std::string::npos ? question : question - std::min(begin, question));
  for (std::size_t at = question; at != std::string::npos;) {
    const std::size_t next = text.find('&', at + 1);
    const std::string option = text.substr(at + 1, next == std::string::npos ? next : next - at - 1);
    const std::size_t equals = option.find('=');
    if (equals == std::string::npos || equals == 0) refuse(url, "option \"" + option + "\" must be KEY=VALUE");
    if (!url.options.emplace(option.substr(0, equals), option.substr(equals + 1)).second)
      refuse(url, "option \"" + option.substr(0, equals) + "\" is given twice");
    at = next;
  }
  return url;
}

OpenedDevice openDevice(const std::string& text, const OpenDeviceOptions& options) {
  const DeviceUrl url = parseDeviceUrl(text);
  return naming(url, [&] {
    const auto* const scheme = std::find_if(std::begin(kSchemes), std::end(kSchemes),
                                            [&](const Scheme& each) { return url.scheme == each.name; });
    const auto found = url.options.find("delay");
    const Delay delay = found != url.options.end() ? delayOf(found->second) : Delay{};
    OpenedDevice opened = scheme != std::end(kSchemes) ? scheme->open(url, options) : openWithDriver(url, options);
    if (found != url.options.end()) opened.delay = delay;
    return opened;
  });
}

std::vector<DeviceForm> builtInDevices() {
  std::vector<DeviceForm> forms;
  for (const Scheme& scheme : kSchemes) forms.push_back({scheme.form, scheme.summary});
  return forms;
}

}  // namespace enamel
