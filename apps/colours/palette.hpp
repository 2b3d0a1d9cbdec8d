// Colours of the viewer: calm backgrounds, and signals that colour-blind people can distinguish (Okabe and Ito 2008).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <string_view>
#include <utility>

#include "enamel/core/types.hpp"

namespace enamel::viewer {

struct Colour {
  double r, g, b;
};

constexpr Colour colour(unsigned rgb) {
  return {(rgb >> 16 & 255) / 255.0, (rgb >> 8 & 255) / 255.0, (rgb & 255) / 255.0};
}

/// Return red, green and blue as a vector, 0 to 1.
inline Vec3 rgbOf(unsigned rgb) {
  const Colour c = colour(rgb);
  return {c.r, c.g, c.b};
}

inline constexpr unsigned kGround = 0xE9EDF1, kPaper = 0xF7F8FA, kLine = 0xD3D9E0, kInk = 0x1F262E, kMuted = 0x66707C;
inline constexpr unsigned kBlue = 0x0072B2, kOrange = 0xE69F00, kGreen = 0x009E73, kVermilion = 0xD55E00;
inline constexpr unsigned kPurple = 0xCC79A7, kSky = 0x56B4E9, kBrown = 0x8C6D1F;
// Each has one meaning. Renderers have the colours of renderers.hpp.
inline constexpr unsigned kForce = kVermilion, kHand = kOrange, kDepth = 0x1F262E, kReference = 0x5B6B7B;
inline constexpr unsigned kJoints[] = {0x2B3138, 0x9A7B4F, 0x8FA0B0};  // of the charts: dark, brown, light
inline constexpr unsigned kWrong = 0xA3141E;                           // a warning
inline constexpr unsigned kChosen = 0x3D4957;                          // the selected button; an action in progress
inline constexpr unsigned kMotor = 0x333C47, kLink1 = 0x55606E, kLink2 = 0x8C97A4, kColumn = 0xB9C2CC;
inline constexpr unsigned kPlatform = 0x6C7785, kHandle = 0x2F6F73, kNeedle = 0x3A424C;
inline constexpr unsigned kEnamel = 0xF3EAD6, kEnamelGrid = 0xBFA873, kEnamelEdge = 0x9C8A5E, kCubeLine = 0x93A0AE;
inline constexpr unsigned kGum = 0xF2B3AA, kGumBack = 0xC98680, kGumEdge = 0xB06A64, kSectionEdge = 0x7A5B34;
inline constexpr unsigned kGuide = 0x6A4C93;
inline constexpr unsigned kBurSteel = 0xA9B2BC, kBurFlute = 0x2B3138;

/// Return the colour of a solid's layer: that of the tissue with its name, else one by its number.
constexpr unsigned layerColour(std::string_view name, std::size_t layer) {
  constexpr std::pair<std::string_view, unsigned> tissues[] = {{"enamel", 0xF3EAD6}, {"dentine", 0xE6BC62},
                                                               {"pulp", 0xC4473F},   {"caries", 0x7A5232},
                                                               {"gum", kGum},        {"bone", 0xC9BBA9}};
  for (const auto& [tissue, rgb] : tissues)
    if (tissue == name) return rgb;
  constexpr unsigned others[] = {0xF3EAD6, 0xE6BC62, 0xC4473F, 0x8FA9BF, 0x7E9B76, 0xA98BB5, 0x6C7785, 0x55606E};
  return others[layer % std::size(others)];
}

/// Distance from a target with the full colour, m, unless another one is chosen.
inline constexpr double kCutRange = 0.5e-3;

/// Return the colour of a prepared surface at a distance above its target, as a share of that with the full colour.
/// Blue is too deep, white is right, red is too high.
inline Vec3 cutColour(double share) {
  return Vec3::Ones() + std::min(1.0, std::abs(share)) * (rgbOf(share < 0.0 ? kBlue : kVermilion) - Vec3::Ones());
}

}  // namespace enamel::viewer
