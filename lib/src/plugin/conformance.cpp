#include "enamel/plugin/conformance.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "bad_inputs.hpp"
#include "core/message.hpp"
#include "enamel/collision/contacts.hpp"
#include "enamel/device/device_file.hpp"

namespace enamel {
namespace conformance {
namespace {

// A path into the wall z = 0 and out again, three times, with a sideways motion. The motors hold the device's weight.
std::vector<EnamelTickInput> pathThroughWall(const Mechanism& mechanism, const ConformanceOptions& options) {
  std::vector<EnamelTickInput> path(static_cast<std::size_t>(options.ticks));
  const Scene wall = flatWall();
  JointVector before = mechanism.home().q;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(path.size());
    TickFrame in;
    in.time = options.period * static_cast<double>(i + 1);
    Pose pose;
    pose.position = {2e-3 * std::sin(7.0 * t), 1e-3 * std::cos(5.0 * t), 1e-3 * std::cos(6.0 * M_PI * t)};
    Kinematics& k = in.kinematics;
    if (mechanism.reach(pose, Vec6::Zero(), true, k) != Status::ok) throw Error("the device cannot reach its own home");
    if (i > 0) k.rates = (k.q - before) / options.period;
    before = k.q;
    k.twist = twistOf(k.jacobian, k.rates);
    in.contacts.contacts[0] = nearestContact(wall, Tool(), pose, nullptr);
    in.contacts.count = 1;
    in.maxTorque = mechanism.limits().effort;
    in.applied = k.gravity;
    std::memset(&path[i], 0, sizeof path[i]);
    toPlain(in, path[i]);
  }
  return path;
}

std::string tick(std::size_t i) { return "tick " + std::to_string(i); }

// The checks of a plugin. Each returns a detail to report, or throws Failure.
class Checks {
 public:
  Checks(const std::shared_ptr<const PluginLibrary>& library, const PluginSetup& setup, const Mechanism& mechanism,
         const ConformanceOptions& options)
      : library_(library),
        table_(library->table()),
        setup_(setup),
        options_(options),
        path_(pathThroughWall(mechanism, options)) {}

  std::string describesItself() {
    demand(table_.describe() == table_.describe(), "describe() returned different addresses");
    return std::string(library_->description().name) + " " + library_->description().version;
  }

  std::string refusesWrongOrder() {
    Instance instance(table_);
    demand(instance.step(path_[0]) == ENAMEL_INACTIVE, "step() on a new instance did not return inactive");
    requireDefined(instance.output, path_[0], true, "step() on a new instance");
    demand(instance.activate(options_.period) != ENAMEL_OK, "activate() before configure() was accepted");
    instance.reset();
    instance.deactivate();
    return "";
  }

  std::string configuresAndActivates() {
    Instance instance(table_);
    instance.prepare(setup_, options_.period);
    return "";
  }

  std::string refusesUnknownParameters() {
    Instance instance(table_);
    PluginSetup unknown = setup_;
    unknown.parameters["no-such-parameter"] = "1";
    demand(instance.configure(unknown) != ENAMEL_OK, "an unknown parameter was accepted");
    instance.prepare(setup_, options_.period);
    return "";
  }

  std::string refusesBadPeriods() {
    for (const double period : {0.0, -1e-3, std::nan(""), std::numeric_limits<double>::infinity()}) {
      Instance instance(table_);
      demand(instance.configure(setup_) == ENAMEL_OK, "configure() failed");
      demand(instance.activate(period) != ENAMEL_OK, "a period of " + formatNumber(period) + " s was accepted");
    }
    return "";
  }

  std::string refusesDoubleActivation() {
    Instance instance(table_);
    instance.prepare(setup_, options_.period);
    demand(instance.step(path_[0]) == ENAMEL_OK, "the first tick failed");
    demand(instance.activate(options_.period) != ENAMEL_OK, "a second activate() was accepted");
    demand(instance.configure(setup_) != ENAMEL_OK, "configure() while active was accepted");
    demand(instance.step(path_[1]) == ENAMEL_OK, "a tick after the refused calls failed");
    return "";
  }

  std::string startsAgain() {
    Instance instance(table_);
    instance.prepare(setup_, options_.period);
    demand(instance.step(path_[0]) == ENAMEL_OK, "the first tick failed");
    const EnamelTickOutput first = instance.output;
    instance.deactivate();
    demand(instance.step(path_[1]) == ENAMEL_INACTIVE, "step() after deactivate() did not return inactive");
    demand(instance.activate(options_.period) == ENAMEL_OK, "the second activate() failed");
    demand(instance.step(path_[0]) == ENAMEL_OK && same(instance.output, first),
           "the first tick after a new activate() differs");
    return "";
  }

