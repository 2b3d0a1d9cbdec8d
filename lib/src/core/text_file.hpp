// Files that are read whole. Private to the library.
#pragma once

#include <string>

namespace enamel {

/// Whole content of a text file. Throws ConfigurationError if it cannot be read or is larger than 16 MiB.
std::string readTextFile(const std::string& path);

}  // namespace enamel
