// Windows has no fork(): the child is this program with the same command line and an environment variable that names
// the call of runInChild() whose work it does. Earlier calls return at once.
#include <fmt/core.h>
#include <windows.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <string>
#include <system_error>
#include <vector>

#include "child_process.hpp"
#include "enamel/core/error.hpp"

namespace enamel::app {
namespace {

constexpr char kAnswered = 'A', kFailed = 'F';         // first byte of the child's message
constexpr const wchar_t* kVariable = L"ENAMEL_CHILD";  // "CALL PIPE", numbers

struct Handle {
  HANDLE value = nullptr;
  ~Handle() { close(); }
  void close() {
    if (value != nullptr) CloseHandle(value);
    value = nullptr;
  }
};

[[noreturn]] void fail(const char* what) {
  throw Error(std::string("cannot ") + what + ": " + std::system_category().message(static_cast<int>(GetLastError())));
}

[[noreturn]] void answer(HANDLE pipe, const std::string& what, const std::function<std::string()>& work) {
  // No dialog box after a crash.
  SetErrorMode(SEM_FAILCRITICALERRORS | SEM_NOGPFAULTERRORBOX | SEM_NOOPENFILEERRORBOX);
  std::string message;
  try {
    message = kAnswered + work();
  } catch (const Error& error) {
    message = kFailed + std::string(error.what());
  } catch (const std::exception& error) {
    message = kFailed + what + " threw: " + error.what();
  } catch (...) {
    message = kFailed + what + " threw an unknown exception";
  }
  std::fflush(nullptr);
  for (std::size_t sent = 0; sent < message.size();) {
    DWORD n = 0;
    if (!WriteFile(pipe, message.data() + sent, static_cast<DWORD>(message.size() - sent), &n, nullptr)) break;
    sent += n;
  }
  TerminateProcess(GetCurrentProcess(), 0);  // without the destructors of the plugin
  std::abort();
}

// Append everything that is in the pipe.
void drain(HANDLE pipe, std::string& message) {
  std::array<char, 4096> buffer;
  for (DWORD there = 0, n = 0; PeekNamedPipe(pipe, nullptr, 0, nullptr, &there, nullptr) && there > 0;) {
    if (!ReadFile(pipe, buffer.data(), static_cast<DWORD>(buffer.size()), &n, nullptr)) return;
    message.append(buffer.data(), n);
  }
}

double computingTime(HANDLE process) {
  FILETIME ignored, kernel{}, user{};
  if (!GetProcessTimes(process, &ignored, &ignored, &kernel, &user)) return 0.0;
  const auto seconds = [](const FILETIME& t) {
    return 1e-7 * static_cast<double>(static_cast<std::uint64_t>(t.dwHighDateTime) << 32 | t.dwLowDateTime);
  };
  return seconds(kernel) + seconds(user);
}

std::string endOf(DWORD status) {
  // Windows ends a process that crashed with a code of severity "error"; abort() ends it with 3.
  if (status >= 0xc0000000) return fmt::format("ended in a crash (0x{:08x})", status);
  if (status == 3) return "ended in a crash (exit status 3, as of abort())";
  return fmt::format("ended the process with exit status {}", status);
}

// Ends the child with this process.
void limitToLifeOfThis(HANDLE job) {
  JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits{};
  limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE;
  SetInformationJobObject(job, JobObjectExtendedLimitInformation, &limits, sizeof limits);
}

void start(int call, HANDLE pipe, HANDLE job, Handle& process) {
  std::wstring name(32768, L'\0'), line = GetCommandLineW();
  name.resize(GetModuleFileNameW(nullptr, name.data(), static_cast<DWORD>(name.size())));
  STARTUPINFOW how{};
  how.cb = sizeof how;
  how.dwFlags = STARTF_USESTDHANDLES;
  how.hStdInput = GetStdHandle(STD_INPUT_HANDLE);
  how.hStdOutput = GetStdHandle(STD_OUTPUT_HANDLE);
  how.hStdError = GetStdHandle(STD_ERROR_HANDLE);
  PROCESS_INFORMATION child{};
  const auto number = reinterpret_cast<std::uintptr_t>(pipe);
  SetEnvironmentVariableW(kVariable, (std::to_wstring(call) + L" " + std::to_wstring(number)).c_str());
  const bool isStarted = CreateProcessW(name.c_str(), line.data(), nullptr, nullptr, TRUE, CREATE_SUSPENDED, nullptr,
                                        nullptr, &how, &child) != 0;
  SetEnvironmentVariableW(kVariable, nullptr);
  if (!isStarted) fail("start a process");
  process.value = child.hProcess;
  AssignProcessToJobObject(job, child.hProcess);
  ResumeThread(child.hThread);
  CloseHandle(child.hThread);
}

}  // namespace

ChildResult runInChild(const std::string& what, double seconds, const std::function<std::string()>& work) {
  static int calls = 0;
  const int call = calls++;
  wchar_t own[64] = {};
  if (GetEnvironmentVariableW(kVariable, own, 64) > 0) {
    int wanted = 0;
    unsigned long long pipe = 0;
    if (std::swscanf(own, L"%d %llu", &wanted, &pipe) != 2) throw Error("ENAMEL_CHILD is for Enamel itself: unset it");
    if (call < wanted) return {};
    answer(reinterpret_cast<HANDLE>(static_cast<std::uintptr_t>(pipe)), what, work);
  }
  using Clock = std::chrono::steady_clock;
  std::fflush(nullptr);
  Handle readEnd, writeEnd, job, process;
  SECURITY_ATTRIBUTES inherited{sizeof(SECURITY_ATTRIBUTES), nullptr, TRUE};
  if (!CreatePipe(&readEnd.value, &writeEnd.value, &inherited, 0)) fail("make a pipe");
  SetHandleInformation(readEnd.value, HANDLE_FLAG_INHERIT, 0);
  job.value = CreateJobObjectW(nullptr, nullptr);
  limitToLifeOfThis(job.value);
  const auto deadline = Clock::now() + std::chrono::duration<double>(3.0 * seconds);
  start(call, writeEnd.value, job.value, process);
  writeEnd.close();
  std::string message, ending;
  while (WaitForSingleObject(process.value, 10) == WAIT_TIMEOUT) {
    drain(readEnd.value, message);
    if (!ending.empty()) continue;
    if (computingTime(process.value) > seconds) ending = fmt::format("computed for longer than {:.3g} s", seconds);
    if (Clock::now() > deadline) ending = fmt::format("did not end in {:.3g} s", 3 * seconds);
    if (!ending.empty()) TerminateProcess(process.value, 1);
  }
  drain(readEnd.value, message);
  DWORD status = 0;
  GetExitCodeProcess(process.value, &status);
  if (message.empty() || status != 0 || !ending.empty())
    return {"", what + " " + (ending.empty() ? endOf(status) : ending)};
  const std::string text = message.substr(1);
  return message[0] == kAnswered ? ChildResult{text, ""} : ChildResult{"", printable(text)};
}

}  // namespace enamel::app
