// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cassert>
#include <cmath>

#include "server/engine/models/needle/needle_step.h"
#include "server/engine/models/tissue/tissue_step.h"
#include "server/engine/state/limits.h"
#include "server/engine/tick/stages/stages.h"

namespace acus {

namespace {

void read_all_forces(Scratch& scratch) {
  std::ranges::fill(scratch.forces, NeedleForces{});
  for (InsertionScratch& insertion : scratch.insertions) insertion.forget_forces();
  for (GuideScratch& guide : scratch.guides) guide.next.contact.forget_forces();
  const std::span<const Contact> contacts{scratch.contacts.found.begin(), scratch.contacts.found.end()};
  for (const Contact& contact : contacts) read_contact(scratch.rows, contact, scratch.forces);
  for (std::size_t i = 0; i < scratch.insertions.size(); ++i)
    scratch.insertions[i].note_forces(scratch.rows, contacts, static_cast<int>(i));
}

// Before the needles are committed.
NeedleBalance balance_of(const Model& model, const Scratch& scratch, const State& state) {
  NeedleBalance balance;
  for (int i = 0; i < model.needle_count(); ++i) {
    const NeedleScratch& needle = scratch.needles[i];
    const Vector3 base = needle.reaction.head<3>();
    balance.sum += base + scratch.forces[i].guides - inertia_less_weight(model.needles[i], needle, state.needles[i]);
    balance.largest_force = std::max(balance.largest_force, base.norm());
    balance.contact_forces = std::max(balance.contact_forces, scratch.forces[i].amounts);
  }
  return balance;
}

// Before the needles are committed.
void monitor_needles(const Model& model, const State& state, Scratch& scratch) {
  for (int i = 0; i < model.needle_count(); ++i) {
    if (model.needles[i].rigid) continue;
    const NeedleScratch& needle = scratch.needles[i];
    const NeedleEnergyChange energy = energy_change(model.needles[i], needle, state.needles[i]);
    scratch.outcome.energy_gained |= energy.gained > kMaxEnergyGain * std::max(energy.stored, kLeastEnergyToGain);
    scratch.outcome.overstrained |= largest_strain(model.needles[i], needle) > kMaxNeedleStrain;
  }
  for (const NeedleContact& contact : scratch.needle_contacts.found) {
    const double thinner = std::min(model.needles[contact.first].diameter, model.needles[contact.second].diameter);
    scratch.outcome.overstrained |= -contact.gap > kMaxNeedleStrain * thinner / 2;
  }
}

}  // namespace

bool is_finite(const Model& model, const Scratch& scratch) {
  for (const BaseState& base : scratch.bases)
    if (!base.is_finite()) return false;
  for (const GuideScratch& guide : scratch.guides)
    if (!guide.next.motion.is_finite()) return false;
  const auto lambda = scratch.rows.lambda();
  if (!std::all_of(lambda.begin(), lambda.end(), [](double force) { return std::isfinite(force); })) return false;
  for (int i = 0; i < model.needle_count(); ++i)
    if (!scratch.needles[i].finite()) return false;
  return scratch.tissue.finite();
}

void commit(const Model& model, Scratch& scratch, State& state) {
  assert(is_finite(model, scratch));
  const StageTimer timer(scratch.times, Stage::transitions);
  read_all_forces(scratch);
  monitor_needles(model, state, scratch);
  scratch.balance = state.balance;
  state.balance = balance_of(model, scratch, state);
  state.spring_energy = scratch.rows.elastic_energy();
  ++state.tick;
  for (int i = 0; i < model.needle_count(); ++i) {
    state.bases[i] = scratch.bases[i];
    commit_needle(scratch.needles[i], state.needles[i]);
    std::swap(state.insertions[i], scratch.insertions[i].next);
  }
  for (int g = 0; g < model.guide_count(); ++g) state.guides[g] = scratch.guides[g].next;
  state.surface_moved += model.surface.largest_move(state.tissue.x, scratch.tissue.x);
  commit_tissue(model.tissue_system, scratch.tissue, state.tissue);
}

}  // namespace acus
