// SPDX-License-Identifier: GPL-3.0-or-later
// The laws of server/engine/laws/laws.h as problems of Siconos (V. Acary, F. Perignon et al., "An introduction to
// Siconos", INRIA TR-0340, 2019; Apache-2.0), whose solvers share no code and no method with ours.
//
// Relay problem: z within [low, high], w = M z + q with w >= 0 where z = low, w <= 0 where z = high, w = 0 between.
// Bilateral rows, rigid or soft, are eliminated; with C = diag(viscosities) the other one-row laws are of that form:
//   tau = lambda + C delta within [0, f] or [-T, T],   delta = (I + W C)⁻¹ (W tau + delta_free).
//
// Friction-contact problem: per contact the reaction lies in the second-order cone of coefficient mu, normal velocity
// and force are complementary, friction opposes sliding (not associated). Our contact without cap and cohesion.
#pragma once

#include <optional>

#include "tests/laws/law_problems.h"

namespace acus {

// Lemke's pivoting on the relay problem; laws of one row only, forces below 1 kN. Nothing if Siconos reports failure.
std::optional<VectorX> solve_relay(const Problem& p);

// Nonsmooth Gauss-Seidel over contacts to 1e-13, bilateral rows eliminated; laws must be rigid bilateral ones, and
// contacts of three consecutive rows without cap and cohesion. Nothing if Siconos reports failure.
std::optional<VectorX> solve_contacts(const Problem& p);

}  // namespace acus
