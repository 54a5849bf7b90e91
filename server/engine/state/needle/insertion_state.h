// SPDX-License-Identifier: GPL-3.0-or-later
// The state of a needle's insertion between ticks.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "server/engine/math/types.h"
#include "server/engine/models/geometry/material_point.h"
#include "server/engine/state/needle/contact_state.h"
#include "server/engine/state/needle/enums.h"

namespace acus {

// Of a path vertex, after the last tick in which it was alongside the shaft.
struct VertexState {
  double s = 0;         // m, its place along the needle
  double traction = 0;  // t_n, N/m: friction per length owned
  ContactState contact{};

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("s", self.s);
    visit("traction", self.traction);
    visit("contact", self.contact);
  }
};

struct TipState {
  ContactState contact{};  // with a surface or border, or across the path
  ContactState cut{};

  void forget_forces() {
    contact.forget_forces();
    cut.forget_forces();
  }

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("contact", self.contact);
    visit("cut", self.cut);
  }
};

// A length of shaft that may touch surfaces beside its path, see tick/insertion/finding/shaft_contact.h.
struct ShaftCell {
  Vector3 looked_from = Vector3::Zero();  // m, world: its middle when the surface was last looked for,
  double distance = 0;                    // m, how far away that was, 0 inside,
  double moved = 0;                       // m, and State::surface_moved
  double s = 0;                           // m, along the needle: its point of contact in the last tick
  double length = 0;                      // m of it that were near the surface in the last tick; 0: it had no rows
  double offset = 0;                      // m, of the surface that it touches, see shaft_contact.h
  Vector3 normal = Vector3::Zero();       // unit, world, out of the tissue, across the needle
  ContactState contact{};

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("looked_from", self.looked_from);
    visit("distance", self.distance);
    visit("moved", self.moved);
    visit("s", self.s);
    visit("length", self.length);
    visit("offset", self.offset);
    visit("normal", self.normal);
    visit("contact", self.contact);
  }
};

struct Insertion {
  Phase phase = Phase::free;             // state/needle/phase.h changes it
  int path = -1;                         // the needle's path, -1: none
  double depth = 0;                      // m of needle in the tissue
  int border = -1;                       // region whose border holds the tip, inside; -1: none
  bool tearing = false;                  // the needle tears its path sideways
  bool slipping = false;                 // the tip slides over a surface faster than it is led
  TipState tip;
  MaterialPoint touched;                 // of the surface, while a tip outside, or through, presses on it
  double end_s = 0;                      // m, place of the path's end along the needle, or ahead of it
  int first_alongside = 0;               // path vertices alongside the shaft in the last tick,
  int last_alongside = -1;               // none where last < first
  std::vector<VertexState> vertices;     // as many as a path can have
  std::vector<ShaftCell> cells;          // of the whole needle, from its base
  ContactState hub;                      // with the surface around the path's mouth

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("phase", self.phase);
    visit("path", self.path);
    visit("depth", self.depth);
    visit("border", self.border);
    visit("tearing", self.tearing);
    visit("slipping", self.slipping);
    visit("tip", self.tip);
    visit("touched", self.touched);
    visit("end_s", self.end_s);
    visit("first_alongside", self.first_alongside);
    visit("last_alongside", self.last_alongside);
    visit("vertices", self.vertices);
    visit("cells", self.cells);
    visit("hub", self.hub);
  }
};

// Whether the tip presses on a surface from outside.
inline bool touches(const Insertion& insertion) { return insertion.touched.tetrahedron >= 0; }
// Whether a vertex of its path was alongside the shaft in the last tick.
inline bool is_alongside(const Insertion& insertion, int vertex) {
  return vertex >= insertion.first_alongside && vertex <= insertion.last_alongside;
}

// Samples of a shaft for shaft_monitor.h; `length` of the needle (m).
inline constexpr double kMonitorSpacing = 5e-4;  // m, of the samples, at most
inline int monitor_samples(double length) { return static_cast<int>(std::ceil(length / kMonitorSpacing)); }

// The shaft beside its path, see tick/insertion/transitions/shaft_monitor.h.
struct ShaftMonitor {
  int next = 0;       // sample to check
  int found = 0;      // samples of this round in tissue that does not support them
  double unheld = 0;  // m, found in the last whole round

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("next", self.next);
    visit("found", self.found);
    visit("unheld", self.unheld);
  }
};

// A needle outside, with room for the vertices of any path.
inline Insertion make_insertion(int path_capacity, int shaft_cells) {
  Insertion insertion;
  insertion.cells.resize(static_cast<std::size_t>(shaft_cells));
  insertion.vertices.resize(static_cast<std::size_t>(path_capacity));
  return insertion;
}

}  // namespace acus
