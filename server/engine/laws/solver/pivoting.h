// SPDX-License-Identifier: GPL-3.0-or-later
// Laws without bilateral rows, by their pieces. Every law of one row is a chain of straight ones: bounds, where the
// force is known (open, capped, sliding), and lines, where the displacement is (closed, sticking) or is proportional to
// the force (sliding with viscosity c: delta = (T - lambda)/c). With the pieces known the forces follow from one
// Cholesky factorisation over the rows on lines; then every row whose law is violated picks its piece anew. That is
// block principal pivoting [Judice, Pires 1994, "A block principal pivoting algorithm for large-scale strictly monotone
// linear complementarity problems"], or Newton's method on the pieces: semismooth, and at the answer as soon as the
// pieces are right. One to three picks are usual. Rows that pick together may all go too far, as they do along a needle
// that comes to rest, one point after the other: as soon as the rows that would pick anew have not become fewer, the
// one alone picks from then on that violates its law most. Nothing proves that the picks end; at kMaxPicks it gives up
// (interior_point.h is what does not).
//
// A contact with friction is no chain of pieces. It is solved exactly (contact_block.h) at every pick, on the block
// K = W_CC - W_CS W_SS⁻¹ W_SC that the rows S on lines leave of it; several contacts in turn, until none moves.
//
// A cone (friction_cone.h) is no chain of pieces either: it sticks, with both displacements known, or slips along its
// tangent at its own answer with all other forces given, which is taken anew at every pick. That is Newton's method
// where it slips; it ends at a tolerance, once no row picks anew.
//
// A row keeps its piece while it violates its law by less than kPickAbove of the largest force, and so a row that
// is between two pieces does not swing between them by rounding. Rows on lines get kRegularization of their mean
// diagonal, and one step of refinement for it, so that points that mesh and beams cannot tell apart share their force.
#pragma once

#include <vector>

#include "server/engine/laws/friction_cone.h"
#include "server/engine/laws/solver/law_method.h"
#include "server/engine/laws/solver/law_system.h"

namespace acus {

class Pivoting {
 public:
  static constexpr double kRegularization = 1e-12;
  static constexpr double kPickAbove = 1e-12;    // violation, as share of the largest force, see force_scale()
  static constexpr double kContactsEnd = 1e-12;  // change of a contact's force, as share of it or of 1 N
  static constexpr double kAtBound = 1 - 1e-9;   // a force of that share of a bound is on it
  static constexpr int kMaxPicks = 16;
  static constexpr int kMaxContactRounds = 100;

  // Violations (N).
  struct Ends {
    double begin = 0;  // there is nothing to pick where the forces given violate no law by more
    double cones = 0;  // Newton's method ends where no cone violates its law by more
  };

  // `room`: rows² numbers, in each call of solve(), that others may use between them. The span must outlive this.
  Pivoting(int capacity, const std::span<double>& room);

  // Starts on the pieces on which the forces given stand, and leaves the forces that violate the laws least, these or
  // better ones, with their displacements. Takes each pick from `budget`, and adds it to `picks`. Returns the violation
  // that is left (N).
  double solve(const LawSystem& system, const LawState& state, const Ends& ends, StepBudget& budget, int& picks);

 private:
  // The piece of a row; the rows of a cone have the same, rest or slipping. `force` (N) at a bound; of a row that
  // slides with viscosity the threshold with its sign.
  struct Piece {
    enum Kind : std::uint8_t { bound, rest, sliding, slipping, contact } kind = bound;
    double force = 0;
    bool on_line() const { return kind == rest || kind == sliding || kind == slipping; }
    bool operator==(const Piece&) const = default;
  };

  // What a row would pick anew.
  struct Pick {
    int row = 0;
    Piece piece;
    double violation = 0;  // N, of its law
  };

  static Piece piece_at(const Law& law, double step, double lambda);
  // Returns the violation (N).
  double start(const LawSystem& system, const LawState& state);
  // Puts the rows into picks_ that would pick anew, and takes the tangents of cones that go on slipping. Returns the
  // largest violation (N); not-a-number is the largest of all.
  double look(const LawSystem& system, const LawState& state);
  double look_at_cone(const LawSystem& system, int i, const LawState& state, double slack);
  void put_piece(const LawSystem& system, const Pick& pick);

  // W of rows_, lower triangle; factor, coupling and K after elimination. Packed, so that it stays in the caches.
  Eigen::Map<MatrixX> matrix() {
    const auto n = static_cast<Eigen::Index>(rows_.size());
    return {room_.data(), n, n};
  }
  double work_of_pick(const LawSystem& system) const;
  bool move(const LawSystem& system, const LawState& state);
  void number_rows(int rows);
  void put_lines(const LawSystem& system);
  void fill(const LawSystem& system, const LawState& state);
  void solve_contacts(const LawSystem& system);
  void refine(const LawSystem& system, const LawState& state);

  std::vector<Piece> pieces_;
  std::vector<ConeTangent> tangents_;  // of cones, at their first row
  std::vector<Pick> picks_;
  std::vector<int> rows_;          // on lines, then of contacts: the numbering of all below
  Eigen::Index lines_ = 0;         // how many of them are on lines
  const std::span<double>& room_;  // of matrix()
  VectorX give_;                   // m/N, of sliding rows 1/c, of slipping ones D_ii, else zero
  VectorX coupled_;                // m/N, of a slipping row with the one behind it, D_12, else zero
  VectorX offset_;                 // m, displacement of a row at zero force
  VectorX rhs_;                    // m
  VectorX forces_;                 // N, of rows_
  std::vector<double> trial_lambda_, trial_delta_;
};

}  // namespace acus
