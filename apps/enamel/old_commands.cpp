#include "old_commands.hpp"

#include <algorithm>
#include <map>

namespace enamel::app {
namespace {

using Arguments = std::vector<std::string>;

std::string nameOf(const std::string& argument) { return argument.substr(0, argument.find('=')); }

bool has(const Arguments& arguments, const std::string& name) {
  return std::any_of(arguments.begin(), arguments.end(), [&](const auto& text) { return nameOf(text) == name; });
}

// Rename options, also in the form NAME=VALUE.
void renameOptions(Arguments& arguments, const std::map<std::string, std::string>& names) {
  for (std::string& text : arguments)
    if (const auto found = names.find(nameOf(text)); found != names.end())
      text = found->second + text.substr(found->first.size());
}

void dropOptions(Arguments& arguments, const std::vector<std::string>& names) {
  const auto old = [&](const std::string& text) {
    return std::find(names.begin(), names.end(), nameOf(text)) != names.end();
  };
  arguments.erase(std::remove_if(arguments.begin(), arguments.end(), old), arguments.end());
}

// Move an option and its values to the end.
void moveToEnd(Arguments& arguments, const std::string& name) {
  Arguments rest, moved;
  bool inside = false;
  for (const std::string& text : arguments) {
    if (text.rfind("-", 0) == 0) inside = nameOf(text) == name;
    (inside ? moved : rest).push_back(text);
  }
  arguments = rest;
  arguments.insert(arguments.end(), moved.begin(), moved.end());
}

// Translate `trials` and its defaults. --gain moves to the end because its columns came last.
void renameTrials(Arguments& arguments) {
  Arguments more{"--release"};
  if (!has(arguments, "--renderers")) more.insert(more.end(), {"--renderers", "position-control,hold,impedance"});
  if (!has(arguments, "--device-damping")) more.insert(more.end(), {"--device-damping", "0"});
  moveToEnd(arguments, "--gain");
  renameOptions(arguments, {{"--gain", "--renderers"}, {"--filter", "--tasks"}, {"--delay", "--delays"}});
  arguments.insert(arguments.begin() + 1, more.begin(), more.end());
  arguments.front() = "compare";
}

}  // namespace

std::vector<std::string> presentCommand(std::vector<std::string> arguments, std::string& warning) {
  const Arguments given = arguments;
  const std::string command = arguments.empty() ? "" : arguments.front();
  if (command == "trials") renameTrials(arguments);
  if (command == "study") {
    renameOptions(arguments, {{"--laws", "--tuned"}});
    if (has(arguments, "--judge")) {
      dropOptions(arguments, {"--judge", "--encoders", "--inside-tick", "--no-convergence"});
      arguments.front() = "compare";
    }
  }
  if (arguments == given) return arguments;
  warning = "an old name, which version 0.4 removes; write: enamel";
  for (const std::string& text : arguments) warning += " " + text;
  return arguments;
}

}  // namespace enamel::app
