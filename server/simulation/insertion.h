// SPDX-License-Identifier: GPL-3.0-or-later
// One needle's relation to the tissue: where its tip is, which path it is in, which points of that path hold its shaft.
// Stages 4 (locate), 5 (rows) and 9 (transitions) of the tick for that needle.
//
// Outside, the tip has a contact row along the surface normal, capped by f_p, and two rows of contact friction. When
// the cap is reached the surface gives way and a path is born at the contact point. Inside, the tip has a cutting row
// against the path's end, capped by f_c, and two lateral rows; every path vertex alongside the shaft has two lateral
// rows across the path and one friction row along it.
//
// The friction threshold of a vertex is l pi d mu p, l the length of needle that the vertex owns: from halfway to its
// neighbour on one side to halfway on the other, the first from the surface, the last to the tip. The lengths sum to
// the inserted length at every moment, so that force does not jump when a vertex comes or goes.
//
// A tip that is back inside its path lies between the last vertex alongside the shaft, A, and the next one ahead, B (or
// the path's end). Its lateral rows hold it to (1 - u) A + u B, u the fraction of the way, with softness (1 - u)²: at
// u = 1 they are the rows that B will have once it is passed, at u = 0, where they would repeat the rows of A with an
// ever shorter lever, they have faded out. So vertices come and go without a jump, pulling and pushing.
// A tip that cuts is held to the path's end across its cutting direction, which is fixed in the tip's frame: that is
// what steers a bevel. The vertex behind it fades in with its distance d from the end, with softness ((1 - d)/d)², d in
// spacings: where a path is just born, or a vertex just set, two rigid pairs at nearly one place would pull against each
// other and turn the tip by whatever it slid in a tick.
//
// The shaft lies off its path by the lateral force times the compliance of the tissue beside it that the mesh does not
// resolve (foundation_compliance()), shared out over the lengths that the vertices own; the tip behind the end of its
// path by the same law, with the length of a spacing. At the end the tip is held where it is: its rows there are on
// displacements of the tick. What it bore when it left the end is the offset to which it is held on the way back, so that
// neither way makes a jump.
//
// A border of a region that holds the tip (borders.h) is a surface inside. Ahead of a cutting tip it adds a contact row,
// capped by f_p. A tip that rests against it, or that the base's motion takes there in this tick, has two rows of
// friction along the border with the cohesion f_c (laws.h) instead of its cutting and lateral rows: it slides, and cuts
// as it slides, once the force along the border is more than f_c + mu times the contact force. Kept to its cutting
// direction, a tip that grazes the border would be wedged in. At f_p the border gives way.
//
// With tissue.local_compliance beyond `lateral` springs stand in series with more of the laws (rows.h, local_compliance.h):
//
// `shaft`: c = k/l in the friction row of a vertex that owns the length l. The row's delta is the slip,
//
//   delta = W lambda + delta_free + c (lambda - lambda_n),       lambda_n = l t_n,
//
// t_n the friction per length that the vertex bore at the end of the last tick. It is this, and so the strain of the
// tissue beside it, that stays when l changes; a vertex that comes alongside takes over that of the one before it. So
// force is continuous as vertices come and go. Within the threshold the spring gives back all that it took; what a
// shaft that slips enters with comes along with its share of energy, k t²/2 per metre.
//
// `all`: s in the contact row (surface_compliance()) and the cutting row (tip_compliance()). The tip stands s lambda
// beyond the mesh's surface, or beyond the path's end: tissue which is really at the tip stands behind it in the mesh.
// A tip that cuts leaves its path's end s f_c behind along the cutting direction, so that the force stays at f_c as the
// end moves on. At a border the spring is that of the cut, but gives no more than it gave at f_c. Across its way the tip
// at the end has the give that it has behind it, on what it bore at the start of the tick: it does not slip sideways.
//
// Torsional friction, if the needle has it, is one more row per vertex (rows.h) with the threshold of its friction row
// times the needle's share.
//
// A law that cannot bear any force has no row: friction with neither threshold nor viscosity, per vertex as its region
// has it, the cutting row where f_c is zero, contact friction without mu and cohesion.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "server/simulation/path.h"
#include "server/simulation/report.h"
#include "server/constraints/rows.h"
#include "server/scene/scene.h"
#include "server/simulation/views.h"

