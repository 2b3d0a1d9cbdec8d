// Files that a program writes: what is there already is overwritten only on request.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace enamel::app {

/// Add the option --overwrite to a command. Before the command runs, requireFree() checks the values of the options
/// `files`.
void addOverwrite(CLI::App& command, bool& overwrite, const std::vector<std::string>& files = {});

/// Throw Error if `path` is a file with content and `overwrite` is false. An empty path, /dev/stdout, an empty file, a
/// pipe and a device are free.
void requireFree(const std::string& path, bool overwrite);

/// Remove the file of a path that is free, for a Recorder, which writes only new files.
void removeOld(const std::string& path, bool overwrite);

}  // namespace enamel::app
