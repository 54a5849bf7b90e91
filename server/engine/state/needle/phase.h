// SPDX-License-Identifier: GPL-3.0-or-later
// The phase of a needle, where its tip is. Nothing else writes Insertion::phase.
//
//            contact            puncture, reentry                      exit, withdrawal
//         ------------>       -------------------->                 ---------------------->
//    free               contact                      inside                                 through
//         <------------                                             <----------------------
//            release                                               reentry, puncture, intrusion
//
//    free    --- reentry, intrusion, puncture --->    inside
//    free    <------------- withdrawal -----------    inside, through
//
// kPhaseChanges has the condition of each arrow. A tick may go along several of them, one after the other: a fast tip
// touches a surface and punctures it. A needle that is through, or at a border inside, tells contact and release, too, and
// stays in its phase.
#pragma once

#include <array>

#include "server/engine/state/needle/insertion_state.h"

namespace acus {

struct PhaseChange {
  Phase from, to;
  EventKind event;   // that the tick reports with it
  const char* when;  // for people
};

inline constexpr std::array<PhaseChange, 14> kPhaseChanges{{
    {Phase::free, Phase::contact, EventKind::contact, "the tip presses on the surface"},
    {Phase::contact, Phase::free, EventKind::release, "the surface bears no force of the tip any more"},
    {Phase::contact, Phase::inside, EventKind::puncture, "the surface bears its puncture force; a path begins"},
    {Phase::free, Phase::inside, EventKind::puncture, "the tip comes to a surface that bears no force; a path begins"},
    {Phase::contact, Phase::inside, EventKind::reentry, "the tip slides over the mouth of an old path, or its far end"},
    {Phase::free, Phase::inside, EventKind::reentry, "the tip comes to the mouth of an old path, or its far end"},
    {Phase::free, Phase::inside, EventKind::intrusion, "the tip is found 1 mm deep in the tissue, without a path"},
    {Phase::inside, Phase::through, EventKind::exit, "the tip is past the place where its path leaves the tissue"},
    {Phase::through, Phase::inside, EventKind::reentry, "the tip is drawn back into its path"},
    {Phase::through, Phase::inside, EventKind::puncture, "the tip punctures the next surface; its path goes on there"},
    {Phase::through, Phase::inside, EventKind::intrusion, "the tip is found 1 mm deep in the tissue, past its path"},
    {Phase::inside, Phase::through, EventKind::withdrawal, "the tip is drawn out of the last part of its path"},
    {Phase::inside, Phase::free, EventKind::withdrawal, "the tip is drawn out of the mouth of its path"},
    {Phase::through, Phase::free, EventKind::withdrawal, "the mouth of its path has gone past the tip"},
}};

// One of kPhaseChanges, or no change.
void change_phase(Insertion& insertion, Phase to);

// The needle is in a path from now on, and remembers nothing of it yet. `needle_length` in m.
void enter(Insertion& insertion, int path, double needle_length);

// The needle is outside again and remembers nothing but where its shaft lies on surfaces.
void forget(Insertion& insertion);

}  // namespace acus
