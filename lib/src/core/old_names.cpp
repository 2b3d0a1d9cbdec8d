#include "enamel/core/old_names.hpp"

#include <array>

namespace enamel {
namespace {

struct OldName {
  std::string_view kind, old, present;
  std::string_view ends;  // first version that rejects it
};

constexpr std::array<OldName, 2> kOldNames = {{
    {"plant", "real", "imperfect", "0.4"},
    {"plant", "real-stiff", "imperfect-stiff", "0.4"},
}};

const OldName* find(std::string_view kind, std::string_view name) noexcept {
  for (const OldName& entry : kOldNames)
    if (entry.kind == kind && entry.old == name) return &entry;
  return nullptr;
}

}  // namespace

std::string_view presentName(std::string_view kind, std::string_view name) noexcept {
  const OldName* entry = find(kind, name);
  return entry == nullptr ? name : entry->present;
}

std::string oldNameWarning(std::string_view kind, std::string_view name, std::string_view where) {
  const OldName* entry = find(kind, name);
  if (entry == nullptr) return "";
  std::string text(where);
  text += " ";
  text += name;
  text += ": is now called ";
  text += entry->present;
  text += "; version ";
  text += entry->ends;
  text += " removes the old name";
  return text;
}

}  // namespace enamel
