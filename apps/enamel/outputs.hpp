// Files that a command writes: what is there already is overwritten only on request.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace enamel::app {

/// Throw Error if `path` is a file with content and `overwrite` is false. An empty path, an empty file, a pipe and a
/// device may be written.
void requireFree(const std::string& path, bool overwrite);

/// Remove an old recording, because a Recorder writes only new files.
void removeOld(const std::string& path, bool overwrite);

/// Give a command the option --overwrite.
void addOverwrite(CLI::App& command, bool& overwrite);

/// The same for a command whose outputs are the values of these options: they are checked before it runs.
void protectOutputs(CLI::App& command, const std::vector<std::string>& options);

}  // namespace enamel::app
