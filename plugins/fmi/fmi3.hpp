// The part of FMI 3.0 that units of co-simulation and their importers need: types and signatures as the standard
// states them (Functional Mock-up Interface Specification 3.0, 2022, sections 2.2 and 4.2), in names of our own. That
// they are those of the official headers is tested where these are at hand (tests/fmi/headers.cpp).
#pragma once

#include <cstddef>
#include <cstdint>

namespace enamel::fmi {

enum Status : int { ok, warning, discard, error, fatal };

using Instance = void*;
using State = void*;
using Reference = std::uint32_t;  // of a variable

using LogMessage = void (*)(void* environment, Status status, const char* category, const char* message);
using IntermediateUpdate = void (*)(void* environment, double time, bool setRequested, bool getAllowed, bool finished,
                                    bool canReturnEarly, bool* earlyReturnRequested, double* earlyReturnTime);

using GetVersion = const char*();
using InstantiateCoSimulation = Instance(const char* name, const char* token, const char* resources, bool visible,
                                         bool loggingOn, bool eventModeUsed, bool earlyReturnAllowed,
                                         const Reference required[], std::size_t requiredCount, void* environment,
                                         LogMessage log, IntermediateUpdate update);
using FreeInstance = void(Instance);
using EnterInitializationMode = Status(Instance, bool toleranceDefined, double tolerance, double startTime,
                                       bool stopTimeDefined, double stopTime);
using Transition = Status(Instance);  // ExitInitializationMode, Terminate, Reset, EnterStepMode ...
template <typename T>
using Get = Status(Instance, const Reference references[], std::size_t count, T values[], std::size_t valueCount);
template <typename T>
using Set = Status(Instance, const Reference references[], std::size_t count, const T values[], std::size_t valueCount);
using DoStep = Status(Instance, double time, double step, bool noSetStateBefore, bool* eventNeeded, bool* terminate,
                      bool* earlyReturn, double* lastTime);
using GetState = Status(Instance, State*);
using SetState = Status(Instance, State);
using FreeState = Status(Instance, State*);
using StateSize = Status(Instance, State, std::size_t*);
using Serialize = Status(Instance, State, std::uint8_t bytes[], std::size_t size);
using Deserialize = Status(Instance, const std::uint8_t bytes[], std::size_t size, State*);

}  // namespace enamel::fmi
