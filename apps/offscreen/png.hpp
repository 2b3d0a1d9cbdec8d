// Pictures as files.
#pragma once

#include <string>

namespace enamel::offscreen {

/// Writes a picture (RGB, rows from the bottom) as PNG: writeFile(). Throws Error.
void writePng(int width, int height, const unsigned char* rgb, const std::string& path);

}  // namespace enamel::offscreen
