// compare.html: the comparison as one self-contained file.
#pragma once

#include "compare/compare.hpp"
#include "compare/conditions.hpp"

namespace enamel::app {

/// Return the conditions of a plant in their order.
std::vector<const Condition*> onPlant(const std::vector<Condition>& conditions, const std::string& plant);

/// Return which renderer ranks first on a plant, and by how much position control is stiffer than its rivals; HTML.
/// Needs kPush.
std::string sentenceOf(const std::vector<const Condition*>& conditions);

std::string pageOf(const CompareOptions& options, const std::vector<Condition>& conditions);

}  // namespace enamel::app
