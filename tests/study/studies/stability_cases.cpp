// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/study/studies/stability_cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace acus {

namespace {

constexpr double kBlock = 60e-3;  // m, edge
constexpr bool kNasty = true, kRefuse = true, kMayMiss = true, kMayStay = true;

Material& tissue(Trial& t) { return t.scene.tissue.regions[0].material; }
Interaction& laws(Trial& t) { return t.scene.tissue.regions[0].interaction; }
Needle& needle(Trial& t) { return t.scene.needles[0]; }

void set_block(Trial& t, const Vector3& size, const std::array<int, 3>& cells) {
  t.scene.tissue.box = {size, cells};
  for (Approach& approach : t.approaches) approach.at.z() = size.z() / 2;
}

// All that lies behind a plane.
Volume half_space(const Vector3& point, const Vector3& normal) {
  Volume volume;
  volume.half_space = HalfSpace{point, normal};
  return volume;
}

void hold_bottom(Trial& t) {
  const double edge = t.scene.tissue.box.size.z() / 2 - 1e-6;
  t.scene.tissue.fixed = {half_space({0, 0, -edge}, Vector3::UnitZ())};
}

void hold_sides(Trial& t) {
  const double edge = t.scene.tissue.box.size.x() / 2 - 1e-6;
  t.scene.tissue.fixed = {half_space({edge, 0, 0}, -Vector3::UnitX()), half_space({-edge, 0, 0}, Vector3::UnitX())};
}

// Elements of 2 mm: a block of 14 mm, and a needle that goes 8 mm deep.
void fine_mesh(Trial& t) {
  set_block(t, Vector3::Constant(14e-3), {7, 7, 7});
  hold_bottom(t);
  t.manoeuvre.depth = 8e-3;
  t.manoeuvre.speed = 0.03;
}

// With forces that such elements can bear.
void fine_tissue(Trial& t) {
  fine_mesh(t);
  laws(t).puncture_force = 0.03;
  laws(t).cutting_force = 0.01;
}

void coarse_mesh(Trial& t) { set_block(t, Vector3::Constant(kBlock), {3, 3, 3}); }

// A plate that a tick's motion goes through.
void thin_plate(Trial& t) {
  set_block(t, {kBlock, kBlock, 2e-3}, {5, 5, 1});
  hold_sides(t);
  t.manoeuvre.jumps = true;
}

void spin(Trial& t) {
  t.manoeuvre.spin_speed = 50 * 2 * std::numbers::pi;
  needle(t).cutting_direction = {1, 0.2, 0};
  needle(t).torsional_friction = 1;
}

void undamped_tissue(Trial& t) { tissue(t).rayleigh_mass = tissue(t).rayleigh_stiffness = 0; }
void undamped_needle(Trial& t) { needle(t).material.rayleigh_mass = needle(t).material.rayleigh_stiffness = 0; }

void no_supports(Trial& t) { t.scene.tissue.fixed.clear(); }

void starts_inside(Trial& t) {
  needle(t).length = 20e-3;
  t.manoeuvre.gap = -40e-3;
}

void rigid_bone(Trial& t) {
  laws(t).puncture_force = kInfinity;
  needle(t).rung = NeedleRung::rigid;
  t.manoeuvre.depth = 50e-3;
}

// Changes of one number or place.
using Change = std::function<void(Trial&)>;
Change tissue_is(double Material::*field, double value) {
  return [=](Trial& t) { tissue(t).*field = value; };
}
Change needle_is(double Material::*field, double value) {
  return [=](Trial& t) { needle(t).material.*field = value; };
}
Change needle_is(double NeedleBody::*field, double value) {
  return [=](Trial& t) { needle(t).*field = value; };
}
Change law_is(double Interaction::*field, double value) {
  return [=](Trial& t) { laws(t).*field = value; };
}
Change stiffnesses(double of_tissue, double of_needle) {
  return [=](Trial& t) { tissue(t).young_modulus = of_tissue, needle(t).material.young_modulus = of_needle; };
}
Change ticks_a_second(double rate) {
  return [=](Trial& t) { t.scene.rate = rate; };
}
Change on_springs(const BaseHold& hold) {
  return [hold](Trial& t) { needle(t).hold = hold; };
}

Change speed(double metres_a_second) {
  return [=](Trial& t) { t.manoeuvre.speed = metres_a_second; };
}
Change jumps(double depth, const Vector3& aside = Vector3::Zero()) {
  return [=](Trial& t) { t.manoeuvre.jumps = true, t.manoeuvre.depth = depth, t.manoeuvre.aside = aside; };
}
Change pulled_aside(const Vector3& way) {
  return [=](Trial& t) { t.manoeuvre.aside = way; };
}
Change friction(double mu_static, double mu_dynamic, double mu_contact) {
  return [=](Trial& t) {
    laws(t).friction_static = mu_static, laws(t).friction_dynamic = mu_dynamic, laws(t).friction_contact = mu_contact;
  };
}
Change fine_mesh_with(double spacing) {
  return [=](Trial& t) { fine_tissue(t), needle(t).constraint_spacing = spacing; };
}
Change coarse_mesh_with(double spacing) {
  return [=](Trial& t) { coarse_mesh(t), needle(t).constraint_spacing = spacing; };
}
Change slivers(double angle) {
  return [=](Trial& t) { t.smallest_dihedral = angle * std::numbers::pi / 180; };
}
Change gravity(double times) {
  return [=](Trial& t) { t.scene.gravity = {0, 0, -9.81 * times}, t.manoeuvre.before = 0.5; };
}
Change from(const Vector3& at, const Vector3& along) {
  return [=](Trial& t) { t.approaches[0] = {at, along}; };
}
Change second_needle(const Vector3& at, const Vector3& along) {
  return [=](Trial& t) { t.approaches.push_back({at, along}); };
}
Change short_needle(double length, double depth) {
  return [=](Trial& t) { needle(t).length = length, needle(t).beams = 5, t.manoeuvre.depth = depth; };
}
Change rung(TissueRung rung) {
  return [=](Trial& t) { t.scene.tissue.rung = rung; };
}

// Down on the vertex nearest to the middle, along edges of the box whatever its cells are. Of a mesh with slivers the
// vertex at the surface alone stands there. Cases that change the mesh come before.
void on_vertex(Trial& t) {
  const BoxMesh& box = t.scene.tissue.box;
  const auto nearest = [&](int axis) {
    const double cell = box.size[axis] / box.cells[axis];
    return (std::floor(box.cells[axis] / 2.0) + 1) * cell - box.size[axis] / 2;
  };
  t.approaches[0].at.head<2>() << nearest(0), nearest(1);
}

// Change, but for the friction of the contact: a tip that comes aslant would slide along the surface.
Change aslant_from(const Vector3& at, const Vector3& along) {
  return [=](Trial& t) { from(at, along)(t), laws(t).friction_contact = 10; };
}

std::vector<StabilityCase> make_cases() {
  constexpr auto kE = &Material::young_modulus, kNu = &Material::poisson_ratio, kDensity = &Material::density;
  constexpr auto kDiameter = &NeedleBody::outer_diameter;
  constexpr auto kPuncture = &Interaction::puncture_force, kCutting = &Interaction::cutting_force;
  const Vector3 down = -Vector3::UnitZ(), across = Vector3::UnitX(), usual = Approach{}.at;
  const auto mm = [](double x, double y, double z) { return Vector3(1e-3 * x, 1e-3 * y, 1e-3 * z); };
  return {
      {"base", {}, [](Trial&) {}},
      {"tissue E 100 Pa", {"tissue E"}, tissue_is(kE, 100), kNasty},
      {"tissue E 1 kPa", {"tissue E"}, tissue_is(kE, 1e3)},
      {"tissue E 100 kPa", {"tissue E"}, tissue_is(kE, 1e5)},
      {"tissue E 10 MPa", {"tissue E"}, tissue_is(kE, 1e7)},
      {"tissue E 1 GPa", {"tissue E"}, tissue_is(kE, 1e9), kNasty},
      {"nu 0", {"nu"}, tissue_is(kNu, 0)},
      {"nu 0.49", {"nu"}, tissue_is(kNu, 0.49)},
      {"nu 0.499", {"nu"}, tissue_is(kNu, 0.499)},
      {"nu 0.4999", {"nu"}, tissue_is(kNu, 0.4999), kNasty},
      {"density 1", {"density"}, tissue_is(kDensity, 1), kNasty},
      {"density 100", {"density"}, tissue_is(kDensity, 100)},
      {"density 20000", {"density"}, tissue_is(kDensity, 20e3), kNasty},
      {"needle E 1 MPa", {"needle E"}, needle_is(kE, 1e6), kNasty},
      {"needle E 100 MPa", {"needle E"}, needle_is(kE, 1e8)},
      {"needle E 10 GPa", {"needle E"}, needle_is(kE, 1e10)},
      {"needle E 1 TPa", {"needle E"}, needle_is(kE, 1e12)},
      {"rigid needle", {"needle E"}, [](Trial& t) { needle(t).rung = NeedleRung::rigid; }},
      {"diameter 0.1 mm", {"diameter"}, needle_is(kDiameter, 0.1e-3), kNasty},
      {"diameter 0.3 mm", {"diameter"}, needle_is(kDiameter, 0.3e-3)},
      {"diameter 5 mm", {"diameter"}, needle_is(kDiameter, 5e-3)},
      {"stiffness ratio 1e-6", {"tissue E", "needle E"}, stiffnesses(1e9, 1e3)},
      {"stiffness ratio 1e-3", {"tissue E", "needle E"}, stiffnesses(1e9, 1e6)},
      {"stiffness ratio 1", {"tissue E", "needle E"}, stiffnesses(1e6, 1e6)},
      {"stiffness ratio 1e9", {"tissue E", "needle E"}, stiffnesses(1e3, 1e12)},
      {"h 0.1 ms", {"h"}, ticks_a_second(10e3)},
      {"h 0.3 ms", {"h"}, ticks_a_second(3e3)},
      {"h 5 ms", {"h"}, ticks_a_second(200)},
      {"h 20 ms", {"h"}, ticks_a_second(50)},
      {"h 100 ms", {"h"}, ticks_a_second(10), kNasty},
      {"base at rest", {"speed"}, speed(0), false, false, kMayMiss},
      // They may be too soft to pull a needle out.
      {"base on soft springs", {"hold"}, on_springs({30, 0.1, 0.3, 1e-3}), kNasty, false, false, kMayStay},
      {"base on stiff springs without dampers", {"hold"}, on_springs({1e6, 0, 1e4, 0})},
      {"base 10 mm/s", {"speed"}, speed(10e-3)},
      {"base 1 m/s", {"speed"}, speed(1)},
      {"base 5 m/s", {"speed"}, speed(5), kNasty},
      {"base jumps 100 mm", {"speed", "depth"}, jumps(95e-3), kNasty},
      {"base jumps 40 mm", {"speed"}, jumps(35e-3)},
      {"base jumps 100 mm aside", {"speed", "aside"}, jumps(35e-3, mm(100, 0, 0))},
      {"base pulled 20 mm aside", {"aside"}, pulled_aside(mm(20, 5, 0)), kNasty},
      {"50 turns a second", {"spin"}, spin, kNasty},
      {"f_p 0", {"f_p"}, law_is(kPuncture, 0)},
      {"f_p 1 N", {"f_p"}, law_is(kPuncture, 1)},
      {"f_p 10 N", {"f_p"}, law_is(kPuncture, 10)},
      {"f_p infinite", {"f_p"}, law_is(kPuncture, kInfinity), kNasty},
      {"f_c 0", {"f_c"}, law_is(kCutting, 0)},
      {"f_c 5 N", {"f_c"}, law_is(kCutting, 5), kNasty},
      {"mu 0", {"mu"}, friction(0, 0, 0)},
      {"mu 1", {"mu"}, friction(1, 1, 1)},
      // Holds what the base pulls by no more than its gap.
      {"mu 10", {"mu"}, friction(10, 10, 10), kNasty, false, false, kMayStay},
      {"mu static 10 and dynamic 0.1", {"mu"}, friction(10, 0.1, 1)},
      {"viscous friction 1000 N s/m2", {"viscous"}, law_is(&Interaction::friction_viscous, 1000)},
      {"spacing 0.5 mm on 2 mm", {"mesh"}, fine_mesh_with(0.5e-3)},
      {"spacing 20 mm on 2 mm", {"mesh"}, fine_mesh_with(20e-3)},
      {"f_p 0.3 N on 2 mm", {"mesh"}, fine_mesh},
      {"spacing 0.5 mm on 20 mm", {"mesh"}, coarse_mesh_with(0.5e-3), kNasty},
      {"spacing 20 mm on 20 mm", {"mesh"}, coarse_mesh_with(20e-3)},
      {"slivers 10 degrees", {"mesh"}, slivers(10)},
      {"slivers 3 degrees", {"mesh"}, slivers(3)},
      {"slivers 1 degree", {"mesh"}, slivers(1), kNasty},
      {"crushed by a rigid needle", {"f_p", "needle E"}, rigid_bone},
      {"gravity times 1", {"gravity"}, gravity(1)},
      // Without supports the tissue would be gone before the needle comes.
      {"gravity times 4", {"gravity", "supports"}, gravity(4), kNasty},
      // Crushes all tissue but the light and the stiff to a heap that the needle does not reach.
      {"gravity times 100", {"gravity", "supports"}, gravity(100), kNasty, false, kMayMiss, kMayStay},
      {"through vertices along edges", {"place"}, on_vertex, kNasty},
      {"within a face", {"place"}, from(mm(6, 1, 30), down)},
      {"through the middles of edges", {"place"}, from(mm(0, 0, 30), down)},
      {"along diagonals", {"place"}, aslant_from(mm(6, 6, 30), mm(-1, -1, -1))},
      // The tip comes over an edge at exactly the height of the face behind it, and need not meet either.
      {"on the surface, parallel", {"place"}, from(mm(-30, 1.7, 30), across), false, false, kMayMiss},
      {"0.1 mm below the surface, parallel", {"place"}, from(mm(-30, 1.7, 29.9), across), kNasty},
      {"down a side of the block", {"place"}, from(mm(30, 1.7, 30), down)},
      {"grazing the surface", {"place"}, from(mm(-20, 0, 30), mm(1, 0, -0.05))},
      {"through the block", {"depth"}, [](Trial& t) { t.manoeuvre.depth = 75e-3; }},
      {"entry and exit in one tick", {"mesh", "place", "speed"}, thin_plate, kNasty},
      {"two needles in one tetrahedron", {"needles"}, second_needle(mm(4, 2.2, 30), down), kNasty},
      {"two needles on one line", {"needles"}, second_needle(usual, down)},
      {"two needles that cross", {"needles"}, second_needle(mm(-30, 1.7, 10), across)},
      {"needle wholly inside", {"length"}, short_needle(20e-3, 35e-3)},
      {"path longer than the needle", {"length", "depth"}, short_needle(10e-3, 50e-3), kNasty},
      {"starts wholly inside", {"place"}, starts_inside, false, kRefuse},
      {"no damping of the tissue", {"damping"}, undamped_tissue, kNasty},
      {"no damping of the needle", {"damping"}, undamped_needle},
      {"no damping", {"damping"}, [](Trial& t) { undamped_tissue(t), undamped_needle(t); }},
      // The block goes along with the needle.
      {"no supports", {"supports"}, no_supports, kNasty, false, false, kMayStay},
      {"rung linear", {"rung"}, rung(TissueRung::linear)},
      {"rung refined", {"rung"}, rung(TissueRung::refined), kNasty},
      {"rung exact", {"rung"}, rung(TissueRung::exact)},
      {"element nodal_pressure", {"element"}, [](Trial& t) { t.scene.tissue.element = TissueElement::nodal_pressure; }},
      {"solver gauss_seidel", {"solver"}, [](Trial& t) { t.scene.laws.solver = LawMethod::gauss_seidel; }},
  };
}

}  // namespace

