#include <fcntl.h>
#include <io.h>
#include <windows.h>
// This needs windows.h.
#include <shellapi.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include "enamel/core/error.hpp"
#include "program/system.hpp"

namespace enamel::app {

namespace fs = std::filesystem;

// Those of main() are in the code page of the system, which lacks most characters.
std::vector<std::string> argumentsOf(int, char**) {
  int count = 0;
  wchar_t** words = CommandLineToArgvW(GetCommandLineW(), &count);
  if (words == nullptr) throw Error("cannot read the command line");
  std::vector<std::string> arguments;
  for (int i = 1; i < count; ++i) arguments.push_back(fs::path(words[i]).u8string());
  LocalFree(words);
  return arguments;
}

void prepareStreams() noexcept {
  for (const int stream : {0, 1, 2}) _setmode(stream, _O_BINARY);
  SetConsoleOutputCP(CP_UTF8);
}

std::string programFile() {
  std::wstring name(32768, L'\0');  // the longest path of Windows
  name.resize(GetModuleFileNameW(nullptr, name.data(), static_cast<DWORD>(name.size())));
  return fs::path(name).u8string();
}

bool isTerminal(int stream) noexcept { return _isatty(stream) != 0; }

bool canWriteInto(const std::string& folder) { return _waccess(fs::u8path(folder).c_str(), 2) == 0; }

std::string processNumber() { return std::to_string(GetCurrentProcessId()); }

// Folders cannot be locked: a file that only one process can open. Windows deletes it with its last handle.
FolderLock::FolderLock(const std::string& folder, bool waits) {
  const std::wstring name = (fs::u8path(folder) / "study.lock").wstring();
  for (;;) {
    const HANDLE handle = CreateFileW(name.c_str(), GENERIC_WRITE | DELETE, 0, nullptr, OPEN_ALWAYS,
                                      FILE_ATTRIBUTE_HIDDEN | FILE_FLAG_DELETE_ON_CLOSE, nullptr);
    if (handle != INVALID_HANDLE_VALUE) {
      handle_ = reinterpret_cast<std::intptr_t>(handle);
      return;
    }
    const DWORD error = GetLastError();
    if (error != ERROR_SHARING_VIOLATION && error != ERROR_ACCESS_DENIED)
      throw Error(folder + ": cannot lock the folder: " + std::system_category().message(static_cast<int>(error)));
    if (!waits) throw Error(folder + ": another study writes into the folder");
    Sleep(50);  // ms
  }
}

FolderLock::~FolderLock() { CloseHandle(reinterpret_cast<HANDLE>(handle_)); }

}  // namespace enamel::app
