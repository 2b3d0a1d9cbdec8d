// Names of the previous version that commands, scripts and files may still use. One table holds them all.
#pragma once

#include <string>
#include <string_view>

namespace enamel {

/// Return the present name for an old `name`, or `name` itself if it has not changed. `kind` is the kind of thing that
/// it names, such as "plant". The result lives as long as its argument. Realtime: yes.
std::string_view presentName(std::string_view kind, std::string_view name) noexcept;

/// Return a warning for an old name, or an empty string if `name` is not an old name. `where` is the option or key that
/// the user gave. Example: "--plant real: its name is imperfect now, the old one ends with version 0.4". Realtime: no.
std::string oldNameWarning(std::string_view kind, std::string_view name, std::string_view where);

}  // namespace enamel
