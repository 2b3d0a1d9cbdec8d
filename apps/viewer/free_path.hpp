// Numbered names of files.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>

namespace enamel::viewer {

/// Return the first of stem-001, stem-002, ... in a folder that is free with each of the endings, without an ending.
std::string freePath(const std::filesystem::path& folder, const char* stem, std::initializer_list<const char*> endings);

}  // namespace enamel::viewer
