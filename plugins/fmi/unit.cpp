// The binary of a unit: a plant, or a haptic tick (contacts, renderer, guard), behind FMI 3.0 for co-simulation. It
// reads from its resources what it is. Nothing throws across the boundary.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>

#include "description.hpp"
#include "enamel/collision/scene_file.hpp"
#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "enamel/plugin/renderer_source.hpp"
#include "enamel/render/tick.hpp"
#include "enamel/sim/hand.hpp"
#include "enamel/sim/plant_maker.hpp"
#include "enamel/sim/real_plant.hpp"
#include "fmi3.hpp"
#include "unit_plants.hpp"

namespace enamel::fmi {
namespace {

enum class Phase { instantiated, initialising, stepping, terminated };

using Values = std::vector<std::vector<double>>;  // by reference

/// What every unit has: its variables and where it stands.
struct Condition {
  Values values;
  Phase phase = Phase::instantiated;
  double start = 0.0, last = 0.0;  // s: of the simulation; of the last communication point
  bool isNew = true;               // an input was set since outputs were computed
};

class Unit {
 public:
  Unit(UnitConfiguration configuration, std::shared_ptr<const Mechanism> device)
      : configuration_(std::move(configuration)),
        device_(std::move(device)),
        variables_(variablesOf(configuration_, *device_)) {
    for (const Variable& variable : variables_) now_.values.push_back(variable.start);
  }
  virtual ~Unit() = default;
  Unit(const Unit&) = delete;
  Unit& operator=(const Unit&) = delete;

  const UnitConfiguration& configuration() const { return configuration_; }
  const std::vector<Variable>& variables() const { return variables_; }
  Condition& now() { return now_; }

  virtual void begin() = 0;            // at the end of initialisation; throws Error
  virtual void refresh() {}            // outputs that follow from inputs at once
  virtual void step(double step) = 0;  // throws Error

  virtual std::shared_ptr<void> copyState() const = 0;
  virtual void putState(const std::shared_ptr<void>& state) = 0;
  virtual std::string bytesOf(const std::shared_ptr<void>&) const { throw Error("its state cannot be serialised"); }
  virtual std::shared_ptr<void> stateOf(const std::string&) const { throw Error("its state cannot be serialised"); }

 protected:
  std::vector<double>& value(const char* name) {
    for (std::size_t i = 0; i < variables_.size(); ++i)
      if (std::strcmp(variables_[i].name, name) == 0) return now_.values[i];
    throw Error(std::string("there is no variable ") + name);
  }
  Vec3 vec3(const char* name) { return Eigen::Map<const Vec3>(value(name).data()); }
  JointVector joints(const char* name) {
    return Eigen::Map<const Eigen::VectorXd>(value(name).data(), device_->joints());
  }
  template <typename Derived>
  void set(const char* name, const Eigen::MatrixBase<Derived>& v) {
    std::vector<double>& to = value(name);
    for (std::size_t i = 0; i < to.size(); ++i) to[i] = v[static_cast<Eigen::Index>(i)];
  }
  Pose startPose() {
    const std::vector<double>& o = value("start_orientation");
    const Eigen::Quaternion<double> orientation(o[0], o[1], o[2], o[3]);
    if (!(std::abs(orientation.norm() - 1.0) < 1e-6)) throw Error("start_orientation is no unit quaternion to 1e-6");
    return {vec3("start_position"), orientation.normalized().toRotationMatrix()};
  }

  UnitConfiguration configuration_;
  std::shared_ptr<const Mechanism> device_;
  std::vector<Variable> variables_;
  Condition now_;
};

// ---- a plant -----------------------------------------------------------------------------------------------------

class PlantUnit final : public Unit {
 public:
  PlantUnit(const UnitConfiguration& configuration, const DeviceParameters& parameters)
      : Unit(configuration, makeMechanism(parameters)) {
    VirtualDeviceSetup setup;
    setup.seed = configuration.seed;
    make_ = plantMaker(configuration.plant, parameters, otherPlants(), setup);
  }