  std::string answersPath() {
    Instance instance(table_);
    instance.prepare(setup_, options_.period);
    expected_ = runPath(instance);
    const auto contacts =
        std::count_if(expected_.begin(), expected_.end(), [](const auto& o) { return o.mode == ENAMEL_CONTACT; });
    demand(contacts > 0, "no tick inside the wall was rendered as a contact");
    return std::to_string(contacts) + " of " + std::to_string(expected_.size()) + " ticks in contact";
  }

  std::string answersSoftSurface() {
    Instance instance(table_);
    instance.prepare(setup_, options_.period);
    for (std::size_t i = 0; i < path_.size(); ++i) {
      EnamelTickInput input = path_[i];
      input.applied_known = 0;
      std::fill(std::begin(input.applied), std::end(input.applied), std::nan(""));
      input.contacts[0].stiffness = 1e4;
      input.contacts[0].friction = 0.5;
      input.contacts[0].sliding_friction = 0.4;
      input.contacts[0].viscosity = 1.0;
      const std::int32_t result = instance.step(input);
      demand(result == ENAMEL_OK, tick(i) + ": " + nameOf(result));
      requireDefined(instance.output, input, false, tick(i));
    }
    return "";
  }

  std::string repeatsInAnotherInstance() {
    Instance instance(table_);
    instance.prepare(setup_, options_.period);
    const std::vector<EnamelTickOutput> outputs = runPath(instance);
    for (std::size_t i = 0; i < outputs.size(); ++i) demand(same(outputs[i], expected_[i]), tick(i) + " differs");
    return "";
  }

  std::string repeatsAfterReset() {
    Instance instance(table_);
    instance.prepare(setup_, options_.period);
    const std::vector<unsigned char> fresh = instance.save();
    (void)runPath(instance);
    for (const std::size_t stop : {path_.size() / 6, path_.size() / 3}) {  // also from inside the wall
      instance.reset();
      demand(instance.save() == fresh, "the state after reset() is not the state after activate()");
      for (std::size_t i = 0; i < stop; ++i) {
        demand(instance.step(path_[i]) == ENAMEL_OK, tick(i) + " after reset() failed");
        demand(same(instance.output, expected_[i]), tick(i) + " after reset() differs");
      }
    }
    return "";
  }

  std::string savesState() {
    Instance one(table_), other(table_);
    one.prepare(setup_, options_.period);
    other.prepare(setup_, options_.period);
    const std::size_t middle = path_.size() / 4;
    for (std::size_t i = 0; i < middle; ++i) demand(one.step(path_[i]) == ENAMEL_OK, tick(i) + " failed");
    const std::vector<unsigned char> state = one.save();
    demand(one.save() == state, "saving twice gives different bytes");
    other.load(state);
    demand(other.save() == state, "the loaded state is not the saved one");
    for (std::size_t i = middle; i < path_.size(); ++i) {
      demand(one.step(path_[i]) == ENAMEL_OK && other.step(path_[i]) == ENAMEL_OK, tick(i) + " failed");
      demand(same(one.output, other.output) && same(one.output, expected_[i]),
             tick(i) + " differs after loading the state into another instance");
      demand(one.save() == other.save(), tick(i) + ": equal states have different bytes");
    }
    return std::to_string(state.size()) + " bytes";
  }

  std::string survivesBadInput() {
    Instance instance(table_);
    instance.prepare(setup_, options_.period);
    const std::size_t last = path_.size() / 5;
    for (std::size_t i = 0; i < last; ++i) demand(instance.step(path_[i]) == ENAMEL_OK, tick(i) + " failed");
    BadInputs inputs(instance, path_[last]);
    inputs.offerNumbers();
    inputs.offerSurfaces();
    inputs.offerCounts();
    inputs.offer("a time that did not advance", path_[last - 1], true);
    demand(instance.step(path_[last]) == ENAMEL_OK && same(instance.output, expected_[last]),
           "the good tick after the bad ones differs");
    return "";
  }

  std::string keepsTorqueLimit() {
    Instance instance(table_);
    instance.prepare(setup_, options_.period);
    for (std::size_t i = 0; i < path_.size(); ++i) {
      EnamelTickInput input = path_[i];
      for (double& limit : input.max_torque) limit = 1e-3;
      demand(instance.step(input) == ENAMEL_OK, tick(i) + " failed");
      requireDefined(instance.output, input, false, tick(i));
    }
    return "";
  }

