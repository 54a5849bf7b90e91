// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/tissue_assembler.h"

#include <algorithm>
#include <cassert>
#include <span>
#include <utility>

#include "server/engine/models/element/corotational_energy.h"

namespace acus {

namespace {

// Unknown of local coordinate a (node * 3 + axis) of a tetrahedron, -1 where its node is fixed.
int unknown_of(const TissueModel& model, const std::array<int, 4>& nodes, int a) {
  const int free = model.free_index[nodes[a / 3]];
  return free < 0 ? -1 : 3 * free + a % 3;
}

// Calls visit(index in the packed triangle, a, b) for a >= b.
template <class Visit>
void for_lower_triangle(Visit visit) {
  int index = 0;
  for (int a = 0; a < 12; ++a)
    for (int b = 0; b <= a; ++b) visit(index++, a, b);
}

int position_in(const SparseMatrix& matrix, int row, int column) {
  const int* begin = matrix.innerIndexPtr() + matrix.outerIndexPtr()[column];
  const int* end = matrix.innerIndexPtr() + matrix.outerIndexPtr()[column + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - matrix.innerIndexPtr());
}

// Per free node, the free nodes from it on (numbered free_index) that a tetrahedron or a patch couples it to,
// ascending.
std::vector<std::vector<int>> coupled_nodes(const TissueModel& model) {
  std::vector<std::vector<int>> coupled(model.free_nodes.size());
  const auto couple = [&](std::span<const int> nodes) {
    for (const int i : nodes)
      for (const int j : nodes) {
        const int a = model.free_index[i], b = model.free_index[j];
        if (a >= 0 && b >= a) coupled[a].push_back(b);
      }
  };
  for (const auto& nodes : model.mesh->tetrahedra) couple(nodes);
  for (int patch = 0; patch < model.pressure.patches(); ++patch)
    if (model.pressure.modulus[patch] > 0) couple(model.pressure.nodes_of(patch));
  for (std::vector<int>& list : coupled) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return coupled;
}

// Lower triangle of 3 x 3 blocks, one for each pair of coupled nodes, zeros.
SparseMatrix make_pattern(const TissueModel& model) {
  const std::vector<std::vector<int>> coupled = coupled_nodes(model);
  SparseMatrix pattern(model.unknowns(), model.unknowns());
  if (model.unknowns() == 0) return pattern;  // Eigen 3.4 reads beyond the end where it compresses an empty matrix
  Eigen::VectorXi entries(model.unknowns());
  for (int i = 0; i < model.unknowns(); ++i) entries[i] = 3 * static_cast<int>(coupled[i / 3].size());
  pattern.reserve(entries);
  for (int column = 0; column < model.unknowns(); ++column)
    for (const int node : coupled[column / 3])
      for (int row = std::max(3 * node, column); row < 3 * node + 3; ++row) pattern.insert(row, column) = 0;
  pattern.makeCompressed();
  return pattern;
}

using ElementMatrix = Eigen::Matrix<double, 12, 12>;

void turn_into(const Matrix4X& frames, const std::array<int, 4>& nodes, ElementMatrix& k) {
  ElementMatrix axes = ElementMatrix::Zero();
  for (int a = 0; a < 4; ++a) axes.block<3, 3>(3 * a, 3 * a) = rotation_of(frames, nodes[a]).toRotationMatrix();
  k = (axes.transpose() * k * axes).eval();
}

// What the elements at x give to the patches: all g_a, and the pressures (Pa).
struct PatchState {
  PatchGradients gradients;
  VectorX pressures;

