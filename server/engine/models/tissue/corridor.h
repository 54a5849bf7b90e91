// SPDX-License-Identifier: GPL-3.0-or-later
// The corridor: the tissue nodes that needles touch. For each of them the three columns Y = L⁻¹ eᵢ of the tissue's
// factor are kept, as far as they are not zero (panel_tree.h), and their Gram matrix G = YᵀY, which is the exact
// compliance between corridor nodes. With y = L⁻¹ r the free displacement of a corridor node is Yᵀ y, and forces on
// corridor nodes enter a tick's one backward substitution as y + Y f. Everything is in the frame of the factor (rest
// frame of the nodes for the rung `warped`).
//
// Where `stiffened` = Psi is given (low_modes.h), G = YᵀY - Psi Psiᵀ: the compliance of a tissue whose slow motions
// have less of it in a tick than the factor says.
//
// Slots are fixed in number; when all are taken, the one that was used longest ago is given to the new node. Columns of
// nodes that may be asked for soon are made ahead, some of one node a tick.
#pragma once

#include <cstdint>
#include <vector>

#include "server/engine/math/factor/sparse_cholesky.h"
#include "server/engine/math/types.h"
#include "server/engine/models/field/low_modes.h"

namespace acus {

class Corridor {
 public:
  // Unknowns of the factor are 3 * node + axis; the factor has been analysed with blocks of 3. It must outlive this,
  // and so must Psi (m/N^0.5; rows in the factor's order), if there is any.
  Corridor(const SparseCholesky& factor, int capacity, const ModeShapes* stiffened = nullptr);

  // Forgets all columns: the factor has changed.
  void clear();

  // A new tick: slots asked for before may be given away from here on. `ahead`: what make_ahead() may spend until the
  // next, in entries of the factor.
  void begin_use(double ahead) {
    ++use_;
    ahead_ = ahead;
  }

  // The slot of a free node, its columns computed if they are not there yet; -1 if every slot is in use already.
  int slot(int node);
  // Goes on with columns of a node that slot() may be asked for later; true if there was something to do. Of one node
  // at a time: the one before is finished first.
  bool make_ahead(int node);

  int capacity() const { return static_cast<int>(slots_.size()); }
  int used() const { return used_; }                // slots 0 .. used - 1 hold columns or get them
  const MatrixX& gram() const { return gram_; }     // 3 used x 3 used in the top left corner (m/N)
  int node(int slot) const { return slots_[slot].node; }
  Vector3 free_displacement(int slot, const VectorX& y) const;       // Yᵀ y (m)
  void add_force(int slot, const Vector3& force, VectorX& y) const;  // y <- y + Y f

 private:
  struct Slot {
    int node = -1;
    int panel = 0;  // of the node: its columns are the way from there to the root
    std::uint64_t last_use = 0;
  };

  // Columns that are made by and by.
  struct Ahead {
    int slot = -1;
    SparseCholesky::OnWay at{};
    int multiplied = 0;  // slots with whose columns they have been, once they are there
    MatrixX panel_rows;
  };

  int take_slot();
  void give_slot(int slot, int node);
  void fill(int slot);
  double go_on(double entries);  // what is left of them
  bool has_columns(int slot) const { return slot != next_.slot || next_.at.panel < 0; }
  double multiply(int slot, int other);
  Matrix3 product(int a, int b) const;
  Matrix3 stiffening(int a, int b) const;

  const SparseCholesky& factor_;
  const ModeShapes* stiffened_;
  MatrixX panel_rows_;  // scratch
  Ahead next_;
  double ahead_ = 0;
  std::vector<Slot> slots_;
  std::vector<int> slot_of_node_;
  std::vector<Eigen::MatrixX3d> columns_;  // longest_way x 3 each
  MatrixX gram_;
  int used_ = 0;
  std::uint64_t use_ = 1;
};

}  // namespace acus
