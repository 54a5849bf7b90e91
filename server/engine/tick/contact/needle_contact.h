// SPDX-License-Identifier: GPL-3.0-or-later
// Needles that touch each other. Each cell of a needle has one contact at most with every needle behind it in the
// scene: at the points A and B of the two curves that are nearest at the start of the tick
// (models/needle/needle_distance.h), with the unit vector n from B to A; where the needles cross in the cell, n is
// across both,
//
//   unilateral   n · (A - B) - (r_A + r_B) + e lambda >= 0,   lambda >= 0 (N): +n lambda on A, -n lambda on B
//   friction     across n, |lambda_t| <= mu lambda, against the slip of A and B in the tick
//
// A and B are points of the needles' material in the tick, and others in the next: contacts slide along both without a
// memory. e is what thin tubes give as they flatten, 1 um/N: little beside what needles bend, and a bound for the force
// of two rigid ones that are driven into each other. n is that of the tick's start: needles pass through each other
// only where they are pressed together by more than a radius, or come nearer by more than they did before. Flag
// needle_overstrained: one is pressed into the other by more than kMaxNeedleStrain of the thinner radius.
//
// Friction acts between the axes: the spin of a needle does not slip in it. The end is a hemisphere: no edge or point
// cuts another needle. Where more than max_needle_contacts() are near, those with the widest gaps are left out, with a
// flag.
#pragma once

#include <span>
#include <vector>

#include "server/engine/math/bounded.h"
#include "server/engine/models/needle/needle_distance.h"
#include "server/engine/state/model.h"
#include "server/engine/state/state.h"
#include "server/engine/tick/contact/contact.h"
#include "server/engine/tick/views.h"

namespace acus {

struct NeedleContact {
  int first = 0, second = 0;          // needles, first < second
  double s = 0, t = 0;                // m, along each
  Vector3 normal = Vector3::UnitZ();  // unit, world, from the second to the first
  double gap = 0;                     // m, between their surfaces at the start of the tick
};

// Contacts of a tick, and what finds them.
struct NeedleContacts {
  std::vector<NeedleCells> cells;  // per needle, at the start of the tick
  std::vector<double> moves;       // m, per needle: how far its nodes may go in the tick
  Bounded<NeedleContact> found;
  bool left_out = false;  // more than there is room for

  explicit NeedleContacts(const Scene& scene);
};

// Stage 4, once a tick, with the needles' shapes at its start.
void find_needle_contacts(const Model& model, const State& state, std::span<const NeedleShape> start_shapes,
                          std::span<const NeedleScratch> needles, NeedleContacts& contacts);

// Stage 5; mu: `friction`.
Contact make_contact(const NeedleView& first, const NeedleView& second, double friction, const NeedleContact& found);

}  // namespace acus