Trial base_trial() {
  Trial t;
  set_block(t, Vector3::Constant(kBlock), {5, 5, 5});
  hold_bottom(t);
  tissue(t).young_modulus = 10e3;
  laws(t).puncture_force = 0.3;
  laws(t).cutting_force = 0.1;
  needle(t).length = 0.1;
  needle(t).beams = 20;
  return t;
}

const std::vector<StabilityCase>& stability_cases() {
  static const std::vector<StabilityCase> cases = make_cases();
  return cases;
}

namespace {

// Tissue that sinks away from the needle shows no more than "gravity times 100".
bool sinks_away(const StabilityCase& a, const StabilityCase& b) {
  static constexpr const char* kSinking[] = {"tissue E 100 Pa", "density 20000", "0.1 mm below the surface, parallel"};
  const auto is_sinking = [](const StabilityCase& c) {
    return std::ranges::any_of(kSinking, [&](const char* name) { return c.name == name; });
  };
  constexpr auto kWeight = "gravity times 4";
  return (a.name == kWeight && is_sinking(b)) || (b.name == kWeight && is_sinking(a));
}

bool make_a_pair(const StabilityCase& a, const StabilityCase& b) {
  const auto turned = [&](const std::string& knob) {
    return std::find(b.knobs.begin(), b.knobs.end(), knob) != b.knobs.end();
  };
  return a.nasty && b.nasty && !sinks_away(a, b) && std::none_of(a.knobs.begin(), a.knobs.end(), turned);
}

}  // namespace

