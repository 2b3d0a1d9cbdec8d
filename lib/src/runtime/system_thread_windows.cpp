#include <windows.h>
// These need windows.h.
#include <avrt.h>
#include <mmsystem.h>

#include <chrono>
#include <string>

#include "runtime/system_thread.hpp"

#ifndef CREATE_WAITABLE_TIMER_HIGH_RESOLUTION
#define CREATE_WAITABLE_TIMER_HIGH_RESOLUTION 0x00000002
#endif

namespace enamel::system {
namespace {

// A timer of each thread. One of high resolution needs Windows 10 of 2018 or later.
struct Timer {
  HANDLE handle = CreateWaitableTimerExW(nullptr, nullptr, CREATE_WAITABLE_TIMER_HIGH_RESOLUTION, TIMER_ALL_ACCESS);
  const bool isCoarse = handle == nullptr;

  Timer() noexcept {
    if (!isCoarse) return;
    handle = CreateWaitableTimerW(nullptr, FALSE, nullptr);
    timeBeginPeriod(1);
  }
  ~Timer() {
    CloseHandle(handle);
    if (isCoarse) timeEndPeriod(1);
  }
};

}  // namespace

std::int64_t clockNow() noexcept {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// The timer ends up to half a millisecond late, a coarse one up to one: compute through that time.
void sleepUntil(std::int64_t deadline) noexcept {
  static thread_local const Timer timer;
  const std::int64_t margin = timer.isCoarse ? 1500000 : 600000;  // ns
  if (const std::int64_t left = deadline - clockNow() - margin; left > 0) {
    LARGE_INTEGER due;
    due.QuadPart = -left / 100;  // relative, in 100 ns
    if (SetWaitableTimer(timer.handle, &due, 0, nullptr, nullptr, FALSE)) WaitForSingleObject(timer.handle, INFINITE);
  }
  while (clockNow() < deadline) YieldProcessor();
}

// Windows has no priorities from 1 to 99: the scheduler for multimedia, or the highest of the normal class.
bool requestRealtime(int) noexcept {
  DWORD task = 0;
  if (const HANDLE handle = AvSetMmThreadCharacteristicsW(L"Pro Audio", &task); handle != nullptr) {
    AvSetMmThreadPriority(handle, AVRT_PRIORITY_CRITICAL);
    return true;
  }
  return SetThreadPriority(GetCurrentThread(), THREAD_PRIORITY_TIME_CRITICAL) != 0;
}

void nameThread(const char* name) noexcept {
  // In Windows 10 of 2016 and later.
  using Function = HRESULT(WINAPI*)(HANDLE, PCWSTR);
  void* function = reinterpret_cast<void*>(GetProcAddress(GetModuleHandleW(L"kernel32"), "SetThreadDescription"));
  wchar_t wide[16] = {};
  for (int i = 0; i < 15 && name[i] != 0; ++i) wide[i] = static_cast<unsigned char>(name[i]);
  if (function != nullptr) (void)reinterpret_cast<Function>(function)(GetCurrentThread(), wide);
}

void makeWriteErrorsOrdinary() noexcept {}  // they are

}  // namespace enamel::system
