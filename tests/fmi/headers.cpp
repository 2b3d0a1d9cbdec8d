// Compiled where the official headers are at hand: our declarations have their types. Enumerations count as what they
// are stored in.
#include <type_traits>

#include "fmi3FunctionTypes.h"
#include "plugins/fmi/fmi3.hpp"

namespace {

// What crosses the boundary: enumerations as integers, pointers to functions by their own parameters.
template <typename T, typename = void>
struct Plain {
  using type = std::remove_cv_t<T>;
};
template <typename T>
struct Plain<T, std::enable_if_t<std::is_enum_v<T>>> {
  using type = int;
};
template <typename R, typename... A>
struct Plain<R(A...), void> {
  using type = typename Plain<R>::type(typename Plain<A>::type...);
};
template <typename R, typename... A>
struct Plain<R (*)(A...), void> {
  using type = typename Plain<R>::type (*)(typename Plain<A>::type...);
};
template <typename Ours, typename Theirs>
constexpr bool same = std::is_same_v<typename Plain<Ours>::type, typename Plain<Theirs>::type>;

namespace fmi = enamel::fmi;
static_assert(fmi::ok == int{fmi3OK} && fmi::warning == int{fmi3Warning} && fmi::discard == int{fmi3Discard} &&
              fmi::error == int{fmi3Error} && fmi::fatal == int{fmi3Fatal} && sizeof(fmi::Status) == sizeof(fmi3Status));
static_assert(same<fmi::LogMessage, fmi3LogMessageCallback>);
static_assert(same<fmi::IntermediateUpdate, fmi3IntermediateUpdateCallback>);
static_assert(same<fmi::GetVersion, fmi3GetVersionTYPE>);
static_assert(same<fmi::InstantiateCoSimulation, fmi3InstantiateCoSimulationTYPE>);
static_assert(same<fmi::FreeInstance, fmi3FreeInstanceTYPE>);
static_assert(same<fmi::EnterInitializationMode, fmi3EnterInitializationModeTYPE>);
static_assert(same<fmi::Transition, fmi3ExitInitializationModeTYPE>);
static_assert(same<fmi::Transition, fmi3TerminateTYPE>);
static_assert(same<fmi::Transition, fmi3ResetTYPE>);
static_assert(same<fmi::Transition, fmi3EnterStepModeTYPE>);
static_assert(same<fmi::Get<double>, fmi3GetFloat64TYPE>);
static_assert(same<fmi::Set<double>, fmi3SetFloat64TYPE>);
static_assert(same<fmi::Get<std::int32_t>, fmi3GetInt32TYPE>);
static_assert(same<fmi::Set<std::int32_t>, fmi3SetInt32TYPE>);
static_assert(same<fmi::Get<bool>, fmi3GetBooleanTYPE>);
static_assert(same<fmi::Set<bool>, fmi3SetBooleanTYPE>);
static_assert(same<fmi::DoStep, fmi3DoStepTYPE>);
static_assert(same<fmi::GetState, fmi3GetFMUStateTYPE>);
static_assert(same<fmi::SetState, fmi3SetFMUStateTYPE>);
static_assert(same<fmi::FreeState, fmi3FreeFMUStateTYPE>);
static_assert(same<fmi::StateSize, fmi3SerializedFMUStateSizeTYPE>);
static_assert(same<fmi::Serialize, fmi3SerializeFMUStateTYPE>);
static_assert(same<fmi::Deserialize, fmi3DeserializeFMUStateTYPE>);
// A trap that must not be same.
static_assert(!same<fmi::DoStep, fmi3EnterInitializationModeTYPE>);

}  // namespace
