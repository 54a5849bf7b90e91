// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/models/tissue.h"

#include <algorithm>
#include <cmath>

namespace acus {

namespace {

TetrahedronShape<double> make_element(const TetrahedralMesh& mesh, int t, const Material& material) {
  const auto& node = mesh.tetrahedra[static_cast<std::size_t>(t)];
  Matrix3 edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = mesh.nodes.col(node[k + 1]) - mesh.nodes.col(node[0]);
  const Matrix3 gradient = edges.inverse();  // row k is grad N_{k+1}
  TetrahedronShape<double> shape;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) shape.gradient[i][j] = gradient(i, j);
  shape.volume = edges.determinant() / 6;
  const double e = material.young_modulus, nu = material.poisson_ratio;
  shape.mu = e / (2 * (1 + nu));
  shape.lambda = e * nu / ((1 + nu) * (1 - 2 * nu));
  return shape;
}

void fill_lane(ElementBatch& batch, int lane, const TetrahedronShape<double>& s, const std::array<int, 4>& nodes) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) batch.shape.gradient[i][j][lane] = s.gradient[i][j];
  batch.shape.volume[lane] = s.volume;
  batch.shape.mu[lane] = s.mu;
  batch.shape.lambda[lane] = s.lambda;
  for (int k = 0; k < 4; ++k) batch.nodes[k][lane] = nodes[k];
}

std::vector<ElementBatch> make_batches(const TissueModel& model) {
  const int count = model.mesh->tetrahedron_count();
  std::vector<ElementBatch> batches(static_cast<std::size_t>((count + kLanes - 1) / kLanes));
  for (int i = 0; i < static_cast<int>(batches.size()) * kLanes; ++i) {
    const int t = std::min(i, count - 1);
    TetrahedronShape<double> shape = model.elements[t];
    if (i != t) shape.volume = 0;
    fill_lane(batches[i / kLanes], i % kLanes, shape, model.mesh->tetrahedra[t]);
  }
  return batches;
}

void gather(const Matrix3X& x, const std::array<int, 4>& nodes, double (&out)[4][3]) {
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i < 3; ++i) out[k][i] = x(i, nodes[k]);
}

}  // namespace

TissueModel make_tissue_model(const TetrahedralMesh& mesh, std::span<const int> region_of,
                              std::span<const Material> materials, const std::vector<bool>& fixed,
                              const Vector3& gravity) {
  TissueModel model;
  model.mesh = &mesh;
  model.gravity = gravity;
  model.mass.setZero(mesh.node_count());
  model.mass_damping.setZero(mesh.node_count());
  for (int t = 0; t < mesh.tetrahedron_count(); ++t) {
    const Material& material = materials[region_of[t]];
    model.elements.push_back(make_element(mesh, t, material));
    model.rayleigh_stiffness.push_back(material.rayleigh_stiffness);
    const double quarter = material.density * model.elements.back().volume / 4;
    for (int node : mesh.tetrahedra[t]) {
      model.mass[node] += quarter;
      model.mass_damping[node] += material.rayleigh_mass * quarter;
    }
  }
  model.batches = make_batches(model);
  for (std::size_t b = 0; b < model.batches.size(); ++b) {
    Lanes& damping = model.batch_damping.emplace_back();
    for (std::size_t lane = 0; lane < kLanes; ++lane)
      damping[lane] = model.rayleigh_stiffness[std::min(b * kLanes + lane, model.rayleigh_stiffness.size() - 1)];
  }
  model.free_index.assign(static_cast<std::size_t>(mesh.node_count()), -1);
  for (int i = 0; i < mesh.node_count(); ++i) {
    if (!fixed[i]) model.free_index[i] = static_cast<int>(model.free_nodes.size());
    (fixed[i] ? model.fixed_nodes : model.free_nodes).push_back(i);
  }
  return model;
}

TissueState make_tissue_state(const TissueModel& model) {
  return {model.mesh->nodes, Matrix3X::Zero(3, model.nodes())};
}

void ElementRotations::reset(const TissueModel& model) {
  batches.resize(model.batches.size());
  for (Batch& b : batches) {
    b.q[0] = Lanes{} + 1.0;
    b.q[1] = b.q[2] = b.q[3] = Lanes{};
  }
  x.setZero(4, model.nodes());
  forces.setZero(4, model.nodes());
}

namespace {

// Nodal forces of all elements from nodal vectors: element(batch number, nodal vectors, forces) does eight at a time.
template <class Element>
void sum_over_elements(const TissueModel& model, const Matrix3X& x, ElementRotations& scratch, Matrix3X& forces,
                       Element element) {
  scratch.x.topRows<3>() = x;
  scratch.forces.setZero();
  const double* position = scratch.x.data();
  double* total = scratch.forces.data();
  for (std::size_t b = 0; b < model.batches.size(); ++b) {
    const ElementBatch& batch = model.batches[b];
    Lanes local[4][3], force[4][3];
    Quad quads[kLanes];
    for (int k = 0; k < 4; ++k) {
      for (int lane = 0; lane < kLanes; ++lane) quads[lane] = load_quad(position + 4 * batch.nodes[k][lane]);
      Lanes axes[4];
      transpose(quads, axes);
      for (int i = 0; i < 3; ++i) local[k][i] = axes[i];
    }
    element(b, local, force);
    for (int k = 0; k < 4; ++k) {
      transpose(force[k][0], force[k][1], force[k][2], Lanes{}, quads);
      for (int lane = 0; lane < kLanes; ++lane) add_quad(total + 4 * batch.nodes[k][lane], quads[lane]);
    }
  }
  forces = scratch.forces.topRows<3>();
}

}  // namespace

