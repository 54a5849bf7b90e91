// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/math/factor/sparse_cholesky.h"

#include <cholmod.h>

#include <algorithm>
#include <cassert>
#include <limits>
#include <new>

// Present when the BLAS behind CHOLMOD is OpenBLAS, and CHOLMOD uses OpenMP. One thread: the simulation owns one core, sums
// must not depend on how they were shared out, and OpenMP ends a process that gets no more threads.
extern "C" void openblas_set_num_threads(int) __attribute__((weak));
extern "C" void omp_set_max_active_levels(int) __attribute__((weak));

namespace acus {

namespace {

// For the calling thread.
void stay_on_one_thread() {
  if (openblas_set_num_threads != nullptr) openblas_set_num_threads(1);
  if (omp_set_max_active_levels != nullptr) omp_set_max_active_levels(0);
}

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

// The pattern of a matrix by blocks of unknowns that are all coupled, lower triangle.
SparseMatrix block_pattern(const SparseMatrix& lower, int block) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int column = 0; column < lower.outerSize(); column += block)
    for (SparseMatrix::InnerIterator it(lower, column); it; ++it)
      if (it.row() % block == 0) entries.emplace_back(it.row() / block, column / block, 1.0);
  SparseMatrix pattern(lower.rows() / block, lower.cols() / block);
  pattern.setFromTriplets(entries.begin(), entries.end());
  return pattern;
}

enum class Ordering { minimum_degree, metis, nested_dissection };

// The blocks in the order of elimination; empty if the method failed.
std::vector<int> order(const SparseMatrix& pattern, Ordering ordering, cholmod_common& common) {
  cholmod_sparse graph = view_of(pattern);
  graph.xtype = CHOLMOD_PATTERN;
  std::vector<int> blocks(graph.nrow), parents(graph.nrow), components(graph.nrow);
  bool done = false;
  switch (ordering) {
    case Ordering::minimum_degree:
      done = cholmod_amd(&graph, nullptr, 0, blocks.data(), &common);
      break;
    case Ordering::metis:
      done = cholmod_metis(&graph, nullptr, 0, 1, blocks.data(), &common);
      break;
    case Ordering::nested_dissection:
      done = cholmod_nested_dissection(&graph, nullptr, 0, blocks.data(), parents.data(), components.data(),
                                       &common) >= 0;
      break;
  }
  return done ? blocks : std::vector<int>{};
}

std::vector<int> expand(const std::vector<int>& blocks, int block) {
  std::vector<int> unknowns;
  for (const int b : blocks)
    for (int k = 0; k < block; ++k) unknowns.push_back(block * b + k);
  return unknowns;
}

}  // namespace

struct SparseCholesky::Factor {
  cholmod_common common{};
  cholmod_factor* L = nullptr;

