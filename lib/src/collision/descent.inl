// Two traversals of the hierarchy: nearest child first, with pruning by the best answer so far, and in any order.
#pragma once

#include "lanes.inl"

// Prefetch to the second-level cache. The first level is too small for all requests.
inline void fetch(const void* address, int bytes) {
  constexpr int kLine = 64;
  for (int at = 0; at < bytes; at += kLine) __builtin_prefetch(static_cast<const char*>(address) + at, 0, 2);
}

inline void fetchTriangle(const Mesh& mesh, int32_t slot) { fetch(mesh.triangles + slot, sizeof(Triangle)); }

inline void fetchChild(const Mesh& mesh, int32_t child, int bytesOfLeaf = sizeof(Leaf::row)) {
  if (child < 0) {
    fetch(mesh.leaves + ~child, bytesOfLeaf);
  } else {
    fetch(mesh.nodes + child, sizeof(Node));
  }
}

// Nodes and leaves that are still to be visited, with lower bounds of their distances.
template <typename Number>
struct Stack {
  int top = 0;
  Number bound[kStackSize + kWidth];
  int32_t child[kStackSize + kWidth];
};

// Visit the nearest child of the mask next; push the others.
template <typename Bounds, typename Number>
inline int32_t goDown(const Mesh& mesh, const Bounds& bounds, const int32_t* child, unsigned mask,
                      Stack<Number>& stack) {
  const unsigned least = mask & lessOrEqualMask(bounds, smallest(bounds));
  const int nearest = __builtin_ctz(least != 0 ? least : mask);
  mask &= ~(1u << nearest);
  if (mask != 0) {
    const int bottom = stack.top;
    stack.top += __builtin_popcount(mask);
    push(bounds, mask, stack.bound + bottom);
    compress(child, choose(mask), stack.child + bottom);
    for (int i = bottom; i < stack.top; ++i) fetchChild(mesh, stack.child[i]);
  }
  return child[nearest];
}

// Depth first through everything within `limit`. atLeaf(leaf) and boundsOf(node), the children's bounds, may lower it.
template <typename Number, typename BoundsOf, typename AtLeaf>
inline void nearestFirst(const Mesh& mesh, const Number& limit, const BoundsOf& boundsOf, const AtLeaf& atLeaf) {
  Stack<Number> stack;
  int32_t current = mesh.root;
  for (;;) {
    if (current < 0) {
      atLeaf(~current);
    } else {
      const Node& node = mesh.nodes[current];
      const auto bounds = boundsOf(node);
      const unsigned mask = node.lanes & lessOrEqualMask(bounds, limit);
      if (mask != 0) {
        current = goDown(mesh, bounds, node.child, mask, stack);
        continue;
      }
    }
    do {
      if (stack.top == 0) return;
      --stack.top;
    } while (!(stack.bound[stack.top] <= limit));
    current = stack.child[stack.top];
  }
}

// Visit all children in the masks that nearOf(node) returns.
template <typename NearOf, typename AtLeaf>
inline void anyOrder(const Mesh& mesh, const NearOf& nearOf, const AtLeaf& atLeaf) {
  int32_t stack[kStackSize + kWidth];
  int top = 0;
  stack[top++] = mesh.root;
  while (top > 0) {
    const int32_t current = stack[--top];
    if (current < 0) {
      atLeaf(~current);
      continue;
    }
    const Node& node = mesh.nodes[current];
    const unsigned mask = node.lanes & nearOf(node);
    const int before = top;
    compress(node.child, choose(mask), stack + top);
    top += __builtin_popcount(mask);
    for (int i = before; i < top; ++i) fetchChild(mesh, stack[i], sizeof(Leaf));
  }
}
