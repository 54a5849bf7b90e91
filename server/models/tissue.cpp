// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/models/tissue.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "server/math/rotation.h"

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

// Leaves to the elements their share of lambda and gives the rest to the nodes.
void average_pressure(TissueModel& model, std::span<const int> region_of, std::size_t regions) {
  std::vector<double> volumes, modulus(regions, 0.0), damping(regions, 0.0);
  for (std::size_t t = 0; t < model.elements.size(); ++t) {
    TetrahedronShape<double>& shape = model.elements[t];
    const double share = std::min(shape.lambda, NodalPressure::kElementShare * shape.mu);
    volumes.push_back(shape.volume);
    modulus[region_of[t]] = shape.lambda - share;
    damping[region_of[t]] = model.rayleigh_stiffness[t];
    shape.lambda = share;
  }
  model.pressure = make_nodal_pressure(*model.mesh, region_of, volumes, modulus, damping);
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

}  // namespace

TissueModel make_tissue_model(const TetrahedralMesh& mesh, std::span<const int> region_of,
                              std::span<const Material> materials, const std::vector<bool>& fixed,
                              const Vector3& gravity, TissueElement element) {
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
  if (element == TissueElement::nodal_pressure) average_pressure(model, region_of, materials.size());
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
  TissueState state;
  state.x = model.mesh->nodes;
  state.v.setZero(3, model.nodes());
  state.rotations = ElementRotations(model);
  return state;
}

ElementRotations::ElementRotations(const TissueModel& model) : batches(model.batches.size()) {
  for (Batch& b : batches) {
    b.q[0] = Lanes{} + 1.0;
    b.q[1] = b.q[2] = b.q[3] = Lanes{};
  }
}

ElementScratch::ElementScratch(const TissueModel& model)
    : x(Matrix4X::Zero(4, model.nodes())),
      forces(Matrix4X::Zero(4, model.nodes())),
      patches(VectorX::Zero(model.pressure.patches())) {}

namespace {

void add_to_nodes(const ElementBatch& batch, const Lanes (&force)[4][3], double* total) {
  Quad quads[kLanes];
  for (int k = 0; k < 4; ++k) {
    transpose(force[k][0], force[k][1], force[k][2], Lanes{}, quads);
    for (int lane = 0; lane < kLanes; ++lane) add_quad(total + 4 * batch.nodes[k][lane], quads[lane]);
  }
}

// Nodal forces of all elements from nodal vectors, into scratch.forces: element(batch number, nodal vectors, forces)
// does eight at a time.
template <class Element>
void sum_over_elements(const TissueModel& model, const Matrix3X& x, ElementScratch& scratch, Element element) {
  scratch.x.topRows<3>() = x;
  scratch.forces.setZero();
  const double* position = scratch.x.data();
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
    add_to_nodes(batch, force, scratch.forces.data());
  }
}

// Six times the volume of a tetrahedron with these nodes (m³), negative where it is inside out.
template <class Real>
Real edge_determinant(const Real (&x)[4][3]) {
  Real e[3][3];
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 3; ++i) e[k][i] = x[k + 1][i] - x[0][i];
  return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) + e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
         e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

// The same for elements that return their volume strain, to which the patches then answer.
template <class Element>
void sum_with_patches(const TissueModel& model, const Matrix3X& x, const ElementRotations& rotations,
                      ElementScratch& scratch, bool damping, Element element) {
  const NodalPressure& pressure = model.pressure;
  VectorX& patches = scratch.patches;
  patches.setZero();
  sum_over_elements(model, x, scratch, [&](std::size_t b, const Lanes(&local)[4][3], Lanes(&force)[4][3]) {
    add_volume_change(pressure, b, model.batches[b].shape.volume * element(b, local, force), patches);
  });
  patches.array() *= pressure.modulus.array() / pressure.volume.array();
  if (damping) patches.array() *= pressure.damping.array();
  for (std::size_t b = 0; b < model.batches.size(); ++b) {
    Lanes force[4][3];
    pressure_forces(model.batches[b].shape, mean_pressure(pressure, b, patches), rotations.batches[b].q, force);
    add_to_nodes(model.batches[b], force, scratch.forces.data());
  }
}

}  // namespace

