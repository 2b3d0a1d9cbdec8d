#include "program/outputs.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "enamel/core/error.hpp"
#include "program/system.hpp"

namespace enamel::app {

namespace fs = std::filesystem;

void addOverwrite(CLI::App& command, bool& overwrite, const std::vector<std::string>& files) {
  command.add_flag("--overwrite", overwrite, "replace existing results");
  if (files.empty()) return;
  command.parse_complete_callback([&command, &overwrite, files] {
    for (const std::string& name : files)
      if (const CLI::Option* option = command.get_option(name); option->count() > 0)
        requireFree(option->results().back(), overwrite);
  });
}

void requireFree(const std::string& path, bool overwrite) {
  std::error_code none;
  if (!overwrite && path != "/dev/stdout" && fs::is_regular_file(fs::u8path(path), none) &&
      fs::file_size(fs::u8path(path), none) > 0)
    throw Error(path + ": exists; --overwrite replaces it");
}

void removeOld(const std::string& path, bool overwrite) {
  std::error_code none;  // a link is never removed
  if (fs::is_regular_file(fs::symlink_status(fs::u8path(path), none)) &&
      (overwrite || fs::file_size(fs::u8path(path), none) == 0))
    fs::remove(fs::u8path(path));
}

NewRecording::NewRecording(const std::string& path, bool overwrite) : path_(path), place_(path) {
  std::error_code none;
  const bool isOld =
      fs::is_regular_file(fs::symlink_status(fs::u8path(path), none)) && fs::file_size(fs::u8path(path), none) > 0;
  if (isOld && overwrite) place_ += "." + processNumber() + ".part";
  removeOld(place_, overwrite);
}

NewRecording::~NewRecording() {
  std::error_code none;
  if (place_ != path_) fs::remove(fs::u8path(place_), none);
}

void NewRecording::keep() {
  if (place_ == path_) return;
  std::error_code error;
  fs::rename(fs::u8path(place_), fs::u8path(path_), error);
  if (error) throw Error(path_ + ": cannot make the recording: " + error.message());
  place_ = path_;
}

}  // namespace enamel::app
