#include "message.hpp"

#include <charconv>
#include <cmath>
#include <cstring>

namespace enamel::haply {
namespace {

constexpr int kDeepest = 32;  // nested values

// Reads JSON (RFC 8259) from left to right, without memory of its own. After an error every function returns false.
class Reader {
 public:
  explicit Reader(std::string_view text) noexcept : at_(text.data()), end_(text.data() + text.size()) {}

  bool isGood() const noexcept { return isGood_; }
  bool isAtEnd() noexcept {
    skipSpace();
    return at_ == end_;
  }

  // Call member(key) for each member; it must read the value.
  template <typename Member>
  bool object(const Member& member) noexcept {
    if (!take('{')) return fail();
    if (take('}')) return true;
    do {
      std::string_view key;
      if (!text(key) || !take(':')) return fail();
      member(key);
    } while (isGood_ && take(','));
    return take('}') || fail();
  }

  // Call element() for each element; it must read it.
  template <typename Element>
  bool array(const Element& element) noexcept {
    if (!take('[')) return fail();
    if (take(']')) return true;
    do {
      element();
    } while (isGood_ && take(','));
    return take(']') || fail();
  }

  // A text as it is written, with its escapes.
  bool text(std::string_view& value) noexcept {
    if (!take('"')) return fail();
    const char* begin = at_;
    while (at_ != end_ && *at_ != '"') at_ += *at_ == '\\' && end_ - at_ > 1 ? 2 : 1;
    if (at_ == end_) return fail();
    value = {begin, static_cast<std::size_t>(at_ - begin)};
    ++at_;
    return true;
  }

  bool number(double& value) noexcept {
    skipSpace();
    const bool isNumber = at_ != end_ && (*at_ == '-' || (*at_ >= '0' && *at_ <= '9'));
    const auto [rest, error] = std::from_chars(at_, end_, value);
    if (!isNumber || error != std::errc{} || !std::isfinite(value)) return fail();
    at_ = rest;
    return true;
  }

  bool boolean(bool& value) noexcept {
    value = word("true");
    return value || word("false") || fail();
  }

  bool skip() noexcept {
    if (++depth_ > kDeepest) return fail();
    skipSpace();
    if (at_ == end_) return fail();
    std::string_view ignored;
    double number = 0.0;
    bool isRead = false;
    if (*at_ == '{')
      isRead = object([this](std::string_view) { skip(); });
    else if (*at_ == '[')
      isRead = array([this] { skip(); });
    else if (*at_ == '"')
      isRead = text(ignored);
    else
      isRead = word("true") || word("false") || word("null") || this->number(number);
    --depth_;
    return isRead;
  }

 private:
  bool fail() noexcept {
    isGood_ = false;
    at_ = end_;
    return false;
  }
  void skipSpace() noexcept {
    while (at_ != end_ && (*at_ == ' ' || *at_ == '\t' || *at_ == '\n' || *at_ == '\r')) ++at_;
  }
  bool take(char expected) noexcept {
    skipSpace();
    if (at_ == end_ || *at_ != expected) return false;
    ++at_;
    return true;
  }
  bool word(const char* expected) noexcept {
    skipSpace();
    const std::size_t length = std::strlen(expected);
    if (static_cast<std::size_t>(end_ - at_) < length || std::strncmp(at_, expected, length) != 0) return false;
    at_ += length;
    return true;
  }

