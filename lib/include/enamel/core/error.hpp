// Exceptions of the configure phase (load, build, design, activate). No function of a tick throws.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace enamel {

/// Return a text in printable form for a message: on one line, with control characters as `\xNN`. The middle of a text
/// longer than 2000 bytes is left out.
std::string printable(std::string_view text);

/// Base of every exception that the library throws. Its message is always printable().
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : std::runtime_error(printable(message)) {}
};

/// Error for an unusable file or configuration value. The message has the form
/// "FILE:LINE: KEY: what is wrong, the value, the limit and the unit".
class ConfigurationError : public Error {
 public:
  ConfigurationError(std::string file, int line, std::string key, const std::string& problem);

  const std::string& file() const noexcept { return file_; }
  int line() const noexcept { return line_; }  ///< counted from 1; 0 if no line applies
  const std::string& key() const noexcept { return key_; }

 private:
  std::string file_;
  int line_;
  std::string key_;
};

/// Error for numbers from which no controller can be designed. The message names the missing property.
class DesignError : public Error {
 public:
  using Error::Error;
};

}  // namespace enamel
