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

  const double* column(int j) const { return x + static_cast<std::ptrdiff_t>(j) * rows; }
  const double* tail(int j) const { return column(j) + columns; }  // the rows below
};

// Forward substitution with one panel: solves for its unknowns in b and takes them out of the rows below. g is scratch
// for those rows, so that the inner loop runs over contiguous memory; four columns at a time share its traffic.
void eliminate(const Panel& p, double* b, double* g) {
  const int below = p.rows - p.columns;
  double* unknown = b + p.first;
  for (int j = 0; j < p.columns; ++j) {
    const double* column = p.column(j);
    const double value = unknown[j] / column[j];
    unknown[j] = value;
    for (int i = j + 1; i < p.columns; ++i) unknown[i] -= column[i] * value;
  }
  std::fill_n(g, below, 0.0);
  int j = 0;
  for (; j + 4 <= p.columns; j += 4) {
    const double* c0 = p.tail(j);
    const double* c1 = p.tail(j + 1);
    const double* c2 = p.tail(j + 2);
    const double* c3 = p.tail(j + 3);
    const double v0 = unknown[j], v1 = unknown[j + 1], v2 = unknown[j + 2], v3 = unknown[j + 3];
    for (int i = 0; i < below; ++i) g[i] += (c0[i] * v0 + c1[i] * v1) + (c2[i] * v2 + c3[i] * v3);
  }
  for (; j < p.columns; ++j) {
    const double* c = p.tail(j);
    const double v = unknown[j];
    for (int i = 0; i < below; ++i) g[i] += c[i] * v;
  }
  for (int i = 0; i < below; ++i) b[p.below[i]] -= g[i];
}

// Backward substitution with one panel, the mirror image.
void substitute(const Panel& p, double* b, double* g) {
  const int below = p.rows - p.columns;
  double* unknown = b + p.first;
  for (int i = 0; i < below; ++i) g[i] = b[p.below[i]];
  int j = 0;
  for (; j + 4 <= p.columns; j += 4) {
    const double* c0 = p.tail(j);
    const double* c1 = p.tail(j + 1);
    const double* c2 = p.tail(j + 2);
    const double* c3 = p.tail(j + 3);
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0;
#pragma omp simd reduction(+ : s0, s1, s2, s3)
    for (int i = 0; i < below; ++i) {
      s0 += c0[i] * g[i];
      s1 += c1[i] * g[i];
      s2 += c2[i] * g[i];
      s3 += c3[i] * g[i];
    }
    unknown[j] -= s0, unknown[j + 1] -= s1, unknown[j + 2] -= s2, unknown[j + 3] -= s3;
  }
  for (; j < p.columns; ++j) {
    const double* c = p.tail(j);
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = 0; i < below; ++i) sum += c[i] * g[i];
    unknown[j] -= sum;
  }
  for (j = p.columns - 1; j >= 0; --j) {
    const double* column = p.column(j);
    double sum = 0;
    for (int i = j + 1; i < p.columns; ++i) sum += column[i] * unknown[i];
    unknown[j] = (unknown[j] - sum) / column[j];
  }
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
  for (int s = factor_->panel_count() - 1; s >= 0; --s) substitute(factor_->panel(s), x.data(), gathered_.data());
}

}  // namespace acus
