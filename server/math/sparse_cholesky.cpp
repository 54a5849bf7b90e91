// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/math/sparse_cholesky.h"

#include <cholmod.h>

#include <algorithm>

// Present when the BLAS behind CHOLMOD is OpenBLAS. One thread: the simulation owns one core, and sums must not depend
// on how they were shared out.
extern "C" void openblas_set_num_threads(int) __attribute__((weak));

namespace acus {

namespace {

cholmod_sparse view_of(const SparseMatrix& lower) {
  cholmod_sparse view{};
  view.nrow = static_cast<std::size_t>(lower.rows());
  view.ncol = static_cast<std::size_t>(lower.cols());
  view.nzmax = static_cast<std::size_t>(lower.nonZeros());
  view.p = const_cast<int*>(lower.outerIndexPtr());
  view.i = const_cast<int*>(lower.innerIndexPtr());
  view.x = const_cast<double*>(lower.valuePtr());
  view.stype = -1;  // lower triangle of a symmetric matrix
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = 1;
  view.packed = 1;
  return view;
}

// One panel of the factor: columns [first, first + columns), and below them the rows listed.
struct Panel {
  int first;
  int columns;
  int rows;           // columns + rows below
  const int* below;   // rows - columns indices
  const double* x;    // rows x columns, column-major
};

// Forward substitution with one panel: solves for its unknowns in b and takes them out of the rows below. g is scratch
// for those rows, so that the inner loop runs over contiguous memory.
void eliminate(const Panel& p, double* b, double* g) {
  const int below = p.rows - p.columns;
  std::fill_n(g, below, 0.0);
  for (int j = 0; j < p.columns; ++j) {
    const double* column = p.x + static_cast<std::ptrdiff_t>(j) * p.rows;
    const double* tail = column + p.columns;
    const double value = b[p.first + j] / column[j];
    b[p.first + j] = value;
    for (int i = j + 1; i < p.columns; ++i) b[p.first + i] -= column[i] * value;
    for (int i = 0; i < below; ++i) g[i] += tail[i] * value;
  }
  for (int i = 0; i < below; ++i) b[p.below[i]] -= g[i];
}

}  // namespace

struct SparseCholesky::Factor {
  cholmod_common common{};
  cholmod_factor* L = nullptr;

  Factor() {
    if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
    cholmod_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.final_ll = 1;
    common.print = 0;
    common.try_catch = 1;  // failures are returned, not printed
  }
  ~Factor() {
    cholmod_free_factor(&L, &common);
    cholmod_finish(&common);
  }
  Factor(const Factor&) = delete;
  Factor& operator=(const Factor&) = delete;

  int panel_count() const { return static_cast<int>(L->nsuper); }
  Panel panel(int s) const {
    const auto* super = static_cast<const int*>(L->super);
    const auto* pi = static_cast<const int*>(L->pi);
    const auto* px = static_cast<const int*>(L->px);
    const int columns = super[s + 1] - super[s];
    return {super[s], columns, pi[s + 1] - pi[s], static_cast<const int*>(L->s) + pi[s] + columns,
            static_cast<const double*>(L->x) + px[s]};
  }
};

SparseCholesky::SparseCholesky() : factor_(std::make_unique<Factor>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyze(const SparseMatrix& lower) {
  cholmod_sparse view = view_of(lower);
  cholmod_free_factor(&factor_->L, &factor_->common);
  factor_->L = cholmod_analyze(&view, &factor_->common);
  if (factor_->L == nullptr) throw std::runtime_error("the tissue matrix could not be analysed: out of memory");

  const auto* permutation = static_cast<const int*>(factor_->L->Perm);
  position_.resize(view.nrow);
  for (int i = 0; i < static_cast<int>(view.nrow); ++i) position_[static_cast<std::size_t>(permutation[i])] = i;
  gathered_.setZero(lower.rows());
}

bool SparseCholesky::factorize(const SparseMatrix& lower) {
  cholmod_sparse view = view_of(lower);
  cholmod_factorize(&view, factor_->L, &factor_->common);
  return factor_->common.status == CHOLMOD_OK;
}

int SparseCholesky::size() const { return static_cast<int>(position_.size()); }

std::size_t SparseCholesky::factor_entries() const { return factor_->L->xsize; }

void SparseCholesky::forward(Eigen::Ref<VectorX> x, int first) const {
  for (int s = 0; s < factor_->panel_count(); ++s) {
    const Panel p = factor_->panel(s);
    if (p.first + p.columns > first) eliminate(p, x.data(), gathered_.data());
  }
}

void SparseCholesky::forward3(Eigen::Ref<Eigen::MatrixX3d> x, int first) const {
  for (int s = 0; s < factor_->panel_count(); ++s) {
    const Panel p = factor_->panel(s);
    if (p.first + p.columns <= first) continue;
    // A sparse right-hand side touches only the panels on its way to the root of the elimination tree.
    if (x.middleRows(p.first, p.columns).isZero(0)) continue;
    for (int k = 0; k < 3; ++k) eliminate(p, x.col(k).data(), gathered_.data());
  }
}

void SparseCholesky::backward(Eigen::Ref<VectorX> x) const {
  double* b = x.data();
  double* g = gathered_.data();
  for (int s = factor_->panel_count() - 1; s >= 0; --s) {
    const Panel p = factor_->panel(s);
    const int below = p.rows - p.columns;
    for (int i = 0; i < below; ++i) g[i] = b[p.below[i]];
    for (int j = p.columns - 1; j >= 0; --j) {
      const double* column = p.x + static_cast<std::ptrdiff_t>(j) * p.rows;
      const double* tail = column + p.columns;
      double sum = 0;
#pragma omp simd reduction(+ : sum)
      for (int i = 0; i < below; ++i) sum += tail[i] * g[i];
      for (int i = j + 1; i < p.columns; ++i) sum += column[i] * b[p.first + i];
      b[p.first + j] = (b[p.first + j] - sum) / column[j];
    }
  }
}

}  // namespace acus
