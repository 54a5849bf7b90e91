// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/tissue.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/math/kernel_set.h"
#include "server/engine/math/rotation.h"
#include "server/engine/models/element/corotational_energy.h"
#include "server/engine/models/element/moduli.h"

namespace acus {

namespace baseline {
extern const ElementKernel kernel_of_elements;
}
#if ACUS_KERNELS_V4
namespace v4 {
extern const ElementKernel kernel_of_elements;
}
#else
namespace v4 = baseline;
#endif

const ElementKernel& element_kernel() {
  return kernel_set() == KernelSet::v4 ? v4::kernel_of_elements : baseline::kernel_of_elements;
}

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
  shape.law = hooke(material);
  return shape;
}

// Leaves to the elements their share of lambda and gives the rest to the nodes.
void average_pressure(TissueModel& model, std::span<const int> region_of, std::size_t regions) {
  std::vector<double> volumes, modulus(regions, 0.0), damping(regions, 0.0);
  for (std::size_t t = 0; t < model.elements.size(); ++t) {
    TetrahedronShape<double>& shape = model.elements[t];
    volumes.push_back(shape.volume);
    modulus[region_of[t]] = shape.law.take_volumetric(NodalPressure::kElementShare * shape.law.mu);
    damping[region_of[t]] = model.rayleigh_stiffness[t];
  }
  model.pressure = make_nodal_pressure(*model.mesh, region_of, volumes, modulus, damping);
}

void fill_lane(ElementBatch& batch, int lane, const TetrahedronShape<double>& s, const std::array<int, 4>& nodes) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) batch.shape.gradient[i][j][lane] = s.gradient[i][j];
  batch.shape.volume[lane] = s.volume;
  batch.shape.law.mu[lane] = s.law.mu;
  batch.shape.law.lambda[lane] = s.law.lambda;
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
  model.applied = gravity * model.mass.transpose();
  for (const Material& material : materials)
    model.branches = std::max(model.branches, static_cast<int>(material.relaxation.size()));
  if (model.branches > 0) {
    model.materials.assign(materials.begin(), materials.end());
    model.material_of.assign(region_of.begin(), region_of.end());
  }
  if (element == TissueElement::nodal_pressure) average_pressure(model, region_of, materials.size());
  model.batches = make_batches(model);
  for (std::size_t b = 0; b < model.batches.size(); ++b) {
    Octet& damping = model.batch_damping.emplace_back();
    for (int lane = 0; lane < kLanes; ++lane)
      damping[lane] = model.rayleigh_stiffness[std::min(b * kLanes + static_cast<std::size_t>(lane),
                                                        model.rayleigh_stiffness.size() - 1)];
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
  if (model.branches > 0) state.crept.emplace(model.batches.size() * static_cast<std::size_t>(model.branches));
  return state;
}

ElementRotations::ElementRotations(const TissueModel& model) : batches(model.batches.size()) {
  for (RotationBatch& b : batches)
    for (int i = 0; i < kLanes; ++i) b.q[0][i] = 1;
}

ElementScratch::ElementScratch(const TissueModel& model)
    : x(Matrix4X::Zero(4, model.nodes())),
      forces(Matrix4X::Zero(4, model.nodes())),
      patches(VectorX::Zero(model.pressure.patches())) {}

