// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/shaft_contact.h"
#include "server/engine/tick/insertion/shaft_rows.h"
#include "server/engine/tick/insertion/tip_rows.h"
#include "server/engine/tick/stages/stages.h"

namespace acus {

namespace {

// False if some did not fit.
bool add_insertion_rows(const InsertionView& at, const State& state, const InsertionScratch& scratch, Rows& rows) {
  const auto& obstacle = scratch.located.obstacle;
  bool all = !scratch.located.left_out;
  for (const ShaftContact& contact : scratch.located.contacts)
    all = add_contact_rows(at, scratch, contact, rows) && all;
  if (scratch.next.path < 0) return (!obstacle || add_surface_rows(at, scratch, rows)) && all;
  const Path& path = scratch.path(state.paths);
  if (scratch.next.phase == Phase::through) {
    all = (!obstacle || add_surface_rows(at, scratch, rows)) && all;
  } else if (obstacle && obstacle->under) {
    all = add_border_rows(at, path, scratch, rows) && all;
  } else {
    all = add_path_rows(at, path, scratch, rows) && all;
  }
  for (const ShaftPoint& point : scratch.located.shaft) all = add_shaft_rows(at, path, scratch, point, rows) && all;
  return all;
}

}  // namespace

void build_rows(const Model& model, const State& state, Scratch& scratch) {
  const StageTimer timer(scratch.times, Stage::build_rows);
  Rows& rows = scratch.rows;
  rows.clear();
  bool all = !scratch.needle_contacts.left_out;
  const double friction = model.scene.needle_contact.friction;
  for (NeedleContact& contact : scratch.needle_contacts.found) {
    const NeedleView first = needle_view(model, scratch, contact.first);
    all = add_needle_contact_rows(first, needle_view(model, scratch, contact.second), friction, contact, rows) && all;
  }
  // Before the tissue: a shaft in squeezed tissue takes no room from them.
  for (int g = 0; g < model.guide_count(); ++g) {
    const int needle = model.guide_needles[g];
    all = add_guide_rows(model.scene.guides[g], g, needle, needle_view(model, scratch, needle), scratch.guides[g],
                         rows) &&
          all;
  }
  for (int i = 0; i < model.needle_count(); ++i)
    all = add_insertion_rows(insertion_view(model, state, scratch, i), state, scratch.insertions[i], rows) && all;
  scratch.outcome.rows_fit = scratch.outcome.rows_fit && all;
}

}  // namespace acus
