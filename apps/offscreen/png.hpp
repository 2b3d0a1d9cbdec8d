// Writes pictures to files.
#pragma once

#include <string>

namespace enamel::offscreen {

/// Write a picture (RGB, rows from the bottom) as PNG with writeFile(). Throws Error.
void writePng(int width, int height, const unsigned char* rgb, const std::string& path);

}  // namespace enamel::offscreen