namespace {

ElementArrays arrays_of(const TissueModel& model, const MemoryArrays* memory = nullptr) {
  const bool patches = model.pressure.patches() > 0;
  return {model.batches.size(), model.batches.data(), model.batch_damping.data(),
          patches ? model.pressure.batches.data() : nullptr, memory};
}

// Nodal forces of all elements from nodal vectors: `add` has those of the elements alone, then their patches answer to
// the changes of volume.
template <class Add>
void sum_over_elements(const TissueModel& model, const Matrix3X& nodal, const ElementRotations& rotations,
                       ElementScratch& scratch, bool damping, Matrix3X& forces, Add add,
                       const MemoryArrays* memory = nullptr) {
  const NodalPressure& pressure = model.pressure;
  VectorX& patches = scratch.patches;
  scratch.x.topRows<3>() = nodal;
  scratch.forces.setZero();
  patches.setZero();
  add(arrays_of(model, memory));
  if (pressure.patches() > 0) {
    patches.array() *= pressure.modulus.array() / pressure.volume.array();
    if (damping) patches.array() *= pressure.damping.array();
    element_kernel().pressure_forces(arrays_of(model), patches.data(), rotations.batches.data(), scratch.forces.data());
  }
  forces = scratch.forces.topRows<3>();
}

}  // namespace

bool elastic_forces(const TissueModel& model, const Matrix3X& x, const ElementRotations& start,
                    ElementRotations& rotations, ElementScratch& scratch, Matrix3X& forces,
                    const MemoryArrays* memory) {
  assert(start.batches.size() == model.batches.size() && rotations.batches.size() == model.batches.size());
  bool upright = true;
  const auto add = [&](const ElementArrays& elements) {
    upright = element_kernel().elastic_forces(elements, scratch.x.data(), start.batches.data(),
                                              rotations.batches.data(), scratch.forces.data(), scratch.patches.data());
  };
  sum_over_elements(model, x, rotations, scratch, false, forces, add, memory);
  return !upright;
}

bool elastic_forces(const TissueModel& model, const Matrix3X& x, ElementRotations& rotations, Matrix3X& forces) {
  ElementScratch scratch(model);
  return elastic_forces(model, x, rotations, rotations, scratch, forces);
}

bool add_elastic_forces(const TissueModel& model, int first, int last, const ElementRotations& start,
                        ElementRotations& rotations, ElementScratch& scratch) {
  assert(model.pressure.patches() == 0);
  const ElementArrays part{static_cast<std::size_t>(last - first), model.batches.data() + first,
                           model.batch_damping.data() + first, nullptr};
  return !element_kernel().elastic_forces(part, scratch.x.data(), start.batches.data() + first,
                                          rotations.batches.data() + first, scratch.forces.data(), nullptr);
}

void damping_forces(const TissueModel& model, const Matrix3X& v, const ElementRotations& rotations,
                    ElementScratch& scratch, Matrix3X& forces) {
  sum_over_elements(model, v, rotations, scratch, true, forces, [&](const ElementArrays& elements) {
    element_kernel().damping_forces(elements, scratch.x.data(), rotations.batches.data(), scratch.forces.data(),
                                    scratch.patches.data());
  });
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
  return -model.applied.cwiseProduct(state.x).sum();
}

// That of a node without elements becomes no rotation.
void normalize_rotations(Matrix4X& q) {
  for (Eigen::Index i = 0; i < q.cols(); ++i) {
    const double norm2 = q.col(i).squaredNorm();
    if (norm2 > 0) {
      q.col(i) *= 1 / std::sqrt(norm2);
    } else {
      q.col(i) = Eigen::Vector4d(1, 0, 0, 0);
    }
  }
}

bool have_one_sign(const TissueModel& model, const ElementRotations& rotations) {
  return element_kernel().all_turned_less(arrays_of(model), rotations.batches.data(), kOneSign);
}

void add_node_rotations(const TissueModel& model, int first, int last, const ElementRotations& rotations, bool one_sign,
                        Matrix4X& q) {
  const ElementArrays part{static_cast<std::size_t>(last - first), model.batches.data() + first};
  element_kernel().add_rotations(part, rotations.batches.data() + first, one_sign, q.data());
}

void node_rotations(const TissueModel& model, const ElementRotations& rotations, Matrix4X& q) {
  q.setZero();
  add_node_rotations(model, 0, static_cast<int>(model.batches.size()), rotations, have_one_sign(model, rotations), q);
  normalize_rotations(q);
}

}  // namespace acus
