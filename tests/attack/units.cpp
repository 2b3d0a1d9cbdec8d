// FMI units: archives, descriptions, and calls in any order on Enamel's units.
#include <array>
#include <cmath>
#include <string>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/device/device_file.hpp"
#include "memory_file.hpp"
#include "plugins/fmi/archive.hpp"
#include "plugins/fmi/export.hpp"
#include "plugins/fmi/fmi3.hpp"
#include "plugins/fmi/import.hpp"
#include "support/command.hpp"
#include "support/devices.hpp"
#include "surfaces.hpp"

namespace enamel::fmi {
#define DECLARE(name, type) extern "C" type name;
ENAMEL_FMI3_FUNCTIONS(DECLARE)
#undef DECLARE
}  // namespace enamel::fmi

namespace enamel::attack {

namespace {

const std::string kDevice = test::deviceFile("cartesian-3.toml");
constexpr std::size_t kLargest = 1 << 20;

void attackArchive(std::string_view bytes) {
  try {
    const fmi::UnpackedArchive archive(MemoryFile(bytes).path(), kLargest);
    std::uintmax_t size = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(archive.folder())) {
      require(!entry.is_symlink(), "no link is unpacked");
      if (entry.is_regular_file()) size += entry.file_size();
    }
    require(size <= kLargest, "no more is unpacked than was allowed");
  } catch (const Error&) {
  }
}

void attackDescription(std::string_view bytes) {
  static const DeviceParameters device = loadDevice(kDevice);
  static const test::TemporaryFolder folder;
  const std::string path = folder / "a.fmu";
  fmi::writeArchive(path, {{"modelDescription.xml", std::string(bytes)}});
  try {
    (void)fmi::plantsOf(path, device);
    require(false, "a unit without a binary is refused");
  } catch (const Error&) {
  }
}

// A unit's folder, and everything that a master needs to instantiate it.
struct Made {
  explicit Made(const std::string& renderer) {
    const test::TemporaryFolder folder;
    fmi::ExportSetup setup;
    setup.unit.renderer = renderer;
    if (!renderer.empty()) setup.unit.plant.clear();
    setup.deviceFile = setup.binary = kDevice;  // this program contains the unit's functions
    fmi::writeUnit(folder / "a.fmu", setup);
    archive = std::make_unique<fmi::UnpackedArchive>(folder / "a.fmu");
    const std::string text = readFile(archive->folder() + "/modelDescription.xml"), key = "instantiationToken=\"";
    const std::size_t at = text.find(key) + key.size();
    token = text.substr(at, text.find('"', at) - at);
  }
  std::unique_ptr<fmi::UnpackedArchive> archive;
  std::string token;
};

class Master {
 public:
  explicit Master(const Made& made) : made_(made) {}
  ~Master() {
    for (fmi::State& state : states_) fmi::fmi3FreeFMUState(instance_, &state);
    if (instance_ != nullptr) fmi::fmi3FreeInstance(instance_);
  }
  Master(const Master&) = delete;
  Master& operator=(const Master&) = delete;

  void act(Numbers& numbers) {
    if (instance_ == nullptr) instantiate();
    fmi::State& state = states_[static_cast<std::size_t>(numbers.pick(2))];
    switch (numbers.pick(12)) {
      case 0: (void)fmi::fmi3EnterInitializationMode(instance_, false, 0.0, number(numbers), false, 0.0); break;
      case 1: (void)fmi::fmi3ExitInitializationMode(instance_); break;
      case 2: (void)fmi::fmi3Terminate(instance_); break;
      case 3: (void)fmi::fmi3Reset(instance_); break;
      case 4: (void)fmi::fmi3GetFMUState(instance_, &state); break;
      case 5: (void)fmi::fmi3SetFMUState(instance_, state); break;
      case 6: (void)fmi::fmi3FreeFMUState(instance_, &state); break;
      case 7: serialise(state, numbers); break;
      case 8: get(numbers); break;
      case 9: set(numbers); break;
      default: step(numbers); break;
    }
  }

