#include <dlfcn.h>
#include <elf.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "enamel/plugin/host.hpp"
#include "plugin/system_library.hpp"

namespace enamel::system {
namespace {

#if defined(__x86_64__)
constexpr int kMachine = EM_X86_64;
#elif defined(__aarch64__)
constexpr int kMachine = EM_AARCH64;
#else
constexpr int kMachine = EM_NONE;  // not checked
#endif

std::string machineName(int machine) {
  switch (machine) {
    case EM_X86_64: return "x86-64";
    case EM_AARCH64: return "AArch64";
    case EM_386: return "x86 of 32 bits";
    case EM_ARM: return "ARM of 32 bits";
    case EM_RISCV: return "RISC-V";
    default: return "ELF machine " + std::to_string(machine);
  }
}

}  // namespace

const std::string kLibraryEnding = ".so";

void checkLibrary(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(std::filesystem::u8path(path), ignored))
    throw PluginError(path + ": no such file");
  Elf64_Ehdr head{};
  std::ifstream file(std::filesystem::u8path(path), std::ios::binary | std::ios::ate);
  const auto size = static_cast<std::uint64_t>(std::max<std::streamoff>(file.tellg(), 0));
  const auto readAt = [&](std::uint64_t at, auto& into) {
    file.seekg(static_cast<std::streamoff>(at));
    return static_cast<bool>(file.read(reinterpret_cast<char*>(&into), sizeof into));
  };
  if (!readAt(0, head) || std::memcmp(head.e_ident, ELFMAG, SELFMAG) != 0)
    throw PluginError(path + ": is not a shared library (its ELF header is missing)");
  if (kMachine != EM_NONE && head.e_machine != kMachine)
    throw PluginError(path + ": is built for " + machineName(head.e_machine) + ", this host for " +
                      machineName(kMachine));
  if (head.e_type != ET_DYN || head.e_ident[EI_CLASS] != ELFCLASS64 || head.e_phentsize != sizeof(Elf64_Phdr))
    throw PluginError(path + ": is not a shared library");
  // The loader maps what the header promises. Past the end of the file that is a bus error.
  for (std::uint64_t i = 0; i < head.e_phnum; ++i) {
    Elf64_Phdr part{};
    const std::uint64_t at = head.e_phoff + i * sizeof part;
    if (at >= size || !readAt(at, part) || part.p_offset > size || part.p_filesz > size - part.p_offset)
      throw PluginError(path + ": is truncated: it has " + std::to_string(size) + " bytes, its header declares more");
  }
}

void* loadLibrary(const std::string& path) {
  // A name without '/' would be searched for in the system's folders.
  void* library = dlopen(std::filesystem::absolute(path).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) throw PluginError(path + ": cannot be loaded: " + dlerror());
  return library;
}

void* symbolOf(void* library, const char* name) { return dlsym(library, name); }

void unloadLibrary(void* library) noexcept { dlclose(library); }

}  // namespace enamel::system