  void begin() override {
    plant_ = make_ ? make_(0)
                   : std::make_unique<ClosedFormPlant>(*device_, Integrator::rungeKutta4, configuration_.substeps);
    start_ = startPose();
    normal_ = vec3("guide_normal");
    if (!(std::abs(normal_.norm() - 1.0) < 1e-6)) throw Error("guide_normal has not the length 1 to 1e-6");
    if (const enamel::Status status = plant_->start(start_); status != enamel::Status::ok)
      throw Error(std::string("the start pose is ") + toString(status));
    Kinematics k;
    if (device_->reach(start_, Vec6::Zero(), false, k) == enamel::Status::ok) set("applied", k.gravity);
    show();
  }

  void step(double step) override {
    Vec6 held;
    held << vec3("force"), vec3("moment");
    const bool guided = value("guide")[0] != 0.0;
    const auto load = [&](double, const Pose& pose, const Vec6& twist) -> Vec6 {
      if (!guided) return held;
      return guidingWrench(pose, twist, start_, normal_) + held;
    };
    const JointVector torque = joints("torque");
    const enamel::Status status = plant_->advance(now_.last, step, torque, load);
    if (status != enamel::Status::ok)
      throw Error("the device cannot move on at " + std::to_string(now_.last) + " s: its pose is " + toString(status));
    set("applied", torque);
    show();
  }

  std::shared_ptr<void> copyState() const override {
    if (const auto* closed = dynamic_cast<const ClosedFormPlant*>(plant_.get()))
      return std::make_shared<Copy>(Copy{now_, std::make_shared<ClosedFormPlant>(*closed), start_, normal_});
    if (const auto* real = dynamic_cast<const RealPlant*>(plant_.get()))
      return std::make_shared<Copy>(Copy{now_, std::make_shared<RealPlant>(*real), start_, normal_});
    if (plant_ == nullptr) return std::make_shared<Copy>(Copy{now_, nullptr, start_, normal_});
    throw Error("the state of this plant cannot be copied");
  }
  void putState(const std::shared_ptr<void>& state) override {
    const Copy& copy = *static_cast<const Copy*>(state.get());
    now_ = copy.now;
    start_ = copy.start;
    normal_ = copy.normal;
    if (const auto* closed = dynamic_cast<const ClosedFormPlant*>(copy.plant.get()))
      plant_ = std::make_unique<ClosedFormPlant>(*closed);
    else if (const auto* real = dynamic_cast<const RealPlant*>(copy.plant.get()))
      plant_ = std::make_unique<RealPlant>(*real);
    else
      plant_.reset();
  }

 private:
  struct Copy {
    Condition now;
    std::shared_ptr<const Plant> plant;
    Pose start;
    Vec3 normal;
  };

  void show() {
    const DeviceState& state = plant_->state();
    Kinematics k;
    if (const auto status = plant_->mechanism().reach(state.pose(), state.twist, false, k);
        status != enamel::Status::ok)
      throw Error("the device left its workspace at " + std::to_string(now_.last) + " s: its pose is " +
                  toString(status));
    JointVector q, rates;
    plant_->read(k, q, rates);
    set("position", state.position);
    const auto& o = state.orientation;
    set("orientation", Eigen::Vector4d(o.w(), o.x(), o.y(), o.z()));
    set("velocity", state.twist.head<3>());
    set("angular_velocity", state.twist.tail<3>());
    set("q", q);
    set("rates", rates);
  }

  MakePlant make_;
  std::unique_ptr<Plant> plant_;
  Pose start_;
  Vec3 normal_ = Vec3::UnitZ();
};

// ---- a renderer --------------------------------------------------------------------------------------------------

class RendererUnit final : public Unit {
 public:
  RendererUnit(const UnitConfiguration& configuration, const DeviceParameters& parameters, SceneFile scene)
      : Unit(configuration, makeMechanism(parameters)),
        scene_(std::move(scene)),
        renderer_(makeLinked(configuration.renderer, configuration.parameters, device_, configuration.period)) {}

  void begin() override {
    GuardOptions guard = guardFor(*device_, configuration_.period);
    guard.on = configuration_.guarded;
    if (configuration_.force > 0.0) guard.force = configuration_.force;
    tick_.emplace(*device_, scene_.scene, scene_.tool, *renderer_, guard, startPose());
    before_.resize(tick_->stateSize());
    tick_->saveState(before_.data());
    number_ = 0;
    now_.isNew = true;
  }

