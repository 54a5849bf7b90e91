// SPDX-License-Identifier: GPL-3.0-or-later
// The work of a window (deferred_field.h): from how things were when it began to the next window, but for what held
// nodes and modes have come to, which the tick between them adds. It reads nothing else, and is cut into steps, each a
// part of one loop, whose cost is counted in entries of the factor. What it has done is a cache: a fresh one makes up
// for it, and gives the same bits.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "server/engine/models/field/field_state.h"
#include "server/engine/models/tissue/tissue_system.h"

namespace acus {

class FieldTask {
 public:
  // `memory`: for the next window, with vectors of the right length.
  FieldTask(const TissueSystem& system, std::shared_ptr<FieldWindow> memory);

  // What it is at; nullptr: nothing.
  const std::shared_ptr<const FieldWindow>& window() const { return window_; }
  void begin(const std::shared_ptr<const FieldWindow>& window);
  // Does what is due at the end of tick `tick` (0 to k - 1) of the window. `start`: of the elements, when it began.
  void advance(const TissueSystem& system, const ElementRotations& start, int tick);
  // Does all of it; false: it was stopped before.
  bool finish(const TissueSystem& system, const ElementRotations& start, const std::atomic<bool>& stopped);

  double cost() const { return cost_; }  // of a window, in entries
  double largest_slice(int window) const;

  struct Result {
    std::shared_ptr<FieldWindow> window;  // the next one; whoever takes it puts another one in its place
    ElementRotations element_rotations;
    Matrix3X ahead;         // 3 x nodes, m: what those that are not held are shown as
    Matrix3X v;             // 3 x nodes, m/s: the mean of the window before
    bool inverted = false;  // an element is
    bool stops = false;     // the field is to be stopped
  };
  // Of the window that is done.
  const Result& result() const { return result_; }
  // Ends with it; whoever takes it may take it apart, but leaves matrices of the same size.
  Result& take();

 private:
  enum class Work {
    prepare,
    carry,
    backward,
    place,
    elements,
    turn,
    normalize,
    gather,
    smooth,
    defect,
    feed,
    project,
    forward
  };
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
  void prepare(const TissueSystem& system, const FieldWindow& window);
  void carry(const FieldWindow& window, int first, int last);
  void place(const TissueSystem& system, const FieldWindow& window, int first, int last);
  void find_defect(const TissueSystem& system, const FieldWindow& window, int first, int last);
  void judge(const TissueSystem& system, const FieldWindow& window);
  void feed(const FieldWindow& window, int first, int last);

  std::vector<SparseCholesky::Part> parts_;
  std::vector<Step> steps_;
  double cost_ = 0, largest_step_ = 0;
  std::shared_ptr<const FieldWindow> window_;
  std::size_t done_ = 0;                       // steps
  Result result_;
  FieldShares shares_;        // at the window's end
  double squares_ = 0;        // N², of the defect, without increase
  double applied_ = 0;        // N², of weight and rows' forces
  std::vector<int> free_at_;  // free nodes in the factor's order: so they lie side by side in memory
  std::vector<int> held_;     // in that order, their numbers in the window's list, or -1
  MatrixX panel_rows_;
  ElementScratch elements_;
  bool one_sign_ = false;  // of the elements' rotations, then the nodes'
  Matrix4X sums_;
};

// With room for so many held nodes: of tissue in the shape of its mesh, to which its applied forces come in the first
// tick, or of tissue that they have brought to rest `in_equilibrium`.
FieldState make_field_state(const TissueSystem& system, int most_held, const TissueState* in_equilibrium = nullptr);

}  // namespace acus
