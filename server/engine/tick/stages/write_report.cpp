// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cassert>

#include "server/engine/state/limits.h"
#include "server/engine/tick/stages/stages.h"

namespace acus {

namespace {

bool any_at_speed_limit(const Model& model, const State& state) {
  for (int i = 0; i < model.needle_count(); ++i)
    if (at_speed_limit(model.needle_limits[i], state.bases[i])) return true;
  for (std::size_t g = 0; g < state.guides.size(); ++g)
    if (at_speed_limit(model.guide_limits[g], state.guides[g].motion)) return true;
  return false;
}

std::uint32_t flags_of(const Model& model, const State& state, const Scratch& scratch) {
  const Outcome& o = scratch.outcome;
  const bool unfinished = model.iterates() ? o.change > model.scene.newton.tolerance : o.went_too_far();
  const bool steps_lowered = state.economizing && model.scene.overrun.max_steps < model.scene.laws.max_steps;
  std::uint32_t flags = o.transitions;
  const auto raise = [&flags](bool trouble, std::uint32_t flag) { flags |= trouble ? flag : 0; };
  raise(!o.tangents_exact, kTangentProjected);
  raise(!o.rows_fit, kRowsDropped);
  raise(model.iterates() && unfinished, kNewtonNotConverged);
  const auto& field = state.tissue.field;
  raise(o.went_too_far() || (field && field->window->share < kLeastShareUnnoticed), kStepLimited);
  raise(scratch.tissue.inverted, kElementsInverted);
  raise(!o.laws.converged, kLawsNotConverged);
  raise(o.laws.fell_back, kSolverFellBack);
  raise(unfinished && o.limit < model.max_tick_steps(), kIterationsCapped);
  raise(o.laws.capped && steps_lowered, kStepsCapped);
  raise(!o.finite, kNotFinite);
  raise(o.energy_gained, kEnergyGained);
  raise(o.overstrained, kNeedleOverstrained);
  raise(std::ranges::any_of(state.monitors, [](const ShaftMonitor& w) { return w.unheld > 0; }), kShaftUnheld);
  raise(any_at_speed_limit(model, state), kBaseLimited);
  return flags;
}

void write_forces(const Scratch& scratch, int i, NeedleReport& report) {
  const NeedleForces& forces = scratch.forces[i];
  report.tip_force = forces.tip;
  report.cutting_force = forces.cutting;
  report.friction_force = forces.friction;
  report.lateral_force = forces.lateral;
  report.guide_force = forces.guides;
  report.needle_force = forces.needles;
  report.base_force = -scratch.needles[i].reaction.head<3>();
  report.base_torque = -scratch.needles[i].reaction.tail<3>();
}

// The tissue's part of the balance needs the elements at the new positions, which the next tick evaluates: what is
// reported speaks of the tick before.
//
// What is missing of the balance acts in this tick. Where it is near the needles it changes their forces; where the tissue
// swings or swells far from them it does not, and those of the tick before were right: against converged ticks from the
// same states they were off by no more than about their change.
void write_balance(const Model& model, const State& state, const Scratch& scratch, TickReport& report) {
  const TissueBalance& b = scratch.tissue.balance;
  report.imbalance = (scratch.balance.sum + b.support + b.applied - b.inertia).norm();
  report.largest_force =
      std::max({scratch.balance.largest_force, b.support.norm(), b.applied.norm(), b.inertia.norm()});
  const double allowed =
      std::max(model.force_rounding, kMaxImbalance * std::max(report.largest_force, scratch.balance.contact_forces));
  const double changed = (state.balance.sum - scratch.balance.sum).norm();  // sums of the tissue's forces on the needles
  if (report.largest_force > kLeastForceToBalance && std::min(report.imbalance, changed) > allowed)
    report.flags |= kForcesUnbalanced;
}

}  // namespace

void report_state(const Model& model, const State& state, TickReport& report) {
  assert(report.needles.size() == state.needles.size());
  report.tick = state.tick;
  report.time = static_cast<double>(state.tick) * model.h;
  for (int i = 0; i < model.needle_count(); ++i) {
    const NeedleState& needle = state.needles[i];
    const BaseState& base = state.bases[i];
    NeedleReport& of_needle = report.needles[i];
    of_needle.command_seq = base.command_seq;
    of_needle.command_tick = base.command_tick;
    of_needle.phase = state.insertions[i].phase;
    of_needle.inserted_depth = state.insertions[i].depth;
    of_needle.unheld = state.monitors[i].unheld;
    of_needle.base = {needle.x.col(0), needle.q[0]};
    of_needle.commanded = model.needles[i].hold ? base.spun_pose() : of_needle.base;
    of_needle.spin = base.spin;
    of_needle.tip_position = needle.x.rightCols<1>();
  }
}

void write_report(const Model& model, const State& state, Scratch& scratch, TickReport& report) {
  const StageTimer timer(scratch.times, Stage::report);
  report_state(model, state, report);
  report.flags = flags_of(model, state, scratch);
  report.rows = scratch.rows.count();
  report.solver = scratch.outcome.laws.method;
  report.sweeps = scratch.outcome.laws.sweeps;
  report.residual = scratch.outcome.laws.residual;
  report.newton_iterations = scratch.outcome.iterations;
  report.events.assign(scratch.events.begin(), scratch.events.end());
  if (!scratch.outcome.finite) return;  // forces stay those of the last good tick
  write_balance(model, state, scratch, report);
  for (int i = 0; i < model.needle_count(); ++i) write_forces(scratch, i, report.needles[i]);
}

}  // namespace acus
