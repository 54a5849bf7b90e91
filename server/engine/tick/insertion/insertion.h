// SPDX-License-Identifier: GPL-3.0-or-later
// One needle in the tissue, as the units of this folder see it: what a tick finds out about it (stage 4, location.h), turns
// into rows (stage 5, tip_rows.h and shaft_rows.h), learns from the laws' forces (forces.h) and changes in the end (stage
// 9, path_transitions.h, path_growth.h). What it remembers from tick to tick is insertion_state.h.
//
// Outside, the tip has a contact row along the surface normal, capped by f_p, and two rows of contact friction. At the cap
// the surface gives way and a path is born at the contact point, or goes on there if the needle is through. Inside, the
// tip has a cutting row against the path's end, capped by f_c, and two lateral rows; every path vertex alongside the shaft
// has two lateral rows across the path and one friction row along it, with torsional friction one about it, and on a
// border that holds a support.
#pragma once

#include <optional>
#include <span>

#include "server/engine/math/bounded.h"
#include "server/engine/scene/scene.h"
#include "server/engine/state/capacities.h"
#include "server/engine/state/insertion_state.h"
#include "server/engine/state/path.h"
#include "server/engine/tick/insertion/contact_patch.h"
#include "server/engine/tick/views.h"

namespace acus {

// A surface is looked for within this distance beyond what the tip moves in a tick.
inline constexpr double kContactMargin = 1e-3;  // m
// Borders that a tip crosses in a tick; more wait for the next.
inline constexpr int kMaxCrossings = 64;

// Material points that they touch at once: the shaft's, the path's end, two that the tip is held between, those of a
// surface.
int max_material_points(const Needle& parameters, double spacing);

// The needle and the tissue of a tick, read only.
struct InsertionView {
  int needle_index;
  const Needle& parameters;
  NeedleView needle;
  TissueView tissue;

  // Along which a pushed tip moves, unit, world.
  Vector3 cutting_direction() const;
};

// A path vertex alongside the shaft in this tick.
struct ShaftPoint {
  int vertex = 0;
  double s = 0;                          // m, along the needle
  double owned = 0;                      // m, length of needle that it stands for
  double held = 0;                       // m, of that across the path; the tip has the rest
  Vector3 tangent = Vector3::UnitX();    // of the path, unit, towards the end
  bool mouth = false;                    // air before it,
  bool exit = false;                     // behind it
};

// A surface that the tip meets, or may meet in this tick.
struct Obstacle {
  int region = 0;          // behind the surface
  SurfacePoint at;
  MaterialPoint material;  // the same point, of the tetrahedron on the tip's side
  std::optional<ContactPatch> patch;  // of the tissue's own surface: what bears the contact
  double compliance = 0;   // m/N, of what gives way under the tip beyond the mesh; a border gives way as the mesh does
  bool under = true;       // the tip rests against it, or will get there in this tick
};

// Where the tip stands in its path: at the end, where it cuts, or back inside, between two vertices.
struct TipPlace {
  bool in_tail = false;  // between the last vertex and the end of a path that has one
  bool at_end = false;   // at the end of its path, not back inside it
  TissuePoint point;     // of the path, that the tip is held to
  double held = 0;       // m, length of needle that it stands for across the path
  Vector3 tangent = Vector3::UnitX();  // of the path there, unit
  Vector3 cutting = Vector3::UnitX();  // along which the tip cuts, at the start of the tick, unit
  double ahead = kInfinity;            // m, from the tip to a border along it, at the start of the tick
};

// What stage 4 finds out about a needle.
struct Located {
  bool reentered = false;  // an old path is picked up in this tick,
  bool far_end = false;    // by the end where it left the tissue
  bool left_out = false;   // more vertices alongside the shaft than there is room for
  std::optional<Obstacle> obstacle;
  Bounded<ShaftPoint> shaft;
  TipPlace tip;
};

// A needle's part of a tick: the memory that the tick will leave behind if it is good, and what lasts for the tick alone.
struct InsertionWork {
  Insertion next;           // what the last tick left, until read_forces() puts in this one's forces
  Located located;
  Path turned;              // the path in use, if it is picked up by its far end
  bool puncturing = false;  // the contact force reached f_p
  bool cutting = false;     // the cutting force reached f_c

  InsertionWork(int shaft_capacity, int path_capacity);

  // The path that the needle is in.
  const Path& path(std::span<const Path> paths) const {
    assert(next.path >= 0);
    return located.reentered && located.far_end ? turned : paths[static_cast<std::size_t>(next.path)];
  }
};

}  // namespace acus
