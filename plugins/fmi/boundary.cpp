// The C functions of FMI 3.0 that a unit's binary exports. A unit reads from its resources whether it is a plant or a
// haptic tick. No exception crosses the boundary.
#include <cmath>
#include <cstring>
#include <filesystem>

#include "enamel/core/error.hpp"
#include "enamel/core/file.hpp"
#include "plant_unit.hpp"
#include "renderer_unit.hpp"

namespace enamel::fmi {
namespace {

/// An instance.
struct Handle {
  std::unique_ptr<Unit> unit;
  std::unique_ptr<UnitState> first;  // state after instantiation
  void* environment;
  LogMessage log;

  void say(Status status, const std::string& message) const noexcept {
    if (log != nullptr) log(environment, status, status == ok ? "logAll" : "logStatusError", message.c_str());
  }
};

// Run the body of a call. Exceptions are logged and become a status.
template <typename Body>
Status guarded(Instance instance, const Body& body) noexcept {
  if (instance == nullptr) return error;
  Handle& handle = *static_cast<Handle*>(instance);
  try {
    body(handle);
    return ok;
  } catch (const std::exception& e) {
    handle.say(error, e.what());
  } catch (...) {
    handle.say(error, "unknown exception");
  }
  return error;
}

void requirePhase(const Condition& now, Phase phase, const char* function) {
  if (now.phase != phase) throw Error(std::string(function) + " is not allowed in this state of the unit");
}

std::string textAt(const std::string& path) { return std::filesystem::exists(path) ? readFile(path) : ""; }

void checkToken(const std::string& resources, const char* token) {
  const std::string expected =
      tokenOf(textAt(resources + "unit.json"), textAt(resources + "device.toml"), textAt(resources + "scene.toml"));
  if (token == nullptr || expected != token)
    throw Error(resources + ": the resources do not match modelDescription.xml");
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

Status refuse(Instance instance, const char* function) noexcept {
  return guarded(instance, [&](Handle&) { throw Error(std::string(function) + ": not supported by this unit"); });
}

Instance refuseKind(void* environment, LogMessage log) noexcept {
  Handle{nullptr, nullptr, environment, log}.say(error, "this unit supports only co-simulation");
  return nullptr;
}

UnitState& stateAt(State state) {
  if (state == nullptr) throw Error("the state is missing (NULL)");
  return *static_cast<UnitState*>(state);
}

void replace(State& state, std::unique_ptr<UnitState> by) {
  delete static_cast<UnitState*>(state);
  state = by.release();
}

}  // namespace

// The table declares every exported function with its type. A definition with other parameters, or one that the table
// lacks, does not compile.
#define EXPORT extern "C" __attribute__((visibility("default")))
#define DECLARE(name, type) EXPORT type name;
ENAMEL_FMI3_FUNCTIONS(DECLARE)
#ifdef __clang__
#pragma clang diagnostic error "-Wmissing-prototypes"
#else
#pragma GCC diagnostic error "-Wmissing-declarations"
#endif

// ---- life --------------------------------------------------------------------------------------------------------

EXPORT String fmi3GetVersion() { return "3.0"; }

EXPORT Instance fmi3InstantiateCoSimulation(String, String token, String resources, bool, bool, bool eventModeUsed,
                                            bool, const Reference[], std::size_t required, void* environment,
                                            LogMessage log, IntermediateUpdate) {
  auto handle = std::make_unique<Handle>(Handle{nullptr, nullptr, environment, log});
  const Status status = guarded(handle.get(), [&](Handle& h) {
    if (eventModeUsed) throw Error("this unit does not support the event mode");
    if (required > 0) throw Error("this unit does not support intermediate variables");
    if (resources == nullptr || *resources == 0) throw Error("the path of the resources is missing");
    std::string folder = resources;
    if (folder.back() != '/') folder += '/';
    checkToken(folder, token);
    h.unit = makeUnit(folder);
    h.first = h.unit->copyState();
  });
  return status == ok ? handle.release() : nullptr;
}

EXPORT Instance fmi3InstantiateModelExchange(String, String, String, bool, bool, void* environment, LogMessage log) {
  return refuseKind(environment, log);
}

EXPORT Instance fmi3InstantiateScheduledExecution(String, String, String, bool, bool, void* environment, LogMessage log,
                                                  ClockUpdate, Preemption, Preemption) {
  return refuseKind(environment, log);
}

EXPORT void fmi3FreeInstance(Instance instance) { delete static_cast<Handle*>(instance); }

EXPORT Status fmi3SetDebugLogging(Instance, bool, std::size_t, const String[]) { return ok; }

EXPORT Status fmi3EnterInitializationMode(Instance instance, bool, double, double startTime, bool, double) {
  return guarded(instance, [&](Handle& h) {
    Condition& now = h.unit->now();
    requirePhase(now, Phase::instantiated, "fmi3EnterInitializationMode");
    now.start = now.last = startTime;
    now.phase = Phase::initialising;
  });
}

EXPORT Status fmi3ExitInitializationMode(Instance instance) {
  return guarded(instance, [](Handle& h) {
    Condition& now = h.unit->now();
    requirePhase(now, Phase::initialising, "fmi3ExitInitializationMode");
    h.unit->begin();
    now.phase = Phase::stepping;
  });
}

EXPORT Status fmi3DoStep(Instance instance, double time, double step, bool, bool* eventNeeded, bool* terminate,
                         bool* earlyReturn, double* lastTime) {
  if (eventNeeded != nullptr) *eventNeeded = false;
  if (terminate != nullptr) *terminate = false;
  if (earlyReturn != nullptr) *earlyReturn = false;
  const Status status = guarded(instance, [&](Handle& h) {
    Condition& now = h.unit->now();
    requirePhase(now, Phase::stepping, "fmi3DoStep");
    if (!(step > 0.0) || !std::isfinite(step) || !std::isfinite(time))
      throw Error("the step is " + std::to_string(step) + " s at " + std::to_string(time) +
                  " s, must be finite and greater than 0 s");
    now.last = time;
    h.unit->step(step);
    now.last = time + step;
  });
  if (lastTime != nullptr && instance != nullptr) *lastTime = static_cast<Handle*>(instance)->unit->now().last;
  return status;
}

EXPORT Status fmi3Terminate(Instance instance) {
  return guarded(instance, [](Handle& h) { h.unit->now().phase = Phase::terminated; });
}

EXPORT Status fmi3Reset(Instance instance) {
  return guarded(instance, [](Handle& h) { h.unit->putState(*h.first); });
}

// ---- state -------------------------------------------------------------------------------------------------------

EXPORT Status fmi3GetFMUState(Instance instance, State* state) {
  return guarded(instance, [&](Handle& h) { replace(*state, h.unit->copyState()); });
}

EXPORT Status fmi3SetFMUState(Instance instance, State state) {
  return guarded(instance, [&](Handle& h) { h.unit->putState(stateAt(state)); });
}

EXPORT Status fmi3FreeFMUState(Instance, State* state) {
  if (state != nullptr) replace(*state, nullptr);
  return ok;
}

EXPORT Status fmi3SerializedFMUStateSize(Instance instance, State state, std::size_t* size) {
  return guarded(instance, [&](Handle& h) { *size = h.unit->bytesOf(stateAt(state)).size(); });
}

EXPORT Status fmi3SerializeFMUState(Instance instance, State state, std::uint8_t bytes[], std::size_t size) {
  return guarded(instance, [&](Handle& h) {
    const std::string written = h.unit->bytesOf(stateAt(state));
    if (written.size() != size)
      throw Error("the state has " + std::to_string(written.size()) + " bytes, the buffer has " + std::to_string(size));
    std::memcpy(bytes, written.data(), size);
  });
}

EXPORT Status fmi3DeserializeFMUState(Instance instance, const std::uint8_t bytes[], std::size_t size, State* state) {
  return guarded(instance, [&](Handle& h) {
    replace(*state, h.unit->stateOf(std::string(reinterpret_cast<const char*>(bytes), size)));
  });
}

// ---- variables ---------------------------------------------------------------------------------------------------

#define GET(name, T)                                                                                  \
  EXPORT Status name(Instance instance, const Reference references[], std::size_t count, T values[],  \
                     std::size_t valueCount) {                                                        \
    return guarded(instance, [&](Handle& h) { h.unit->get(references, count, values, valueCount); }); \
  }
#define SET(name, T)                                                                                       \
  EXPORT Status name(Instance instance, const Reference references[], std::size_t count, const T values[], \
                     std::size_t valueCount) {                                                             \
    return guarded(instance, [&](Handle& h) { h.unit->set(references, count, values, valueCount); });      \
  }
GET(fmi3GetFloat64, double)
GET(fmi3GetInt32, std::int32_t)
GET(fmi3GetBoolean, bool)
SET(fmi3SetFloat64, double)
SET(fmi3SetInt32, std::int32_t)
SET(fmi3SetBoolean, bool)

// ---- what the standard wants every unit to have, and this one has no variables or modes for -----------------------

#define REFUSED(name, ...) \
  EXPORT Status name(Instance instance, __VA_ARGS__) { return refuse(instance, #name); }
#define REFUSED_MODE(name) \
  EXPORT Status name(Instance instance) { return refuse(instance, #name); }
#define REFUSED_GET(name, T) REFUSED(name, const Reference[], std::size_t, T[], std::size_t)
#define REFUSED_SET(name, T) REFUSED(name, const Reference[], std::size_t, const T[], std::size_t)

REFUSED_GET(fmi3GetFloat32, float)
REFUSED_GET(fmi3GetInt8, std::int8_t)
REFUSED_GET(fmi3GetUInt8, std::uint8_t)
REFUSED_GET(fmi3GetInt16, std::int16_t)
REFUSED_GET(fmi3GetUInt16, std::uint16_t)
REFUSED_GET(fmi3GetUInt32, std::uint32_t)
REFUSED_GET(fmi3GetInt64, std::int64_t)
REFUSED_GET(fmi3GetUInt64, std::uint64_t)
REFUSED_GET(fmi3GetString, String)
REFUSED_SET(fmi3SetFloat32, float)
REFUSED_SET(fmi3SetInt8, std::int8_t)
REFUSED_SET(fmi3SetUInt8, std::uint8_t)
REFUSED_SET(fmi3SetInt16, std::int16_t)
REFUSED_SET(fmi3SetUInt16, std::uint16_t)
REFUSED_SET(fmi3SetUInt32, std::uint32_t)
REFUSED_SET(fmi3SetInt64, std::int64_t)
REFUSED_SET(fmi3SetUInt64, std::uint64_t)
REFUSED_SET(fmi3SetString, String)
REFUSED(fmi3GetBinary, const Reference[], std::size_t, std::size_t[], Binary[], std::size_t)
REFUSED(fmi3SetBinary, const Reference[], std::size_t, const std::size_t[], const Binary[], std::size_t)
REFUSED(fmi3GetNumberOfVariableDependencies, Reference, std::size_t*)
REFUSED(fmi3GetVariableDependencies, Reference, std::size_t[], Reference[], std::size_t[], DependencyKind[],
        std::size_t)
REFUSED(fmi3GetDirectionalDerivative, const Reference[], std::size_t, const Reference[], std::size_t, const double[],
        std::size_t, double[], std::size_t)
REFUSED(fmi3GetAdjointDerivative, const Reference[], std::size_t, const Reference[], std::size_t, const double[],
        std::size_t, double[], std::size_t)
REFUSED(fmi3GetOutputDerivatives, const Reference[], std::size_t, const std::int32_t[], double[], std::size_t)

REFUSED_MODE(fmi3EnterConfigurationMode)
REFUSED_MODE(fmi3ExitConfigurationMode)
REFUSED_MODE(fmi3EnterEventMode)
REFUSED_MODE(fmi3EnterStepMode)
REFUSED_MODE(fmi3EnterContinuousTimeMode)
REFUSED_MODE(fmi3EvaluateDiscreteStates)
REFUSED(fmi3UpdateDiscreteStates, bool*, bool*, bool*, bool*, bool*, double*)

REFUSED(fmi3CompletedIntegratorStep, bool, bool*, bool*)
REFUSED(fmi3SetTime, double)
REFUSED(fmi3SetContinuousStates, const double[], std::size_t)
REFUSED(fmi3GetContinuousStates, double[], std::size_t)
REFUSED(fmi3GetContinuousStateDerivatives, double[], std::size_t)
REFUSED(fmi3GetNominalsOfContinuousStates, double[], std::size_t)
REFUSED(fmi3GetEventIndicators, double[], std::size_t)
REFUSED(fmi3GetNumberOfContinuousStates, std::size_t*)
REFUSED(fmi3GetNumberOfEventIndicators, std::size_t*)

REFUSED(fmi3GetClock, const Reference[], std::size_t, bool[])
REFUSED(fmi3SetClock, const Reference[], std::size_t, const bool[])
REFUSED(fmi3GetIntervalDecimal, const Reference[], std::size_t, double[], IntervalQualifier[])
REFUSED(fmi3GetIntervalFraction, const Reference[], std::size_t, std::uint64_t[], std::uint64_t[], IntervalQualifier[])
REFUSED(fmi3GetShiftDecimal, const Reference[], std::size_t, double[])
REFUSED(fmi3GetShiftFraction, const Reference[], std::size_t, std::uint64_t[], std::uint64_t[])
REFUSED(fmi3SetIntervalDecimal, const Reference[], std::size_t, const double[])
REFUSED(fmi3SetIntervalFraction, const Reference[], std::size_t, const std::uint64_t[], const std::uint64_t[])
REFUSED(fmi3SetShiftDecimal, const Reference[], std::size_t, const double[])
REFUSED(fmi3SetShiftFraction, const Reference[], std::size_t, const std::uint64_t[], const std::uint64_t[])
REFUSED(fmi3ActivateModelPartition, Reference, double)

}  // namespace enamel::fmi
