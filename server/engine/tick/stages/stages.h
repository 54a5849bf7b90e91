// SPDX-License-Identifier: GPL-3.0-or-later
// The stages of a tick (MODEL.md, "The tick"), one file each. Up to stage 8 they write scratch alone; the state is
// written by commit() and transitions(), the report by write_report(). None throws or locks, and none allocates but in
// rung exact, which factorises.
#pragma once

#include "server/engine/state/model.h"
#include "server/engine/state/report.h"
#include "server/engine/state/state.h"
#include "server/engine/tick/scratch.h"

namespace acus {

// 1. Bases and guides follow their newest commands; every needle is carried along rigidly with its base.
void take_commands(const Model& model, const State& state, const Commands& commands, Scratch& scratch);

// 2. Beam forces and tangents, block-tridiagonal factor, free motion of every needle.
void needle_free_motion(const Model& model, const State& state, Scratch& scratch);

// 3. Element forces and one forward substitution.
void tissue_free_motion(const Model& model, const State& state, Scratch& scratch);

// 4. Tips against surfaces and borders, path vertices and guides against the needles' curves. In the first iteration of a
// tick only: directions, paths and thresholds are those of its start.
void locate(const Model& model, const State& state, Scratch& scratch);

// 5. Directions, gaps and laws of all rows.
void build_rows(const Model& model, const State& state, Scratch& scratch);

// 6. W and delta_free.
void compute_compliance(const Model& model, Scratch& scratch);

// 7. lambda.
void solve_laws(const Model& model, const State& state, Scratch& scratch);

// 8. Free motion and the rows' forces together. Afterwards outcome says how far it went.
void correct(const Model& model, const State& state, Scratch& scratch);

// Whether another iteration follows: to the tolerance in rungs that iterate, in the others where a step went too far.
// A shortened step is short at contacts, too: without a repeat a tip would sink into bone.
bool continues(const Model& model, const Scratch& scratch);

// Whether bases, guides, forces, needles and tissue are all finite: whatever else the state takes over follows from them.
bool is_finite(const Model& model, const Scratch& scratch);

// The new positions and the laws' forces become the state.
void commit(const Model& model, Scratch& scratch, State& state);

// 9. Contact, puncture, borders, growth of paths, exit, withdrawal; shafts beside their paths.
void transitions(const Model& model, Scratch& scratch, State& state);

// Part of 9. Of a deferred field, holds the nodes that the tips come to next.
void hold_ahead(const Model& model, Scratch& scratch, State& state);

// Part of 9. Compliance of the tetrahedra that the tips come to next, a node a tick, so that entering one costs no more
// than staying in it. Fills a cache; no result depends on it.
void look_ahead(const Model& model, const State& state, Scratch& scratch);

// 10. The report.
void write_report(const Model& model, const State& state, Scratch& scratch, TickReport& report);

// The part of it that is the state's alone: tick, time, and of every needle its command, base, tip, phase and lengths.
void report_state(const Model& model, const State& state, TickReport& report);

}  // namespace acus
