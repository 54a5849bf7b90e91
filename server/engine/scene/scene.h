// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene file says, as plain data. Every field has a default and a unit; validate() checks the ranges, which
// scene_fields.h lists.
#pragma once

#include <array>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "server/engine/laws/solver/law_method.h"
#include "server/engine/math/types.h"
#include "server/engine/models/element/moduli.h"
#include "server/engine/models/element/tissue_element.h"
#include "server/engine/models/geometry/tetrahedral_mesh.h"
#include "server/engine/scene/files/scene_error.h"

namespace acus {

// Of the workspace and of a needle's spin, in scenes as in commands.
using protocol::kMaxPosition;
using protocol::kMaxSpin;

inline constexpr int kMaxNeedles = 64, kMaxGuides = 64;  // of a scene

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The laws between a needle and one region of the tissue. See laws/laws.h for their graphs.
struct Interaction {
  double puncture_force = 1.0;     // f_p (N), >= 0, .inf for bone
  double deep_indentation = 2.1;   // beta (-), >= 0: force of a deep dimple over E D², see models/unresolved/dimple.h
  double cutting_force = 0.5;      // f_c (N), >= 0
  double tear_strength = kInfinity;  // t (N/m), > 0, .inf: never: sideways force per length of path at which it tears
  std::optional<double> pressure;  // p (Pa), >= 0, of the tissue on the shaft; absent: 2 G, see shaft_pressure()
  double friction_static = 0.8;    // mu_s (-), >= friction_dynamic
  double friction_dynamic = 0.6;   // mu_d (-), >= 0
  double friction_viscous = 0;     // b (N s/m^2), >= 0: force per metre of shaft and m/s of slow sliding
  std::optional<double> friction_thinning_speed{};  // v_t (m/s), > 0: from which that grows less; absent: never
  double friction_exponent = 0;  // n (-), in [0, 1]: far above v_t it grows as v^n; 0: it has an end, b v_t
  double friction_back = 1;      // r (-), > 0: friction of a shaft drawn back over that of one pushed in
  // k (Pa), > 0, .inf allowed: lateral force per metre of shaft and metre off its path, of the tissue beside it that
  // the mesh does not resolve; absent: 1/foundation_compliance()
  std::optional<double> foundation_stiffness;
  double friction_contact = 1.0;  // mu of the tip on the surface before puncture (-), >= 0; a tip tilted from the
                                  // normal by more than atan(mu) slides and never punctures
};

// Shapes in the mesh frame. All contain their boundary, and points up to `margin` (m) outside of it.
struct Box {
  Vector3 min = Vector3::Constant(-kInfinity);  // m, may be infinite
  Vector3 max = Vector3::Constant(kInfinity);   // m, may be infinite

  bool contains(const Vector3& p, double margin = 0) const;
};

struct Sphere {
  Vector3 center = Vector3::Zero();  // m
  double radius = 0.01;              // m, > 0

  bool contains(const Vector3& p, double margin = 0) const;
};

// All points on the side of a plane away from its normal.
struct HalfSpace {
  Vector3 point = Vector3::Zero();    // m, on the plane
  Vector3 normal = Vector3::UnitZ();  // out of the half-space; any length but zero

  bool contains(const Vector3& p, double margin = 0) const;
};

// The round cylinder around the segment between the centres of its ends.
struct Cylinder {
  Vector3 from = Vector3::Zero();  // m
  Vector3 to = Vector3::UnitZ();   // m, not the same point as `from`
  double radius = 0.01;            // m, > 0

  bool contains(const Vector3& p, double margin = 0) const;
};

// A part of space: where all the shapes that are given agree.
struct Volume {
  std::optional<Box> box;
  std::optional<Sphere> sphere;
  std::optional<HalfSpace> half_space;
  std::optional<Cylinder> cylinder;