namespace acus {

class Insertion {
 public:
  // Borders that a tip crosses in a tick; more wait for the next.
  static constexpr int kMaxCrossings = 64;
  // A surface is looked for within this distance beyond what the tip moves in a tick.
  static constexpr double kContactMargin = 1e-3;  // m

  // A tip that touches nothing and stands deeper than this in the tissue has got there without a puncture.
  static constexpr double kUnnoticed = 1e-3;  // m

  // Path points that the shaft can hold at once.
  static int max_points(const Needle& parameters);
  static int max_rows(const Needle& parameters) {
    return (parameters.torsional_friction > 0 ? 5 : 4) * max_points(parameters) + 5;
  }
  // Material points that the rows touch at once: the shaft's, the path's end, two that the tip is held between, and one
  // of a surface.
  static int max_material_points(const Needle& parameters) { return max_points(parameters) + 4; }

  // `path_capacity`: vertices that any path can hold.
  Insertion(int needle, const Needle& parameters, int path_capacity);
  void reset();

  // Stage 4, once a tick: the contact point or the parameters of the path's points along the needle. May pick an old
  // path up again at its mouth.
  void locate(const NeedleView& needle, const TissueView& tissue, std::vector<Path>& paths);

  // Stage 5, at every iteration: rows with their gaps at the current configuration. False if some did not fit.
  bool build_rows(const NeedleView& needle, const TissueView& tissue, std::span<const Path> paths, Rows& rows);

  // After the solve: remembers forces for the next tick's start and adds them up for the report.
  void read_forces(const Rows& rows, NeedleReport& report);

  // Stage 9, at the new positions (`needle.shape` and `tissue.x`): puncture, growth of the path, exit, withdrawal.
  // Returns flags.
  std::uint32_t transitions(const NeedleView& needle, const TissueView& tissue, std::uint64_t tick,
                            std::vector<Path>& paths, std::vector<Event>& events);

  // The tetrahedron that a pushed tip gets to in `distance` (m) along its cutting direction, -1 if it lies in an old path
  // or touches nothing. At the new positions.
  int tetrahedron_ahead(const NeedleView& needle, const TissueView& tissue, std::span<const Path> paths,
                        double distance) const;

  Phase phase() const { return phase_; }
  double inserted_depth() const { return depth_; }  // m

 private:
  // What a path vertex remembers from tick to tick.
  struct Memory {
    double s = 0;                       // m, where it stands along the needle
    bool sliding = true;
    double friction = 0;                // N
    double traction = 0;                // t_n, N/m, the same per length owned
    bool turning = true;                // slips about the axis
    double torsion = 0;                 // N
    Vector3 lateral = Vector3::Zero();  // N, world
  };
  // A vertex alongside the shaft in this tick.
  struct ShaftPoint {
    int vertex;
    double s;         // m, along the needle
    double owned;     // m, length of needle that it stands for
    Vector3 tangent;  // of the path, unit, towards the end
    double softness;  // of its lateral rows
  };
  struct TipMemory {
    double contact = 0;                 // N
    double cutting = 0;                 // N
    Vector3 lateral = Vector3::Zero();  // N, contact friction or tip path
  };
  // A surface that the tip meets, or may meet in this tick.
  struct Obstacle {
    int region;              // behind the surface
    SurfacePoint at;
    MaterialPoint material;  // the same point, of the tetrahedron on the tip's side
    bool under = true;       // the tip rests against it, or will get there in this tick
  };
  // What a tick's transitions need to know.
  struct Transition {
    const NeedleView& needle;
    const TissueView& tissue;
    std::uint64_t tick;
    std::vector<Event>& events;
  };

  void locate_outside(const NeedleView& needle, const TissueView& tissue, std::vector<Path>& paths);
  struct Mouth {
    int path = -1;         // -1: none
    bool far_end = false;  // the one where the path left the tissue
  };
  Mouth find_mouth(const Vector3& place, const TissueView& tissue, std::span<const Path> paths) const;
  void locate_inside(const NeedleView& needle, const TissueView& tissue, const Path& path);
  void share_length(double end);
  void take_over_traction(int first, int last);
  Vector3 path_tangent(const TissueView& tissue, const Path& path, int vertex, const Vector3& needle_tangent) const;
  Vector3 end_tangent(const TissueView& tissue, const Path& path, const Vector3& needle_tangent) const;
  Vector3 young_direction(const Vector3& along, const Vector3& needle_tangent) const;
  void place_tip(const NeedleView& needle, const TissueView& tissue, const Path& path);
  void find_border(const NeedleView& needle, const TissueView& tissue, const Path& path);
  int holding_vertices(const Path& path) const;
  Vector3 cutting_direction(const NeedleView& needle) const;

