// The search loops on the vector V of the including file. lanes.inl lists what V needs. The including file also needs
// closestOfFour and closestToAxisOfFour of exact_four.inl. Everything has internal linkage.
#include "brick_cut.inl"
#include "cell_search.inl"
#include "clusters.inl"
#include "minima.inl"
#include "point_search.inl"