  // The tick at the communication point, on the inputs as they are: may come again with others.
  void refresh() override {
    if (!now_.isNew || !tick_) return;
    tick_->loadState(before_.data());
    Measurement m;
    m.time = now_.start + static_cast<double>(number_) * configuration_.period;
    m.q = joints("q");
    m.rates = joints("rates");
    m.applied = joints("applied");
    m.enabled = value("enabled")[0] != 0.0;
    Command command;
    const enamel::Status status = (*tick_)(m, command);
    set("torque", command.torque);
    set("requested", tick_->output().torque);
    value("normal_force")[0] = tick_->output().normalForce;
    value("mode")[0] = static_cast<double>(tick_->output().mode);
    value("saturated")[0] = tick_->output().saturated ? 1.0 : 0.0;
    value("status")[0] = static_cast<double>(status);
    value("guard")[0] = static_cast<double>(tick_->reason());
    now_.isNew = false;
  }

  void step(double step) override {
    if (!(std::abs(step - configuration_.period) <= 1e-9 * configuration_.period))
      throw Error("a step of " + std::to_string(step) + " s: its ticks take " + std::to_string(configuration_.period) +
                  " s");
    now_.isNew = true;  // also where outputs were got: a state may have been set since
    refresh();
    tick_->saveState(before_.data());
    ++number_;
  }

  std::shared_ptr<void> copyState() const override { return std::make_shared<Copy>(Copy{now_, before_, number_}); }
  void putState(const std::shared_ptr<void>& state) override {
    const Copy& copy = *static_cast<const Copy*>(state.get());
    now_ = copy.now;
    before_ = copy.before;
    number_ = copy.number;
    if (tick_ && before_.size() == tick_->stateSize()) tick_->loadState(before_.data());
  }

  std::string bytesOf(const std::shared_ptr<void>& state) const override {
    const Copy& copy = *static_cast<const Copy*>(state.get());
    std::string bytes;
    const auto put = [&bytes](const auto& number) {
      bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
    };
    put(copy.now.start);
    put(copy.now.last);
    put(static_cast<std::int64_t>(copy.now.phase));
    put(static_cast<std::int64_t>(copy.now.isNew));
    put(copy.number);
    for (const auto& values : copy.now.values)
      for (const double number : values) put(number);
    bytes.append(copy.before.begin(), copy.before.end());
    return bytes;
  }

  std::shared_ptr<void> stateOf(const std::string& bytes) const override {
    Copy copy{now_, {}, 0};
    std::size_t at = 0;
    const auto take = [&](auto& number) {
      if (bytes.size() - at < sizeof number) throw Error("the bytes are of another unit's state");
      std::memcpy(&number, bytes.data() + at, sizeof number);
      at += sizeof number;
    };
    std::int64_t phase = 0, isNew = 0;
    take(copy.now.start);
    take(copy.now.last);
    take(phase);
    take(isNew);
    take(copy.number);
    if (phase < 0 || phase > static_cast<std::int64_t>(Phase::terminated))
      throw Error("the bytes are of another unit's state");
    copy.now.phase = static_cast<Phase>(phase);
    copy.now.isNew = isNew != 0;
    for (auto& values : copy.now.values)
      for (double& number : values) take(number);
    copy.before.assign(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end());
    if (!copy.before.empty() && tick_ && copy.before.size() != tick_->stateSize())
      throw Error("the bytes are of another unit's state");
    return std::make_shared<Copy>(std::move(copy));
  }

 private:
  struct Copy {
    Condition now;
    std::vector<char> before;
    std::uint64_t number;
  };

  SceneFile scene_;
  std::unique_ptr<Renderer> renderer_;
  std::optional<HapticTick> tick_;
  std::vector<char> before_;  // the tick's state at the communication point
  std::uint64_t number_ = 0;  // of the tick
};

// ---- the boundary ------------------------------------------------------------------------------------------------

struct Handle {
  std::function<std::unique_ptr<Unit>()> make;
  std::unique_ptr<Unit> unit;
  void* environment;
  LogMessage log;

