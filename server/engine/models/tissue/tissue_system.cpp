// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/models/tissue/tissue_system.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <new>

#include "server/engine/models/tissue/unfit_tissue.h"

namespace acus {

namespace {

constexpr double kLargestErrorOfHeld = 0.5;  // - (factor_error())
// Of the rest shape's stiffness, that an equilibrium's must have left for every motion: where it is near to buckling,
// tissue gets many times as stiff as it moves, which a field about it does not bear (deferred_field.h).
constexpr double kLeastOfRest = 0.3;

// The free nodes of tetrahedra and patches that have a fixed node.
std::vector<int> nodes_beside_supports(const TissueModel& model) {
  std::vector<bool> beside(static_cast<std::size_t>(model.nodes()));
  const auto mark = [&](std::span<const int> nodes) {
    const auto is_fixed = [&](int node) { return model.free_index[node] < 0; };
    if (std::none_of(nodes.begin(), nodes.end(), is_fixed)) return;
    for (const int node : nodes) beside[node] = beside[node] || !is_fixed(node);
  };
  for (const auto& nodes : model.mesh->tetrahedra) mark(nodes);
  for (int patch = 0; patch < model.pressure.patches(); ++patch) mark(model.pressure.nodes_of(patch));
  std::vector<int> list;
  for (const int node : model.free_nodes)
    if (beside[node]) list.push_back(node);
  return list;
}

// Sum of all rows of beta K0 restricted to free unknowns, three rows: the damping force that the free nodes receive in
// total is this times their velocity, and the supports take the opposite. Zero but beside supports, since no element
// answers a translation.
Matrix3X stiffness_damping_sums(const SparseMatrix& lower) {
  Matrix3X sums = Matrix3X::Zero(3, lower.cols());
  for (int column = 0; column < lower.outerSize(); ++column)
    for (SparseMatrix::InnerIterator it(lower, column); it; ++it) {
      sums(it.row() % 3, column) += it.value();
      if (it.row() != column) sums(column % 3, it.row()) += it.value();
    }
  return sums;
}

bool has_stiffness_damping(const TissueModel& model) {
  return std::any_of(model.rayleigh_stiffness.begin(), model.rayleigh_stiffness.end(), [](double b) { return b > 0; });
}

// How far L Lᵀ is from A: the largest relative error of A⁻¹ A z for displacements z, the three translations and one
// that differs from node to node.
double factor_error(const SparseCholesky& factor, const SparseMatrix& lower) {
  double largest = 0;
  VectorX z(lower.cols()), solution(lower.cols());
  MatrixX panel_rows = factor.make_panel_rows();
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < z.size(); ++i) z[i] = k == 3 ? std::sin(1.0 + i) : i % 3 == k ? 1 : 0;
    const VectorX force = lower.selfadjointView<Eigen::Lower>() * z;
    for (int i = 0; i < z.size(); ++i) solution[factor.position(i)] = force[i];
    factor.forward(solution, panel_rows);
    factor.backward(solution, panel_rows);
    for (int i = 0; i < z.size(); ++i) {
      const double error = std::abs(solution[factor.position(i)] - z[i]);
      if (!(error <= largest)) largest = error;  // not-a-number is the largest of all
    }
  }
  return largest;
}

// Says how far off the test is: in half precision if that does, else in single precision.
double keep_few_bits(SparseCholesky& factor, const SparseMatrix& rest) {
  const auto error_in = [&](Precision precision) {
    factor.keep(precision);
    return factor_error(factor, rest);
  };
  if (factor.factor_entries() >= TissueSystem::kHalfPrecisionEntries)
    if (const double error = error_in(Precision::half_precision); error < TissueSystem::kHalfPrecisionError)
      return error;
  const double error = error_in(Precision::single_precision);
  if (!(error < TissueSystem::kSinglePrecisionError)) factor.keep(Precision::double_precision);
  return error;
}

// Whether it is positive definite. Throws std::bad_alloc.
bool factorize(SparseCholesky& factor, const SparseMatrix& matrix) {
  const bool definite = factor.factorize(matrix);
  if (factor.ran_out_of_memory()) throw std::bad_alloc();
  return definite;
}

// c2 times the Hessian at an equilibrium, in the frames that nodes have there; false where it does not hold the tissue
// as the rest shape's does.
bool factorize_about(TissueSystem& system, const TissueState& equilibrium) {
  const Matrix4X frames = node_frames(system, equilibrium.rotations);
  const MatrixFactors factors{.stiffness = system.field->c2};
  SparseMatrix matrix, margin;
  system.assembler.assemble(equilibrium.x, equilibrium.rotations, Tangent::exact, factors, matrix, &frames);
  system.assembler.assemble(equilibrium.x, equilibrium.rotations, Tangent::turned, factors, margin, &frames);
  Eigen::Map<VectorX> difference(margin.valuePtr(), margin.nonZeros());
  difference = Eigen::Map<const VectorX>(matrix.valuePtr(), matrix.nonZeros()) - kLeastOfRest * difference;
  return factorize(system.factor, margin) && factorize(system.factor, matrix) &&
         keep_few_bits(system.factor, matrix) < kLargestErrorOfHeld;
}

