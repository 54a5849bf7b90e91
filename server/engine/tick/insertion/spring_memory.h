// SPDX-License-Identifier: GPL-3.0-or-later
// Springs that the mesh does not resolve (models/unresolved/local_compliance.h, dimple.h, groove.h) in tissue that
// relaxes (models/element/relaxation.h). A spring of the compliance e at rest has the stretch
//
//   u' = (e f' + S)/G,   S = sum of g_i (1 - alpha_i) z_i,
//
// z_i (m) the stretch to which branch i has crept: contacts have the compliance e/G and S/G in their gaps. The stretch
// is the needle's distance from its path across the shaft, what friction has strained along it (vertex_contacts.h), the
// tip's lead before its path's end (tip_laws.h), and its yield along a border. Dimples and grooves are not linear: they
// remember forces (models/unresolved/relaxing_spring.h).
//
// A vertex that comes alongside takes over the memory of the one before it and of the tip. Memories keep the world's
// axes. A dimple follows a tip that slides, a groove a shaft that does; the tissue ahead of a tip that cuts is new
// (path_growth.cpp). Bone behind a border relaxes with the memory of the vertex on it.
//
// State::spring_energy is that of springs of e/G, without branches.
#pragma once

#include "server/engine/tick/insertion/insertion.h"

namespace acus {

// Stage 4, once the vertices alongside and the obstacle are known: the springs creep by what the last tick has left.
// `before`: of the last tick; `path`: the needle's, or null.
void relax_springs(const InsertionView& at, const Insertion& before, const Path* path, InsertionScratch& scratch);

// A tick of branches beside what is `now` strained, or borne.
inline void creep_to(const RelaxationStep& law, double now, Branches& crept) {
  crept += law.taken.cwiseProduct(Branches::Constant(now) - crept);
}

// At the start of a tick: a tip that has let go finds the next surface or border at rest.
void forget_dimple(Insertion& state);

// Of a spring across the shaft at a point: what it has crept (S/G, m), and what divides its compliance (G); nothing,
// and 1, where the tissue does not relax.
struct CreptAcross {
  Vector3 crept = Vector3::Zero();
  double stiffening = 1;
};
CreptAcross crept_across(const TissueView& tissue, const MaterialPoint& point, const Creep& creep);

}  // namespace acus