  Factor() {
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

  // The given order, or another of the same quality that suits panels better; null when memory runs out.
  cholmod_factor* analyze(const SparseMatrix& lower, std::vector<int> permutation) {
    cholmod_sparse view = view_of(lower);
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_GIVEN;
    return cholmod_analyze_p(&view, permutation.data(), nullptr, 0, &common);
  }
  PanelTree tree() const {
    return make_panel_tree(static_cast<int>(L->nsuper), static_cast<const int*>(L->super),
                           static_cast<const int*>(L->pi), static_cast<const int*>(L->s));
  }
};

SparseCholesky::SparseCholesky() : factor_(std::make_unique<Factor>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyze(const SparseMatrix& lower, int block) {
  stay_on_one_thread();
  Factor& f = *factor_;
  cholmod_free_factor(&f.L, &f.common);
  const SparseMatrix pattern = block_pattern(lower, block);
  double fewest = 0;
  for (const Ordering ordering : {Ordering::minimum_degree, Ordering::metis, Ordering::nested_dissection}) {
    const std::vector<int> blocks = order(pattern, ordering, f.common);
    cholmod_factor* L = blocks.empty() ? nullptr : f.analyze(lower, expand(blocks, block));
    if (L != nullptr && (f.L == nullptr || f.common.lnz < fewest)) {
      std::swap(f.L, L);
      fewest = f.common.lnz;
    }
    cholmod_free_factor(&L, &f.common);
  }
  if (f.L == nullptr) throw std::bad_alloc();

  const auto* permutation = static_cast<const int*>(f.L->Perm);
  position_.resize(static_cast<std::size_t>(lower.rows()));
  for (int i = 0; i < size(); ++i) position_[static_cast<std::size_t>(permutation[i])] = i;
  tree_ = f.tree();
  entries_ = kept_entries(tree_);
}

bool SparseCholesky::factorize(const SparseMatrix& lower) {
  Factor& f = *factor_;
  assert(f.L != nullptr);
  stay_on_one_thread();
  cholmod_sparse view = view_of(lower);
  cholmod_factorize(&view, f.L, &f.common);
  return f.common.status == CHOLMOD_OK;
}

bool SparseCholesky::ran_out_of_memory() const { return factor_->common.status == CHOLMOD_OUT_OF_MEMORY; }

void SparseCholesky::keep(Precision precision) {
  if (precision != this->precision()) {
    if (precision == Precision::half_precision) values_.emplace<PanelValues<Float16>>();
    if (precision == Precision::single_precision) values_.emplace<PanelValues<float>>();
    if (precision == Precision::double_precision) values_.emplace<PanelValues<double>>();
  }
  const cholmod_factor& L = *factor_->L;
  std::visit([&](auto& values) { values.pack(tree_, static_cast<const double*>(L.x), static_cast<const int*>(L.px)); },
             values_);
}

void SparseCholesky::finish() { cholmod_free_factor(&factor_->L, &factor_->common); }

std::size_t SparseCholesky::factor_bytes() const {
  return std::visit([](const auto& values) { return values.bytes(); }, values_);
}

Precision SparseCholesky::precision() const { return static_cast<Precision>(values_.index()); }

MatrixX SparseCholesky::make_panel_rows() const { return MatrixX::Zero(tree_.widest + kTileRows, 3); }

namespace {

double entries_of(const PanelTree::Panel& panel, int first, int last) {
  return (last - first) * (panel.columns + panel.below - 0.5 * (first + last - 1));
}

// Columns from `first` on that have no more entries than that, in whole strips: one at least.
int end_of_part(const PanelTree::Panel& panel, int first, double most) {
  int last = first;
  do last = std::min(last + kStripColumns, panel.columns);
  while (last < panel.columns && entries_of(panel, first, last + kStripColumns) <= most);
  return last;
}

}  // namespace

double SparseCholesky::entries(const Part& part) const {
  double sum = 0;
  for (int s = part.first_panel; s < part.last_panel; ++s) {
    const PanelTree::Panel& panel = tree_.panels[s];
    sum += part.last_column == 0 ? entries_of(panel, 0, panel.columns)
                                 : entries_of(panel, part.first_column, part.last_column);
  }
  return sum;
}

std::vector<SparseCholesky::Part> SparseCholesky::parts(double most) const {
  std::vector<Part> all;
  double of_last = most;
  for (int s = 0; s < panels(); ++s) {
    const PanelTree::Panel& panel = tree_.panels[s];
    const double of_panel = entries_of(panel, 0, panel.columns);
    if (of_panel <= most) {
      if (of_last + of_panel > most || all.empty()) all.push_back({s, s}), of_last = 0;
      all.back().last_panel = s + 1;
      of_last += of_panel;
      continue;
    }
    for (int first = 0, last = 0; first < panel.columns; first = last) {
      last = end_of_part(panel, first, most);
      all.push_back({s, s + 1, first, last});
    }
    of_last = most;
  }
  return all;
}

void SparseCholesky::forward(const Part& part, Eigen::Ref<VectorX> x, MatrixX& panel_rows) const {
  assert(panel_rows.rows() >= tree_.widest + kTileRows);
  double* w = panel_rows.data();
  std::visit(
      [&](const auto& values) {
        for (int s = part.first_panel; s < part.last_panel; ++s) {
          const PanelTree::Panel& panel = tree_.panels[s];
          const int last = part.last_column == 0 ? panel.columns : part.last_column;
          const int* rows = tree_.rows.data() + panel.first_row;
          double* columns = x.data() + panel.first;
          double* below = w + panel.columns;
          if (part.first_column == 0) {
            std::copy_n(columns, panel.columns, w);
            std::fill_n(below, panel.below + kTileRows, 0.0);
          }
          values.forward(tree_, s, part.first_column, last, w);
          if (last < panel.columns) continue;
          std::copy_n(w, panel.columns, columns);
          for (int i = 0; i < panel.below; ++i) x[rows[i]] += below[i];
        }
      },
      values_);
}

void SparseCholesky::backward(const Part& part, Eigen::Ref<VectorX> x, MatrixX& panel_rows) const {
  assert(panel_rows.rows() >= tree_.widest + kTileRows);
  double* w = panel_rows.data();
  std::visit(
      [&](const auto& values) {
        for (int s = part.last_panel - 1; s >= part.first_panel; --s) {
          const PanelTree::Panel& panel = tree_.panels[s];
          const int last = part.last_column == 0 ? panel.columns : part.last_column;
          const int* rows = tree_.rows.data() + panel.first_row;
          double* columns = x.data() + panel.first;
          if (last == panel.columns) {
            double* below = std::copy_n(columns, panel.columns, w);
            for (int i = 0; i < panel.below; ++i) below[i] = x[rows[i]];
            std::fill_n(below + panel.below, kTileRows, 0.0);
          }
          values.backward(tree_, s, part.first_column, last, w);
          if (part.first_column == 0) std::copy_n(w, panel.columns, columns);
        }
      },
      values_);
}

void SparseCholesky::unit_columns(int position, Eigen::Ref<Eigen::MatrixX3d> columns, MatrixX& panel_rows) const {
  OnWay at = begin_unit_columns(position, columns);
  double all = std::numeric_limits<double>::infinity();
  go_on(at, all, columns, panel_rows);
}

SparseCholesky::OnWay SparseCholesky::begin_unit_columns(int position, Eigen::Ref<Eigen::MatrixX3d> columns) const {
  const int leaf = tree_.panel_of[position], length = tree_.panels[leaf].to_root;
  assert(tree_.panel_of[position + 2] == leaf);
  columns.topRows(length).setZero();
  columns.block<3, 3>(length - tree_.from_root[position], 0).setIdentity();
  return {position, leaf};
}

void SparseCholesky::go_on(OnWay& at, double& entries, Eigen::Ref<Eigen::MatrixX3d> columns,
                           MatrixX& panel_rows) const {
  const int length = tree_.panels[tree_.panel_of[at.position]].to_root;
  std::visit(
      [&](const auto& values) {
        while (at.panel >= 0 && entries > 0) {
          const PanelTree::Panel& panel = tree_.panels[at.panel];
          auto own = columns.middleRows(length - panel.to_root, panel.columns);
          if (at.column == 0) {
            panel_rows.topRows(panel.columns) = own;
            panel_rows.middleRows(panel.columns, panel.below + kTileRows).setZero();
          }
          const int first = at.column;
          at.column = end_of_part(panel, first, entries);
          values.forward_three(tree_, at.panel, first, at.column, panel_rows.data(), panel_rows.rows());
          entries -= entries_of(panel, first, at.column);
          if (at.column < panel.columns) return;
          own = panel_rows.topRows(panel.columns);
          for (int i = 0; i < panel.below; ++i)
            columns.row(length - tree_.from_root[tree_.rows[panel.first_row + i]]) += panel_rows.row(panel.columns + i);
          at = {at.position, panel.parent};
        }
      },
      values_);
}

}  // namespace acus
