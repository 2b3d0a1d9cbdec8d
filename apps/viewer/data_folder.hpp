// Where the scenes and devices that come with the program are.
#pragma once

#include <string>

namespace enamel::viewer {

/// The folder `data`: beside the installed program if there is one, else that of the source tree.
std::string dataFolder();

}  // namespace enamel::viewer
