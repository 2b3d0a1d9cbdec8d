// Output files of a program: existing files are overwritten only on request.
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

/// Remove the file of a free path for a Recorder, which writes new files only.
void removeOld(const std::string& path, bool overwrite);

/// A file that a Recorder writes in place of `path`. An old recording remains complete until keep() replaces it. Until
/// then the new one grows beside it as PATH.NUMBER.part; without keep() it is removed.
class NewRecording {
 public:
  /// Throws Error: as removeOld().
  NewRecording(const std::string& path, bool overwrite);
  ~NewRecording();
  NewRecording(const NewRecording&) = delete;
  NewRecording& operator=(const NewRecording&) = delete;

  const std::string& place() const noexcept { return place_; }
  /// Replace the old recording. Throws Error with the file and the cause.
  void keep();

 private:
  std::string path_, place_;
};

}  // namespace enamel::app
