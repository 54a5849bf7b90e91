// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/element/rotation_grid.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/rotation.h"

namespace acus {

namespace {

// Of a mean of unit quaternions: below it they cancel.
constexpr double kLeastMean = 1e-3;

// The nodes along axes that turn with the mesh.
Matrix3X nodes_along_mesh(const TetrahedralMesh& mesh) {
  const auto& first = mesh.tetrahedra[0];
  const Vector3 x = (mesh.nodes.col(first[1]) - mesh.nodes.col(first[0])).normalized();
  Vector3 y, z;
  perpendicular_basis(mesh, x, y, z);
  Matrix3 axes;
  axes << x, y, z;
  return axes.transpose() * mesh.nodes;
}

// `aligned`: all quaternions have one sign.
template <class Sum, class Quaternion>
void add_aligned(const Quaternion& q, double weight, bool aligned, Sum&& sum) {
  sum += (aligned || sum.dot(q) >= 0 ? weight : -weight) * q;
}

}  // namespace

RotationGrid make_rotation_grid(const TetrahedralMesh& mesh) {
  RotationGrid grid;
  if (mesh.tetrahedra.empty()) return grid;
  const Matrix3X nodes = nodes_along_mesh(mesh);
  const Vector3 low = nodes.rowwise().minCoeff(), extent = nodes.rowwise().maxCoeff() - low;
  const double spacing = kRotationGridSpacing * mean_element_size(mesh);
  Eigen::Array3i cells;
  for (int k = 0; k < 3; ++k) cells[k] = std::max(1, static_cast<int>(extent[k] / spacing));
  grid.points = (cells + 1).prod();
  grid.nodes.resize(static_cast<std::size_t>(mesh.node_count()));
  for (int i = 0; i < mesh.node_count(); ++i) {
    RotationGrid::Node& node = grid.nodes[static_cast<std::size_t>(i)];
    Eigen::Array3i cell;
    Vector3 within;  // the cell, 0 to 1
    for (int k = 0; k < 3; ++k) {
      const double at = (nodes(k, i) - low[k]) / extent[k] * cells[k];
      cell[k] = std::min(static_cast<int>(at), cells[k] - 1);
      within[k] = at - cell[k];
    }
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Array3i step(corner & 1, corner >> 1 & 1, corner >> 2);
      const Eigen::Array3i p = cell + step;
      double weight = 1;
      for (int k = 0; k < 3; ++k) weight *= step[k] == 1 ? within[k] : 1 - within[k];
      node.points[static_cast<std::size_t>(corner)] = p[0] + (cells[0] + 1) * (p[1] + (cells[1] + 1) * p[2]);
      node.weights[static_cast<std::size_t>(corner)] = weight;
    }
  }
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    for (const int i : mesh.tetrahedra[static_cast<std::size_t>(t)])
      grid.nodes[static_cast<std::size_t>(i)].volume += rest_volume(mesh, t) / 4;
  }
  return grid;
}

void smooth_rotations(const RotationGrid& grid, Matrix4X& q, Matrix4X& sums) {
  assert(q.cols() == static_cast<Eigen::Index>(grid.nodes.size()) && sums.cols() == grid.points);
  if (grid.nodes.empty()) return;
  const bool aligned = have_one_sign(q);
  const int nodes = static_cast<int>(grid.nodes.size());
  sums.setZero();
  add_to_grid(grid, q, aligned, 0, nodes, sums);
  normalize_grid(sums);
  take_from_grid(grid, sums, aligned, 0, nodes, q);
}

bool have_one_sign(const Matrix4X& q) { return q.row(0).minCoeff() > kOneSign; }

void add_to_grid(const RotationGrid& grid, const Matrix4X& q, bool aligned, int first, int last, Matrix4X& sums) {
  for (int i = first; i < last; ++i) {
    const RotationGrid::Node& node = grid.nodes[static_cast<std::size_t>(i)];
    for (std::size_t k = 0; k < 8; ++k)
      add_aligned(q.col(i), node.weights[k] * node.volume, aligned, sums.col(node.points[k]));
  }
}

void normalize_grid(Matrix4X& sums) {
  for (Eigen::Index g = 0; g < sums.cols(); ++g) sums.col(g).stableNormalize();
}

void take_from_grid(const RotationGrid& grid, const Matrix4X& sums, bool aligned, int first, int last, Matrix4X& q) {
  for (int i = first; i < last; ++i) {
    const RotationGrid::Node& node = grid.nodes[static_cast<std::size_t>(i)];
    Eigen::Vector4d mean = Eigen::Vector4d::Zero();
    for (std::size_t k = 0; k < 8; ++k) add_aligned(sums.col(node.points[k]), node.weights[k], aligned, mean);
    const double norm = mean.norm();
    if (norm > kLeastMean) q.col(i) = mean / norm;
  }
}

}  // namespace acus