 private:
  static double number(Numbers& numbers) { return numbers.pick(4) == 0 ? numbers.next<double>() : 1e-3; }
  void instantiate() {
    instance_ =
        fmi::fmi3InstantiateCoSimulation("a", made_.token.c_str(), (made_.archive->folder() + "/resources/").c_str(),
                                         false, false, false, false, nullptr, 0, nullptr, nullptr, nullptr);
    require(instance_ != nullptr, "a unit is instantiated");
  }
  void serialise(fmi::State& state, Numbers& numbers) {
    std::size_t size = 0;
    if (fmi::fmi3SerializedFMUStateSize(instance_, state, &size) != fmi::ok) return;
    std::vector<std::uint8_t> bytes(size + 1);
    require(fmi::fmi3SerializeFMUState(instance_, state, bytes.data(), size) == fmi::ok, "a state has its size");
    for (int changes = numbers.pick(4); changes > 0; --changes)
      bytes[numbers.next<std::uint16_t>() % (size + 1)] = numbers.next<std::uint8_t>();
    if (numbers.pick(4) == 0) size = numbers.next<std::uint16_t>() % (size + 1);
    (void)fmi::fmi3DeserializeFMUState(instance_, bytes.data(), size, &state);
  }
  void get(Numbers& numbers) {
    const fmi::Reference reference = numbers.pick(16) == 0 ? numbers.next<fmi::Reference>() : numbers.pick(40) + 0u;
    std::array<double, 16> values{};
    std::array<std::int32_t, 16> integers{};
    std::array<bool, 16> flags{};
    const std::size_t count = static_cast<std::size_t>(numbers.pick(8));
    if (fmi::fmi3GetFloat64(instance_, &reference, 1, values.data(), count) == fmi::ok)
      for (const double value : values) require(std::isfinite(value), "variables are finite");
    (void)fmi::fmi3GetInt32(instance_, &reference, 1, integers.data(), count);
    (void)fmi::fmi3GetBoolean(instance_, &reference, 1, flags.data(), count);
  }
  void set(Numbers& numbers) {
    const fmi::Reference reference = static_cast<fmi::Reference>(numbers.pick(40));
    std::array<double, 16> values{};
    const std::array<std::int32_t, 16> integers{numbers.next<std::int32_t>()};
    const std::array<bool, 16> flags{numbers.pick(2) == 0};
    for (double& value : values)
      value = numbers.pick(8) == 0 ? numbers.next<double>() : 1e-4 * numbers.next<signed char>();
    const std::size_t count = static_cast<std::size_t>(numbers.pick(8));
    (void)fmi::fmi3SetFloat64(instance_, &reference, 1, values.data(), count);
    (void)fmi::fmi3SetInt32(instance_, &reference, 1, integers.data(), count);
    (void)fmi::fmi3SetBoolean(instance_, &reference, 1, flags.data(), count);
  }
  void step(Numbers& numbers) {
    bool event = true, terminate = true, early = true;
    double last = 0.0;
    const double size = number(numbers);
    if (fmi::fmi3DoStep(instance_, time_, size, true, &event, &terminate, &early, &last) == fmi::ok) time_ = last;
    require(!event && !terminate && !early, "a step ends where it should");
  }

  const Made& made_;
  fmi::Instance instance_ = nullptr;
  std::array<fmi::State, 2> states_{};
  double time_ = 0.0;
};

void attackUnit(std::string_view bytes) {
  static const Made plant(""), renderer("impedance");
  Numbers numbers(bytes);
  Master master(numbers.pick(2) == 0 ? plant : renderer);
  for (int i = 0; i < 300 && !numbers.empty(); ++i) master.act(numbers);
}

const Registration kUnits[] = {{"archive", attackArchive}, {"description", attackDescription}, {"unit", attackUnit}};

}  // namespace

}  // namespace enamel::attack