const StabilityCase& stability_case(const std::string& name) {
  for (const StabilityCase& c : stability_cases())
    if (c.name == name) return c;
  throw std::out_of_range("no case of stability is called " + name);
}

std::vector<StabilityRun> quick_stability_runs() {
  constexpr std::array<const char*, 2> kRuns[] = {
      {"base"},
      {"tissue E 1 GPa"},
      {"nu 0.4999"},
      {"stiffness ratio 1e9"},
      {"diameter 0.1 mm"},
      {"h 20 ms"},
      {"base jumps 100 mm aside"},
      {"50 turns a second"},
      {"f_p infinite"},
      {"slivers 1 degree"},
      {"crushed by a rigid needle"},
      {"through vertices along edges"},
      {"on the surface, parallel"},
      {"two needles that cross"},
      {"starts wholly inside"},
      {"no damping"},
      {"rung linear"},
      {"rung refined"},
      {"rung exact"},
      {"element nodal_pressure"},
      {"solver gauss_seidel"},
      {"density 20000", "no supports"},
      {"nu 0.4999", "h 100 ms"},
      {"50 turns a second", "entry and exit in one tick"},
      {"mu 10", "two needles in one tetrahedron"},
  };
  std::vector<StabilityRun> runs;
  for (const auto& [first, partner] : kRuns)
    runs.push_back({&stability_case(first), partner ? &stability_case(partner) : nullptr});
  return runs;
}