  const char *at_, *end_;
  bool isGood_ = true;
  int depth_ = 0;
};

// Return whether x, y and z are there.
bool readNumbers(Reader& reader, Numbers& value) noexcept {
  std::array<bool, 3> isRead{};
  reader.object([&](std::string_view key) {
    const std::size_t i = key == "x" ? 0 : key == "y" ? 1 : key == "z" ? 2 : 3;
    if (i == 3)
      reader.skip();
    else
      isRead[i] = reader.number(value[i]);
  });
  return isRead[0] && isRead[1] && isRead[2];
}

// Return whether a transform has a rotation, or a scale other than 1. Its position only moves the centre.
bool readTurn(Reader& reader) noexcept {
  constexpr double kSame = 1e-3;
  bool isTurned = false;
  reader.object([&](std::string_view key) {
    const bool isRotation = key == "rotation";
    if (!isRotation && key != "scale") return void(reader.skip());
    reader.object([&](std::string_view part) {
      double value = 0.0;
      if (reader.number(value) && part != "w") isTurned |= std::abs(value - (isRotation ? 0.0 : 1.0)) > kSame;
    });
  });
  return isTurned;
}

void readConfig(Reader& reader, DeviceState& device) noexcept {
  reader.object([&](std::string_view name) {
    if (name == "type")
      reader.text(device.type);
    else if (name == "preset")
      reader.text(device.preset);
    else if (name == "extended_firmware_version")
      reader.text(device.firmware);
    else if (name == "mount")
      device.isTurned |= readTurn(reader);
    else if (name == "basis")
      reader.object([&](std::string_view part) { part == "permutation" ? reader.text(device.basis) : reader.skip(); });
    else
      reader.skip();
  });
}

void readDevice(Reader& reader, DeviceState& device) noexcept {
  bool hasPosition = false, hasVelocity = false;
  reader.object([&](std::string_view key) {
    if (key == "device_id") {
      reader.text(device.id);
    } else if (key == "state") {
      reader.object([&](std::string_view name) {
        if (name == "cursor_position")
          hasPosition = readNumbers(reader, device.position);
        else if (name == "cursor_velocity")
          hasVelocity = readNumbers(reader, device.velocity);
        else if (name == "transform")
          device.isTurned |= readTurn(reader);
        else
          reader.skip();
      });
    } else if (key == "config") {
      readConfig(reader, device);
    } else if (key == "status") {
      reader.object([&](std::string_view name) {
        name == "calibrated"     ? reader.boolean(device.isCalibrated)
        : name == "power_supply" ? reader.boolean(device.hasPower)
                                 : reader.skip();
      });
    } else {
      reader.skip();
    }
  });
  device.hasPosition = hasPosition && hasVelocity;
}

void readButtons(Reader& reader, std::uint32_t& buttons) noexcept {
  reader.object([&](std::string_view key) {
    if (key != "state") return void(reader.skip());
    reader.object([&](std::string_view name) {
      if (bool isPressed = false; name == "button") {  // of a wired grip
        if (reader.boolean(isPressed) && isPressed) buttons |= 1U;
        return;
      }
      if (name != "buttons") return void(reader.skip());
      reader.object([&](std::string_view button) {
        const bool isKnown = button.size() == 1 && button[0] >= 'a' && button[0] <= 'c';
        bool isPressed = false;
        if (!isKnown) return void(reader.skip());
        if (reader.boolean(isPressed) && isPressed) buttons |= 1U << static_cast<unsigned>(button[0] - 'a');
      });
    });
  });
}

// Appends to a text of fixed size.
class Writer {
 public:
  explicit Writer(std::array<char, kMessageBytes>& text) noexcept : text_(text) {}
  Writer& operator<<(std::string_view part) noexcept {
    if (part.size() > text_.size() - size_) return isFull_ = true, *this;
    std::memcpy(text_.data() + size_, part.data(), part.size());
    size_ += part.size();
    return *this;
  }
  Writer& operator<<(double number) noexcept {
    std::array<char, 32> digits{};
    const auto [end, error] =
        std::to_chars(digits.data(), digits.data() + digits.size(), number, std::chars_format::fixed, 5);
    if (error != std::errc{}) return isFull_ = true, *this;
    return *this << std::string_view(digits.data(), static_cast<std::size_t>(end - digits.data()));
  }
  std::size_t size() const noexcept { return isFull_ ? 0 : size_; }

 private:
  std::array<char, kMessageBytes>& text_;
  std::size_t size_ = 0;
  bool isFull_ = false;
};

}  // namespace

Message readMessage(std::string_view text) noexcept {
  Message message;
  Reader reader(text);
  bool hasGrip = false;
  reader.object([&](std::string_view key) {
    if (key == "inverse3") {
      reader.array([&] {
        DeviceState ignored;
        readDevice(reader, message.count < message.devices.size() ? message.devices[message.count++] : ignored);
      });
    } else if (key == "verse_grip" || key == "wireless_verse_grip") {
      reader.array([&] {
        std::uint32_t ignored = 0;
        readButtons(reader, hasGrip ? ignored : message.buttons);
        hasGrip = true;
      });
    } else {
      reader.skip();
    }
  });
  message.isValid = reader.isGood() && reader.isAtEnd();
  return message;
}

std::size_t writeForce(std::string_view id, const Numbers& force, Format format, bool isFirst,
                       std::array<char, kMessageBytes>& text) noexcept {
  if (id.size() > kIdBytes) return 0;
  Writer out(text);
  out << "{";
  if (isFirst && format == Format::v35) out << R"("session":{"configure":{"profile":{"name":"enamel"}}},)";
  out << R"("inverse3":[{"device_id":")" << id << R"(","commands":{"set_cursor_force":{")"
      << (format == Format::v35 ? "vector" : "values") << R"(":{"x":)" << force[0] << R"(,"y":)" << force[1]
      << R"(,"z":)" << force[2] << "}}}}]}";
  return out.size();
}

}  // namespace enamel::haply
