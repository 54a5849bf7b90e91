// SPDX-License-Identifier: GPL-3.0-or-later
// One needle in the tissue, and the data that the files of this folder share. In a tick:
//
//   stage 4   finding/location.h                     finds what is ahead of the tip, the vertices alongside the shaft,
//             finding/obstacle.h, shaft_contact.h    the tip's place, and where the shaft lies on surfaces beside its
//             path
//   stage 5   finding/tip_contacts.h,                make contacts of them (tick/contact/contact.h), as shaft_contact.h
//             finding/vertex_contacts.h              does
//   stage 9   transitions/path_transitions.h         changes phase and path
//
// The state between ticks is Insertion (state/needle/insertion_state.h), its phases are in state/needle/phase.h.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "server/engine/math/bounded.h"
#include "server/engine/scene/scene.h"
#include "server/engine/state/capacities.h"
#include "server/engine/state/needle/insertion_state.h"
#include "server/engine/state/needle/path.h"
#include "server/engine/tick/contact/contact.h"
#include "server/engine/tick/contact/contact_patch.h"
#include "server/engine/tick/views.h"

namespace acus {

// The search for a surface reaches this far beyond the tip's motion in a tick.
inline constexpr double kContactMargin = 1e-3;  // m
// A tip without contact that is deeper than this in the tissue has entered without a puncture.
inline constexpr double kUnnoticedDepth = 1e-3;  // m
// Most borders that a tip crosses in a tick; more wait for the next.
inline constexpr int kMaxCrossings = 64;

// The needle and the tissue of a tick, read only.
struct InsertionView {
  int needle_index;
  const Needle& parameters;
  NeedleView needle;
  TissueView tissue;
  Vector3 tip_cutting = Vector3::UnitX();  // cutting direction in the tip's frame, unit

  // Unit, world.
  Vector3 cutting_direction() const { return needle.shape.frames.back() * tip_cutting; }
};

// The tip, or the hub: in this tick, where it was at its start (m), and the way of the hub's rim as it turned since
// (m).
struct NeedleEnd {
  CurvePoint now;
  Vector3 before;
  double turned = 0;
};
inline NeedleEnd tip_of(const InsertionView& at) { return {at.needle.tip(), at.needle.start_tip()}; }

// A path vertex alongside the shaft in this tick.
struct ShaftPoint {
  int vertex = 0;
  double s = 0;                        // m, along the needle
  double advance = 0;                  // m, from there to the wall of a mouth or exit (path_wall.h)
  double owned = 0;                    // m, owned length (owned_lengths.h)
  double supported = 0;                // m, supported length; the tip has the rest
  double tearing = 0;                  // m, tearing length, likewise
  double crept = 0;                    // m, of the spring along it, in the last tick
  Vector3 tangent = Vector3::UnitX();  // of the path, unit, towards the end
  bool mouth = false;                  // the path enters the tissue here,
  bool exit = false;                   // or leaves it
};

// A length of the shaft that touches a surface beside its path, or may in this tick (shaft_contact.h).
inline constexpr int kContactPoints = 3;
struct ShaftContact {
  int cell = 0;
  double s = 0;                       // m, along the needle
  double length = 0;                  // m of shaft that it stands for
  Vector3 normal = Vector3::UnitZ();  // unit, world, across the needle and out of the tissue
  // Of the surface, which bear it; their weights are shares, which sum to 1.
  std::array<MaterialPoint, kContactPoints> points;
};

// A surface or border that the tip touches, or may reach in this tick.
struct Obstacle {
  int region = 0;  // behind the surface
  SurfacePoint at;
  MaterialPoint material;       // the same point, of the tetrahedron on the tip's side
  ContactPatch patch;           // which bears the contact
  double rise = 0;              // m, of the surface at the contact over the patch, along the normal
  DimpleSpring dimple{};        // under the tip, or hub
  Spring seat{};                // in series, of a hub that lies on a part of its face alone
  double compliance_along = 0;  // m/N, of the dimple along a border
  Vector3 crept_along = Vector3::Zero();   // m, world, of that spring,
  Vector3 creeps_along = Vector3::Zero();  // and of it in the last tick
  double bears = 0;             // N, of the tip at the start of the tick; before a border, of its cut
  double dimple_before = 0;     // m, the depth of dimple and seat under that
  bool under = true;            // the tip presses on it, or will in this tick
  bool yields = true;           // at f_p: not what faces away from the tip, nor to a needle drawn back
};

// A border that holds tips, before one that cuts (obstacle.h, tip_laws.h).
struct BorderAhead {
  double distance = kInfinity;  // m, from the tip, along the cutting direction
  double dimple = 0;            // m, likewise, that the tip presses into it once it bears the cutting force
};

// The tip's place in its path: at the end, where it cuts, or back inside, between two vertices.
struct TipPlace {
  bool in_tail = false;                // between the last vertex and the end of a path that has one
  bool at_end = false;                 // at the end of its path, not back inside it
  TissuePoint point;                   // of the path, that supports the tip laterally, between
  int behind = -1;                     // this vertex, -1: it is the next one alone,
  int next = -1;                       // and this one, -1: the path's end
  double supported = 0;                // m, supported length
  double tearing = 0;                  // m, tearing length
  Vector3 tangent = Vector3::UnitX();  // of the path there, unit
  Vector3 cutting = Vector3::UnitX();  // cutting direction at the start of the tick, unit
  BorderAhead ahead;                   // along it, at the start of the tick
  double lead = 0;                     // m, of the tip before its path's end, by the spring there, likewise
};

// What stage 4 finds.
struct Located {
  bool reentered = false;  // the needle enters an old path in this tick,
  bool far_end = false;    // at the end where that left the tissue
  bool left_out = false;   // more vertices are alongside the shaft than there is room for
  std::optional<Obstacle> obstacle;
  Bounded<ShaftPoint> shaft;
  TipPlace tip;
  Bounded<ShaftContact> contacts;
  std::optional<Obstacle> hub;  // what its hub touches, or may reach in this tick (finding/hub.h)
};

// What a tick needs of a needle: the state that it leaves if it is good, and scratch.
struct InsertionScratch {
  Insertion next;  // has the last tick's forces until forget_forces()
  Located located;
  Path turned;              // the needle's path, if it enters that by the far end
  bool puncturing = false;  // the contact force reached f_p
  bool cutting = false;     // the cutting force reached f_c

  InsertionScratch(int shaft_capacity, int path_capacity, int shaft_cells);

  // Before forces are read: those of the last tick go.
  void forget_forces();
  // Once they are: what follows from them.
  void note_forces(const Rows& rows, std::span<const Contact> contacts, int needle);

  // The path that the needle is in.
  const Path& path(std::span<const Path> paths) const {
    assert(next.path >= 0);
    return located.reentered && located.far_end ? turned : paths[static_cast<std::size_t>(next.path)];
  }
};

}  // namespace acus
