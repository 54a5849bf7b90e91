// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/spring_memory.h"

#include "server/engine/tick/insertion/tip_laws.h"

namespace acus {

namespace {

// Off a path along the unit tangent, at the start of the tick (m).
Vector3 stretch_across(const Vector3& on_needle, const Vector3& on_path, const Vector3& tangent) {
  const Vector3 apart = on_needle - on_path;
  return tangent.dot(apart) * tangent - apart;
}

void creep_across(const RelaxationStep& law, const Vector3& stretch, Creep& creep) {
  creep.across += (stretch.replicate<1, Branches::RowsAtCompileTime>() - creep.across) * law.taken.asDiagonal();
}

void relax_vertices(const InsertionView& at, const Insertion& before, const Path& path, InsertionScratch& scratch) {
  Branches along_before = Branches::Zero();
  for (ShaftPoint& point : scratch.located.shaft) {
    const MaterialPoint& material = path.vertices[point.vertex];
    const RelaxationStep& law = at.tissue.relaxation_of(material);
    Creep& creep = scratch.next.vertices[point.vertex].contact.creep;
    // As it takes over the traction of the one before it (location.cpp); across it is where the tip was.
    if (!is_alongside(before, point.vertex))
      creep = {.across = scratch.next.tip.contact.creep.across,
               .along = point.mouth ? Branches(Branches::Zero()) : along_before};
    along_before = creep.along;
    creep_across(law,
                 stretch_across(at.needle.start_position(point.s), at.tissue.start_position(material), point.tangent),
                 creep);
    const double axial = at.tissue.axial_compliance(material, at.needle.model.diameter);
    const double traction = scratch.next.vertices[point.vertex].traction;
    const auto stretch = [&] { return (axial * traction + law.given.dot(creep.along)) / law.stiffening; };
    const double before_creep = stretch();
    creep_to(law, before_creep, creep.along);
    point.crept = stretch() - before_creep;
  }
}

// Across its path, and ahead of it.
void relax_tip(const InsertionView& at, const Path& path, InsertionScratch& scratch) {
  const TipPlace& place = scratch.located.tip;
  TipState& tip = scratch.next.tip;
  if (scratch.next.border < 0) {
    const Vector3 on_path = tissue_position(at.tissue.mesh, at.tissue.x_start, place.point);
    creep_across(at.tissue.relaxation_of(place.point.a), stretch_across(at.needle.start_tip(), on_path, place.tangent),
                 tip.contact.creep);
  }
  creep_to(at.tissue.relaxation_of(path.end), cut_spring(at, path.end, tip.cut.creep, {}).lead(tip.cut.along),
           tip.cut.creep.along);
}

// Under the tip, and along a border that holds it. `dimple` is that of the last tick.
void relax_dimple(const InsertionView& at, InsertionScratch& scratch) {
  if (!scratch.located.obstacle) return;
  Obstacle& obstacle = *scratch.located.obstacle;
  ContactState& contact = scratch.next.tip.contact;
  const bool on_border = scratch.next.phase == Phase::inside;
  const RelaxationStep law = at.tissue.relaxation_of(obstacle.material, on_border ? obstacle.region : -1);
  creep_to(law, obstacle.dimple.at_rest(obstacle.bears), contact.creep.along);
  obstacle.dimple.relax(law, contact.creep.along);
  if (!on_border || scratch.next.border != obstacle.region) return;
  const auto crept = [&] { return Vector3(contact.creep.across * law.given / law.stiffening); };
  const Vector3 before = crept();
  creep_across(law, obstacle.compliance_along * contact.across + before, contact.creep);
  obstacle.crept_along = crept();
  obstacle.creeps_along = obstacle.crept_along - before;
}

}  // namespace

void forget_dimple(Insertion& state) {
  if (!touches(state) && state.border < 0) state.tip.contact.creep.along.setZero();
}

void relax_springs(const InsertionView& at, const Insertion& before, const Path* path, InsertionScratch& scratch) {
  if (path != nullptr) relax_vertices(at, before, *path, scratch);
  if (path != nullptr && scratch.next.phase == Phase::inside) {
    relax_tip(at, *path, scratch);
  } else {
    scratch.next.tip.contact.creep.across.setZero();
  }
  relax_dimple(at, scratch);
}

CreptAcross crept_across(const TissueView& tissue, const MaterialPoint& point, const Creep& creep) {
  const RelaxationStep& law = tissue.relaxation_of(point);
  return {creep.across * law.given / law.stiffening, law.stiffening};
}

}  // namespace acus
