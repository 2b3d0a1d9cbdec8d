// Shared libraries: system_library_posix.cpp, system_library_windows.cpp.
#pragma once

#include <string>

namespace enamel::system {

extern const std::string kLibraryEnding;  // ".so"

// Throw PluginError unless the file is a whole shared library for this machine. The file's header permits a better
// message than the loader's.
void checkLibrary(const std::string& path);

void* loadLibrary(const std::string& path);       // throws PluginError
void* symbolOf(void* library, const char* name);  // nullptr: not exported
void unloadLibrary(void* library) noexcept;

}  // namespace enamel::system
