// SPDX-License-Identifier: GPL-3.0-or-later
// The rows of a tick as forces on free nodes of the tissue, in the frame of its factor, and what they do to each other:
//
//   W_t = Sᵀ G S,    delta_free = Sᵀ Yᵀ y,    y <- y + Y S lambda
//
// S: the rows' forces on the corridor's slots; G, Y: corridor.h; y = L⁻¹ (-g). A row acts on few slots, and the rows at
// one point of the tissue on the same ones: up to four of them are a block, and what one number does for all four is
// one operation. Of a block p, G S_p is made at the slots of the blocks from p on alone, which is half of G S, and is
// used up before the next one's is made, so it stays in the nearest cache; columns of G that the next block needs are
// on their way there meanwhile.
#pragma once

#include <span>
#include <vector>

#include "server/engine/models/tissue/corridor.h"

namespace acus {

class TissueRows {
 public:
  // There is room for rows of eight nodes, and for a few that act on all `max_nodes`. The factor must outlive this; one
  // of no unknowns leaves rows without forces.
  TissueRows(const SparseCholesky& factor, int max_rows, int max_nodes, const ModeShapes* stiffened = nullptr);

  Corridor& corridor() { return corridor_; }
  const Corridor& corridor() const { return corridor_; }

  int count() const { return count_; }
  void clear();
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
  // Sets the lower triangle of W to W_t (m/N) and adds the free displacements of the rows to `delta`.
  void set_compliance(Eigen::Ref<MatrixX> W, std::span<double> delta);

  // S lambda: forces on the slots in touched(), in the order in which rows touch them, so that no sum depends on which
  // slot a node was given.
  void gather_forces(std::span<const double> lambda);
  const std::vector<int>& touched() const { return touched_; }
  Vector3 slot_force(int slot) const { return slot_forces_.segment<3>(3 * slot); }
  // y <- y + Y S lambda
  void add_forces(std::span<const double> lambda, VectorX& y);

 private:
  static constexpr int kBlockRows = 4;
  using Four = Eigen::Array<double, kBlockRows, 1>;  // one number of each row of a block, 0 for those that it has not

  struct Part {
    int slot;
    Vector3 force;
  };
  struct Block {
    int first_row;
    int rows;
    int begin, end;  // of its slots in slots_; three numbers per slot in forces_, one after the other
  };

  bool fits_last_block() const;
  std::span<const int> slots(const Block& block) const {
    return {slots_.begin() + block.begin, slots_.begin() + block.end};
  }
  const Four* forces(const Block& block) const { return forces_.data() + 3 * block.begin; }
  // Meets every slot once, in the order of the rows.
  bool meet(int slot);
  void forget_met();
  void multiply_by_gram(const Block& block);
  void fetch_gram(const Block& block) const;
  void set_block(const Block& block, const Block& later, double* column, Eigen::Index stride) const;

  Corridor corridor_;
  int count_ = 0;
  std::vector<Part> open_;      // of the row that is being made
  std::vector<Block> blocks_;   // of one row after the other
  std::vector<int> slots_;      // never beyond its capacity, as the others
  std::vector<Four> forces_;    // S
  Matrix3X slot_displacement_;  // Yᵀ y
  std::vector<int> place_;      // per slot, where it is in touched_, -1 if it has not been met
  std::vector<int> touched_;    // slots met
  std::vector<int> places_;     // as slots_: where each is in touched_
  std::vector<Four> moved_;     // G S of one block: three numbers per slot met
  VectorX slot_forces_;         // S lambda
};

}  // namespace acus
