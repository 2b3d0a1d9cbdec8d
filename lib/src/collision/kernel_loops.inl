// The search loops on the vector V of the including file (what it must have: lanes.inl, and closestOfFour and
// closestToAxisOfFour of exact_four.inl). Everything has internal linkage.
#include "minima.inl"
#include "point_search.inl"
