#include <windows.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "enamel/plugin/host.hpp"
#include "plugin/system_library.hpp"

namespace enamel::system {
namespace {

#if defined(_M_ARM64) || defined(__aarch64__)
constexpr WORD kMachine = IMAGE_FILE_MACHINE_ARM64;
#else
constexpr WORD kMachine = IMAGE_FILE_MACHINE_AMD64;
#endif

std::string machineName(WORD machine) {
  switch (machine) {
    case IMAGE_FILE_MACHINE_AMD64: return "x86-64";
    case IMAGE_FILE_MACHINE_ARM64: return "AArch64";
    case IMAGE_FILE_MACHINE_I386: return "x86 of 32 bits";
    default: return "machine " + std::to_string(machine);
  }
}

}  // namespace

const std::string kLibraryEnding = ".dll";

void checkLibrary(const std::string& path) {
  const std::filesystem::path place = std::filesystem::u8path(path);
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(place, ignored)) throw PluginError(path + ": no such file");
  std::ifstream file(place, std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
  const auto readAt = [&](std::uint64_t at, auto& into) {
    file.seekg(static_cast<std::streamoff>(at));
    return static_cast<bool>(file.read(reinterpret_cast<char*>(&into), sizeof into));
  };
  IMAGE_DOS_HEADER dos{};
  DWORD signature = 0;
  IMAGE_FILE_HEADER head{};
  const auto at = [&dos] { return static_cast<std::uint64_t>(std::max<LONG>(dos.e_lfanew, 0)); };
  if (!readAt(0, dos) || dos.e_magic != IMAGE_DOS_SIGNATURE || !readAt(at(), signature) ||
      signature != IMAGE_NT_SIGNATURE || !readAt(at() + sizeof signature, head))
    throw PluginError(path + ": is not a shared library (its PE header is missing)");
  if (head.Machine != kMachine)
    throw PluginError(path + ": is built for " + machineName(head.Machine) + ", this host for " +
                      machineName(kMachine));
  if ((head.Characteristics & IMAGE_FILE_DLL) == 0) throw PluginError(path + ": is not a shared library");
  for (std::uint64_t i = 0; i < head.NumberOfSections; ++i) {
    IMAGE_SECTION_HEADER part{};
    const std::uint64_t header = at() + sizeof signature + sizeof head + head.SizeOfOptionalHeader + i * sizeof part;
    if (!readAt(header, part) || part.PointerToRawData > size || part.SizeOfRawData > size - part.PointerToRawData)
      throw PluginError(path + ": is truncated: it has " + std::to_string(size) + " bytes, its header declares more");
  }
}

void* loadLibrary(const std::string& path) {
  // With the whole path, libraries beside the plugin are found as well.
  HMODULE library = LoadLibraryExW(std::filesystem::absolute(std::filesystem::u8path(path)).c_str(), nullptr,
                                   LOAD_WITH_ALTERED_SEARCH_PATH);
  if (library == nullptr) {
    const auto error = static_cast<int>(GetLastError());
    throw PluginError(path + ": cannot be loaded: " + std::system_category().message(error));
  }
  return library;
}

void* symbolOf(void* library, const char* name) {
  return reinterpret_cast<void*>(GetProcAddress(static_cast<HMODULE>(library), name));
}

void unloadLibrary(void* library) noexcept { FreeLibrary(static_cast<HMODULE>(library)); }

}  // namespace enamel::system
