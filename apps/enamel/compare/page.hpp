// compare.html: the comparison in one file that needs nothing else.
#pragma once

#include "compare/compare.hpp"
#include "compare/conditions.hpp"

namespace enamel::app {

/// The conditions of a plant, in their order.
std::vector<const Condition*> onPlant(const std::vector<Condition>& conditions, const std::string& plant);

/// Who ranks first on a plant, and by how much position control is stiffer than its rivals; HTML. Needs kPush.
std::string sentenceOf(const std::vector<const Condition*>& conditions);

std::string pageOf(const CompareOptions& options, const std::vector<Condition>& conditions);

}  // namespace enamel::app
