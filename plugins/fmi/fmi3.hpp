// FMI 3.0 for units of co-simulation and their importers: types, and the signatures of all functions that a unit must
// export. Source: Functional Mock-up Interface Specification 3.0, 2022, sections 2 to 5; the names are our own.
// tests/fmi/headers.cpp compares them with the official headers if these are available.
#pragma once

#include <cstddef>
#include <cstdint>

namespace enamel::fmi {

enum Status : int { ok, warning, discard, error, fatal };
enum DependencyKind : int;     // values are not used here
enum IntervalQualifier : int;  // of clocks

using Instance = void*;
using State = void*;
using Reference = std::uint32_t;  // of a variable
using String = const char*;
using Binary = const std::uint8_t*;

using LogMessage = void (*)(void* environment, Status status, String category, String message);
using IntermediateUpdate = void (*)(void* environment, double time, bool setRequested, bool getAllowed, bool finished,
                                    bool canReturnEarly, bool* earlyReturnRequested, double* earlyReturnTime);
using ClockUpdate = void (*)(void* environment);
using Preemption = void (*)();

// ---- life --------------------------------------------------------------------------------------------------------

using GetVersion = String();
using SetDebugLogging = Status(Instance, bool on, std::size_t count, const String categories[]);
using InstantiateCoSimulation = Instance(String name, String token, String resources, bool visible, bool loggingOn,
                                         bool eventModeUsed, bool earlyReturnAllowed, const Reference required[],
                                         std::size_t requiredCount, void* environment, LogMessage log,
                                         IntermediateUpdate update);
using InstantiateModelExchange = Instance(String name, String token, String resources, bool visible, bool loggingOn,
                                          void* environment, LogMessage log);
using InstantiateScheduledExecution = Instance(String name, String token, String resources, bool visible,
                                               bool loggingOn, void* environment, LogMessage log, ClockUpdate update,
                                               Preemption lock, Preemption unlock);
using FreeInstance = void(Instance);
using EnterInitializationMode = Status(Instance, bool toleranceDefined, double tolerance, double startTime,
                                       bool stopTimeDefined, double stopTime);
using Transition = Status(Instance);  // from one mode to another

// ---- variables ---------------------------------------------------------------------------------------------------

template <typename T>
using Get = Status(Instance, const Reference references[], std::size_t count, T values[], std::size_t valueCount);
template <typename T>
using Set = Status(Instance, const Reference references[], std::size_t count, const T values[], std::size_t valueCount);
using GetBinary = Status(Instance, const Reference references[], std::size_t count, std::size_t sizes[],
                         Binary values[], std::size_t valueCount);
using SetBinary = Status(Instance, const Reference references[], std::size_t count, const std::size_t sizes[],
                         const Binary values[], std::size_t valueCount);
using CountDependencies = Status(Instance, Reference, std::size_t* count);
using GetDependencies = Status(Instance, Reference dependent, std::size_t elements[], Reference independents[],
                               std::size_t independentElements[], DependencyKind kinds[], std::size_t count);
using Differentiate = Status(Instance, const Reference unknowns[], std::size_t unknownCount, const Reference knowns[],
                             std::size_t knownCount, const double seed[], std::size_t seedCount, double result[],
                             std::size_t resultCount);
using GetOutputDerivatives = Status(Instance, const Reference references[], std::size_t count,
                                    const std::int32_t orders[], double values[], std::size_t valueCount);

// ---- state -------------------------------------------------------------------------------------------------------

using GetState = Status(Instance, State*);
using SetState = Status(Instance, State);
using FreeState = Status(Instance, State*);
using StateSize = Status(Instance, State, std::size_t*);
using Serialize = Status(Instance, State, std::uint8_t bytes[], std::size_t size);
using Deserialize = Status(Instance, const std::uint8_t bytes[], std::size_t size, State*);

// ---- steps, continuous time --------------------------------------------------------------------------------------

using DoStep = Status(Instance, double time, double step, bool noSetStateBefore, bool* eventNeeded, bool* terminate,
                      bool* earlyReturn, double* lastTime);
using CompletedStep = Status(Instance, bool noSetStateBefore, bool* enterEventMode, bool* terminate);
using SetTime = Status(Instance, double time);
using SetContinuous = Status(Instance, const double values[], std::size_t count);
using GetContinuous = Status(Instance, double values[], std::size_t count);
using CountContinuous = Status(Instance, std::size_t* count);

// ---- events, clocks ----------------------------------------------------------------------------------------------

using UpdateDiscreteStates = Status(Instance, bool* needUpdate, bool* terminate, bool* nominalsChanged,
                                    bool* valuesChanged, bool* nextEventTimeDefined, double* nextEventTime);
using GetClock = Status(Instance, const Reference references[], std::size_t count, bool values[]);
using SetClock = Status(Instance, const Reference references[], std::size_t count, const bool values[]);
using GetIntervalDecimal = Status(Instance, const Reference references[], std::size_t count, double intervals[],
                                  IntervalQualifier qualifiers[]);
using GetIntervalFraction = Status(Instance, const Reference references[], std::size_t count, std::uint64_t counters[],
                                   std::uint64_t resolutions[], IntervalQualifier qualifiers[]);
using GetShiftDecimal = Status(Instance, const Reference references[], std::size_t count, double shifts[]);
using GetShiftFraction = Status(Instance, const Reference references[], std::size_t count, std::uint64_t counters[],
                                std::uint64_t resolutions[]);
using SetClockTimes = Status(Instance, const Reference references[], std::size_t count, const double times[]);
using SetClockFractions = Status(Instance, const Reference references[], std::size_t count,
                                 const std::uint64_t counters[], const std::uint64_t resolutions[]);
using ActivateModelPartition = Status(Instance, Reference clock, double time);

}  // namespace enamel::fmi

