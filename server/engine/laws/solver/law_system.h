// SPDX-License-Identifier: GPL-3.0-or-later
// The laws of a tick and the lines on which they meet their graphs, delta = W lambda + delta_free, and by how much
// forces violate them.
//
// The violation of a row is the force by which it would still move, |lambda - law_force(...)| (N) on its own line
// through (lambda, delta) with the slope `scale`, W_ii; a disk's is its change by disk_step(). It measures the laws
// themselves, not the progress of an iteration.
#pragma once

#include <algorithm>
#include <span>

#include "server/engine/laws/friction_cone.h"
#include "server/engine/laws/laws.h"
#include "server/engine/math/types.h"

namespace acus {

// A view: what it speaks of lives elsewhere.
struct LawSystem {
  Eigen::Ref<const MatrixX> W;         // m/N, rows x rows, symmetric
  std::span<const Law> laws;           // rows
  std::span<const double> delta_free;  // m, rows
  std::span<const double> scale;       // m/N, rows, see law_scales()

  int rows() const { return static_cast<int>(laws.size()); }
};

// Forces and their displacements W lambda + delta_free, one of each per row.
struct LawState {
  std::span<double> lambda;  // N
  std::span<double> delta;   // m
};

void copy(const LawState& from, const LawState& to);

// The largest force (N), and at least 1 N: rounding errors, and so what can be asked of an answer, grow with the
// forces.
double force_scale(std::span<const double> lambda);

// A normal row with its two rows of friction right behind it (contact_block.h).
inline bool is_contact(std::span<const Law> laws, int i) {
  return i + 2 < static_cast<int>(laws.size()) && laws[i + 1].kind == LawKind::disk_first &&
         laws[i + 1].normal_row == i;
}

// Rows of the cone (friction_cone.h) at row i; 0: it is none.
inline int cone_rows(std::span<const Law> laws, int i) {
  return laws[i].cone == nullptr ? 0 : laws[i].kind == LawKind::disk_first ? 2 : 1;
}

// Whether a law is no chain of straight pieces: a cone's (friction_cone.h).
inline bool has_curves(std::span<const Law> laws) {
  return std::any_of(laws.begin(), laws.end(), [](const Law& law) { return law.cone != nullptr; });
}

// What the roots of cones and contacts take once, as multiplications (see StepBudget).
double work_of_curves(std::span<const Law> laws);

// Per row the slope of its line: W_ii, and for the first row of a disk a bound of the two rows' block.
void law_scales(const Eigen::Ref<const MatrixX>& W, std::span<const Law> laws, std::span<double> scale);

// delta <- W lambda + delta_free.
void update_displacements(const LawSystem& system, const LawState& state);

// What the cone at row i comes to, with all other forces as they are, and how far the forces are from that (N).
DiskContact cone_answer(const LawSystem& system, int i, const LawState& state);
double distance(const LawSystem& system, int i, const LawState& state, const DiskContact& answer);

// The force of a disk's two rows after one step from (lambda, delta); exact for a cone.
Eigen::Vector2d disk_step(const LawSystem& system, int i, const LawState& state);

// The violation (N) of the law of row i, of a disk at its first row; zero at its second.
double law_violation(const LawSystem& system, int i, const LawState& state);

// The largest violation (N); not-a-number is the largest of all.
double law_residual(const LawSystem& system, const LawState& state);

}  // namespace acus