void elastic_forces(const TissueModel& model, const Matrix3X& x, ElementRotations& rotations, Matrix3X& forces) {
  sum_over_elements(model, x, rotations, forces, [&](std::size_t b, const Lanes(&local)[4][3], Lanes(&force)[4][3]) {
    corotational_forces(model.batches[b].shape, local, rotations.batches[b].q, force);
  });
}

void damping_forces(const TissueModel& model, const Matrix3X& v, ElementRotations& rotations, Matrix3X& forces) {
  sum_over_elements(model, v, rotations, forces, [&](std::size_t b, const Lanes(&local)[4][3], Lanes(&force)[4][3]) {
    turned_stiffness_forces(model.batches[b].shape, local, rotations.batches[b].q, force);
    for (auto& node : force)
      for (Lanes& component : node) component *= model.batch_damping[b];
  });
}

double elastic_energy(const TissueModel& model, const Matrix3X& x, const ElementRotations& rotations) {
  double energy = 0;
  for (int t = 0; t < model.mesh->tetrahedron_count(); ++t) {
    double local[4][3], q[4];
    gather(x, model.mesh->tetrahedra[t], local);
    rotations.element(t, q);
    energy += corotational_energy(model.elements[t], local, q);
  }
  return energy;
}

double kinetic_energy(const TissueModel& model, const TissueState& state) {
  return state.v.colwise().squaredNorm().dot(model.mass) / 2;
}

double potential_energy(const TissueModel& model, const TissueState& state) {
  return -model.gravity.dot(state.x * model.mass);
}

namespace {

// Quaternions of length one; that of a node without elements becomes no rotation.
void normalize(Matrix4X& q) {
  for (Eigen::Index i = 0; i < q.cols(); ++i) {
    const double norm2 = q.col(i).squaredNorm();
    if (norm2 > 0) {
      q.col(i) *= 1 / std::sqrt(norm2);
    } else {
      q.col(i) = Eigen::Vector4d(1, 0, 0, 0);
    }
  }
}

}  // namespace

void node_rotations(const TissueModel& model, const ElementRotations& rotations, Matrix4X& q) {
  q.setZero();
  double* total = q.data();
  for (std::size_t b = 0; b < model.batches.size(); ++b) {
    const ElementBatch& batch = model.batches[b];
    const Lanes(&turn)[4] = rotations.batches[b].q;
    const Lanes& weight = batch.shape.volume;
    Quad weighted[kLanes];
    transpose(weight * turn[0], weight * turn[1], weight * turn[2], weight * turn[3], weighted);
    for (int k = 0; k < 4; ++k)
      for (int lane = 0; lane < kLanes; ++lane) add_quad(total + 4 * batch.nodes[k][lane], weighted[lane]);
  }
  normalize(q);
}

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

}  // namespace

TissueAssembler::TissueAssembler(const TissueModel& model) : model_(model) {
  const int n = model.unknowns();
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) entries.emplace_back(i, i, 0.0);
  for (const auto& nodes : model.mesh->tetrahedra)
    for_lower_triangle([&](int, int a, int b) {
      const int row = unknown_of(model, nodes, a), column = unknown_of(model, nodes, b);
      if (row >= 0 && column >= 0) entries.emplace_back(std::max(row, column), std::min(row, column), 0.0);
    });
  pattern_.resize(n, n);
  pattern_.setFromTriplets(entries.begin(), entries.end());

  for (const auto& nodes : model.mesh->tetrahedra) {
    auto& positions = positions_.emplace_back();
    for_lower_triangle([&](int index, int a, int b) {
      const int row = unknown_of(model, nodes, a), column = unknown_of(model, nodes, b);
      positions[index] =
          row < 0 || column < 0 ? -1 : position_in(pattern_, std::max(row, column), std::min(row, column));
    });
  }
  for (int i = 0; i < n; ++i) diagonal_.push_back(position_in(pattern_, i, i));
}

void TissueAssembler::assemble(const Matrix3X& x, const ElementRotations& rotations, Tangent tangent,
                               const MatrixFactors& factors, SparseMatrix& matrix) const {
  if (matrix.nonZeros() != pattern_.nonZeros()) matrix = pattern_;
  double* values = matrix.valuePtr();
  std::fill_n(values, matrix.nonZeros(), 0.0);
  const Matrix3X& where = tangent == Tangent::rest ? model_.mesh->nodes : x;
  for (int t = 0; t < model_.mesh->tetrahedron_count(); ++t) {
    double local[4][3], q[4] = {1, 0, 0, 0};
    gather(where, model_.mesh->tetrahedra[t], local);
    if (tangent != Tangent::rest) rotations.element(t, q);
    const double factor = factors.stiffness + factors.stiffness_damping * model_.rayleigh_stiffness[t];
    const Eigen::Matrix<double, 12, 12> k =
        corotational_tangent(model_.elements[t], local, q, tangent == Tangent::exact);
    for_lower_triangle([&](int index, int a, int b) {
      if (positions_[t][index] >= 0) values[positions_[t][index]] += factor * k(a, b);
    });
  }
  for (std::size_t f = 0; f < model_.free_nodes.size(); ++f) {
    const int node = model_.free_nodes[f];
    const double d = factors.mass * model_.mass[node] + factors.mass_damping * model_.mass_damping[node];
    for (std::size_t i = 0; i < 3; ++i) values[diagonal_[3 * f + i]] += d;
  }
}

}  // namespace acus
