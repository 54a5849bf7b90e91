// SPDX-License-Identifier: GPL-3.0-or-later
// One needle in a cube of tissue, both where a test puts them, for the units of tick/insertion. The cube has
// 60 mm around the origin in cells of 10 mm; the needle is straight and rigid, 100 mm long, 1 mm thick. Nothing moves
// by itself: numbers are those that a person computes.
#pragma once

#include <vector>

#include "server/engine/laws/rows.h"
#include "server/engine/scene/scene.h"
#include "server/engine/tick/insertion/finding/location.h"
#include "server/engine/tick/insertion/transitions/path_transitions.h"

namespace acus::test {

inline constexpr double kTop = 0.03, kBottom = -0.03;     // m, z of two faces of the cube
inline constexpr double kLength = 0.1, kDiameter = 1e-3;  // m, of the needle
inline constexpr double kH = 1e-3;                        // s
inline constexpr double kRounding = 1e-12;                // m; 1e-16 was measured

// The point at z of a line that meets no edge of the mesh (m).
inline Vector3 on_line(double z) { return {0.0032, 0.0021, z}; }

// One region, f_p 0.4 N, f_c 0.2 N, p 6 kPa, mu 0.35 and 0.3, foundation 50 kPa.
Scene one_region();
// Another one below z = 0, whose border takes `puncture_force`.
Scene two_regions(double puncture_force);
inline constexpr int kUpper = 0, kLower = 1;

class InsertionBench {
 public:
  explicit InsertionBench(const Scene& from = one_region(), int path_vertices = 80);
  InsertionBench(const InsertionBench&) = delete;
  InsertionBench& operator=(const InsertionBench&) = delete;

  // The needle with its tip here, along a unit vector, now and at the start of the tick.
  void put_needle(const Vector3& tip, const Vector3& along = -Vector3::UnitZ());
  // Where it is now; at the start of the tick it was where it has been put.
  void move_needle(const Vector3& tip, const Vector3& along = -Vector3::UnitZ(), double spin = 0);

  MaterialPoint point(const Vector3& p) const;
  // On the border of a region, of the tissue before it.
  MaterialPoint border_point(int region, const Vector3& p) const;
  // Puts a path into the tissue; the last place is its end.
  Path& add_path(const std::vector<Vector3>& places, double spacing);
  // Straight down from the top, a vertex every `spacing`, to z.
  Path& add_straight_path(double z, double spacing = 4e-3);

  InsertionView view() const;
  Vector3 position(const MaterialPoint& p) const { return view().tissue.position(p); }
  // How far a tip that cuts stands before its path's end (m), straight down and in the upper region.
  double give() const;
  // Stage 4 from what the needle remembers.
  const Located& locate();
  // From now on the needle remembers that it is in a path.
  void be_in_path(int path);

  // Makes rows of what `find` puts into contacts; false if one did not fit.
  template <class Find>
  bool add_rows(Find&& find) {
    contacts.clear();
    find();
    bool all = true;
    for (Contact& contact : contacts.found) all = add_contact(contact, rows) && all;
    return all;
  }

  std::vector<EventKind> event_kinds() const;

  Scene scene;
  TetrahedralMesh mesh;
  std::vector<int> regions;
  std::vector<Interaction> interactions;
  std::vector<double> element_sizes;
  Surface surface;
  Borders borders;
  Matrix3X x;
  Needle& parameters;
  NeedleModel model;
  NeedleShape start, shape;
  std::vector<Path> paths;
  std::vector<char> paths_taken;
  Insertion state;
  InsertionScratch scratch;
  std::vector<Event> events;
  Contacts contacts{400};
  Rows rows{400};
};

// Stage 9 at the bench's positions, in tick 7.
inline constexpr std::uint64_t kTick = 7;

template <class Unit>
auto in_transition(InsertionBench& bench, Unit&& unit) {
  const InsertionView at = bench.view();
  return unit(Transition{at, bench.scratch, kTick, bench.state, bench.paths, bench.events});
}

}  // namespace acus::test