  void say(Status status, const std::string& message) const noexcept {
    if (log != nullptr) log(environment, status, status == ok ? "logAll" : "logStatusError", message.c_str());
  }
};

// Runs the body of a call; what it throws is logged and becomes a status.
template <typename Body>
Status guarded(Instance instance, const Body& body) noexcept {
  if (instance == nullptr) return error;
  Handle& handle = *static_cast<Handle*>(instance);
  try {
    return body(handle);
  } catch (const std::exception& e) {
    handle.say(error, e.what());
    return error;
  } catch (...) {
    handle.say(error, "unknown exception");
    return error;
  }
}

Status refuse(Instance instance, const char* function) noexcept {
  return guarded(instance, [&](Handle& h) {
    h.say(error, std::string(function) + ": this unit does not have it");
    return error;
  });
}

void requirePhase(const Condition& now, Phase phase, const char* function) {
  if (now.phase != phase) throw Error(std::string(function) + " is not allowed in this state of the unit");
}

template <typename T>
constexpr Type typeOf = std::is_same_v<T, double> ? Type::real
                        : std::is_same_v<T, bool> ? Type::boolean
                                                  : Type::integer;

template <typename T, typename Visit>
Status eachValue(Handle& h, const Reference references[], std::size_t count, std::size_t valueCount,
                 const Visit& visit) {
  Unit& unit = *h.unit;
  std::size_t at = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (references[i] >= unit.variables().size()) throw Error("there is no variable " + std::to_string(references[i]));
    const Variable& variable = unit.variables()[references[i]];
    if (variable.type != typeOf<T>) throw Error(std::string(variable.name) + " is of another type");
    std::vector<double>& values = unit.now().values[references[i]];
    if (valueCount - at < values.size()) throw Error(std::string(variable.name) + " has more numbers");
    visit(variable, values, at);
    at += values.size();
  }
  if (at != valueCount) throw Error("there are more values than the variables have");
  return ok;
}

template <typename T>
Status getValues(Instance instance, const Reference references[], std::size_t count, T values[],
                 std::size_t valueCount) noexcept {
  return guarded(instance, [&](Handle& h) {
    Unit& unit = *h.unit;
    if (unit.now().phase == Phase::stepping) unit.refresh();
    return eachValue<T>(h, references, count, valueCount, [&](const Variable& variable, auto& from, std::size_t at) {
      if (variable.causality == Causality::independent) from[0] = unit.now().last;
      for (std::size_t k = 0; k < from.size(); ++k) values[at + k] = static_cast<T>(from[k]);
    });
  });
}

template <typename T>
Status setValues(Instance instance, const Reference references[], std::size_t count, const T values[],
                 std::size_t valueCount) noexcept {
  return guarded(instance, [&](Handle& h) {
    Unit& unit = *h.unit;
    return eachValue<T>(h, references, count, valueCount, [&](const Variable& variable, auto& to, std::size_t at) {
      const bool isInput = variable.causality == Causality::input;
      const bool early = unit.now().phase == Phase::instantiated || unit.now().phase == Phase::initialising;
      if (!isInput && !(variable.causality == Causality::parameter && early))
        throw Error(std::string(variable.name) + " cannot be set now");
      for (std::size_t k = 0; k < to.size(); ++k) {
        const auto number = static_cast<double>(values[at + k]);
        if (!std::isfinite(number)) throw Error(std::string(variable.name) + " is not finite");
        to[k] = number;
      }
      unit.now().isNew = true;
    });
  });
}

std::unique_ptr<Unit> makeUnit(const std::string& resources) {
  const UnitConfiguration configuration = readUnit(resources + "unit.json");
  const DeviceParameters device = loadDevice(resources + "device.toml");
  if (configuration.renderer.empty()) return std::make_unique<PlantUnit>(configuration, device);
  SceneFile scene;
  const std::string file = resources + "scene.toml";
  if (std::filesystem::exists(file))
    scene = loadScene(file);
  else
    scene.scene = flatWall();
  return std::make_unique<RendererUnit>(configuration, device, std::move(scene));
}

std::string textAt(const std::string& path) { return std::filesystem::exists(path) ? readFile(path) : ""; }

using StateHandle = std::shared_ptr<void>;

}  // namespace
}  // namespace enamel::fmi

using namespace enamel::fmi;  // the last source of its translation unit

#define EXPORT extern "C" __attribute__((visibility("default")))

EXPORT const char* fmi3GetVersion() { return "3.0"; }

