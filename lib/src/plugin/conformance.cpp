#include "enamel/plugin/conformance.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "convert.hpp"
#include "core/message.hpp"
#include "enamel/collision/contacts.hpp"
#include "enamel/device/device_file.hpp"

namespace enamel {
namespace {

/// What a check throws to fail.
struct Failure {
  std::string reason;
};

void demand(bool condition, const std::string& reason) {
  if (!condition) throw Failure{reason};
}

std::string nameOf(std::int32_t result) {
  constexpr const char* names[] = {"ok",           "not finite", "unreachable", "singular",    "not converged",
                                   "out of range", "stale",      "inactive",    "wrong order", "bad configuration"};
  return result >= 0 && result < 10 ? names[result] : "unknown code " + std::to_string(result);
}

// Into the wall z = 0 and out again, three times, swaying; as a device at rest in every tick would measure it.
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
    in.maxTorque = mechanism.limits().torque;
    in.applied = k.gravity;
    std::memset(&path[i], 0, sizeof path[i]);
    toPlain(in, path[i]);
  }
  return path;
}

// An instance under test, called as a host calls it.
class Instance {
 public:
  explicit Instance(const EnamelPlugin& table) : table_(table), self_(table.create()) {
    demand(self_ != nullptr, "create() returned nothing");
  }
  ~Instance() { table_.destroy(self_); }
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  std::int32_t configure(const PluginSetup& setup) {
    const PlainSetup plain(setup);
    return table_.configure(self_, plain.get(), message());
  }
  std::int32_t activate(double period) { return table_.activate(self_, period, message()); }
  std::int32_t step(const EnamelTickInput& input) {
    std::memset(&output, 0x7f, sizeof output);  // what a plugin does not write shows
    return table_.step(self_, &input, &output);
  }
  void reset() { table_.reset(self_); }
  void deactivate() { table_.deactivate(self_); }
  std::vector<unsigned char> save() const {
    std::vector<unsigned char> state(table_.state_size(self_));
    table_.save_state(self_, state.data());
    return state;
  }
  void saveTo(std::vector<unsigned char>& state) const { table_.save_state(self_, state.data()); }
  void load(const std::vector<unsigned char>& state) { table_.load_state(self_, state.data()); }

  void prepare(const PluginSetup& setup, double period) {
    if (const std::int32_t result = configure(setup); result != ENAMEL_OK) fail("configure()", result);
    if (const std::int32_t result = activate(period); result != ENAMEL_OK) fail("activate()", result);
  }

  EnamelTickOutput output{};

 private:
  EnamelMessage message() {
    text_.fill(0);
    return {text_.data(), text_.size()};
  }
  [[noreturn]] void fail(const char* what, std::int32_t result) {
    text_.back() = 0;
    throw Failure{std::string(what) + " failed: " + nameOf(result) + (text_[0] != 0 ? ": " : "") + text_.data()};
  }

  const EnamelPlugin& table_;
  void* self_;
  std::array<char, 512> text_{};
};

// Finite, and a torque within the limits of `input`; zero where it `failed`.
void requireDefined(const EnamelTickOutput& output, const EnamelTickInput& input, bool failed,
                    const std::string& when) {
  demand(output.answer == ENAMEL_TORQUE || output.answer == ENAMEL_WRENCH,
         when + ": the answer is " + std::to_string(output.answer) + ", neither torque nor wrench");
  for (int i = 0; i < kMaxJoints; ++i) {
    const std::string name = when + ": torque " + std::to_string(i + 1);
    const double limit = i < input.joint_count && std::isfinite(input.max_torque[i]) ? input.max_torque[i] : 0.0;
    demand(std::isfinite(output.torque[i]), name + " is not finite");
    demand(std::abs(output.torque[i]) <= (failed ? 0.0 : std::max(0.0, limit)),
           name + " is " + formatNumber(output.torque[i]) + " N m, the limit " + formatNumber(failed ? 0.0 : limit) +
               " N m");
    demand(output.answer == ENAMEL_TORQUE || output.torque[i] == 0.0, name + " is set beside a wrench");
  }
  for (const double value : output.wrench) {
    demand(std::isfinite(value), when + ": the wrench is not finite");
    demand((output.answer == ENAMEL_WRENCH && !failed) || value == 0.0, when + ": the wrench is not zero");
  }
  demand(std::isfinite(output.normal_force), when + ": the normal force is not finite");
  demand(output.mode >= ENAMEL_FREE && output.mode <= ENAMEL_FAULT,
         when + ": the mode is " + std::to_string(output.mode));
  demand(output.saturated == 0 || output.saturated == 1, when + ": saturated is " + std::to_string(output.saturated));
}

