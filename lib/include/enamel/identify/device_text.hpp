// Device files with estimated numbers.
#pragma once

#include <string>

#include "enamel/identify/identify.hpp"
#include "enamel/render/position_control.hpp"

namespace enamel {

/// Replace the value of a key of a TOML text, such as "platform.mass". Comments and order remain. A missing key or
/// table is added. Throws Error if the value extends over several lines. Realtime: no.
std::string withValue(const std::string& text, const std::string& key, const std::string& value);

/// Return the text of a device file with the estimates of an identification. All estimates and what the file cannot
/// hold, such as the delay, are comments at its beginning. `text` is that of the device file. Throws Error if the
/// identification is not usable, and ConfigurationError if the result is not a device. Realtime: no.
std::string identifiedText(const std::string& text, const Identification& result);

/// Return the text of a device file with the masses and the stiffness of the cables that position control has learnt in
/// use. A comment at its beginning has the factors, their 95 % intervals and the learnt delay. `text` is that of the
/// device file that position control had. Throws ConfigurationError if the result is not a device. Realtime: no.
std::string learntText(const std::string& text, const PositionControlState& learnt);

/// Return the learnt factors and the delay as lines for people.
std::string tableOf(const PositionControlState& learnt);

/// Return the estimates as lines for people: value, interval, value before, and what is not seen.
std::string tableOf(const Identification& result);

}  // namespace enamel
