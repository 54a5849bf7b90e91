// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/geometry/clusters.h"

#include <algorithm>
#include <cassert>
#include <numeric>

namespace acus {
namespace {

// Sorts part of `order` so that every `capacity` of its elements are neighbours: halves it across the longest side of
// the box around the middles, and then each half. Equal coordinates are told apart by the elements' numbers.
void sort_by_place(std::span<int> order, const Matrix3X& middles, int capacity) {
  const int count = static_cast<int>(order.size());
  if (count <= capacity) return;
  const Bounds box = bounds_of(middles, order);
  int axis = 0;
  (box.high - box.low).maxCoeff(&axis);
  const int clusters = (count + capacity - 1) / capacity;
  const int half = clusters / 2 * capacity;
  std::nth_element(order.begin(), order.begin() + half, order.end(),
                   [&](int a, int b) { return std::pair(middles(axis, a), a) < std::pair(middles(axis, b), b); });
  sort_by_place(order.first(half), middles, capacity);
  sort_by_place(order.subspan(half), middles, capacity);
}

}  // namespace

Bounds bounds_of(const Matrix3X& x, std::span<const int> nodes) {
  Vector3 low = Bounds().low, high = Bounds().high;
  // Of two numbers Eigen takes the first if the second is not a number, as std::min does.
  for (const int i : nodes) {
    low = low.cwiseMin(x.col(i));
    high = high.cwiseMax(x.col(i));
  }
  return {low, high};
}

Clusters::Clusters(const Matrix3X& rest, std::span<const std::array<int, 3>> triangles, int capacity) {
  build(rest, triangles, capacity);
}

Clusters::Clusters(const Matrix3X& rest, std::span<const std::array<int, 4>> tetrahedra, int capacity) {
  build(rest, tetrahedra, capacity);
}

template <std::size_t Corners>
void Clusters::build(const Matrix3X& rest, std::span<const std::array<int, Corners>> elements, int capacity) {
  assert(capacity > 0);
  assert(rest.allFinite());
  const int count = static_cast<int>(elements.size());
  Matrix3X middles = Matrix3X::Zero(3, count);
  for (int i = 0; i < count; ++i)
    for (const int node : elements[i]) middles.col(i) += rest.col(node) / static_cast<double>(Corners);
  elements_.resize(elements.size());
  std::iota(elements_.begin(), elements_.end(), 0);
  sort_by_place(elements_, middles, capacity);

  for (int begin = 0; begin < count; begin += capacity) {
    const int end = std::min(begin + capacity, count);
    std::sort(elements_.begin() + begin, elements_.begin() + end);
    std::vector<int> corners;
    for (int i = begin; i < end; ++i)
      corners.insert(corners.end(), elements[elements_[i]].begin(), elements[elements_[i]].end());
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    nodes_.insert(nodes_.end(), corners.begin(), corners.end());
    ends_.push_back({end, static_cast<int>(nodes_.size())});
  }
}

std::span<const int> Clusters::elements(int cluster) const {
  assert(cluster >= 0 && cluster < count());
  const int begin = cluster > 0 ? ends_[cluster - 1].element : 0;
  return std::span(elements_).subspan(begin, ends_[cluster].element - begin);
}

std::span<const int> Clusters::nodes(int cluster) const {
  assert(cluster >= 0 && cluster < count());
  const int begin = cluster > 0 ? ends_[cluster - 1].node : 0;
  return std::span(nodes_).subspan(begin, ends_[cluster].node - begin);
}

}  // namespace acus