bool same(const EnamelTickOutput& a, const EnamelTickOutput& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;  // NOLINT(bugprone-suspicious-memory-comparison): to the bit
}

std::string tick(std::size_t i) { return "tick " + std::to_string(i); }

}  // namespace

bool checkPlugin(const std::shared_ptr<const PluginLibrary>& library, const PluginSetup& setup,
                 const ConformanceOptions& options, const std::function<void(const ConformanceResult&)>& report) {
  using Verdict = ConformanceResult::Verdict;
  const auto mechanism =
      makeMechanism(setup.deviceText.empty() ? loadDevice(setup.devicePath) : parseDevice(setup.deviceText, "device"));
  const std::vector<EnamelTickInput> path = pathThroughWall(*mechanism, options);
  const EnamelPlugin& table = library->table();
  bool allPassed = true;
  const auto check = [&](const char* what, const std::function<std::string()>& run) {
    ConformanceResult result{what, Verdict::passed, ""};
    try {
      result.detail = run();
    } catch (const Failure& failure) {
      result = {what, Verdict::failed, failure.reason};
    } catch (const std::exception& error) {
      result = {what, Verdict::failed, std::string("an exception crossed the boundary: ") + error.what()};
    } catch (...) {
      result = {what, Verdict::failed, "an exception crossed the boundary"};
    }
    allPassed = allPassed && result.verdict != Verdict::failed;
    report(result);
    return result.verdict == Verdict::passed;
  };
  // The outputs of the whole path from a fresh reset, for comparison.
  const auto runPath = [&](Instance& instance) {
    std::vector<EnamelTickOutput> outputs;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const std::int32_t result = instance.step(path[i]);
      demand(result == ENAMEL_OK, tick(i) + " of a plain path: " + nameOf(result));
      requireDefined(instance.output, path[i], false, tick(i));
      outputs.push_back(instance.output);
    }
    return outputs;
  };

  check("describes itself the same way every time", [&] {
    demand(table.describe() == table.describe(), "describe() returned different places");
    return std::string(library->description().name) + " " + library->description().version;
  });
  check("refuses calls out of order", [&] {
    Instance instance(table);
    demand(instance.step(path[0]) == ENAMEL_INACTIVE, "step() on a new instance did not answer inactive");
    requireDefined(instance.output, path[0], true, "step() on a new instance");
    demand(instance.activate(options.period) != ENAMEL_OK, "activate() before configure() was accepted");
    instance.reset();
    instance.deactivate();
    return std::string();
  });
  check("configures and activates", [&] {
    Instance instance(table);
    instance.prepare(setup, options.period);
    return std::string();
  });
  if (!allPassed) return false;  // nothing else can be judged
  check("refuses unknown parameters and stays usable", [&] {
    Instance instance(table);
    PluginSetup unknown = setup;
    unknown.parameters["no-such-parameter"] = "1";
    demand(instance.configure(unknown) != ENAMEL_OK, "an unknown parameter was accepted");
    instance.prepare(setup, options.period);
    return std::string();
  });
  check("refuses bad periods", [&] {
    for (const double period : {0.0, -1e-3, std::nan(""), std::numeric_limits<double>::infinity()}) {
      Instance instance(table);
      demand(instance.configure(setup) == ENAMEL_OK, "configure() failed");
      demand(instance.activate(period) != ENAMEL_OK, "a period of " + formatNumber(period) + " s was accepted");
    }
    return std::string();
  });
  check("refuses double activation and configuration while active", [&] {
    Instance instance(table);
    instance.prepare(setup, options.period);
    demand(instance.step(path[0]) == ENAMEL_OK, "the first tick failed");
    demand(instance.activate(options.period) != ENAMEL_OK, "a second activate() was accepted");
    demand(instance.configure(setup) != ENAMEL_OK, "configure() while active was accepted");
    demand(instance.step(path[1]) == ENAMEL_OK, "a tick after the refused calls failed");
    return std::string();
  });
  check("is inactive after deactivate, and starts again", [&] {
    Instance instance(table);
    instance.prepare(setup, options.period);
    demand(instance.step(path[0]) == ENAMEL_OK, "the first tick failed");
    const EnamelTickOutput first = instance.output;
    instance.deactivate();
    demand(instance.step(path[1]) == ENAMEL_INACTIVE, "step() after deactivate() did not answer inactive");
    demand(instance.activate(options.period) == ENAMEL_OK, "the second activate() failed");
    demand(instance.step(path[0]) == ENAMEL_OK && same(instance.output, first),
           "the first tick after a new activate() differs");
    return std::string();
  });
  std::vector<EnamelTickOutput> expected;
  check("answers a path into a wall, finite and within the limits", [&] {
    Instance instance(table);
    instance.prepare(setup, options.period);
    expected = runPath(instance);
    const auto contacts =
        std::count_if(expected.begin(), expected.end(), [](const auto& o) { return o.mode == ENAMEL_CONTACT; });
    demand(contacts > 0, "no tick inside the wall was rendered as a contact");
    return std::to_string(contacts) + " of " + std::to_string(expected.size()) + " ticks in contact";
  });
  if (!allPassed) return false;
  check("answers a soft surface with friction, on a device that cannot tell what acted", [&] {
    Instance instance(table);
    instance.prepare(setup, options.period);
    for (std::size_t i = 0; i < path.size(); ++i) {
      EnamelTickInput input = path[i];
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
    return std::string();
  });
  check("gives the same bits in another instance", [&] {
    Instance instance(table);
    instance.prepare(setup, options.period);
    const std::vector<EnamelTickOutput> outputs = runPath(instance);
    for (std::size_t i = 0; i < outputs.size(); ++i) demand(same(outputs[i], expected[i]), tick(i) + " differs");
    return std::string();
  });
  check("reset gives the first tick again", [&] {
    Instance instance(table);
    instance.prepare(setup, options.period);
    const std::vector<unsigned char> fresh = instance.save();
    (void)runPath(instance);
    for (const std::size_t stop : {path.size() / 6, path.size() / 3}) {  // from inside the wall as well
      instance.reset();
      demand(instance.save() == fresh, "the state after reset() is not the state after activate()");
      for (std::size_t i = 0; i < stop; ++i) {
        demand(instance.step(path[i]) == ENAMEL_OK, tick(i) + " after reset() failed");
        demand(same(instance.output, expected[i]), tick(i) + " after reset() differs");
      }
    }
    return std::string();
  });
  check("its state can be saved, loaded and compared", [&] {
    Instance one(table), other(table);
    one.prepare(setup, options.period);
    other.prepare(setup, options.period);
    const std::size_t middle = path.size() / 4;
    for (std::size_t i = 0; i < middle; ++i) demand(one.step(path[i]) == ENAMEL_OK, tick(i) + " failed");
    const std::vector<unsigned char> state = one.save();
    demand(one.save() == state, "saving twice gives different bytes");
    other.load(state);
    demand(other.save() == state, "the loaded state is not the saved one");
    for (std::size_t i = middle; i < path.size(); ++i) {
      demand(one.step(path[i]) == ENAMEL_OK && other.step(path[i]) == ENAMEL_OK, tick(i) + " failed");
      demand(same(one.output, other.output) && same(one.output, expected[i]),
             tick(i) + " differs after loading the state into another instance");
      demand(one.save() == other.save(), tick(i) + ": equal states have different bytes");
    }
    return std::to_string(state.size()) + " bytes";
  });
  check("survives bad input: a result, a defined output, the state unchanged", [&] {
    Instance instance(table);
    instance.prepare(setup, options.period);
    for (std::size_t i = 0; i < path.size() / 5; ++i) demand(instance.step(path[i]) == ENAMEL_OK, tick(i) + " failed");
    const std::vector<unsigned char> before = instance.save();
    const EnamelTickInput good = path[path.size() / 5];
    const auto offer = [&](const std::string& what, const EnamelTickInput& bad, bool mustRefuse) {
      const std::int32_t result = instance.step(bad);
      demand(!mustRefuse || result != ENAMEL_OK, what + " was accepted");
      requireDefined(instance.output, bad, result != ENAMEL_OK, what);
      if (result == ENAMEL_OK) {
        instance.load(before);
        return;
      }
      demand(instance.output.mode == ENAMEL_FAULT, what + ": the mode is not fault");
      demand(instance.save() == before, what + ": the state has changed");
    };
    // Every number of the input in turn; what a renderer does not use it may accept.
    const double bads[] = {std::nan(""), std::numeric_limits<double>::infinity(), -1e300, 1e300};
    constexpr std::size_t kNumbers = offsetof(EnamelTickInput, joint_count) / sizeof(double);
    const auto joints = static_cast<std::size_t>(good.joint_count);
    for (std::size_t k = 0; k < kNumbers; ++k)
      for (const double value : bads) {
        EnamelTickInput bad = good;
        std::memcpy(reinterpret_cast<char*>(&bad) + k * sizeof(double), &value, sizeof value);
        const bool time = k == 0, angle = k >= 1 && k < 1 + joints;
        offer("number " + std::to_string(k) + " = " + formatNumber(value), bad,
              (angle || time) && !(std::isfinite(value) && time));
      }
    for (const double value : bads) {
      EnamelTickInput bad = good;
      bad.contacts[0].gap = value;
      offer("gap = " + formatNumber(value), bad, std::isnan(value));
    }
    for (double EnamelContact::*number : {&EnamelContact::stiffness, &EnamelContact::friction,
                                          &EnamelContact::sliding_friction, &EnamelContact::viscosity})
      for (const double value : bads) {
        EnamelTickInput bad = good;
        bad.contacts[0].*number = value;
        offer("a number of the surface = " + formatNumber(value), bad, false);
      }
    for (const int count : {-1, ENAMEL_MAX_CONTACTS + 1, 1 << 30}) {
      EnamelTickInput bad = good;
      bad.contact_count = count;
      offer("contact count " + std::to_string(count), bad, true);
    }
    for (const int count : {-1, 0, ENAMEL_MAX_JOINTS + 1, 1 << 30}) {
      EnamelTickInput bad = good;
      bad.joint_count = count;
      offer("joint count " + std::to_string(count), bad, true);
    }
    EnamelTickInput late = path[path.size() / 5 - 1];
    offer("a time that has not advanced", late, true);
    demand(instance.step(good) == ENAMEL_OK && same(instance.output, expected[path.size() / 5]),
           "the good tick after the bad ones differs");
    return std::string();
  });
  check("keeps to the torque limit that it is given", [&] {
    Instance instance(table);
    instance.prepare(setup, options.period);
    for (std::size_t i = 0; i < path.size(); ++i) {
      EnamelTickInput input = path[i];
      for (double& limit : input.max_torque) limit = 1e-3;
      demand(instance.step(input) == ENAMEL_OK, tick(i) + " failed");
      requireDefined(instance.output, input, false, tick(i));
    }
    return std::string();
  });
  if (!options.allocationCount) {
    report({"allocates nothing in a tick", Verdict::notChecked, "allocations are not counted in this program"});
  } else {
    check("allocates nothing in a tick", [&] {
      Instance instance(table);
      instance.prepare(setup, options.period);
      std::vector<unsigned char> state = instance.save();
      const long before = options.allocationCount();
      for (std::size_t i = 0; i < path.size(); ++i) {
        (void)instance.step(path[i]);
        instance.saveTo(state);
      }
      instance.reset();
      const long count = options.allocationCount() - before;
      demand(count == 0, std::to_string(count) + " allocations or releases in " + std::to_string(path.size()) +
                             " ticks and a reset");
      return std::string();
    });
  }
  check("time per step (reported only)", [&] {
    using Clock = std::chrono::steady_clock;
    Instance instance(table);
    instance.prepare(setup, options.period);
    std::vector<double> times_us;
    for (const EnamelTickInput& input : path) {
      const auto start = Clock::now();
      (void)instance.step(input);
      times_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - start).count());
    }
    std::sort(times_us.begin(), times_us.end());
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), "median %.2f us, p99.9 %.2f us, longest %.2f us",
                  times_us[times_us.size() / 2], times_us[times_us.size() * 999 / 1000], times_us.back());
    return std::string(text.data());
  });
  return allPassed;
}

}  // namespace enamel