  bool contains(const Vector3& p, double margin = 0) const;
  bool unbounded() const { return !box && !sphere && !half_space && !cylinder; }  // no shape is given
};

// A part of the tissue. A tetrahedron belongs to the last region that selects it; a region with several selectors
// selects where they agree, a region without a selector is the background and takes all. The volume selects
// tetrahedra whose centroid lies inside.
struct Region : Volume {
  std::string name = "tissue";
  std::optional<std::string> physical_group;  // group of the mesh file, by name or number
  std::optional<std::string> colour;          // in pictures: six hexadecimal digits, "#" before them or not
  Material material;
  Interaction interaction;
};

// The pressure of a region's tissue on a shaft (Pa): as given, or 2 G = E/(1 + nu), which Lamé's solution for a
// cylindrical hole in an unbounded body needs to widen the hole by its own radius.
inline double shaft_pressure(const Region& region) {
  return region.interaction.pressure.value_or(2 * Moduli(region.material).shear());
}

// Where two regions meet. A pair without an entry holds the tip with the puncture force of the region it goes into.
struct Interface {
  std::string between, and_;      // names of the regions
  double puncture_force = 0;      // f_p (N), >= 0, .inf allowed, in both directions; not above f_c: no obstacle
  double friction_contact = 1.0;  // mu of the tip that slides along it (-), >= 0
};

struct BoxMesh {
  Vector3 size{0.1, 0.1, 0.1};        // m, > 0
  std::array<int, 3> cells{9, 9, 9};  // >= 1
};

struct GmshMesh {
  std::string file;            // as read_scene() leaves it, relative to the working directory; in YAML, to the scene
  double metres_per_unit = 1;  // m, > 0
};

// A load on a part of the surface, of a probe, a plate or gas, constant from the first tick on: on the faces of the
// mesh whose centroid lies inside, along their normals at rest, however they turn.
struct Pressure : Volume {
  double pressure = 0;  // Pa, into the tissue; negative: out of it
};

// How the tissue is solved; see section "rungs" of MODEL.md.
enum class TissueRung { none, linear, warped, refined, exact };

// Whether the give around a needle inside tissue that elements larger than it cannot resolve is added to its rows.
enum class LocalCompliance { none, all };

struct Tissue {
  TissueRung rung = TissueRung::warped;
  TissueElement element = TissueElement::linear;
  LocalCompliance local_compliance = LocalCompliance::all;
  int window = 0;              // ticks of the deferred field, 0: every tick moves the whole tissue
  bool window_thread = false;  // it is worked on by a thread of its own
  BoxMesh box;
  std::optional<GmshMesh> gmsh;  // instead of the box
  Pose pose;                     // mesh frame in the world
  std::vector<Region> regions{Region{}};
  std::vector<Interface> interfaces;
  std::vector<Volume> fixed;  // nodes inside any of them, mesh frame, do not move
  std::vector<Pressure> pressures;

