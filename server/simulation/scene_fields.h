// SPDX-License-Identifier: GPL-3.0-or-later
// The fields of a scene file: name, member, unit, range and meaning of each, once. Defaults stand in scene.h.
#pragma once

#include <array>

#include "server/simulation/field.h"
#include "server/simulation/scene.h"

namespace acus {

// The value of the field `acus_scene`, with which every scene file opens.
inline constexpr int kSceneVersion = 1;
inline constexpr const char* kVersionField = "acus_scene";

inline constexpr Range kNameLength = between(1, 100);
inline constexpr Range kPathLength = between(1, 4096);

// A quaternion whose length differs from 1 by no more is taken and normalised.
inline constexpr double kUnitTolerance = 1e-3;

template <>
struct NamesOf<TissueRung> {
  static constexpr std::array names{"none", "linear", "warped", "refined", "exact"};
};

template <>
struct FieldsOf<Material> {
  static constexpr const char* title = "material";
  static constexpr std::tuple list{
      Field{"young_modulus", &Material::young_modulus, "Pa", above(0), "Young's modulus E"},
      Field{"poisson_ratio", &Material::poisson_ratio, "-", half_open(0, 0.5), "Poisson's ratio nu"},
      Field{"density", &Material::density, "kg/m^3", above(0), "mass per volume"},
      Field{"rayleigh_mass", &Material::rayleigh_mass, "1/s", at_least(0), "damping in proportion to the mass matrix"},
      Field{"rayleigh_stiffness", &Material::rayleigh_stiffness, "s", at_least(0),
            "damping in proportion to the stiffness matrix"},
  };
};

template <>
struct FieldsOf<Interaction> {
  static constexpr const char* title = "interaction";
  static constexpr std::tuple list{
      Field{"puncture_force", &Interaction::puncture_force, "N", at_least_or_infinite(0),
            "f_p, force of the tip on the surface at which it enters; .inf for bone, on which it slides"},
      Field{"cutting_force", &Interaction::cutting_force, "N", at_least(0),
            "f_c, force of the tip at which its path grows"},
      Field{"pressure", &Interaction::pressure, "Pa", at_least(0),
            "p, of the tissue on the shaft; absent: estimated from the stiffness as E/(1 + nu)"},
      Field{"friction_static", &Interaction::friction_static, "-", at_least(0),
            "mu_s, friction coefficient of a shaft that sticks; not below friction_dynamic"},
      Field{"friction_dynamic", &Interaction::friction_dynamic, "-", at_least(0),
            "mu_d, friction coefficient of a shaft that slides"},
      Field{"friction_viscous", &Interaction::friction_viscous, "N s/m^2", at_least(0),
            "b, friction per metre of shaft and m/s of sliding"},
      Field{"foundation_stiffness", &Interaction::foundation_stiffness, "Pa", above_or_infinite(0),
            "k, lateral force per metre of shaft and metre off its path, of the tissue beside the shaft that the mesh "
            "does not resolve; absent: estimated from material, element size and diameter; .inf: the mesh alone"},
      Field{"friction_contact", &Interaction::friction_contact, "-", at_least(0),
            "mu, friction coefficient of the tip on the surface before puncture"},
  };
};

template <>
struct FieldsOf<Box> {
  static constexpr const char* title = "box";
  static constexpr std::tuple list{
      Field{"min", &Box::min, "m", any_or_infinite(), "lower corner [x, y, z] in the mesh frame"},
      Field{"max", &Box::max, "m", any_or_infinite(), "upper corner [x, y, z] in the mesh frame, not below min"},
  };
};

template <>
struct FieldsOf<Sphere> {
  static constexpr const char* title = "sphere";
  static constexpr std::tuple list{
      Field{"center", &Sphere::center, "m", any(), "[x, y, z] in the mesh frame"},
      Field{"radius", &Sphere::radius, "m", above(0), "of the sphere"},
  };
};

template <>
struct FieldsOf<HalfSpace> {
  static constexpr const char* title = "half_space";
  static constexpr std::tuple list{
      Field{"point", &HalfSpace::point, "m", any(), "[x, y, z] on the plane, in the mesh frame"},
      Field{"normal", &HalfSpace::normal, "-", any(), "[x, y, z] out of the half-space; any length but zero"},
  };
};

template <>
struct FieldsOf<Cylinder> {
  static constexpr const char* title = "cylinder";
  static constexpr std::tuple list{
      Field{"from", &Cylinder::from, "m", any(), "centre [x, y, z] of one end, in the mesh frame"},
      Field{"to", &Cylinder::to, "m", any(), "centre [x, y, z] of the other end"},
      Field{"radius", &Cylinder::radius, "m", above(0), "of the cylinder"},
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
      Field{"position", &Pose::position, "m", any(), "origin [x, y, z] in the world"},
      Field{"orientation", &Pose::orientation, "-", any(), "unit quaternion [w, x, y, z] from this frame to the world"},
  };
};

template <>
struct FieldsOf<Region> {
  static constexpr const char* title = "region";
  static constexpr std::tuple list{
      Field{"name", &Region::name, "", kNameLength, "distinct from the other regions' names"},
      Field{"physical_group", &Region::physical_group, "", kNameLength,
            "selects the tetrahedra of a Gmsh physical group, by name or number"},
      Field{"box", &Region::box, "", any(), "selects the tetrahedra whose centroid lies inside"},
      Field{"sphere", &Region::sphere, "", any(), "likewise"},
      Field{"half_space", &Region::half_space, "", any(), "likewise"},
      Field{"cylinder", &Region::cylinder, "", any(), "likewise"},
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
      Field{"puncture_force", &Interface::puncture_force, "N", at_least_or_infinite(0),
            "f_p, force of the tip at which it crosses, either way; at or below cutting_force it is no obstacle"},
      Field{"friction_contact", &Interface::friction_contact, "-", at_least(0),
            "mu, friction coefficient of the tip that slides along it"},
  };
};

template <>
struct FieldsOf<BoxMesh> {
  static constexpr const char* title = "mesh.box";
  static constexpr std::tuple list{
      Field{"size", &BoxMesh::size, "m", above(0), "edge lengths [x, y, z]; the box is centred on the mesh frame"},
      Field{"cells", &BoxMesh::cells, "-", between(1, 1000),
            "cells along each edge, one node more; six tetrahedra per cell"},
  };
};

template <>
struct FieldsOf<GmshMesh> {
  static constexpr const char* title = "mesh.gmsh";
  static constexpr std::tuple list{
      Field{"file", &GmshMesh::file, "", kPathLength, "mesh file, relative to the scene file"},
      Field{"metres_per_unit", &GmshMesh::metres_per_unit, "m", above(0),
            "length of the file's unit: 0.001 for millimetres"},
  };
};

template <>
struct NamesOf<TissueElement> {
  static constexpr std::array names{"linear", "nodal_pressure"};
};

template <>
struct NamesOf<LocalCompliance> {
  static constexpr std::array names{"lateral", "shaft", "all"};
};

template <>
struct FieldsOf<Tissue> {
  static constexpr const char* title = "tissue";
  static constexpr std::tuple list{
      Field{"rung", &Tissue::rung, "", any(),
            "how the tissue is solved: none (no tissue), linear (no rotations, fastest), warped (fixed factor, real time), "
            "refined (warped, iterated) or exact (refactorised, the reference)"},
      Field{"element", &Tissue::element, "", any(),
            "linear (tetrahedra that lock as poisson_ratio nears 0.5) or nodal_pressure (volume changes averaged at the "
            "nodes, which does not lock; a larger factor)"},
      Field{"local_compliance", &Tissue::local_compliance, "", any(),
            "which give of the tissue around a needle, that elements larger than it cannot resolve, is added: lateral "
            "(across the shaft, see foundation_stiffness), shaft (also along it), all (also ahead of the tip)"},
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
  };
};

template <>
struct NamesOf<NeedleRung> {
  static constexpr std::array names{"flexible", "rigid"};
};

template <>
struct FieldsOf<Needle> {
  static constexpr const char* title = "needle";
  static constexpr std::tuple list{
      Field{"name", &Needle::name, "", kNameLength, "distinct from the other needles' names"},
      Field{"rung", &Needle::rung, "", any(),
            "how it is solved: flexible (beams) or rigid (follows its base as it is)"},
      Field{"length", &Needle::length, "m", above(0), "from base to tip"},
      Field{"beams", &Needle::beams, "-", between(1, 1000), "beam elements of equal length"},
      Field{"outer_diameter", &Needle::outer_diameter, "m", above(0), "d of the shaft"},
      Field{"inner_diameter", &Needle::inner_diameter, "m", at_least(0),
            "of the bore, below outer_diameter; 0 for a solid needle"},
      Field{"curvature", &Needle::curvature, "1/m", any(),
            "of the unloaded needle's end; positive bends it from +x towards +y"},
      Field{"curved_length", &Needle::curved_length, "m", above(0),
            "of that end, from the tip, at most length; absent: the whole needle"},
      Field{"cutting_direction", &Needle::cutting_direction, "-", any(),
            "[x, y, z] in the tip's frame, along which the tip cuts when it is pushed: [1, 0, 0] for a symmetric tip, "
            "[1, 0.1, 0] for a bevel that steers towards +y; any length, x > 0"},
      Field{"torsional_friction", &Needle::torsional_friction, "-", at_least(0),
            "share of the shaft's friction that resists spin; 0 leaves it out"},
      Field{"material", &Needle::material, "", any(), "how it bends; the default is steel"},
      Field{"base", &Needle::base, "", any(), "first node at the start; the needle lies along +x of this frame"},
      Field{"constraint_spacing", &Needle::constraint_spacing, "m", above(0),
            "between the points that hold the shaft to its path; at least length / 1000"},
      Field{"max_speed", &Needle::max_speed, "m/s", above(0), "limit of the base's speed"},
      Field{"max_angular_speed", &Needle::max_angular_speed, "rad/s", above(0), "limit of the base's rotation"},
      Field{"max_spin_speed", &Needle::max_spin_speed, "rad/s", above(0), "limit of the spin about the needle's axis"},
      Field{"smoothing", &Needle::smoothing, "s", at_least(0),
            "time constant with which the base follows its commands; 0 follows at once"},
  };
};

template <>
struct FieldsOf<Guide> {
  static constexpr const char* title = "guide";
  static constexpr std::tuple list{
      Field{"name", &Guide::name, "", kNameLength, "distinct from the names of the other guides and the needles"},
      Field{"needle", &Guide::needle, "", kNameLength, "name of the needle that slides in it"},
      Field{"pose", &Guide::pose, "", any(), "of the hole at the start; its axis is +x of this frame"},
      Field{"play", &Guide::play, "m", at_least(0), "between needle and hole, to each side"},
      Field{"friction", &Guide::friction, "-", at_least(0), "mu, friction coefficient of the needle in the hole"},
      Field{"max_speed", &Guide::max_speed, "m/s", above(0), "limit of its speed"},
      Field{"max_angular_speed", &Guide::max_angular_speed, "rad/s", above(0), "limit of its rotation"},
      Field{"smoothing", &Guide::smoothing, "s", at_least(0),
            "time constant with which it follows its commands; 0 follows at once"},
  };
};

template <>
struct FieldsOf<Newton> {
  static constexpr const char* title = "newton";
  static constexpr std::tuple list{
      Field{"max_iterations", &Newton::max_iterations, "-", between(1, 1000),
            "limit per tick, rungs refined and exact"},
      Field{"tolerance", &Newton::tolerance, "m", above(0),
            "largest change of a node's position in the last iteration"},
  };
};

template <>
struct NamesOf<LawMethod> {
  static constexpr std::array names{"gauss_seidel", "direct"};
};

template <>
struct FieldsOf<LawSolver> {
  static constexpr const char* title = "laws";
  static constexpr std::tuple list{
      Field{"solver", &LawSolver::solver, "", any(),
            "gauss_seidel (sweeps over the laws) or direct (pieces of their graphs, solved exactly)"},
      Field{"max_sweeps", &LawSolver::max_sweeps, "-", between(1, 100000),
            "limit of the steps of a solution, whatever the solver: sweeps, choices of pieces and interior-point "
            "iterations together; one solution per tick, with refined and exact one per iteration"},
      Field{"tolerance", &LawSolver::tolerance, "N", above(0),
            "largest violation of a law, as the force that would mend it"},
  };
};

template <>
struct FieldsOf<Overrun> {
  static constexpr const char* title = "overrun";
  static constexpr std::tuple list{
      Field{"max_sweeps", &Overrun::max_sweeps, "-", between(1, 100000),
            "limit of the laws' steps, of either solver, while ticks come late, where laws.max_sweeps is more"},
      Field{"max_iterations", &Overrun::max_iterations, "-", between(1, 1000),
            "limit of the iterations, and of the repeats of steps that go too far, while ticks come late, where the "
            "limit is otherwise more"},
      Field{"publish_every", &Overrun::publish_every, "-", between(1, 1000),
            "one of so many needle and tissue states goes out while ticks come late; forces go out every tick"},
      Field{"recovery", &Overrun::recovery, "s", above(0),
            "without a tick whose own work took longer than its period, after which all is as before; a relapse doubles "
            "it, up to 64 times"},
  };
};

template <>
struct FieldsOf<Publishing> {
  static constexpr const char* title = "publish";
  static constexpr std::tuple list{
      Field{"needle_rate", &Publishing::needle_rate, "Hz", above(0), "of the topic needle, in simulation time"},
      Field{"tissue_rate", &Publishing::tissue_rate, "Hz", above(0), "of the topic tissue, in simulation time"},
  };
};

template <>
struct FieldsOf<Scene> {
  static constexpr const char* title = "scene";
  static constexpr std::tuple list{
      Field{"name", &Scene::name, "", kNameLength, "what clients are told"},
      Field{"rate", &Scene::rate, "Hz", above(0), "ticks per second; the time step is h = 1/rate"},
      Field{"gravity", &Scene::gravity, "m/s^2", any(), "acceleration [x, y, z] in the world"},
      Field{"tissue", &Scene::tissue, "", any(), "mesh, place, regions and fixed nodes"},
      Field{"needles", &Scene::needles, "", between(1, 64), "one entry per needle"},
      Field{"guides", &Scene::guides, "", between(0, 64), "one entry per guide; they take commands like needles"},
      Field{"newton", &Scene::newton, "", any(), "iterations of the tissue"},
      Field{"laws", &Scene::laws, "", any(), "solver of contact, cutting and friction"},
      Field{"overrun", &Scene::overrun, "", any(), "what gives way when ticks come late"},
      Field{"publish", &Scene::publish, "", any(), "how often states go out; forces go out every tick"},
  };
};

}  // namespace acus
