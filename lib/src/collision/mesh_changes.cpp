#include "enamel/collision/mesh_changes.hpp"

#include <utility>

namespace enamel {
namespace {

// Set the value of a number, and replace an earlier one.
template <typename Value>
void put(int number, const Value& value, std::vector<int>& place, std::vector<int>& numbers,
         std::vector<Value>& values) noexcept {
  int& at = place[static_cast<std::size_t>(number)];
  if (at >= 0) {
    values[static_cast<std::size_t>(at)] = value;
    return;
  }
  at = static_cast<int>(numbers.size());
  numbers.push_back(number);  // within the reserved size: each number is stored once
  values.push_back(value);
}

}  // namespace

MeshChanges::MeshChanges(int vertices, int triangles) {
  for (List& list : lists_) {
    list.ofVertex.assign(static_cast<std::size_t>(vertices), -1);
    list.ofTriangle.assign(static_cast<std::size_t>(triangles), -1);
    list.change.vertices.reserve(list.ofVertex.size());
    list.change.positions.reserve(list.ofVertex.size());
    list.change.triangles.reserve(list.ofTriangle.size());
    list.change.corners.reserve(list.ofTriangle.size());
  }
}

void MeshChanges::List::clear() noexcept {
  for (const int v : change.vertices) ofVertex[static_cast<std::size_t>(v)] = -1;
  for (const int t : change.triangles) ofTriangle[static_cast<std::size_t>(t)] = -1;
  change.vertices.clear();
  change.positions.clear();
  change.triangles.clear();
  change.corners.clear();
}

void MeshChanges::recordVertex(int vertex, const Vec3& position) noexcept {
  put(vertex, position, told_->ofVertex, told_->change.vertices, told_->change.positions);
  isEdited_ = true;
}

void MeshChanges::recordTriangle(int triangle, const std::array<int, 3>& corners) noexcept {
  put(triangle, corners, told_->ofTriangle, told_->change.triangles, told_->change.corners);
  isEdited_ = true;
}

std::uint64_t MeshChanges::publish() noexcept {
  if (isEdited_) ++edits_;
  isEdited_ = false;
  const MeshChange& change = told_->change;
  if (change.vertices.empty() && change.triangles.empty()) return edits_;
  if (isFull_.load(std::memory_order_acquire)) return edits_;
  told_->change.revision = edits_;
  std::swap(told_, published_);
  isFull_.store(true, std::memory_order_release);
  return edits_;
}

const MeshChange* MeshChanges::take() noexcept {
  if (!isFull_.load(std::memory_order_acquire)) return nullptr;
  taken_->clear();
  std::swap(taken_, published_);
  isFull_.store(false, std::memory_order_release);
  return &taken_->change;
}

}  // namespace enamel