/// Calls X(name, type in enamel::fmi) for every function that a unit must export.
#define ENAMEL_FMI3_FUNCTIONS(X)                                      \
  X(fmi3GetVersion, GetVersion)                                       \
  X(fmi3SetDebugLogging, SetDebugLogging)                             \
  X(fmi3InstantiateCoSimulation, InstantiateCoSimulation)             \
  X(fmi3InstantiateModelExchange, InstantiateModelExchange)           \
  X(fmi3InstantiateScheduledExecution, InstantiateScheduledExecution) \
  X(fmi3FreeInstance, FreeInstance)                                   \
  X(fmi3EnterInitializationMode, EnterInitializationMode)             \
  X(fmi3ExitInitializationMode, Transition)                           \
  X(fmi3EnterConfigurationMode, Transition)                           \
  X(fmi3ExitConfigurationMode, Transition)                            \
  X(fmi3EnterEventMode, Transition)                                   \
  X(fmi3EnterStepMode, Transition)                                    \
  X(fmi3EnterContinuousTimeMode, Transition)                          \
  X(fmi3EvaluateDiscreteStates, Transition)                           \
  X(fmi3Terminate, Transition)                                        \
  X(fmi3Reset, Transition)                                            \
  X(fmi3GetFloat32, Get<float>)                                       \
  X(fmi3GetFloat64, Get<double>)                                      \
  X(fmi3GetInt8, Get<std::int8_t>)                                    \
  X(fmi3GetUInt8, Get<std::uint8_t>)                                  \
  X(fmi3GetInt16, Get<std::int16_t>)                                  \
  X(fmi3GetUInt16, Get<std::uint16_t>)                                \
  X(fmi3GetInt32, Get<std::int32_t>)                                  \
  X(fmi3GetUInt32, Get<std::uint32_t>)                                \
  X(fmi3GetInt64, Get<std::int64_t>)                                  \
  X(fmi3GetUInt64, Get<std::uint64_t>)                                \
  X(fmi3GetBoolean, Get<bool>)                                        \
  X(fmi3GetString, Get<String>)                                       \
  X(fmi3GetBinary, GetBinary)                                         \
  X(fmi3SetFloat32, Set<float>)                                       \
  X(fmi3SetFloat64, Set<double>)                                      \
  X(fmi3SetInt8, Set<std::int8_t>)                                    \
  X(fmi3SetUInt8, Set<std::uint8_t>)                                  \
  X(fmi3SetInt16, Set<std::int16_t>)                                  \
  X(fmi3SetUInt16, Set<std::uint16_t>)                                \
  X(fmi3SetInt32, Set<std::int32_t>)                                  \
  X(fmi3SetUInt32, Set<std::uint32_t>)                                \
  X(fmi3SetInt64, Set<std::int64_t>)                                  \
  X(fmi3SetUInt64, Set<std::uint64_t>)                                \
  X(fmi3SetBoolean, Set<bool>)                                        \
  X(fmi3SetString, Set<String>)                                       \
  X(fmi3SetBinary, SetBinary)                                         \
  X(fmi3GetNumberOfVariableDependencies, CountDependencies)           \
  X(fmi3GetVariableDependencies, GetDependencies)                     \
  X(fmi3GetDirectionalDerivative, Differentiate)                      \
  X(fmi3GetAdjointDerivative, Differentiate)                          \
  X(fmi3GetOutputDerivatives, GetOutputDerivatives)                   \
  X(fmi3GetFMUState, GetState)                                        \
  X(fmi3SetFMUState, SetState)                                        \
  X(fmi3FreeFMUState, FreeState)                                      \
  X(fmi3SerializedFMUStateSize, StateSize)                            \
  X(fmi3SerializeFMUState, Serialize)                                 \
  X(fmi3DeserializeFMUState, Deserialize)                             \
  X(fmi3DoStep, DoStep)                                               \
  X(fmi3CompletedIntegratorStep, CompletedStep)                       \
  X(fmi3SetTime, SetTime)                                             \
  X(fmi3SetContinuousStates, SetContinuous)                           \
  X(fmi3GetContinuousStates, GetContinuous)                           \
  X(fmi3GetContinuousStateDerivatives, GetContinuous)                 \
  X(fmi3GetNominalsOfContinuousStates, GetContinuous)                 \
  X(fmi3GetEventIndicators, GetContinuous)                            \
  X(fmi3GetNumberOfContinuousStates, CountContinuous)                 \
  X(fmi3GetNumberOfEventIndicators, CountContinuous)                  \
  X(fmi3UpdateDiscreteStates, UpdateDiscreteStates)                   \
  X(fmi3GetClock, GetClock)                                           \
  X(fmi3SetClock, SetClock)                                           \
  X(fmi3GetIntervalDecimal, GetIntervalDecimal)                       \
  X(fmi3GetIntervalFraction, GetIntervalFraction)                     \
  X(fmi3GetShiftDecimal, GetShiftDecimal)                             \
  X(fmi3GetShiftFraction, GetShiftFraction)                           \
  X(fmi3SetIntervalDecimal, SetClockTimes)                            \
  X(fmi3SetIntervalFraction, SetClockFractions)                       \
  X(fmi3SetShiftDecimal, SetClockTimes)                               \
  X(fmi3SetShiftFraction, SetClockFractions)                          \
  X(fmi3ActivateModelPartition, ActivateModelPartition)
