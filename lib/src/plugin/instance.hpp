// An instance of a plugin under test, called as a host calls it, and the requirements on its answers.
#pragma once

#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "checks.hpp"
#include "convert.hpp"

namespace enamel::conformance {

class Instance {
 public:
  explicit Instance(const EnamelPlugin& table) : table_(table), self_(table.create()) {
    demand(self_ != nullptr, "create() returned NULL");
  }
  ~Instance() { table_.destroy(self_); }
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  std::int32_t configure(const PluginSetup& setup) {
    const PlainSetup plain(setup);
    return table_.configure(self_, plain.get(), message());
  }
  std::int32_t activate(double period) { return table_.activate(self_, period, message()); }
  std::int32_t step(const EnamelTickInput& input) {
    std::memset(&output, 0x7f, sizeof output);  // reveals what a plugin does not write
    return table_.step(self_, &input, &output);
  }
  void reset() { table_.reset(self_); }
  void deactivate() { table_.deactivate(self_); }
  std::vector<unsigned char> save() const {
    std::vector<unsigned char> state(table_.state_size(self_));
    table_.save_state(self_, state.data());
    return state;
  }
  void saveTo(std::vector<unsigned char>& state) const { table_.save_state(self_, state.data()); }
  void load(const std::vector<unsigned char>& state) { table_.load_state(self_, state.data()); }

  void prepare(const PluginSetup& setup, double period) {
    if (const std::int32_t result = configure(setup); result != ENAMEL_OK) fail("configure()", result);
    if (const std::int32_t result = activate(period); result != ENAMEL_OK) fail("activate()", result);
  }

  EnamelTickOutput output{};

 private:
  EnamelMessage message() {
    text_.fill(0);
    return {text_.data(), text_.size()};
  }
  [[noreturn]] void fail(const char* what, std::int32_t result) {
    text_.back() = 0;
    throw Failure{std::string(what) + " failed: " + nameOf(result) + (text_[0] != 0 ? ": " : "") + text_.data()};
  }

  const EnamelPlugin& table_;
  void* self_;
  std::array<char, 512> text_{};
};

/// Require that an output is finite and its torque within the limits of `input`; if it `failed`, zero.
void requireDefined(const EnamelTickOutput& output, const EnamelTickInput& input, bool failed, const std::string& when);

/// Whether two outputs are equal bit by bit.
bool same(const EnamelTickOutput& a, const EnamelTickOutput& b);

}  // namespace enamel::conformance