  PatchState(const TissueModel& model, const Matrix3X& x, const ElementRotations* rotations)
      : gradients(model.pressure), pressures(VectorX::Zero(model.pressure.patches())) {
    if (model.pressure.patches() == 0) return;
    for (int t = 0; t < model.mesh->tetrahedron_count(); ++t) {
      const auto& nodes = model.mesh->tetrahedra[t];
      double local[4][3], q[4] = {1, 0, 0, 0};
      gather_nodes(x, nodes, local);
      if (rotations != nullptr) rotations->element(t, q);
      const VolumeStrain strain = volume_strain(model.elements[t], local, q);
      gradients.add(t, nodes, strain.gradient);
      for (const int patch : model.pressure.of_element[t])
        pressures[patch] += model.elements[t].volume / 4 * strain.value;
    }
    pressures.array() *= model.pressure.modulus.array() / model.pressure.volume.array();
  }
};

}  // namespace

TissueAssembler::TissueAssembler(const TissueModel& model, std::vector<double> stiffening)
    : model_(model), stiffening_(std::move(stiffening)), pattern_(make_pattern(model)) {
  for (const auto& nodes : model.mesh->tetrahedra) {
    auto& positions = positions_.emplace_back();
    for_lower_triangle([&](int index, int a, int b) {
      const int row = unknown_of(model, nodes, a), column = unknown_of(model, nodes, b);
      positions[index] =
          row < 0 || column < 0 ? -1 : position_in(pattern_, std::max(row, column), std::min(row, column));
    });
  }
  for (int i = 0; i < model.unknowns(); ++i) diagonal_.push_back(position_in(pattern_, i, i));
}

void TissueAssembler::assemble(const Matrix3X& x, const ElementRotations& rotations, Tangent tangent,
                               const MatrixFactors& factors, SparseMatrix& matrix, const Matrix4X* frames) const {
  assert(!frames || model_.pressure.patches() == 0);
  if (matrix.nonZeros() != pattern_.nonZeros()) matrix = pattern_;
  double* values = matrix.valuePtr();
  std::fill_n(values, matrix.nonZeros(), 0.0);
  const Matrix3X& where = tangent == Tangent::rest ? model_.mesh->nodes : x;
  const PatchState patches(model_, where, tangent == Tangent::rest ? nullptr : &rotations);
  for (int t = 0; t < model_.mesh->tetrahedron_count(); ++t) {
    double local[4][3], q[4] = {1, 0, 0, 0};
    gather_nodes(where, model_.mesh->tetrahedra[t], local);
    if (tangent != Tangent::rest) rotations.element(t, q);
    const double pressure = model_.pressure.patches() == 0 ? 0 : mean_pressure(model_.pressure, t, patches.pressures);
    const double stiffness = stiffening_.empty() ? factors.stiffness : factors.stiffness * stiffening_[t];
    const double factor = stiffness + factors.stiffness_damping * model_.rayleigh_stiffness[t];
    ElementMatrix k = corotational_tangent(model_.elements[t], local, q, tangent == Tangent::exact, pressure);
    if (frames) turn_into(*frames, model_.mesh->tetrahedra[t], k);
    for_lower_triangle([&](int index, int a, int b) {
      if (positions_[t][index] >= 0) values[positions_[t][index]] += factor * k(a, b);
    });
  }
  add_patches(patches.gradients, factors, matrix);
  for (std::size_t f = 0; f < model_.free_nodes.size(); ++f) {
    const int node = model_.free_nodes[f];
    const double d = factors.mass * model_.mass[node] + factors.mass_damping * model_.mass_damping[node];
    for (std::size_t i = 0; i < 3; ++i) values[diagonal_[3 * f + i]] += d;
  }
}

void TissueAssembler::add_patches(const PatchGradients& gradients, const MatrixFactors& factors,
                                  SparseMatrix& matrix) const {
  gradients.for_each_block([&](int i, int j, const Matrix3& k, double damping) {
    const int row = 3 * model_.free_index[i], column = 3 * model_.free_index[j];  // i >= j, and so are these
    if (row < 0 || column < 0) return;
    const double factor = factors.stiffness + factors.stiffness_damping * damping;
    for (int b = 0; b < 3; ++b) {
      const int first = i == j ? b : 0;  // on the diagonal the lower triangle only
      double* values = matrix.valuePtr() + position_in(pattern_, row + first, column + b);
      for (int a = first; a < 3; ++a) values[a - first] += factor * k(a, b);
    }
  });
}

}  // namespace acus
