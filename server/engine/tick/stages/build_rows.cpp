// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/finding/hub.h"
#include "server/engine/tick/insertion/finding/shaft_contact.h"
#include "server/engine/tick/insertion/finding/tip_contacts.h"
#include "server/engine/tick/insertion/finding/vertex_contacts.h"
#include "server/engine/tick/stages/stages.h"

namespace acus {

namespace {

void find_insertion_contacts(const InsertionView& at, const State& state, InsertionScratch& scratch,
                             Contacts& contacts) {
  const auto& obstacle = scratch.located.obstacle;
  find_hub_contact(at, scratch, contacts);
  for (const ShaftContact& found : scratch.located.contacts) contacts.put(make_contact(at, scratch, found));
  if (scratch.next.path < 0 || scratch.next.phase == Phase::through) {
    if (obstacle) find_surface_contact(at, scratch, contacts);
  } else if (obstacle && obstacle->under) {
    find_border_contact(at, scratch.path(state.paths), scratch, contacts);
  } else {
    find_path_contacts(at, scratch.path(state.paths), scratch, contacts);
  }
  for (const ShaftPoint& point : scratch.located.shaft)
    find_vertex_contacts(at, scratch.path(state.paths), scratch, point, contacts);
}

// Those of needles and guides before those of the tissue: a shaft in squeezed tissue takes no room from them.
void find_contacts(const Model& model, const State& state, Scratch& scratch) {
  Contacts& contacts = scratch.contacts;
  contacts.clear();
  const double friction = model.scene.needle_contact.friction;
  for (const NeedleContact& found : scratch.needle_contacts.found)
    contacts.put(make_contact(needle_view(model, scratch, found.first), needle_view(model, scratch, found.second),
                              friction, found));
  for (int g = 0; g < model.guide_count(); ++g) {
    const int needle = model.guide_needles[g];
    find_guide_contacts(model.scene.guides[g], needle, needle_view(model, scratch, needle), scratch.guides[g],
                        contacts);
  }
  for (int i = 0; i < model.needle_count(); ++i)
    find_insertion_contacts(insertion_view(model, state, scratch, i), state, scratch.insertions[i], contacts);
}

}  // namespace

void build_rows(const Model& model, const State& state, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::build_rows);
  find_contacts(model, state, scratch);
  scratch.rows.clear();
  bool all = !scratch.needle_contacts.left_out && !scratch.contacts.left_out;
  for (Contact& contact : scratch.contacts.found) all = add_contact(contact, scratch.rows) && all;
  for (const InsertionScratch& insertion : scratch.insertions) all = all && !insertion.located.left_out;
  scratch.outcome.rows_fit = scratch.outcome.rows_fit && all;
}

}  // namespace acus
