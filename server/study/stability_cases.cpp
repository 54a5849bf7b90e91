// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/study/stability_cases.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus {

namespace {

constexpr double kBlock = 60e-3;  // m, edge

Material& tissue(Trial& t) { return t.scene.tissue.regions[0].material; }
Interaction& laws(Trial& t) { return t.scene.tissue.regions[0].interaction; }
Needle& needle(Trial& t) { return t.scene.needles[0]; }

void set_block(Trial& t, const Vector3& size, const std::array<int, 3>& cells) {
  t.scene.tissue.box = {size, cells};
  for (Approach& approach : t.approaches) approach.at.z() = size.z() / 2;
}

// Nodes beyond a distance below and beside the middle of the block are fixed.
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

void set_spacing(Trial& t, double spacing) { needle(t).constraint_spacing = spacing; }

// Elements of 2 mm: a block of 14 mm, and a needle that goes 8 mm deep.
void fine_mesh(Trial& t) {
  set_block(t, Vector3::Constant(14e-3), {7, 7, 7});
  hold_bottom(t);
  t.manoeuvre.depth = 8e-3;
  t.manoeuvre.speed = 0.03;
}

void coarse_mesh(Trial& t) { set_block(t, Vector3::Constant(kBlock), {3, 3, 3}); }

// A plate that a tick's motion goes through.
void thin_plate(Trial& t) {
  set_block(t, {kBlock, kBlock, 2e-3}, {5, 5, 1});
  hold_sides(t);
}

void fast(Trial& t, double speed) { t.manoeuvre.speed = speed; }

void jump(Trial& t) {
  t.manoeuvre.jumps = true;
  t.manoeuvre.depth = 95e-3;
}

void spin(Trial& t) {
  t.manoeuvre.spin_speed = 50 * 2 * std::numbers::pi;
  needle(t).cutting_direction = {1, 0.2, 0};
  needle(t).torsional_friction = 1;
}

void second_needle(Trial& t, const Vector3& at, const Vector3& along) { t.approaches.push_back({at, along}); }

void approach(Trial& t, const Vector3& at, const Vector3& along) { t.approaches[0] = {at, along}; }

// A tip that comes aslant would slide along the surface.
void approach_aslant(Trial& t, const Vector3& at, const Vector3& along) {
  approach(t, at, along);
  laws(t).friction_contact = 10;
}

void short_needle(Trial& t, double length) {
  needle(t).length = length;
  needle(t).beams = 5;
}

void gravity(Trial& t, double times) {
  t.scene.gravity = {0, 0, -9.81 * times};
  t.manoeuvre.before = 0.5;
}

void undamped_tissue(Trial& t) { tissue(t).rayleigh_mass = tissue(t).rayleigh_stiffness = 0; }
void undamped_needle(Trial& t) { needle(t).material.rayleigh_mass = needle(t).material.rayleigh_stiffness = 0; }

void bone(Trial& t) { laws(t).puncture_force = kInfinity; }

void rigid_bone(Trial& t) {
  bone(t);
  needle(t).rung = NeedleRung::rigid;
  t.manoeuvre.depth = 50e-3;
}

void set_friction(Trial& t, double mu) { laws(t).friction_static = laws(t).friction_dynamic = mu; }

constexpr double degrees(double angle) { return angle * std::numbers::pi / 180; }

std::vector<StabilityCase> make_cases() {
  constexpr bool kNasty = true, kRefuse = true;
  const std::string kTissueE = "tissue E", kNeedleE = "needle E";
  return {
      {"base", {}, false, [](Trial&) {}},
      {"tissue E 100 Pa", {kTissueE}, kNasty, [](Trial& t) { tissue(t).young_modulus = 100; }},
      {"tissue E 1 kPa", {kTissueE}, false, [](Trial& t) { tissue(t).young_modulus = 1e3; }},
      {"tissue E 100 kPa", {kTissueE}, false, [](Trial& t) { tissue(t).young_modulus = 1e5; }},
      {"tissue E 10 MPa", {kTissueE}, false, [](Trial& t) { tissue(t).young_modulus = 1e7; }},
      {"tissue E 1 GPa", {kTissueE}, kNasty, [](Trial& t) { tissue(t).young_modulus = 1e9; }},
      {"nu 0", {"nu"}, false, [](Trial& t) { tissue(t).poisson_ratio = 0; }},
      {"nu 0.49", {"nu"}, false, [](Trial& t) { tissue(t).poisson_ratio = 0.49; }},
      {"nu 0.499", {"nu"}, false, [](Trial& t) { tissue(t).poisson_ratio = 0.499; }},
      {"nu 0.4999", {"nu"}, kNasty, [](Trial& t) { tissue(t).poisson_ratio = 0.4999; }},
      {"density 1", {"density"}, kNasty, [](Trial& t) { tissue(t).density = 1; }},
      {"density 100", {"density"}, false, [](Trial& t) { tissue(t).density = 100; }},
      {"density 20,000", {"density"}, kNasty, [](Trial& t) { tissue(t).density = 20e3; }},
      {"needle E 1 MPa", {kNeedleE}, kNasty, [](Trial& t) { needle(t).material.young_modulus = 1e6; }},
      {"needle E 100 MPa", {kNeedleE}, false, [](Trial& t) { needle(t).material.young_modulus = 1e8; }},
      {"needle E 10 GPa", {kNeedleE}, false, [](Trial& t) { needle(t).material.young_modulus = 1e10; }},
      {"needle E 1 TPa", {kNeedleE}, false, [](Trial& t) { needle(t).material.young_modulus = 1e12; }},
      {"diameter 0.1 mm", {"diameter"}, kNasty, [](Trial& t) { needle(t).outer_diameter = 0.1e-3; }},
      {"diameter 0.3 mm", {"diameter"}, false, [](Trial& t) { needle(t).outer_diameter = 0.3e-3; }},
      {"diameter 5 mm", {"diameter"}, false, [](Trial& t) { needle(t).outer_diameter = 5e-3; }},
      {"stiffness ratio 1e-6", {kTissueE, kNeedleE}, false,
       [](Trial& t) { tissue(t).young_modulus = 1e9, needle(t).material.young_modulus = 1e3; }},
      {"stiffness ratio 1e-3", {kTissueE, kNeedleE}, false,
       [](Trial& t) { tissue(t).young_modulus = 1e9, needle(t).material.young_modulus = 1e6; }},
      {"stiffness ratio 1", {kTissueE, kNeedleE}, false,
       [](Trial& t) { tissue(t).young_modulus = needle(t).material.young_modulus = 1e6; }},
      {"stiffness ratio 1e9", {kTissueE, kNeedleE}, false,
       [](Trial& t) { tissue(t).young_modulus = 1e3, needle(t).material.young_modulus = 1e12; }},
      {"rigid needle", {kNeedleE}, false, [](Trial& t) { needle(t).rung = NeedleRung::rigid; }},
      {"h 0.1 ms", {"h"}, false, [](Trial& t) { t.scene.rate = 10e3; }},
      {"h 0.3 ms", {"h"}, false, [](Trial& t) { t.scene.rate = 3e3; }},
      {"h 5 ms", {"h"}, false, [](Trial& t) { t.scene.rate = 200; }},
      {"h 20 ms", {"h"}, false, [](Trial& t) { t.scene.rate = 50; }},
      {"h 100 ms", {"h"}, kNasty, [](Trial& t) { t.scene.rate = 10; }},
      {"base at rest", {"speed"}, false, [](Trial& t) { fast(t, 0); }},
      {"base 1 mm/s", {"speed"}, false, [](Trial& t) { fast(t, 1e-3), t.manoeuvre.depth = 2e-3, t.manoeuvre.gap = 1e-4; }},
      {"base 1 m/s", {"speed"}, false, [](Trial& t) { fast(t, 1); }},
      {"base 5 m/s", {"speed"}, kNasty, [](Trial& t) { fast(t, 5); }},
      {"base jumps 100 mm", {"speed", "depth"}, kNasty, jump},
      {"base jumps 40 mm", {"speed"}, false, [](Trial& t) { t.manoeuvre.jumps = true; }},
      {"base jumps 100 mm aside", {"speed"}, false,
       [](Trial& t) { t.manoeuvre.jumps = true, t.manoeuvre.aside = {0.1, 0, 0}; }},
      {"base pulled 20 mm aside", {"aside"}, kNasty, [](Trial& t) { t.manoeuvre.aside = {0.02, 0.005, 0}; }},
      {"50 turns a second", {"spin"}, kNasty, spin},
      {"f_p 0", {"f_p"}, false, [](Trial& t) { laws(t).puncture_force = 0; }},
      {"f_p 1 N", {"f_p"}, false, [](Trial& t) { laws(t).puncture_force = 1; }},
      {"f_p 10 N", {"f_p"}, false, [](Trial& t) { laws(t).puncture_force = 10; }},
      {"f_p infinite", {"f_p"}, kNasty, bone},
      {"f_c 0", {"f_c"}, false, [](Trial& t) { laws(t).cutting_force = 0; }},
      {"f_c 5 N", {"f_c"}, kNasty, [](Trial& t) { laws(t).cutting_force = 5; }},
      {"mu 0", {"mu"}, false, [](Trial& t) { set_friction(t, 0), laws(t).friction_contact = 0; }},
      {"mu 1", {"mu"}, false, [](Trial& t) { set_friction(t, 1); }},
      {"mu 10", {"mu"}, kNasty, [](Trial& t) { set_friction(t, 10), laws(t).friction_contact = 10; }},
      {"mu static 10, dynamic 0.1", {"mu"}, false,
       [](Trial& t) { set_friction(t, 0.1), laws(t).friction_static = 10; }},
      {"viscous friction 1000 N s/m2", {"viscous"}, false, [](Trial& t) { laws(t).friction_viscous = 1000; }},
      {"spacing 0.5 mm on 2 mm", {"mesh"}, false, [](Trial& t) { fine_mesh(t), set_spacing(t, 0.5e-3); }},
      {"spacing 20 mm on 2 mm", {"mesh"}, false, [](Trial& t) { fine_mesh(t), set_spacing(t, 20e-3); }},
      {"spacing 0.5 mm on 20 mm", {"mesh"}, kNasty, [](Trial& t) { coarse_mesh(t), set_spacing(t, 0.5e-3); }},
      {"spacing 20 mm on 20 mm", {"mesh"}, false, [](Trial& t) { coarse_mesh(t), set_spacing(t, 20e-3); }},
      {"slivers 10 degrees", {"mesh"}, false, [](Trial& t) { t.smallest_dihedral = degrees(10); }},
      {"slivers 3 degrees", {"mesh"}, false, [](Trial& t) { t.smallest_dihedral = degrees(3); }},
      {"slivers 1 degree", {"mesh"}, kNasty, [](Trial& t) { t.smallest_dihedral = degrees(1); }},
      {"crushed by a rigid needle", {"f_p", kNeedleE}, false, rigid_bone},
      {"gravity times 1", {"gravity"}, false, [](Trial& t) { gravity(t, 1); }},
      {"gravity times 100", {"gravity"}, kNasty, [](Trial& t) { gravity(t, 100); }},
      {"through vertices along edges", {"place"}, kNasty, [](Trial& t) { approach(t, {6e-3, 6e-3, 30e-3}, {0, 0, -1}); }},
      {"within a face", {"place"}, false, [](Trial& t) { approach(t, {6e-3, 1e-3, 30e-3}, {0, 0, -1}); }},
      {"through the middles of edges", {"place"}, false, [](Trial& t) { approach(t, {0, 0, 30e-3}, {0, 0, -1}); }},
      {"along diagonals", {"place"}, false, [](Trial& t) { approach_aslant(t, {6e-3, 6e-3, 30e-3}, {-1, -1, -1}); }},
      {"on the surface, parallel", {"place"}, false, [](Trial& t) { approach(t, {-30e-3, 1.7e-3, 30e-3}, {1, 0, 0}); }},
      {"0.1 mm below the surface, parallel", {"place"}, kNasty,
       [](Trial& t) { approach(t, {-30e-3, 1.7e-3, 29.9e-3}, {1, 0, 0}); }},
      {"at the edge of the block, parallel", {"place"}, false,
       [](Trial& t) { approach(t, {30e-3, 1.7e-3, 30e-3}, {0, 0, -1}); }},
      {"grazing the surface", {"place"}, false, [](Trial& t) { approach(t, {-20e-3, 0, 30e-3}, {1, 0, -0.05}); }},
      {"through the block", {"depth"}, false, [](Trial& t) { t.manoeuvre.depth = 75e-3; }},
      {"entry and exit in one tick", {"mesh", "place", "speed"}, kNasty,
       [](Trial& t) { thin_plate(t), t.manoeuvre.jumps = true; }},
      {"two needles in one tetrahedron", {"needles"}, kNasty,
       [](Trial& t) { second_needle(t, {4e-3, 2.2e-3, 30e-3}, {0, 0, -1}); }},
      {"two needles on one line", {"needles"}, false,
       [](Trial& t) { second_needle(t, t.approaches[0].at, t.approaches[0].along); }},
      {"two needles that cross", {"needles"}, false,
       [](Trial& t) { second_needle(t, {-30e-3, 1.7e-3, 10e-3}, {1, 0, 0}); }},
      {"needle wholly inside", {"length"}, false, [](Trial& t) { short_needle(t, 20e-3); }},
      {"path longer than the needle", {"length", "depth"}, kNasty,
       [](Trial& t) { short_needle(t, 10e-3), t.manoeuvre.depth = 50e-3; }},
      {"starts wholly inside", {"place"}, false, [](Trial& t) { short_needle(t, 20e-3), t.manoeuvre.gap = -40e-3; }, kRefuse},
      {"no damping of the tissue", {"damping"}, kNasty, undamped_tissue},
      {"no damping of the needle", {"damping"}, false, undamped_needle},
      {"no damping", {"damping"}, false, [](Trial& t) { undamped_tissue(t), undamped_needle(t); }},
      {"no supports", {"supports"}, kNasty, [](Trial& t) { t.scene.tissue.fixed.clear(); }},
      {"rung linear", {"rung"}, false, [](Trial& t) { t.scene.tissue.rung = TissueRung::linear; }},
      {"rung refined", {"rung"}, kNasty, [](Trial& t) { t.scene.tissue.rung = TissueRung::refined; }},
      {"rung exact", {"rung"}, false, [](Trial& t) { t.scene.tissue.rung = TissueRung::exact; }},
      {"solver gauss_seidel", {"solver"}, false, [](Trial& t) { t.scene.laws.solver = LawMethod::gauss_seidel; }},
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

bool make_a_pair(const StabilityCase& a, const StabilityCase& b) {
  const auto turned = [&](const std::string& knob) {
    return std::find(b.knobs.begin(), b.knobs.end(), knob) != b.knobs.end();
  };
  return a.nasty && b.nasty && std::none_of(a.knobs.begin(), a.knobs.end(), turned);
}

}  // namespace

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
