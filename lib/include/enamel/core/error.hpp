// Exceptions of the configure phase (load, build, design, activate). Nothing in a tick throws.
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

namespace enamel {

/// A text as it may stand in a message: one line, control characters as `\xNN`, the middle of more than 2000 bytes left
/// out.
std::string printable(std::string_view text);

/// Base of every exception that the library throws. Its message is printable(), whatever a file held.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : std::runtime_error(printable(message)) {}
};

/// A file or a value of a configuration is unusable. The message has the form
/// "FILE:LINE: KEY: what is wrong, the value, the limit and the unit".
class ConfigurationError : public Error {
 public:
  ConfigurationError(std::string file, int line, std::string key, const std::string& problem);

  const std::string& file() const noexcept { return file_; }
  int line() const noexcept { return line_; }  ///< counted from 1; 0 where no line is to blame
  const std::string& key() const noexcept { return key_; }

 private:
  std::string file_;
  int line_;
  std::string key_;
};

/// A controller cannot be designed from these numbers; the message says which property is missing.
class DesignError : public Error {
 public:
  using Error::Error;
};

}  // namespace enamel
