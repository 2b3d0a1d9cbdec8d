// Names of the version before that commands, scripts and files may still use. They all stand in one table.
#pragma once

#include <string>
#include <string_view>

namespace enamel {

/// Return the present name of what the version before called `name`; `name` itself where it has not changed. `kind` is
/// what it names: "plant". The result lives as long as its argument. Realtime: yes.
std::string_view presentName(std::string_view kind, std::string_view name) noexcept;

/// Return the warning for a user who gave an old name: "--plant real: its name is imperfect now, the old one ends with
/// version 0.4". `where` is how the user gave it. Empty where `name` is not an old name. Realtime: no.
std::string oldNameWarning(std::string_view kind, std::string_view name, std::string_view where);

}  // namespace enamel
