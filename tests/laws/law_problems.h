// SPDX-License-Identifier: GPL-3.0-or-later
// Problems for the solvers of the laws, an oracle that tries every combination of branches, and a check that takes
// forces and displacements to the laws' graphs, independently of how any solver measures itself.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "server/engine/laws/solver/constraint_solver.h"
#include "server/engine/math/random.h"

namespace acus {

inline constexpr double kInfinite = std::numeric_limits<double>::infinity();
inline constexpr LawMethod kBothMethods[] = {LawMethod::gauss_seidel, LawMethod::direct};

struct Problem {
  MatrixX W;
  std::vector<Law> laws;
  VectorX delta_free;

  int rows() const { return static_cast<int>(laws.size()); }
};

struct Answer {
  VectorX lambda, delta;
  SolverResult result;
};

struct Effort {
  int max_steps = 100000;
  double tolerance = 1e-11;
};

Answer solve(ConstraintSolver& solver, const Problem& p, LawMethod method, Effort effort = {},
             const VectorX& start = {});
Answer solve(const Problem& p, LawMethod method, Effort effort = {}, const VectorX& start = {});

// The forces of the one combination of branches that lies on all graphs; laws of one row only.
std::optional<VectorX> enumerate(const Problem& p);

// How far (N or m, relative to the largest of its kind) the answer is off the worst of its graphs.
double off_graphs(const Problem& p, const Answer& a);

// Symmetric positive definite: of condition about 100 to 1000.
MatrixX random_compliance(int n, Random& random);
// Any law of one row.
Law random_law(Random& random);
// One of the laws of a unilateral row and its disk, appended.
void append_contact(Problem& p, Random& random);
// A unilateral row 0 and its two friction rows 1 and 2 on random compliances.
Problem contact_problem(Random& random, double mu);
// Rows as of a needle in tissue: `points` at a spacing (m), each with two bilateral rows, friction and torsion. A
// kernel of `element` (m) takes the tissue's part, a clamped beam `stiffness` times as stiff the needle's.
Problem needle_problem(Random& random, int points, double spacing, double element, double stiffness);

}  // namespace acus
