// Compiled where the official headers are available: our declarations have their types. Enumerations count as the type
// in which they are stored.
#include <type_traits>

#include "fmi3FunctionTypes.h"
#include "plugins/fmi/fmi3.hpp"

namespace {

// Types at the boundary: enumerations as integers, pointers to functions by their own parameters.
template <typename T, typename = void>
struct Plain {
  using type = std::remove_cv_t<T>;
};
template <typename T>
struct Plain<T, std::enable_if_t<std::is_enum_v<T>>> {
  using type = int;
};
template <typename T>
struct Plain<T*, std::enable_if_t<std::is_enum_v<T>>> {
  using type = int*;
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
              fmi::error == int{fmi3Error} && fmi::fatal == int{fmi3Fatal} &&
              sizeof(fmi::Status) == sizeof(fmi3Status));
static_assert(same<fmi::LogMessage, fmi3LogMessageCallback>);
static_assert(same<fmi::IntermediateUpdate, fmi3IntermediateUpdateCallback>);
static_assert(same<fmi::ClockUpdate, fmi3ClockUpdateCallback>);
static_assert(same<fmi::Preemption, fmi3LockPreemptionCallback> && same<fmi::Preemption, fmi3UnlockPreemptionCallback>);
// A counterexample that must not be same.
static_assert(!same<fmi::DoStep, fmi3EnterInitializationModeTYPE>);

}  // namespace

namespace enamel::fmi {
#define SAME(name, type) static_assert(same<type, name##TYPE>, #name);
ENAMEL_FMI3_FUNCTIONS(SAME)
}  // namespace enamel::fmi
