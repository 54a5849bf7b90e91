// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/bench/calibration.h"

#include <Eigen/CholmodSupport>
#include <stdexcept>

#include "server/engine/models/tissue/tissue_assembler.h"

// Present when the BLAS behind CHOLMOD is OpenBLAS.
extern "C" void openblas_set_num_threads(int) __attribute__((weak));

namespace acus {

SparseMatrix tick_matrix(const Simulation& simulation) {
  const Scene& scene = simulation.scene();
  const TetrahedralMesh& mesh = simulation.mesh();
  if (simulation.costs().free_nodes == 0) return {};

  std::vector<Material> materials;
  for (const Region& region : scene.tissue.regions) materials.push_back(region.material);
  const TissueModel model =
      make_tissue_model(mesh, simulation.regions(), materials, find_fixed_nodes(scene, mesh), scene.gravity,
                        scene.tissue.element);
  ElementRotations rotations(model);
  SparseMatrix matrix;
  TissueAssembler(model).assemble(mesh.nodes, rotations, Tangent::rest, tick_factors(1 / scene.rate), matrix);
  return matrix;
}

std::vector<int> simulation_order(const SparseMatrix& lower_triangle) {
  SparseCholesky cholesky;
  cholesky.analyze(lower_triangle, 3);
  std::vector<int> order(static_cast<std::size_t>(cholesky.size()));
  for (int i = 0; i < cholesky.size(); ++i) order[static_cast<std::size_t>(cholesky.position(i))] = i;
  return order;
}

CholmodSolve::CholmodSolve(const SparseMatrix& lower_triangle, std::vector<int> order) {
  if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
  cholmod_start(&common_);
  common_.supernodal = CHOLMOD_SUPERNODAL;
  common_.final_ll = 1;
  common_.print = 0;
  if (!order.empty()) {
    common_.nmethods = 1;
    common_.method[0].ordering = CHOLMOD_GIVEN;
  }
  cholmod_sparse matrix = Eigen::viewAsCholmod(lower_triangle.selfadjointView<Eigen::Lower>());
  factor_ = cholmod_analyze_p(&matrix, order.empty() ? nullptr : order.data(), nullptr, 0, &common_);
  if (factor_ != nullptr) cholmod_factorize(&matrix, factor_, &common_);
  if (factor_ == nullptr || common_.status != CHOLMOD_OK)
    throw std::runtime_error("calibration: CHOLMOD could not factorise the tissue's matrix");
  right_side_ = cholmod_ones(matrix.nrow, 1, CHOLMOD_REAL, &common_);
  run();  // makes the workspaces
}

CholmodSolve::~CholmodSolve() {
  for (cholmod_dense** vector : {&right_side_, &solution_, &scratch_[0], &scratch_[1]})
    cholmod_free_dense(vector, &common_);
  cholmod_free_factor(&factor_, &common_);
  cholmod_finish(&common_);
}

void CholmodSolve::run() {
  cholmod_solve2(CHOLMOD_A, factor_, right_side_, nullptr, &solution_, nullptr, &scratch_[0], &scratch_[1], &common_);
}

Eigen::Map<const VectorX> CholmodSolve::solution() const {
  return {static_cast<const double*>(solution_->x), static_cast<Eigen::Index>(solution_->nrow)};
}

const char* CholmodSolve::ordering_name() const {
  switch (factor_->ordering) {
    case CHOLMOD_GIVEN:
      return "the simulation's";
    case CHOLMOD_AMD:
      return "AMD";
    case CHOLMOD_METIS:
      return "METIS";
    case CHOLMOD_NESDIS:
      return "nested dissection";
    default:
      return "another ordering";
  }
}

void TwoReads::run() {
  for (int read = 0; read < 2; ++read) sum_ = sum_ + numbers_.sum();
}

// Diagonally dominant: its factor does not matter, only the work.
DenseCholesky::DenseCholesky() : matrix_(MatrixX::Constant(kRows, kRows, 0.5)), factor_(matrix_) {
  matrix_.diagonal().setConstant(kRows);
}

void DenseCholesky::run() {
  factor_ = matrix_;
  const Eigen::LLT<Eigen::Ref<MatrixX>> in_place(factor_);
}

}  // namespace acus