  std::string allocatesNothing() {
    Instance instance(table_);
    instance.prepare(setup_, options_.period);
    std::vector<unsigned char> state = instance.save();
    const long before = options_.allocationCount();
    for (std::size_t i = 0; i < path_.size(); ++i) {
      (void)instance.step(path_[i]);
      instance.saveTo(state);
    }
    instance.reset();
    const long count = options_.allocationCount() - before;
    demand(count == 0, std::to_string(count) + " allocations or releases in " + std::to_string(path_.size()) +
                           " ticks and a reset");
    return "";
  }

  std::string takesTime() {
    using Clock = std::chrono::steady_clock;
    Instance instance(table_);
    instance.prepare(setup_, options_.period);
    std::vector<double> times_us;
    for (const EnamelTickInput& input : path_) {
      const auto start = Clock::now();
      (void)instance.step(input);
      times_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    }
    std::sort(times_us.begin(), times_us.end());
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), "median %.2f us, p99.9 %.2f us, longest %.2f us",
                  times_us[times_us.size() / 2], times_us[times_us.size() * 999 / 1000], times_us.back());
    return text.data();
  }

 private:
  // Run the whole path, without a reset, and return its outputs for comparison.
  std::vector<EnamelTickOutput> runPath(Instance& instance) {
    std::vector<EnamelTickOutput> outputs;
    for (std::size_t i = 0; i < path_.size(); ++i) {
      const std::int32_t result = instance.step(path_[i]);
      demand(result == ENAMEL_OK, tick(i) + " of a plain path: " + nameOf(result));
      requireDefined(instance.output, path_[i], false, tick(i));
      outputs.push_back(instance.output);
    }
    return outputs;
  }

  const std::shared_ptr<const PluginLibrary> library_;
  const EnamelPlugin& table_;
  const PluginSetup& setup_;
  const ConformanceOptions& options_;
  const std::vector<EnamelTickInput> path_;
  std::vector<EnamelTickOutput> expected_;  // of the path, set by answersPath()
};

// The other checks need these to pass.
constexpr Check<Checks> kBasics[] = {
    {"describes itself the same way every time", &Checks::describesItself},
    {"refuses calls out of order", &Checks::refusesWrongOrder},
    {"configures and activates", &Checks::configuresAndActivates},
};
constexpr Check<Checks> kCalls[] = {
    {"refuses unknown parameters and stays usable", &Checks::refusesUnknownParameters},
    {"refuses bad periods", &Checks::refusesBadPeriods},
    {"refuses double activation and configuration while active", &Checks::refusesDoubleActivation},
    {"is inactive after deactivate and starts again", &Checks::startsAgain},
    {"renders a path into a wall with finite torques within the limits", &Checks::answersPath},
};
constexpr Check<Checks> kAnswers[] = {
    {"renders a soft surface with friction on a device that does not report the torque that acted",
     &Checks::answersSoftSurface},
    {"gives the same bits in another instance", &Checks::repeatsInAnotherInstance},
    {"repeats the first tick after reset", &Checks::repeatsAfterReset},
    {"its state can be saved, loaded and compared", &Checks::savesState},
    {"rejects bad input with an error, a defined output and an unchanged state", &Checks::survivesBadInput},
    {"keeps the torque within the given limit", &Checks::keepsTorqueLimit},
};
constexpr Check<Checks> kAllocation = {"allocates nothing in a tick", &Checks::allocatesNothing};
constexpr Check<Checks> kTime = {"time per step (reported only)", &Checks::takesTime};

}  // namespace
}  // namespace conformance

bool checkPlugin(const std::shared_ptr<const PluginLibrary>& library, const PluginSetup& setup,
                 const ConformanceOptions& options, const std::function<void(const ConformanceResult&)>& report) {
  using namespace conformance;
  const auto mechanism =
      makeMechanism(setup.deviceText.empty() ? loadDevice(setup.devicePath) : parseDevice(setup.deviceText, "device"));
  Checks checks(library, setup, *mechanism, options);
  Suite<Checks> suite(checks, report);
  if (!suite.run(kBasics) || !suite.run(kCalls)) return false;
  suite.run(kAnswers);
  suite.runCounted(kAllocation, static_cast<bool>(options.allocationCount));
  return suite.run(kTime);
}

}  // namespace enamel
