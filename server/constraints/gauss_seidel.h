// SPDX-License-Identifier: GPL-3.0-or-later
// Gauss-Seidel over the laws (Duriez et al. 2009, section 3, eq. 6): each row in turn moves to where its law's graph
// meets its line, the others frozen, until no law is violated by more than the tolerance.
//
// Departure from the paper: the bilateral rows B (tip and shaft path) are eliminated first, by a Cholesky factorisation
// of their block, and the sweeps run over the other rows I with
//
//   S = W_II - W_IB W_BB⁻¹ W_BI,    delta_bar = delta_free_I - W_IB W_BB⁻¹ delta_free_B,
//   lambda_B = -W_BB⁻¹ (delta_free_B + W_BI lambda_I).
//
// A stiff needle couples the bilateral rows of neighbouring points so tightly that sweeping over them needs hundreds of
// sweeps and more with every point; the remaining rows are few and nearly independent. To stay factorisable when points
// are closer than mesh and beams can tell apart, W_BB gets kRegularization of its mean diagonal added.
//
// A contact and its two rows of friction, which stand right behind it, move together (contact_block.h).
//
// Points that stick within one element are nearly dependent, and sweeps alone converge slowly there. So after
// kSubspaceInterval sweeps, and twice as many, four times and so on, the rows that stand on a straight piece of their
// graph (sticking, sliding with viscosity, or held at a distance of zero) are solved for exactly and together, the others
// at their bounds [Silcowitz, Niebe, Erleben 2010, "Projected Gauss-Seidel subspace minimization"]; then every row picks
// its piece anew, and again, at most kMaxPicks times: Newton's method on the pieces, or block principal pivoting [Judice,
// Pires 1994, "A block principal pivoting algorithm for large-scale strictly monotone linear complementarity problems"],
// whose rule keeps the picks from going round in circles. The answer that violates the laws least is kept.
//
// The violation of a row is the force by which it would still move, |lambda - law_force(...)| (N), on the full W: it
// measures the laws themselves, not the progress of the iteration. Starts from the lambda it is given.
#pragma once

#include <span>
#include <vector>

#include "server/constraints/laws.h"
#include "server/math/types.h"

namespace acus {

struct SolverResult {
  bool converged = false;
  int sweeps = 0;
  double residual = 0;  // N, largest violation at the end
};

// The largest violation (N) of the laws by lambda with its delta = W lambda + delta_free.
double law_residual(const MatrixX& W, std::span<const Law> laws, std::span<const double> lambda,
                    std::span<const double> delta);

class GaussSeidel {
 public:
  static constexpr double kRegularization = 1e-9;
  static constexpr double kSubspaceRegularization = 1e-10;
  static constexpr int kSubspaceInterval = 8;
  static constexpr int kMaxPicks = 400;
  static constexpr int kPatience = 3;

  explicit GaussSeidel(int capacity);

  // W: symmetric (m/N), positive diagonal, rows x rows in its top left corner, rows <= capacity. delta_free (m) and
  // lambda (N) have one entry per law; delta returns W lambda + delta_free.
  SolverResult solve(const MatrixX& W, std::span<const Law> laws, std::span<const double> delta_free, int max_sweeps,
                     double tolerance, std::span<double> lambda, std::span<double> delta);

 private:
  void split(std::span<const Law> laws);
  void factorize_bilateral();
  void eliminate(const MatrixX& W, std::span<const Law> laws, std::span<const double> delta_free);

  void solve_bilateral(std::span<const double> lambda_others, const MatrixX& W, std::span<const double> delta_free,
                       std::span<double> lambda, std::span<double> delta);
  // A piece of a graph: straight, or a bound with its force (N); sliding with viscosity is straight with the threshold.
  struct Piece {
    bool straight = false;
    double force = 0;
    bool operator==(const Piece&) const = default;
  };
  // How the picks have gone so far: the fewest that changed at once, and how often that may not get less.
  struct Picks {
    int fewest;
    int patience;
  };
  Piece piece_of(int i, double lambda, double delta) const;
  bool pick_pieces(std::span<const double> lambda, std::span<const double> delta, Picks& picks);
  bool solve_straight(std::span<double> lambda);
  void subspace_step(std::span<double> lambda, std::span<double> delta);

  std::vector<int> bilateral_, others_;  // rows of W
  std::vector<Law> laws_;                // of the others, normal_row in their own numbering
  std::vector<int> place_;               // row of W -> index in others_
  std::vector<double> lambda_, delta_;   // of the others
  MatrixX block_;                        // Cholesky factor of W_BB
  MatrixX coupling_;                     // L⁻¹ W_BI
  MatrixX schur_;                        // S
  VectorX free_bilateral_;               // L⁻¹ delta_free_B
  VectorX softening_;                    // m/N, of the soft bilateral rows
  VectorX diagonal_;                     // of W_BB, softening included
  VectorX free_others_;                  // delta_bar
  std::vector<Piece> pieces_, picked_;   // of the others
  std::vector<int> straight_;            // of the others: rows of a subspace step
  MatrixX subspace_;
  VectorX subspace_rhs_;
  std::vector<double> trial_lambda_, trial_delta_;
};

}  // namespace acus
