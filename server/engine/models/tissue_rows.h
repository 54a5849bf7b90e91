// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of a tick as forces on free nodes of the tissue, in the frame of its factor, and what they do to each other:
//
//   W_t = Sᵀ G S,    delta_free = Sᵀ Yᵀ y,    y <- y + Y S lambda
//
// S: the rows' forces on the corridor's slots; G, Y: corridor.h; y = L⁻¹ (-g). A row acts on few slots, and W_t takes
// one pass over contiguous memory for each.
#pragma once

#include <span>
#include <vector>

#include "server/engine/models/corridor.h"

namespace acus {

class TissueRows {
 public:
  // There is room for rows of eight nodes, and for a few that act on all `max_nodes`. The factor must outlive this; one
  // of no unknowns leaves rows without forces.
  TissueRows(const SparseCholesky& factor, int max_rows, int max_nodes, const ModeShapes* stiffened = nullptr);

  Corridor& corridor() { return corridor_; }
  const Corridor& corridor() const { return corridor_; }

  int count() const { return count_; }
  void clear() {
    count_ = 0;
    parts_.clear();
  }
  // A row is made by begin(), add_force() for each of its nodes and end(), which returns its index; without end() it is
  // forgotten.
  void begin();
  // N on a free node for a unit of the row; forces on one node add up. False if there is no room.
  bool add_force(int free_node, const Vector3& force);
  int end();

  // Free displacements (m) of the corridor's slots, 3 x capacity: read_displacements() fills in Yᵀ y for those that
  // rows act on.
  Matrix3X& displacements() { return slot_displacement_; }
  void read_displacements(const VectorX& y);
  // Adds W_t (m/N) to the lower triangle of W and the free displacements of the rows to `delta`.
  void add_compliance(Eigen::Ref<MatrixX> W, std::span<double> delta);

  // S lambda: forces on the slots in touched(), in the order in which rows touch them, so that no sum depends on which
  // slot a node was given.
  void gather_forces(std::span<const double> lambda);
  const std::vector<int>& touched() const { return touched_; }
  Vector3 slot_force(int slot) const { return slot_forces_.segment<3>(3 * slot); }
  // y <- y + Y S lambda
  void add_forces(std::span<const double> lambda, VectorX& y);

 private:
  struct Part {
    int slot;
    Vector3 force;
  };
  std::span<const Part> parts(int row) const {
    return {parts_.begin() + ends_[row], parts_.begin() + ends_[row + 1]};
  }

  Corridor corridor_;
  std::vector<int> ends_;    // per row, where the parts of the one before end; one more than rows
  std::vector<Part> parts_;  // of one row after the other; never beyond its capacity
  int count_ = 0;
  MatrixX gram_rows_, gram_columns_;  // G S: 3 slots x rows; its transpose
  Matrix3X slot_displacement_;        // Yᵀ y
  std::vector<char> slot_read_;       // per slot, whether this call has met it
  std::vector<int> touched_;          // slots that forces act on, in the order of the rows
  VectorX slot_forces_;               // S lambda
};

}  // namespace acus