  bool left_out() const { return rung == TissueRung::none; }  // then nothing else here is used
};

// How a needle is solved.
enum class NeedleRung { flexible, rigid };

// How the tip is ground. A blunt one slides on a surface as friction lets it. A sharp one bites: pushed at more than
// the angle of its face against the surface its edge comes first, and it does not slide (tick/insertion/tip_laws.h).
enum class TipShape { blunt, bevel, pencil, trocar };

struct Needle : NeedleBody {
  std::string name = "needle";
  NeedleRung rung = NeedleRung::flexible;
  Pose base;  // first node in the world at the start; the needle lies along its +x axis
  Vector3 cutting_direction = Vector3::UnitX();  // in the tip's frame, along which a pushed tip cuts; any length, x > 0
  // Of a bevel: off the axis in the tip's frame, towards which its edge lies; it cuts as models/unresolved/bevel.h says
  std::optional<Vector3> point_side;
  double point_offset = 1;  // -, >= 0, of that edge from the axis, over the needle's radius
  TipShape tip = TipShape::blunt;
  std::optional<double> tip_angle;   // rad, in (0, pi/2), of a sharp tip's face against the axis; none: of its shape
  double hub_diameter = 0;           // m, >= 0, of the flat face at the base that a surface stops; 0: none
  double torsional_friction = 0;     // -, >= 0: share of the shaft's friction that resists spin; 0 leaves it out
  double constraint_spacing = 4e-3;  // m, > 0, between the points that hold the shaft to its path
  double max_speed = 1;              // m/s, > 0, of the base
  double max_angular_speed = 20;     // rad/s, > 0, of the base
  double max_spin_speed = 320;       // rad/s, > 0, of the spin about the needle's axis
  std::optional<double> smoothing;  // s, >= 0: time constant with which the base follows its commands; none: evenly, in
                                    // the time between two of them
  std::optional<BaseHold> hold;     // none: the base is where it is told
};

// Of a tip's face against the needle's axis (rad); none for a blunt tip. Without tip_angle: hypodermic bevels 11 +- 2
// degrees (ISO 7864:2016; short ones have 17 +- 2); pencil points, cones of about 15 degrees half angle, and trocars,
// of three faces at about 20, follow no standard.
std::optional<double> face_angle(const Needle& needle);

// A hole through which a needle slides without turning it: a template, or the collar of a robot. Takes commands by its
// name like a needle; without any it stays where it is.
struct Guide {
  std::string name = "guide";
  std::string needle = "needle";  // name of the needle in it
  Pose pose;                      // of the hole at the start; its axis is the frame's +x
  double play = 0;                // m, >= 0, between the needle and the hole, to each side
  double friction = 0;            // mu (-), >= 0
  double max_speed = 1;           // m/s, > 0
  double max_angular_speed = 20;  // rad/s, > 0
  std::optional<double> smoothing;  // s, >= 0, likewise
};

// How a world begins: as the scene describes it, which weight and pressures then deform, or deformed by them, at rest.
enum class Start { undeformed, equilibrium };

// Of needles with each other.
struct NeedleContactSettings {
  bool enabled = true;    // needles do not pass through each other
  double friction = 0.2;  // mu (-), >= 0
};

struct Newton {
  int max_iterations = 20;   // 1 to 1000, rungs `refined` and `exact`
  double tolerance = 1e-12;  // m, > 0: largest change of a node's position in the last iteration
};

struct LawSettings {
  LawMethod solver = LawMethod::direct;
  int max_steps = 1000;     // 1 to 100000
  double tolerance = 1e-6;  // N, > 0: largest violation of a law, as the force that would mend it
};

// What is reduced from a tick on whose own work took longer than its period, until none has for a while. Physics
// continues at every tick.
struct Overrun {
  int max_steps = 16;           // 1 to 100000, where laws.max_steps is more
  int max_iterations = 1;       // 1 to 1000, where the limit is otherwise more
  int publish_every = 4;        // 1 to 1000: one of so many shapes goes out, from such a tick with shapes on
  double recovery = 0.5;        // s, > 0, without such a tick, after which steps are as before; relapses double it
};

struct Publishing {
  double needle_rate = 60;  // Hz of simulation time, > 0
  double tissue_rate = 30;  // Hz of simulation time, > 0
  std::optional<double> snapshot_every;  // s of simulation time, >= 1: into --snapshot; none: never
};

// Who may hold a needle or guide, and so command it.
enum class Holding { one, any };

// What becomes of a pose that is farther from the base than clients may ask for.
enum class Beyond { clamp, reject };

// What clients may do, and what happens when one falls silent.
struct Clients {
  Holding holding = Holding::one;  // clients that may hold one needle or guide at a time
  double stale_after = 0.1;        // s, > 0, .inf allowed: without a command, in real time, after which a body that was
                                   // commanded comes to rest where it is
  double ramp = 0.05;              // s, >= 0: in which the haptic force then falls to zero, and comes back
  std::optional<double> max_step;  // m, > 0: of a pose from where the base, or guide, is; none: no limit
  std::optional<double> max_turn;  // rad, likewise
  Beyond beyond = Beyond::clamp;
};

class SceneFolders;

// The place of a field in its file, both counted from 1.
struct Place {
  int line = 0;
  int column = 0;
};

struct Scene {
  std::string name = "scene";
  std::string file;                   // where it was read from, empty if built in code
  std::string text;                   // what is there, likewise
  double rate = 1000;                 // Hz, > 0, ticks per second; the time step is h = 1/rate
  Vector3 gravity = Vector3::Zero();  // m/s^2, world
  Start start = Start::undeformed;
  Tissue tissue;
  std::vector<Needle> needles{Needle{}};  // 1 to kMaxNeedles, distinct names
  std::vector<Guide> guides;              // distinct names, none that of a needle
  NeedleContactSettings needle_contact;
  Newton newton;
  LawSettings laws;
  Overrun overrun;
  Publishing publish;
  Clients clients;
  std::map<std::string, Place> places;  // of every field that the file gives, by its path, "tissue.regions[0].box"
};

// Throws SceneError for the first value out of range or at odds with another. read_scene() calls it; scenes built in
// code need the same.
void validate(const Scene& scene);

// Reads and checks a YAML scene; throws SceneError. Nothing of the file is ignored: an unknown field is an error.
// With `allowed`, scene and mesh must lie in these folders.
Scene read_scene(const std::string& path, const SceneFolders* allowed = nullptr);

// The same from text; `name` stands for the file in messages, relative mesh files are looked up in `folder`.
Scene parse_scene(const std::string& text, const std::string& name, const std::string& folder,
                  const SceneFolders* allowed = nullptr);

// The same without a look at any file: for a scene whose mesh is at hand.
Scene parse_scene(const std::string& text, const std::string& name);

// The scene's mesh in its own frame, with topology; throws SceneError (broken file, inverted or unconnected
// tetrahedra). A scene without tissue has a mesh without nodes, which has no regions and no fixed nodes either. With
// `allowed`, a mesh file must lie in these folders.
TetrahedralMesh read_mesh(const Scene& scene, const SceneFolders* allowed = nullptr);

// The same mesh at its place in the world; throws SceneError (too many tetrahedra, nodes outside the workspace).
TetrahedralMesh placed(const Scene& scene, TetrahedralMesh mesh);

// Both.
TetrahedralMesh load_mesh(const Scene& scene);

// Per tetrahedron, the index of its region in scene.tissue.regions; throws SceneError if a tetrahedron has none, a
// region selects nothing, or the regions of an interface do not touch.
std::vector<int> assign_regions(const Scene& scene, const TetrahedralMesh& mesh);

// In how many faces of the mesh two regions meet, by their indices, the smaller first. `regions` per tetrahedron.
std::map<std::pair<int, int>, int> count_border_faces(const TetrahedralMesh& mesh, std::span<const int> regions);

// Nodal forces of tissue.pressures (3 x nodes, N, world); throws SceneError if one holds no face of the surface.
Matrix3X pressure_forces(const Scene& scene, const TetrahedralMesh& mesh);

// Per node, whether it is fixed; throws SceneError if an entry of `fixed` holds no node.
std::vector<bool> find_fixed_nodes(const Scene& scene, const TetrahedralMesh& mesh);

}  // namespace acus
