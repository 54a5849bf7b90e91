// SPDX-License-Identifier: GPL-3.0-or-later
// The work of a window (deferred_field.h): from how things were when it began to the next window's field and defect. It
// reads nothing else, and is cut into steps, each a part of one loop, whose cost is counted in entries of the factor; a tick
// takes its share of them. What it has done is a cache: a fresh one makes up for it, and gives the same bits.
#pragma once

#include <memory>
#include <vector>

#include "server/engine/models/field_state.h"
#include "server/engine/models/tissue_system.h"

namespace acus {

class FieldTask {
 public:
  explicit FieldTask(const TissueSystem& system);

  // Does what is due at the end of tick `tick` (0 to k - 1) of the window. `start`: of the elements, when it began.
  void advance(const TissueSystem& system, const std::shared_ptr<const FieldWindow>& window, const ElementRotations& start,
               int tick);

  double cost() const { return cost_; }  // of a window, in entries
  double largest_slice(int window) const;

  struct Result {
    Matrix3X x;                              // 3 x nodes, m
    ElementRotations element_rotations;
    Matrix4X rotations;
    VectorX defect, y_defect, modes_defect;  // of the next window
    VectorX total;
    Vector3 left = Vector3::Zero();
    double squares = 0;                      // of the defect, without increase
    double applied = 0;                      // of weight and rows' forces
    bool inverted = false;
  };
  // Of the window that is done; whoever takes it may take it apart.
  Result& take();

 private:
  enum class Work { begin, backward, place, elements, turn, smooth, defect, project, forward };
  struct Step {
    Work work;
    int first, last;  // parts (backward: from the last), nodes in the factor's order, or batches
    double until;     // cost of all steps up to this one
  };

  void plan(const TissueSystem& system);
  template <class Cost>
  void add(Work work, int count, Cost cost);
  std::size_t steps_until(int tick, int window) const;
  void run(const TissueSystem& system, const FieldWindow& window, const ElementRotations& start, const Step& step);
  void begin(const TissueSystem& system, const FieldWindow& window);
  void place(const TissueSystem& system, const FieldWindow& window, int first, int last);
  void find_defect(const TissueSystem& system, const FieldWindow& window, int first, int last);

  std::vector<SparseCholesky::Part> parts_;
  std::vector<Step> steps_;
  double cost_ = 0, largest_step_ = 0;
  std::shared_ptr<const FieldWindow> window_;  // that it is at
  std::size_t done_ = 0;                       // steps
  Result result_;
  std::vector<int> free_at_;  // free nodes in the factor's order: so they lie side by side in memory
  std::vector<int> held_;     // in that order, their numbers in the window's list, or -1
  MatrixX panel_rows_;
  ElementScratch elements_;
  bool one_sign_ = false;                      // of the elements' rotations
  Matrix4X sums_;
};

// Of a tissue at rest whose weight acts from the first tick on, with room for so many held nodes.
FieldState make_field_state(const TissueSystem& system, int most_held);

}  // namespace acus
