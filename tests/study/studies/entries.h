// SPDX-License-Identifier: GPL-3.0-or-later
// Needles that go in anywhere: what any lay person takes for granted, at random places.
//
// Each entry is a scene of its own, the same on every machine: a block of tissue or a mesh from a folder, held on the far
// side, and a needle that is pushed along its axis onto a random point of the surface. Random, too, are tilt against the
// surface's normal (0 to 60 degrees), speed (5 to 300 mm/s), rung, stiffness, and f_p/(E a²) (0.3 to 20, by its
// logarithm), a the edge of a regular tetrahedron as large as the one at the entry: a point force of E a² is about what
// turns elements inside out.
//
// A ghost is a needle whose tip was deeper than 1 mm in the tissue in neither a path nor contact at the end of a tick. One
// that was found there in the tick, and got a path (event `intrusion`), is told apart.
#pragma once

#include <string>
#include <vector>

#include "server/engine/scene/scene.h"

namespace acus {

struct Entry {
  int number = 0;
  std::string body;                       // "block", or the name of a mesh file
  Scene scene;                            // with one needle, its tip `gap` before the entry
  Vector3 at = Vector3::Zero();           // m, world, on the surface at rest
  Vector3 normal = Vector3::UnitZ();      // of the surface there, unit, outward
  Vector3 along = -Vector3::UnitZ();      // the needle's axis, unit
  double gap = 2e-3;                      // m
  double element = 0;                     // a (m)
  double ratio = 0;                       // f_p/(E a²)
  double support = 0;                     // -, share of a circle of the contact's radius that lies on the surface
  double tilt = 0;                        // rad, of the axis against the normal
  double speed = 0;                       // m/s
};

// The entry of a number, on a block or on one of `meshes` (Gmsh files in m), picked at random.
Entry random_entry(int number, const std::vector<GmshMesh>& meshes);

struct EntryOutcome {
  int ticks = 0;
  bool touched = false;
  bool punctured = false;
  int ghost_ticks = 0;         // that ended with a ghost
  int found_inside = 0;        // times that a path was opened around a tip
  int released = 0;            // times that a contact was lost
  double puncture_force = 0;   // N, of the event
  double indentation = 0;      // m, way of the base along the needle from the contact to the puncture
  double deepest = 0;          // m of needle inside
  int inverted_ticks = 0;      // flagged
  std::uint32_t flags = 0;     // of all ticks
  double seconds = 0;          // of processor time in the ticks

  bool ghost() const { return ghost_ticks > 0; }
};

// Pushes the needle until it is kPushedOn deep or the base has gone its way.
EntryOutcome run_entry(const Entry& entry);

inline constexpr double kPushedOn = 10e-3;  // m

}  // namespace acus
