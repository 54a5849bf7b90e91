// SPDX-License-Identifier: GPL-3.0-or-later
// Neighbouring triangles or tetrahedra in groups, so that a query looks at the boxes around a few nodes each, and at
// the elements of the few boxes that matter. Constant after construction: a box is that of its nodes in the
// configuration x (3 x nodes, m) at the moment of the query, however the elements are deformed.
#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include "server/engine/math/types.h"

namespace acus {

// A box along the axes (m); empty until it has a point. Coordinates that are not numbers are left out.
struct Bounds {
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity());
  Vector3 high = Vector3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Bounds& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  // False for a p that is not a number.
  bool contains(const Vector3& p, double margin = 0) const {
    return (p.array() >= low.array() - margin).all() && (p.array() <= high.array() + margin).all();
  }
};

// The box around some nodes.
Bounds bounds_of(const Matrix3X& x, std::span<const int> nodes);

class Clusters {
 public:
  Clusters() = default;
  // Elements whose middles are neighbours at rest come together, at most `capacity` of them.
  Clusters(const Matrix3X& rest, std::span<const std::array<int, 3>> triangles, int capacity);
  Clusters(const Matrix3X& rest, std::span<const std::array<int, 4>> tetrahedra, int capacity);

  int count() const { return static_cast<int>(ends_.size()); }
  // Numbers of the elements, and of the nodes, of a cluster; both ascend.
  std::span<const int> elements(int cluster) const;
  std::span<const int> nodes(int cluster) const;
  Bounds bounds(const Matrix3X& x, int cluster) const { return bounds_of(x, nodes(cluster)); }

 private:
  struct End {
    int element, node;  // one past the last in elements_ and nodes_
  };
  template <std::size_t Corners>
  void build(const Matrix3X& rest, std::span<const std::array<int, Corners>> elements, int capacity);

  std::vector<int> elements_, nodes_;  // of one cluster after the other
  std::vector<End> ends_;              // per cluster
};

}  // namespace acus