  double surface_compliance(const TissueView& tissue) const;
  double cutting_compliance(const TissueView& tissue, const Path& path) const;
  double border_compliance(const TissueView& tissue, const Path& path) const;
  double obstacle_gap(const NeedleView& needle, const TissueView& tissue, double recovery, double compliance) const;
  double cutting_gap(const NeedleView& needle, const TissueView& tissue, const Path& path, const Vector3& n,
                     double compliance) const;
  bool add_contact(const NeedleView& needle, double puncture_force, double gap, double compliance, Rows& rows) const;
  bool add_contact_friction(const NeedleView& needle, const TissueView& tissue, double friction, double cohesion,
                            int normal_row, Rows& rows) const;
  bool add_surface(const NeedleView& needle, const TissueView& tissue, Rows& rows) const;
  bool add_border_contact(const NeedleView& needle, const TissueView& tissue, const Path& path, Rows& rows) const;
  bool add_border(const NeedleView& needle, const TissueView& tissue, const Path& path, Rows& rows) const;
  bool add_tip(const NeedleView& needle, const TissueView& tissue, const Path& path, Rows& rows) const;
  bool add_shaft(const NeedleView& needle, const TissueView& tissue, const Path& path, const ShaftPoint& point,
                 Rows& rows) const;

  bool add_support(const NeedleView& needle, double s, const TissueView& tissue, Row row, Rows& rows) const;
  bool add_friction(const NeedleView& needle, const TissueView& tissue, const ShaftPoint& point, Row& row,
                    Rows& rows) const;

  void leave_contact_or_puncture(const Transition& now, std::vector<Path>& paths);
  std::uint32_t open_where_found(const Transition& now, std::vector<Path>& paths);
  void place_mouth(const CurvePoint& tip, const TissueView& tissue, double depth);
  std::uint32_t advance_end(const Transition& now, Path& path);
  std::uint32_t meet_border(const Transition& now, Path& path);
  void leave_border(const Transition& now);
  std::uint32_t slide(const Transition& now, Path& path, const MaterialPoint& end);
  Vector3 cut_place(const Transition& now, const Path& path) const;
  std::uint32_t grow(const Transition& now, Path& path, int start, int came_from);
  std::uint32_t lay_vertices(const Transition& now, Path& path, int start, const Vector3& from, const Vector3& to);
  void report(const Transition& now, EventKind kind, int region, double force) const;
  void enter(int path, std::vector<Path>& paths);

  int needle_;
  const Needle& parameters_;
  Phase phase_ = Phase::free;
  int path_ = -1;
  double depth_ = 0;

  Vector3 cutting_direction_;      // in the tip's frame, unit
  bool reentered_ = false;         // an old path was picked up in this tick
  bool left_out_ = false;          // more vertices alongside the shaft than max_points()
  bool puncturing_ = false;        // the contact force reached f_p
  int held_ = -1;                  // the region at whose border the tip rests, inside
  bool cutting_ = false;           // the cutting force reached f_c
  std::optional<Obstacle> obstacle_;  // of this tick
  std::vector<Memory> memory_;     // per path vertex
  std::vector<ShaftPoint> shaft_;  // of this tick
  TipMemory tip_;
  bool in_tail_ = false;           // the tip is between the last vertex and the end of a path that has one
  bool at_end_ = false;            // the tip is at the end of its path, not back inside it
  double end_s_ = 0;               // m, where the path's end stands along the needle, or ahead of it
  TissuePoint tip_point_;          // the point of the path that the tip is held to
  double tip_softness_ = 0;        // -, of its lateral rows
  double tip_offset_ = 0;          // -, share of the end's offset that the point has
  Vector3 end_force_ = Vector3::Zero();  // N, across the path on the tip when it last was at the end
  Vector3 tip_tangent_ = Vector3::Zero();  // of the path there, unit
};

}  // namespace acus
