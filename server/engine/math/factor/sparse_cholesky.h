// SPDX-License-Identifier: GPL-3.0-or-later
// Sparse Cholesky factorisation P A Pᵀ = L Lᵀ by CHOLMOD's supernodal code (Chen, Davis, Hager, Rajamanickam 2008,
// "Algorithm 887: CHOLMOD"), with our own substitutions on its factor: they can be called one at a time, allocate
// nothing, give the same bits every time, and can read L rounded to fewer bits (panel_values.h).
// Vectors handed to forward() and backward() are in the permuted order, unknown i at position(i).
#pragma once

#include <Eigen/Sparse>
#include <memory>
#include <stdexcept>
#include <variant>
#include <vector>

#include "server/engine/math/factor/panel_tree.h"
#include "server/engine/math/factor/panel_values.h"
#include "server/engine/math/types.h"

namespace acus {

using SparseMatrix = Eigen::SparseMatrix<double>;

enum class Precision { half_precision, single_precision, double_precision };

class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  // Orders and analyses the pattern of the symmetric matrix whose lower triangle is given. `block` unknowns that follow
  // each other, like the three of a node, are all coupled and keep together. Of minimum degree, METIS and nested
  // dissection the ordering with the smallest factor is taken. Throws std::bad_alloc when memory runs out.
  void analyze(const SparseMatrix& lower_triangle, int block = 1);

  // Numeric factorisation of a matrix with the analysed pattern; false if it is not positive definite. Substitutions go
  // with the factor that was last kept.
  bool factorize(const SparseMatrix& lower_triangle);
  bool ran_out_of_memory() const;  // why the last one failed, perhaps
  void keep(Precision precision);

  // Frees what only factorize() and keep() need: they must not be called again.
  void finish();

  int size() const { return static_cast<int>(position_.size()); }
  std::size_t factor_entries() const { return entries_; }  // stored entries of L, padding included
  std::size_t factor_bytes() const;
  Precision precision() const;

  // position(i): the place of unknown i in the permuted order. A block's unknowns follow each other there too.
  int position(int unknown) const { return position_[static_cast<std::size_t>(unknown)]; }

  // Scratch of the substitutions, for one panel: room for the widest. Threads that share a factor have one each.
  MatrixX make_panel_rows() const;
  // x <- L⁻¹ x.
  void forward(Eigen::Ref<VectorX> x, MatrixX& panel_rows) const { forward({0, panels()}, x, panel_rows); }
  // x <- L⁻ᵀ x.
  void backward(Eigen::Ref<VectorX> x, MatrixX& panel_rows) const { backward({0, panels()}, x, panel_rows); }

  // A part of a substitution: whole panels, or some columns of one. Who takes all parts, backward in the opposite
  // order, with the same scratch, gets the bits of the whole.
  struct Part {
    int first_panel, last_panel;            // the last is one further
    int first_column = 0, last_column = 0;  // of one panel; both 0: all
  };
  // None has more entries than that, if it can be cut.
  std::vector<Part> parts(double entries) const;
  double entries(const Part& part) const;  // of L, without padding
  void forward(const Part& part, Eigen::Ref<VectorX> x, MatrixX& panel_rows) const;
  void backward(const Part& part, Eigen::Ref<VectorX> x, MatrixX& panel_rows) const;

  const PanelTree& tree() const { return tree_; }
  // columns <- L⁻¹ of the unit vectors at three positions from `position` on, all in one panel; only the way of that
  // panel to the root (panel_tree.h), longest_way entries at most. The rest of `columns` is left alone.
  void unit_columns(int position, Eigen::Ref<Eigen::MatrixX3d> columns, MatrixX& panel_rows) const;

  // unit_columns() by and by, with the same bits. Whoever goes on leaves `columns` and `panel_rows` alone in between.
  struct OnWay {
    int position;
    int panel;       // that comes next, -1: there is none, all is done
    int column = 0;  // of it
  };
  OnWay begin_unit_columns(int position, Eigen::Ref<Eigen::MatrixX3d> columns) const;
  // Through about so many entries of L, which are taken off `entries`.
  void go_on(OnWay& at, double& entries, Eigen::Ref<Eigen::MatrixX3d> columns, MatrixX& panel_rows) const;

 private:
  struct Factor;
  int panels() const { return static_cast<int>(tree_.panels.size()); }

  std::unique_ptr<Factor> factor_;
  std::vector<int> position_;
  PanelTree tree_;
  std::size_t entries_ = 0;
  std::variant<PanelValues<Float16>, PanelValues<float>, PanelValues<double>> values_;  // as Precision
};

}  // namespace acus