bool is_refused(const StabilityRun& run) { return run.first->refuse || (run.partner && run.partner->refuse); }

namespace {

// A tip that may not go in, and whose base jumps by the tissue's thickness, is through within the tick. On the way back
// the surface beneath holds it.
bool is_caught_beneath(const StabilityRun& run) {
  const auto has = [&](const char* name) {
    return run.first->name == name || (run.partner && run.partner->name == name);
  };
  return has("f_p infinite") && (has("base jumps 100 mm") || has("entry and exit in one tick"));
}

}  // namespace

Expected expected_of(const StabilityRun& run) {
  const auto any = [&](bool StabilityCase::*may) { return run.first->*may || (run.partner && run.partner->*may); };
  return {!any(&StabilityCase::may_miss), !any(&StabilityCase::may_stay) && !is_caught_beneath(run)};
}

std::vector<StabilityRun> stability_runs() {
  const std::vector<StabilityCase>& cases = stability_cases();
  std::vector<StabilityRun> runs;
  for (const StabilityCase& alone : cases) runs.push_back({&alone, nullptr});
  for (std::size_t i = 0; i < cases.size(); ++i)
    for (std::size_t k = i + 1; k < cases.size(); ++k)
      if (make_a_pair(cases[i], cases[k])) runs.push_back({&cases[i], &cases[k]});
  return runs;
}

Trial make_trial(const StabilityRun& run) {
  Trial trial = base_trial();
  run.first->change(trial);
  if (run.partner) run.partner->change(trial);
  return trial;
}

}  // namespace acus
