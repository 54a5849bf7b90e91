// SPDX-License-Identifier: GPL-3.0-or-later
// The fields of a scene file: name, member, unit, range and meaning of each, once. Defaults stand in scene.h.
#pragma once

#include <array>

#include "server/engine/scene/scene.h"
#include "server/engine/scene/text/field.h"

namespace acus {

// The value of the field `acus_scene`, with which every scene file opens.
inline constexpr int kSceneVersion = 1;
inline constexpr const char* kVersionField = "acus_scene";

inline constexpr Range kNameLength = between(1, 100);
inline constexpr Range kPathLength = between(1, 4096);

// Ranges that several fields share. They end far beyond what needles, tissue and machines are, and near enough for the
// squares and products of their values to stay numbers.
inline constexpr Range kRate = between(1, 1e5);                  // Hz: ticks of 10 us to 1 s
inline constexpr Range kWorkspace = within(kMaxPosition);        // m
inline constexpr Range kSelection = within(1e4);                 // m, of volumes, which only select
inline constexpr Range kRadius = between(1e-6, 1e4);             // m, of volumes
inline constexpr Range kDirection = within(1e6);                 // of a vector of which only the direction counts
inline constexpr Range kForce = between(0, 1e6);                 // N
inline constexpr Range kFrictionCoefficient = between(0, 1000);  // -
inline constexpr Range kSpeed = between(1e-6, 1e6);              // m/s or rad/s
inline constexpr Range kSmoothing = between(0, 1000);            // s
inline constexpr Range kRelaxationTime = between(1e-4, 1e6);     // s

// A quaternion whose length differs from 1 by no more is taken and normalised.
inline constexpr double kUnitTolerance = 1e-3;

template <>
struct NamesOf<TissueRung> {
  static constexpr std::array names{"none", "linear", "warped", "refined", "exact"};
};

template <>
struct FieldsOf<Relaxation> {
  static constexpr const char* title = "relaxation";
  static constexpr std::tuple list{
      Field{"ratio", &Relaxation::ratio, "-", between(0, 1e3),
            "g, stiffness of the branch over young_modulus, before it relaxes"},
      Field{"time", &Relaxation::time, "s", kRelaxationTime, "tau, in which it loses all but 1/e of its stress"},
  };
};

template <>
struct FieldsOf<Material> {
  static constexpr const char* title = "material";
  static constexpr std::tuple list{
      Field{"young_modulus", &Material::young_modulus, "Pa", between(0.01, 1e13), "Young's modulus E"},
      Field{"poisson_ratio", &Material::poisson_ratio, "-", between(0, 0.499999), "Poisson's ratio nu"},
      Field{"density", &Material::density, "kg/m^3", between(1e-6, 1e6), "mass per volume"},
      Field{"rayleigh_mass", &Material::rayleigh_mass, "1/s", between(0, 1e6),
            "damping in proportion to the mass matrix"},
      Field{"rayleigh_stiffness", &Material::rayleigh_stiffness, "s", between(0, 1000),
            "damping in proportion to the stiffness matrix"},
      Field{"relaxation", &Material::relaxation, "", between(0, kMaxRelaxations),
            "Prony series of tissue, whose young_modulus is that at rest: strained at once it is 1 + the sum of all "
            "ratios times as stiff; rungs warped and refined, without a window"},
  };
};

template <>
struct FieldsOf<Interaction> {
  static constexpr const char* title = "interaction";
  static constexpr std::tuple list{
      Field{"puncture_force", &Interaction::puncture_force, "N", or_infinite(kForce),
            "f_p, force of the tip on the surface at which it enters; .inf for bone, on which it slides"},
      Field{
          "deep_indentation", &Interaction::deep_indentation, "-", between(0, 100),
          "beta, force of a tip on the surface over E D^2 where its dimple's depth D is many times its radius; 0.2 for "
          "neo-Hookean tissue, more the more it stiffens with strain"},
      Field{"cutting_force", &Interaction::cutting_force, "N", kForce, "f_c, force of the tip at which its path grows"},
      Field{"tear_strength", &Interaction::tear_strength, "N/m", or_infinite(between(1e-6, 1e9)),
            "t, force per length of path, sideways, at which the shaft tears it; .inf: never"},
      Field{"pressure", &Interaction::pressure, "Pa", between(0, 1e12),
            "p, of the tissue on the shaft; absent: estimated from the stiffness as E/(1 + nu)"},
      Field{"friction_static", &Interaction::friction_static, "-", kFrictionCoefficient,
            "mu_s, friction coefficient of a shaft that sticks; not below friction_dynamic"},
      Field{"friction_dynamic", &Interaction::friction_dynamic, "-", kFrictionCoefficient,
            "mu_d, friction coefficient of a shaft that slides"},
      Field{"friction_viscous", &Interaction::friction_viscous, "N s/m^2", between(0, 1e9),
            "b, friction per metre of shaft and m/s of slow sliding; at a speed v it is b v (1 + v/v_t)^(n - 1)"},
      Field{"friction_thinning_speed", &Interaction::friction_thinning_speed, "m/s", between(1e-9, 1e3),
            "v_t, from which viscous friction grows less than in proportion to the speed; absent: never"},
      Field{"friction_exponent", &Interaction::friction_exponent, "-", between(0, 1),
            "n, of the speed, far above friction_thinning_speed; 0: viscous friction has an end, b v_t"},
      Field{"friction_back", &Interaction::friction_back, "-", between(0.01, 100),
            "friction of a shaft that is drawn back over that of one pushed in, at the same speed"},
      Field{"foundation_stiffness", &Interaction::foundation_stiffness, "Pa", or_infinite(between(1e-6, 1e15)),
            "k, lateral force per metre of shaft and metre off its path, of the tissue beside the shaft that the mesh "
            "does not resolve; absent: estimated from material, element size and diameter; .inf: the mesh alone"},
      Field{"friction_contact", &Interaction::friction_contact, "-", kFrictionCoefficient,
            "mu, friction coefficient of the tip on the surface before puncture"},
  };
};

template <>
struct FieldsOf<Box> {
  static constexpr const char* title = "box";
  static constexpr std::tuple list{
      Field{"min", &Box::min, "m", or_infinite(kSelection), "lower corner [x, y, z] in the mesh frame"},
      Field{"max", &Box::max, "m", or_infinite(kSelection), "upper corner [x, y, z] in the mesh frame, not below min"},
  };
};

template <>
struct FieldsOf<Sphere> {
  static constexpr const char* title = "sphere";
  static constexpr std::tuple list{
      Field{"center", &Sphere::center, "m", kSelection, "[x, y, z] in the mesh frame"},
      Field{"radius", &Sphere::radius, "m", kRadius, "of the sphere"},
  };
};

template <>
struct FieldsOf<HalfSpace> {
  static constexpr const char* title = "half_space";
  static constexpr std::tuple list{
      Field{"point", &HalfSpace::point, "m", kSelection, "[x, y, z] on the plane, in the mesh frame"},
      Field{"normal", &HalfSpace::normal, "-", kDirection, "[x, y, z] out of the half-space; any length but zero"},
  };
};

template <>
struct FieldsOf<Cylinder> {
  static constexpr const char* title = "cylinder";
  static constexpr std::tuple list{
      Field{"from", &Cylinder::from, "m", kSelection, "centre [x, y, z] of one end, in the mesh frame"},
      Field{"to", &Cylinder::to, "m", kSelection, "centre [x, y, z] of the other end"},
      Field{"radius", &Cylinder::radius, "m", kRadius, "of the cylinder"},
  };
};

template <>
struct FieldsOf<Volume> {
  static constexpr const char* title = "volume";
  static constexpr std::tuple list{
      Field{"box", &Volume::box, "", any(), "what lies in a box"},
      Field{"sphere", &Volume::sphere, "", any(), "what lies in a sphere"},
      Field{"half_space", &Volume::half_space, "", any(), "what lies on one side of a plane"},
      Field{"cylinder", &Volume::cylinder, "", any(), "what lies in a round cylinder"},
  };
};

template <>
struct FieldsOf<Pose> {
  static constexpr const char* title = "pose";
  static constexpr std::tuple list{
      Field{"position", &Pose::position, "m", kWorkspace, "origin [x, y, z] in the world"},
      Field{"orientation", &Pose::orientation, "-", any(), "unit quaternion [w, x, y, z] from this frame to the world"},
  };
};

template <>
struct FieldsOf<Region> {
  static constexpr const char* title = "region";
  static constexpr std::tuple list{
      Field{"name", &Region::name, "", kNameLength, "distinct from the other regions' names"},
      Field{"physical_group", &Region::physical_group, "", kNameLength,
            "selects the tetrahedra of a group of the mesh file, by name or number"},
      Field{"box", &Region::box, "", any(), "selects the tetrahedra whose centroid lies inside"},
      Field{"sphere", &Region::sphere, "", any(), "likewise"},
      Field{"half_space", &Region::half_space, "", any(), "likewise"},
      Field{"cylinder", &Region::cylinder, "", any(), "likewise"},
      Field{"colour", &Region::colour, "", between(6, 7),
            "in pictures: red, green, blue in six hexadecimal digits, '#c08060' in quotes or c08060; without it by the "
            "name"},
      Field{"material", &Region::material, "", any(), "how it deforms"},
      Field{"interaction", &Region::interaction, "", any(), "how a needle enters it and slides in it"},
  };
};

template <>
struct FieldsOf<Interface> {
  static constexpr const char* title = "interface";
  static constexpr std::tuple list{
      Field{"between", &Interface::between, "", kNameLength, "name of one region"},
      Field{"and", &Interface::and_, "", kNameLength, "name of the other"},
      Field{"puncture_force", &Interface::puncture_force, "N", or_infinite(kForce),
            "f_p, force of the tip at which it crosses, either way; at or below cutting_force it is no obstacle"},
      Field{"friction_contact", &Interface::friction_contact, "-", kFrictionCoefficient,
            "mu, friction coefficient of the tip that slides along it"},
  };
};

template <>
struct FieldsOf<Pressure> {
  static constexpr const char* title = "pressure";
  static constexpr std::tuple list{
      Field{"pressure", &Pressure::pressure, "Pa", within(1e9),
            "on the faces of the mesh's surface, along their normals at rest; positive presses into the tissue"},
      Field{"box", &Pressure::box, "", any(), "selects the faces whose centroid lies inside"},
      Field{"sphere", &Pressure::sphere, "", any(), "likewise"},
      Field{"half_space", &Pressure::half_space, "", any(), "likewise"},
      Field{"cylinder", &Pressure::cylinder, "", any(), "likewise"},
  };
};

template <>
struct FieldsOf<BoxMesh> {
  static constexpr const char* title = "mesh.box";
  static constexpr std::tuple list{
      Field{"size", &BoxMesh::size, "m", between(1e-6, kMaxPosition),
            "edge lengths [x, y, z]; the box is centred on the mesh frame"},
      Field{"cells", &BoxMesh::cells, "-", between(1, 1000),
            "cells along each edge, one node more; six tetrahedra per cell; at most 100,000 cells in all"},
  };
};

template <>
struct FieldsOf<GmshMesh> {
  static constexpr const char* title = "mesh.gmsh";
  static constexpr std::tuple list{
      Field{"file", &GmshMesh::file, "", kPathLength, "mesh file, relative to the scene file"},
      Field{"metres_per_unit", &GmshMesh::metres_per_unit, "m", between(1e-9, 1000),
            "length of the file's unit: 0.001 for millimetres"},
  };
};

template <>
struct NamesOf<TissueElement> {
  static constexpr std::array names{"linear", "nodal_pressure"};
};

template <>
struct NamesOf<LocalCompliance> {
  static constexpr std::array names{"none", "all"};
};

template <>
struct FieldsOf<Tissue> {
  static constexpr const char* title = "tissue";
  static constexpr std::tuple list{
      Field{"rung", &Tissue::rung, "", any(),
            "how the tissue is solved: none (no tissue), linear (no rotations, fastest), warped (fixed factor, real "
            "time), "
            "refined (warped, iterated) or exact (refactorised, the reference)"},
      Field{
          "element", &Tissue::element, "", any(),
          "linear (tetrahedra that lock as poisson_ratio nears 0.5) or nodal_pressure (volume changes averaged at the "
          "nodes, which does not lock; a larger factor)"},
      Field{
          "local_compliance", &Tissue::local_compliance, "", any(),
          "which compliance of the tissue around a needle inside it, that elements larger than the needle cannot "
          "resolve, is "
          "added: all (across the shaft, see foundation_stiffness, along it and around the tip) or none (forces act on "
          "points of the mesh, and depend on it)"},
      Field{"window", &Tissue::window, "", between(0, 1000),
            "ticks k of the deferred field: the nodes that needles touch move at every tick, all others once in k "
            "ticks, for "
            "a share of the work; 0: all move at every tick; about 16 ms are good. Rung warped, element linear"},
      Field{"window_thread", &Tissue::window_thread, "", any(),
            "whether a thread of its own, on another processor, does the work of windows; forces and tissue are the "
            "same to "
            "the bit. A window of so many ticks that the thread is done in time"},
      choice("mesh", "the tetrahedra, from one of two sources",
             Field{"box", &Tissue::box, "", any(), "a box that is cut into tetrahedra"},
             Field{"gmsh", &Tissue::gmsh, "", any(), "a mesh file"}),
      Field{"pose", &Tissue::pose, "", any(), "where the mesh frame is in the world"},
      Field{"regions", &Tissue::regions, "", between(1, 1000),
            "parts with their own material; a tetrahedron belongs to the last region that selects it"},
      Field{"interfaces", &Tissue::interfaces, "", between(0, 1000),
            "where two regions meet; a pair that is not listed holds the tip with the puncture_force of the region it "
            "goes into"},
      Field{"fixed", &Tissue::fixed, "", between(0, 1000), "volumes; the nodes inside any of them do not move"},
      Field{
          "pressures", &Tissue::pressures, "", between(0, 1000),
          "what presses on parts of the surface all the time, as a probe, a plate or gas; where several select a face "
          "they add up"},
  };
};

template <>
struct NamesOf<NeedleRung> {
  static constexpr std::array names{"flexible", "rigid"};
};

template <>
struct FieldsOf<BaseHold> {
  static constexpr const char* title = "hold";
  static constexpr std::tuple list{
      Field{"stiffness", &BaseHold::stiffness, "N/m", between(1e-3, 1e9), "k, of the spring against displacement"},
      Field{"damping", &BaseHold::damping, "N s/m", between(0, 1e9), "c, of the damper beside it"},
      Field{"angular_stiffness", &BaseHold::angular_stiffness, "N m/rad", between(1e-6, 1e9),
            "k_r, of the spring against turns, spin included; the base lags by less than half a turn"},
      Field{"angular_damping", &BaseHold::angular_damping, "N m s/rad", between(0, 1e9),
            "c_r, of the damper beside it"},
  };
};

template <>
struct FieldsOf<Needle> {
  static constexpr const char* title = "needle";
  static constexpr std::tuple list{
      Field{"name", &Needle::name, "", kNameLength, "distinct from the other needles' names"},
      Field{"rung", &Needle::rung, "", any(),
            "how it is solved: flexible (beams) or rigid (follows its base as it is)"},
      Field{"length", &Needle::length, "m", between(1e-4, 10), "from base to tip"},
      Field{"beams", &Needle::beams, "-", between(1, 1000), "beam elements of equal length"},
      Field{"outer_diameter", &Needle::outer_diameter, "m", between(1e-6, 1), "d of the shaft"},
      Field{"inner_diameter", &Needle::inner_diameter, "m", between(0, 0.999),
            "of the bore, at most 0.999 outer_diameter; 0 for a solid needle"},
      Field{"curvature", &Needle::curvature, "1/m", within(1e4),
            "of the unloaded needle's end; positive bends it from +x towards +y"},
      Field{"curved_length", &Needle::curved_length, "m", between(1e-6, 10),
            "of that end, from the tip, at most length; absent: the whole needle"},
      Field{"cutting_direction", &Needle::cutting_direction, "-", kDirection,
            "[x, y, z] in the tip's frame, along which the tip cuts when it is pushed: [1, 0, 0] for a symmetric tip, "
            "[1, 0.1, 0] for a bevel that steers towards +y; any length, x > 0"},
      Field{
          "point_side", &Needle::point_side, "-", kDirection,
          "[x, y, z] in the tip's frame, of a bevel instead of cutting_direction: to which side of the axis its point "
          "lies, and so steers by its geometry, the needle's stiffness and the tissue's: [0, 1, 0]; any length"},
      Field{"point_offset", &Needle::point_offset, "-", between(0, 2),
            "how far off the axis that point lies, over the needle's radius: 1 for a plane bevel, less for a lancet "
            "point"},
      Field{"tip", &Needle::tip, "", any(),
            "blunt (slides on surfaces as friction lets it) or sharp: bevel (its face 11 degrees off the axis), pencil "
            "(15) or trocar (20), which bite where they are pushed more steeply than that"},
      Field{"tip_angle", &Needle::tip_angle, "rad", between(0.01, 1.5),
            "of a sharp tip's face, instead of its shape's"},
      Field{"hub_diameter", &Needle::hub_diameter, "m", between(0, 1),
            "of the round flat face at the base, which the skin around the needle stops; 0: the base goes in, too"},
      Field{"torsional_friction", &Needle::torsional_friction, "-", kFrictionCoefficient,
            "share of the shaft's friction that resists spin; 0 leaves it out"},
      Field{"material", &Needle::material, "", any(), "how it bends; the default is steel"},
      Field{"base", &Needle::base, "", any(), "first node at the start; the needle lies along +x of this frame"},
      Field{"constraint_spacing", &Needle::constraint_spacing, "m", between(1e-6, 10),
            "between the points that hold the shaft to its path; at least length / 500; the "
            "needles of a tissue have at most 500 such points together"},
      Field{"max_speed", &Needle::max_speed, "m/s", kSpeed, "limit of the base's speed"},
      Field{"max_angular_speed", &Needle::max_angular_speed, "rad/s", kSpeed, "limit of the base's rotation"},
      Field{"max_spin_speed", &Needle::max_spin_speed, "rad/s", kSpeed, "limit of the spin about the needle's axis"},
      Field{"smoothing", &Needle::smoothing, "s", kSmoothing,
            "time constant with which the base follows its commands, 0: at once; left out: evenly from one command to "
            "the next, in the time between two of them"},
      Field{
          "hold", &Needle::hold, "", any(),
          "spring and damper that hold the base to where it is told, as a robot's flange or a hand does; left out: the "
          "base is there"},
  };
};

template <>
struct FieldsOf<Guide> {
  static constexpr const char* title = "guide";
  static constexpr std::tuple list{
      Field{"name", &Guide::name, "", kNameLength, "distinct from the names of the other guides and the needles"},
      Field{"needle", &Guide::needle, "", kNameLength, "name of the needle that slides in it"},
      Field{"pose", &Guide::pose, "", any(), "of the hole at the start; its axis is +x of this frame"},
      Field{"play", &Guide::play, "m", between(0, 1), "between needle and hole, to each side"},
      Field{"friction", &Guide::friction, "-", kFrictionCoefficient,
            "mu, friction coefficient of the needle in the hole"},
      Field{"max_speed", &Guide::max_speed, "m/s", kSpeed, "limit of its speed"},
      Field{"max_angular_speed", &Guide::max_angular_speed, "rad/s", kSpeed, "limit of its rotation"},
      Field{"smoothing", &Guide::smoothing, "s", kSmoothing, "likewise, with which it follows its commands"},
  };
};

template <>
struct FieldsOf<NeedleContactSettings> {
  static constexpr const char* title = "needle_contact";
  static constexpr std::tuple list{
      Field{"enabled", &NeedleContactSettings::enabled, "", any(),
            "whether needles push each other aside; false: they pass through each other, as where one lies in the "
            "other"},
      Field{"friction", &NeedleContactSettings::friction, "-", kFrictionCoefficient,
            "mu, friction coefficient of a needle on another"},
  };
};

template <>
struct FieldsOf<Newton> {
  static constexpr const char* title = "newton";
  static constexpr std::tuple list{
      Field{"max_iterations", &Newton::max_iterations, "-", between(1, 1000),
            "limit per tick, rungs refined and exact"},
      Field{"tolerance", &Newton::tolerance, "m", between(1e-18, 1),
            "largest change of a node's position in the last iteration"},
  };
};

template <>
struct NamesOf<LawMethod> {
  static constexpr std::array names{"gauss_seidel", "direct"};
};

template <>
struct FieldsOf<LawSettings> {
  static constexpr const char* title = "laws";
  static constexpr std::tuple list{
      Field{"solver", &LawSettings::solver, "", any(),
            "gauss_seidel (sweeps over the laws) or direct (pieces of their graphs, solved exactly)"},
      Field{"max_steps", &LawSettings::max_steps, "-", between(1, 100000),
            "limit of the steps of a solution, whatever the solver: sweeps, choices of pieces and interior-point "
            "iterations together; one solution per tick, with refined and exact one per iteration"},
      Field{"tolerance", &LawSettings::tolerance, "N", between(1e-15, 1e6),
            "largest violation of a law, as the force that would mend it"},
  };
};

template <>
struct FieldsOf<Overrun> {
  static constexpr const char* title = "overrun";
  static constexpr std::tuple list{
      Field{"max_steps", &Overrun::max_steps, "-", between(1, 100000),
            "limit of the laws' steps, of either solver, while ticks come late, where laws.max_steps is more"},
      Field{"max_iterations", &Overrun::max_iterations, "-", between(1, 1000),
            "limit of the iterations, and of the repeats of steps that go too far, while ticks come late, where the "
            "limit is otherwise more"},
      Field{"publish_every", &Overrun::publish_every, "-", between(1, 1000),
            "one of so many needle or tissue states goes out from a tick on whose own work took longer than its period "
            "with one of them; forces go out every tick"},
      Field{"recovery", &Overrun::recovery, "s", between(1e-3, 1e6),
            "without a tick whose own work took longer than its period, after which max_steps and max_iterations no "
            "longer hold; a relapse doubles it, up to 64 times"},
  };
};

template <>
struct FieldsOf<Publishing> {
  static constexpr const char* title = "publish";
  static constexpr std::tuple list{
      Field{"needle_rate", &Publishing::needle_rate, "Hz", between(1e-3, 1e5),
            "of the topic needle, in simulation time"},
      Field{"tissue_rate", &Publishing::tissue_rate, "Hz", between(1e-3, 1e5),
            "of the topic tissue, in simulation time"},
      Field{"snapshot_every", &Publishing::snapshot_every, "s", between(1, 1e6),
            "of simulation time between two snapshots into the file of the server's --snapshot; left out: there are "
            "none"},
  };
};

template <>
struct NamesOf<TipShape> {
  static constexpr std::array names{"blunt", "bevel", "pencil", "trocar"};
};

template <>
struct NamesOf<Holding> {
  static constexpr std::array names{"one", "any"};
};

template <>
struct NamesOf<Beyond> {
  static constexpr std::array names{"clamp", "reject"};
};

template <>
struct FieldsOf<Clients> {
  static constexpr const char* title = "clients";
  static constexpr std::tuple list{
      Field{"holding", &Clients::holding, "", any(),
            "one (client at a time may hold, and so command, a needle or guide) or any (number; the last command "
            "counts)"},
      Field{"stale_after", &Clients::stale_after, "s", or_infinite(between(1e-3, 1e6)),
            "in real time a needle or guide that got no command for so long comes to rest where it is"},
      Field{"ramp", &Clients::ramp, "s", between(0, 100),
            "in which the haptic force then falls to zero, and comes back"},
      Field{"max_step", &Clients::max_step, "m", between(1e-6, 1e6),
            "how far from where the base, or guide, is a pose may be; left out: anywhere"},
      Field{"max_turn", &Clients::max_turn, "rad", between(1e-6, 10), "likewise, how far turned from it"},
      Field{"beyond", &Clients::beyond, "", any(),
            "clamp (a pose beyond max_step or max_turn to what is within) or reject (it)"},
  };
};

template <>
struct NamesOf<Start> {
  static constexpr std::array names{"undeformed", "equilibrium"};
};

template <>
struct FieldsOf<Scene> {
  static constexpr const char* title = "scene";
  static constexpr std::tuple list{
      Field{"name", &Scene::name, "", kNameLength, "what clients are told"},
      Field{"rate", &Scene::rate, "Hz", kRate, "ticks per second; the time step is h = 1/rate"},
      Field{"gravity", &Scene::gravity, "m/s^2", within(1e4), "acceleration [x, y, z] in the world"},
      Field{"start", &Scene::start, "", any(),
            "what is at tick 0: undeformed (the shapes of the scene, which gravity and pressures then deform) or "
            "equilibrium (deformed by them, relaxed and at rest)"},
      Field{"tissue", &Scene::tissue, "", any(), "mesh, place, regions and fixed nodes"},
      Field{"needles", &Scene::needles, "", between(1, kMaxNeedles), "one entry per needle"},
      Field{"guides", &Scene::guides, "", between(0, kMaxGuides),
            "one entry per guide; they take commands like needles"},
      Field{"needle_contact", &Scene::needle_contact, "", any(), "of needles with each other"},
      Field{"newton", &Scene::newton, "", any(), "iterations of the tissue"},
      Field{"laws", &Scene::laws, "", any(), "solver of contact, cutting and friction"},
      Field{"overrun", &Scene::overrun, "", any(), "what is reduced when ticks come late"},
      Field{"publish", &Scene::publish, "", any(), "how often states go out; forces go out every tick"},
      Field{"clients", &Scene::clients, "", any(), "who may command, and what happens when a client falls silent"},
  };
};

}  // namespace acus