EXPORT Instance fmi3InstantiateCoSimulation(const char*, const char* token, const char* resources, bool, bool,
                                            bool eventModeUsed, bool, const Reference*, std::size_t required,
                                            void* environment, LogMessage log, IntermediateUpdate) {
  auto handle = std::make_unique<Handle>(Handle{{}, nullptr, environment, log});
  const Status status = guarded(handle.get(), [&](Handle& h) {
    if (eventModeUsed) throw enamel::Error("this unit has no event mode");
    if (required > 0) throw enamel::Error("this unit has no intermediate variables");
    if (resources == nullptr || *resources == 0) throw enamel::Error("no path of the resources was given");
    std::string folder = resources;
    if (folder.back() != '/') folder += '/';
    const std::string expected =
        tokenOf(textAt(folder + "unit.json"), textAt(folder + "device.toml"), textAt(folder + "scene.toml"));
    if (token == nullptr || expected != token)
      throw enamel::Error(folder + ": the resources are not those that modelDescription.xml was written for");
    h.make = [folder] { return makeUnit(folder); };
    h.unit = h.make();
    return ok;
  });
  return status == ok ? handle.release() : nullptr;
}

EXPORT void fmi3FreeInstance(Instance instance) { delete static_cast<Handle*>(instance); }

EXPORT Status fmi3SetDebugLogging(Instance, bool, std::size_t, const char* const*) { return ok; }

EXPORT Status fmi3EnterInitializationMode(Instance instance, bool, double, double startTime, bool, double) {
  return guarded(instance, [&](Handle& h) {
    Condition& now = h.unit->now();
    requirePhase(now, Phase::instantiated, "fmi3EnterInitializationMode");
    now.start = now.last = startTime;
    now.phase = Phase::initialising;
    return ok;
  });
}

EXPORT Status fmi3ExitInitializationMode(Instance instance) {
  return guarded(instance, [](Handle& h) {
    Condition& now = h.unit->now();
    requirePhase(now, Phase::initialising, "fmi3ExitInitializationMode");
    h.unit->begin();
    now.phase = Phase::stepping;
    return ok;
  });
}

EXPORT Status fmi3EnterStepMode(Instance instance) { return refuse(instance, "fmi3EnterStepMode"); }

EXPORT Status fmi3DoStep(Instance instance, double time, double step, bool, bool* eventNeeded, bool* terminate,
                         bool* earlyReturn, double* lastTime) {
  if (eventNeeded != nullptr) *eventNeeded = false;
  if (terminate != nullptr) *terminate = false;
  if (earlyReturn != nullptr) *earlyReturn = false;
  const Status status = guarded(instance, [&](Handle& h) {
    Condition& now = h.unit->now();
    requirePhase(now, Phase::stepping, "fmi3DoStep");
    if (!(step > 0.0) || !std::isfinite(step) || !std::isfinite(time))
      throw enamel::Error("a step of " + std::to_string(step) + " s at " + std::to_string(time) + " s");
    now.last = time;
    h.unit->step(step);
    now.last = time + step;
    return ok;
  });
  if (lastTime != nullptr && instance != nullptr) *lastTime = static_cast<Handle*>(instance)->unit->now().last;
  return status;
}

EXPORT Status fmi3Terminate(Instance instance) {
  return guarded(instance, [](Handle& h) {
    h.unit->now().phase = Phase::terminated;
    return ok;
  });
}

EXPORT Status fmi3Reset(Instance instance) {
  return guarded(instance, [](Handle& h) {
    h.unit = h.make();
    return ok;
  });
}

EXPORT Status fmi3GetFMUState(Instance instance, State* state) {
  return guarded(instance, [&](Handle& h) {
    auto copy = std::make_unique<StateHandle>(h.unit->copyState());
    if (*state != nullptr) delete static_cast<StateHandle*>(*state);
    *state = copy.release();
    return ok;
  });
}

EXPORT Status fmi3SetFMUState(Instance instance, State state) {
  return guarded(instance, [&](Handle& h) {
    if (state == nullptr) throw enamel::Error("there is no state to set");
    h.unit->putState(*static_cast<StateHandle*>(state));
    return ok;
  });
}

EXPORT Status fmi3FreeFMUState(Instance, State* state) {
  if (state == nullptr) return ok;
  delete static_cast<StateHandle*>(*state);
  *state = nullptr;
  return ok;
}

EXPORT Status fmi3SerializedFMUStateSize(Instance instance, State state, std::size_t* size) {
  return guarded(instance, [&](Handle& h) {
    *size = h.unit->bytesOf(*static_cast<StateHandle*>(state)).size();
    return ok;
  });
}

