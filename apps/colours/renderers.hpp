// Name, colour and line style of every renderer, the same in the viewer, on pages and in plots.
#pragma once

#include <string_view>

#include "colours/palette.hpp"

namespace enamel::viewer {

struct RendererLook {
  std::string_view name;  ///< as in --renderers
  const char* title;      ///< for people
  unsigned colour;
  int dash[2];  ///< lengths of dashes and gaps; zero: a solid line
};

/// Methods of one family have one colour: solid as published, dashed as varied or tuned. The first four are the linked
/// renderers, in the order of the viewer's slots.
inline constexpr RendererLook kRendererLooks[] = {
    {"position-control", "position control", kBlue, {}},
    {"impedance", "impedance", kPurple, {}},
    {"hold", "hold", kSky, {}},
    {"passivity", "passivity control", kGreen, {}},
    {"hold-scheduled", "scheduled hold", kSky, {9, 3}},
    {"impedance-edge", "impedance at the edge of eq. 16", kPurple, {2, 3}},
    {"best-spring", "best spring", kPurple, {9, 3}},
    {"tuned:hold", "hold, tuned", kSky, {5, 3}},
    {"tuned:hold-delay", "hold that foresees the delay, tuned", kSky, {2, 3}},
    {"tuned:virtual-coupling", "virtual coupling, tuned", kOrange, {5, 3}},
    {"tuned:passivity", "passivity control, tuned", kGreen, {5, 3}},
    {"tuned:passivity-memory", "passivity control with memory, tuned", kGreen, {2, 3}},
    {"tuned:impedance", "impedance, tuned", kPurple, {5, 3}}};

/// Looks of all other renderers, in their order: plugins and servo files.
inline constexpr RendererLook kOtherLooks[] = {
    {"", "", kBrown, {}}, {"", "", kInk, {}}, {"", "", kBrown, {5, 3}}, {"", "", kInk, {5, 3}}};

/// Return the look of a renderer; nullptr if its name is not in the table.
constexpr const RendererLook* lookOf(std::string_view name) {
  for (const RendererLook& look : kRendererLooks)
    if (look.name == name) return &look;
  return nullptr;
}

}  // namespace enamel::viewer
