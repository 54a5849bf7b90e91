// SPDX-License-Identifier: GPL-3.0-or-later
// A guide and the needle in it: a hole with the axis a through the point G, both prescribed by commands. The needle's
// curve passes through the plane at G across a at the point Q; there it has
//
//   without play   two bilateral rows across a,      n · (Q - G) = 0
//   with play c    one unilateral row towards G,     c - |Q - G| >= 0, pushing inwards without limit
//   with friction  one friction row along a, stick-slip at mu N, N the force across that the guide bore in the last tick
//
// The guide holds the needle from outside: no row of it acts on the tissue. It bears no moment, and a needle that has
// not reached it, or has left it, is free; one that comes to it beside its axis is taken onto it within a tick. With play
// the one row pushes against where the needle is at the start of the tick.
#pragma once

#include "server/engine/state/needle/guide_state.h"
#include "server/engine/tick/base_motion.h"
#include "server/engine/tick/contact/contact.h"
#include "server/engine/tick/views.h"

namespace acus {

// What a tick needs of a guide.
struct GuideScratch {
  GuideState next;
  Vector3 center = Vector3::Zero(), before = Vector3::Zero();  // G in this tick and at its start (m)
  Vector3 axis = Vector3::UnitX();                             // a
  bool holds = false;                                          // the needle passes through
};

// Stage 1.
void begin_guide(const BaseLimits& limits, double h, const GuideState& state, const std::optional<Command>& newest,
                 std::uint64_t tick, GuideScratch& scratch);
// Stage 4.
void locate_guide(const NeedleView& needle, GuideScratch& scratch);
// Stage 5: what a guide does to needle `index`.
void find_guide_contacts(const Guide& parameters, int index, const NeedleView& needle, GuideScratch& scratch,
                         Contacts& contacts);

}  // namespace acus