EXPORT Status fmi3SerializeFMUState(Instance instance, State state, std::uint8_t bytes[], std::size_t size) {
  return guarded(instance, [&](Handle& h) {
    const std::string written = h.unit->bytesOf(*static_cast<StateHandle*>(state));
    if (written.size() != size) throw enamel::Error("the state has " + std::to_string(written.size()) + " bytes");
    std::memcpy(bytes, written.data(), size);
    return ok;
  });
}

EXPORT Status fmi3DeserializeFMUState(Instance instance, const std::uint8_t bytes[], std::size_t size, State* state) {
  return guarded(instance, [&](Handle& h) {
    auto read = std::make_unique<StateHandle>(h.unit->stateOf(std::string(reinterpret_cast<const char*>(bytes), size)));
    if (*state != nullptr) delete static_cast<StateHandle*>(*state);
    *state = read.release();
    return ok;
  });
}

#define GET_AND_SET(Name, type)                                                                                        \
  EXPORT Status fmi3Get##Name(Instance instance, const Reference references[], std::size_t count, type values[],       \
                              std::size_t valueCount) {                                                                \
    return getValues(instance, references, count, values, valueCount);                                                 \
  }                                                                                                                    \
  EXPORT Status fmi3Set##Name(Instance instance, const Reference references[], std::size_t count, const type values[], \
                              std::size_t valueCount) {                                                                \
    return setValues(instance, references, count, values, valueCount);                                                 \
  }
GET_AND_SET(Float64, double)
GET_AND_SET(Int32, std::int32_t)
GET_AND_SET(Boolean, bool)

// What the standard wants every unit to have, and this one has no variables or modes for. Whatever their arguments,
// they look at the instance alone.
#define REFUSED(name) \
  EXPORT Status name(Instance instance) { return refuse(instance, #name); }
REFUSED(fmi3GetFloat32)
REFUSED(fmi3GetInt8)
REFUSED(fmi3GetUInt8)
REFUSED(fmi3GetInt16)
REFUSED(fmi3GetUInt16)
REFUSED(fmi3GetUInt32)
REFUSED(fmi3GetInt64)
REFUSED(fmi3GetUInt64)
REFUSED(fmi3GetString)
REFUSED(fmi3GetBinary)
REFUSED(fmi3GetClock)
REFUSED(fmi3SetFloat32)
REFUSED(fmi3SetInt8)
REFUSED(fmi3SetUInt8)
REFUSED(fmi3SetInt16)
REFUSED(fmi3SetUInt16)
REFUSED(fmi3SetUInt32)
REFUSED(fmi3SetInt64)
REFUSED(fmi3SetUInt64)
REFUSED(fmi3SetString)
REFUSED(fmi3SetBinary)
REFUSED(fmi3SetClock)
REFUSED(fmi3GetNumberOfVariableDependencies)
REFUSED(fmi3GetVariableDependencies)
REFUSED(fmi3GetDirectionalDerivative)
REFUSED(fmi3GetAdjointDerivative)
REFUSED(fmi3EnterConfigurationMode)
REFUSED(fmi3ExitConfigurationMode)
REFUSED(fmi3GetIntervalDecimal)
REFUSED(fmi3GetIntervalFraction)
REFUSED(fmi3GetShiftDecimal)
REFUSED(fmi3GetShiftFraction)
REFUSED(fmi3SetIntervalDecimal)
REFUSED(fmi3SetIntervalFraction)
REFUSED(fmi3SetShiftDecimal)
REFUSED(fmi3SetShiftFraction)
REFUSED(fmi3EvaluateDiscreteStates)
REFUSED(fmi3UpdateDiscreteStates)
REFUSED(fmi3EnterEventMode)
REFUSED(fmi3EnterContinuousTimeMode)
REFUSED(fmi3CompletedIntegratorStep)
REFUSED(fmi3SetTime)
REFUSED(fmi3SetContinuousStates)
REFUSED(fmi3GetContinuousStateDerivatives)
REFUSED(fmi3GetEventIndicators)
REFUSED(fmi3GetContinuousStates)
REFUSED(fmi3GetNominalsOfContinuousStates)
REFUSED(fmi3GetNumberOfEventIndicators)
REFUSED(fmi3GetNumberOfContinuousStates)
REFUSED(fmi3GetOutputDerivatives)
REFUSED(fmi3ActivateModelPartition)
EXPORT Instance fmi3InstantiateModelExchange() { return nullptr; }
EXPORT Instance fmi3InstantiateScheduledExecution() { return nullptr; }