// The matrix that stays, of refactorized ones the pattern.
void factorize_once(TissueSystem& system, const ElementRotations& upright, const TissueState* equilibrium) {
  SparseMatrix rest;
  const Matrix3X& nodes = system.model.mesh->nodes;
  system.assembler.assemble(nodes, upright, Tangent::rest,
                            system.field ? MatrixFactors{.stiffness = system.field->c2} : tick_factors(system.h), rest);
  system.factor.analyze(rest, 3);
  if (system.field && equilibrium) {
    system.field->about_equilibrium = factorize_about(system, *equilibrium);
    if (system.field->about_equilibrium) return system.factor.finish();
    system.field->increase = 0;
  }
  const bool definite = factorize(system.factor, rest), once = system.matrix != TissueMatrix::refactorized;
  const double error = definite && once ? keep_few_bits(system.factor, rest) : 0;
  // Rounding may make a singular matrix definite; but then it does not say where translations go.
  if (system.field && (!definite || !(error < kLargestErrorOfHeld))) {
    throw UnfitTissue("tissue.window",
                      "expected 0 for tissue that supports do not hold, found parts that are free; add `fixed` volumes "
                      "that hold them, or leave the window out");
  }
  if (!definite) {
    throw UnfitTissue(
        "tissue",
        "expected a stiffness that can be factorised, found a matrix that is not positive definite; bring "
        "young_modulus and density of its regions closer together, or poisson_ratio further from 0.5");
  }
  if (once) system.factor.finish();
}

void sum_damping_beside_supports(TissueSystem& system, const ElementRotations& upright) {
  SparseMatrix damping;
  system.assembler.assemble(system.model.mesh->nodes, upright, Tangent::rest, {.stiffness_damping = 1}, damping);
  system.beside_supports = nodes_beside_supports(system.model);
  const Matrix3X sums = stiffness_damping_sums(damping);
  for (const int node : system.beside_supports)
    system.damping_sums.push_back(sums.middleCols<3>(3 * system.model.free_index[node]));
}

// alpha of the whole: per region it is the defect's.
double mean_mass_damping(const TissueModel& model) { return model.mass_damping.sum() / model.mass.sum(); }

DeferredField begin_deferred_field(const TissueSystem& system, int window, bool threaded) {
  DeferredField field;
  field.window = window;
  field.threaded = threaded;
  field.h = system.h;
  field.beta = system.largest_damping;
  field.alpha = mean_mass_damping(system.model);
  field.c1 = (1 / field.h + field.alpha) / field.h;
  field.c2 = 1 + field.beta / field.h;
  field.rho = field.beta / (field.beta + field.h);
  return field;
}

// What takes the factor.
void finish_deferred_field(const TissueSystem& system, DeferredField& field) {
  const TissueModel& model = system.model;
  VectorX mass(model.unknowns());
  Matrix3X places(3, static_cast<Eigen::Index>(model.free_nodes.size()));
  for (std::size_t f = 0; f < model.free_nodes.size(); ++f) {
    const int node = model.free_nodes[f], position = system.position[f];
    mass.segment<3>(position).setConstant(model.mass[node]);
    places.col(position / 3) = model.mesh->nodes.col(node);
  }
  field.modes = find_low_modes(system.factor, field.c2, mass, places, DeferredField::kModes);
  const auto stiffness = field.c2 * field.modes.omega2.array();
  field.theta0 = stiffness.inverse();
  field.theta1 = (field.c1 + stiffness).inverse();
  field.stiffening = field.modes.shapes * (field.theta0 - field.theta1).cwiseSqrt().cast<float>().asDiagonal();
}

}  // namespace

TissueSystem::TissueSystem(const TissueModel& tissue, double time_step, TissueMatrix kind, int window, bool threaded,
                           const TissueState* equilibrium)
    : model(tissue),
      h(time_step),
      matrix(kind),
      damped(has_stiffness_damping(tissue)),
      memory(tissue.branches > 0 ? std::optional<TissueMemory>(std::in_place, tissue, time_step) : std::nullopt),
      assembler(tissue, memory ? memory->stiffening : std::vector<double>{}) {
  assert(!memory || (matrix == TissueMatrix::turned && window == 0));
  large_step = kLargeStep * mean_element_size(*model.mesh);
  for (const double beta : model.rayleigh_stiffness) largest_damping = std::max(largest_damping, beta);
  for (const int i : model.free_nodes) applied += model.applied.col(i);
  if (matrix == TissueMatrix::constant) stiffness.emplace(model);
  if (matrix == TissueMatrix::turned) rotation_grid = make_rotation_grid(*model.mesh);
  if (empty()) return;
  const ElementRotations upright(model);
  if (window > 0) field = begin_deferred_field(*this, window, threaded);
  factorize_once(*this, upright, equilibrium);
  for (int f = 0; f < static_cast<int>(model.free_nodes.size()); ++f) position.push_back(factor.position(3 * f));
  if (field) {
    finish_deferred_field(*this, *field);
  } else if (damped && matrix != TissueMatrix::refactorized) {
    sum_damping_beside_supports(*this, upright);
  }
}

Matrix4X node_frames(const TissueSystem& system, const ElementRotations& rotations) {
  Matrix4X frames(4, system.model.nodes()), sums(4, system.rotation_grid.points);
  node_rotations(system.model, rotations, frames);
  smooth_rotations(system.rotation_grid, frames, sums);
  return frames;
}

double elastic_energy(const TissueSystem& system, const TissueState& state) {
  if (!system.stiffness) {
    const double elements = elastic_energy(system.model, state.x, state.rotations);
    if (!system.memory) return elements;
    return elements + memory_energy(system.model, *system.memory, state.x, state.rotations, *state.crept);
  }
  Matrix3X displacement, forces;
  system.stiffness->forces(state.x, displacement, forces);
  return forces.cwiseProduct(displacement).sum() / 2;
}

}  // namespace acus
