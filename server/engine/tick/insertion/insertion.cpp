// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/insertion.h"

namespace acus {

InsertionScratch::InsertionScratch(int shaft_capacity, int path_capacity, int shaft_cells)
    : next(make_insertion(path_capacity, shaft_cells)), turned(path_capacity) {
  located.contacts = Bounded<ShaftContact>(static_cast<std::size_t>(shaft_cells));
  located.shaft = Bounded<ShaftPoint>(static_cast<std::size_t>(shaft_capacity));
}

void InsertionScratch::forget_forces() {
  puncturing = cutting = false;
  next.tip.forget_forces();
  for (const ShaftPoint& point : located.shaft) next.vertices[point.vertex].contact.forget_forces();
  for (ShaftCell& cell : next.cells) cell.contact.forget_forces();
  next.hub.forget_forces();
}

void InsertionScratch::note_forces(const Rows& rows, std::span<const Contact> contacts, int needle) {
  for (const Contact& contact : contacts) {
    if (contact.needle != needle) continue;
    if (contact.kind == ContactKind::cut) cutting = at_most(rows, contact);
    if (contact.kind == ContactKind::surface || contact.kind == ContactKind::border)
      puncturing = at_most(rows, contact) && rows.delta()[contact.first_row] < 0;
  }
  for (const ShaftPoint& point : located.shaft) {
    VertexState& state = next.vertices[point.vertex];
    state.traction = point.owned > 0 ? state.contact.along / point.owned : 0;
  }
}

}  // namespace acus