bool elastic_forces(const TissueModel& model, const Matrix3X& x, const ElementRotations& start,
                    ElementRotations& rotations, ElementScratch& scratch, Matrix3X& forces) {
  assert(start.batches.size() == model.batches.size() && rotations.batches.size() == model.batches.size());
  LaneMask upright = Lanes{} == Lanes{};
  const auto element = [&](std::size_t b, const Lanes(&local)[4][3], Lanes(&force)[4][3]) {
    upright &= edge_determinant(local) > 0.0;
    rotations.batches[b] = start.batches[b];
    return corotational_forces(model.batches[b].shape, local, rotations.batches[b].q, force);
  };
  if (model.pressure.patches() == 0) {
    sum_over_elements(model, x, scratch, element);
  } else {
    sum_with_patches(model, x, rotations, scratch, false, element);
  }
  forces = scratch.forces.topRows<3>();
  return !all(upright);
}

bool elastic_forces(const TissueModel& model, const Matrix3X& x, ElementRotations& rotations, Matrix3X& forces) {
  ElementScratch scratch(model);
  return elastic_forces(model, x, rotations, rotations, scratch, forces);
}

void damping_forces(const TissueModel& model, const Matrix3X& v, const ElementRotations& rotations,
                    ElementScratch& scratch, Matrix3X& forces) {
  const auto element = [&](std::size_t b, const Lanes(&local)[4][3], Lanes(&force)[4][3]) {
    const Lanes rate = turned_stiffness_forces(model.batches[b].shape, local, rotations.batches[b].q, force);
    for (auto& node : force)
      for (Lanes& component : node) component *= model.batch_damping[b];
    return rate;
  };
  if (model.pressure.patches() == 0) {
    sum_over_elements(model, v, scratch, element);
  } else {
    sum_with_patches(model, v, rotations, scratch, true, element);
  }
  forces = scratch.forces.topRows<3>();
}

double elastic_energy(const TissueModel& model, const Matrix3X& x, const ElementRotations& rotations) {
  const NodalPressure& pressure = model.pressure;
  VectorX volume_change = VectorX::Zero(pressure.patches());
  double energy = 0;
  for (int t = 0; t < model.mesh->tetrahedron_count(); ++t) {
    double local[4][3], q[4];
    gather_nodes(x, model.mesh->tetrahedra[t], local);
    rotations.element(t, q);
    energy += corotational_energy(model.elements[t], local, q);
    if (pressure.patches() == 0) continue;
    const double change = model.elements[t].volume * volume_strain(model.elements[t], local, q).value;
    for (const int patch : pressure.of_element[t]) volume_change[patch] += change / 4;
  }
  return energy + (pressure.modulus.array() / pressure.volume.array() * volume_change.array().square()).sum() / 2;
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

namespace {

bool all_turned_less(const ElementRotations& rotations) {
  LaneMask less = Lanes{} == Lanes{};
  for (const ElementRotations::Batch& batch : rotations.batches) less &= batch.q[0] > kOneSign;
  return all(less);
}

// q and -q are the same rotation: each is added with the sign that it has beside what is there already.
void add_aligned(double* total, const double* q) {
  const double dot = total[0] * q[0] + total[1] * q[1] + total[2] * q[2] + total[3] * q[3];
  for (int i = 0; i < 4; ++i) total[i] += dot < 0 ? -q[i] : q[i];
}

}  // namespace

void node_rotations(const TissueModel& model, const ElementRotations& rotations, Matrix4X& q) {
  q.setZero();
  double* total = q.data();
  const bool aligned = all_turned_less(rotations);
  for (std::size_t b = 0; b < model.batches.size(); ++b) {
    const ElementBatch& batch = model.batches[b];
    const Lanes(&turn)[4] = rotations.batches[b].q;
    const Lanes& weight = batch.shape.volume;
    Quad weighted[kLanes];
    transpose(weight * turn[0], weight * turn[1], weight * turn[2], weight * turn[3], weighted);
    for (int k = 0; k < 4; ++k)
      for (int lane = 0; lane < kLanes; ++lane) {
        double* node = total + 4 * batch.nodes[k][lane];
        if (aligned) {
          add_quad(node, weighted[lane]);
        } else {
          double one[4];
          std::memcpy(one, &weighted[lane], sizeof one);
          add_aligned(node, one);
        }
      }
  }
  normalize(q);
}

}  // namespace acus
