// SPDX-License-Identifier: GPL-3.0-or-later
// The displacement that a mesh is too coarse to show, around one place where a needle loads the tissue. The mesh
// spreads the load over a radius R, the needle over r < R. The tissue at x, on the mesh, is really at x + u(x),
//
//   u(x) = m s(|x - c|),   s(rho) = (1/sqrt(rho² + r²) - 1/sqrt(rho² + R²)) / (1/r - 1/R),
//
// c the place on the mesh, m the displacement there: a load spread over r less the same load spread over R, each with
// the displacement of a regularised point force [de Goes, James 2017, doi 10.1145/3072959.3073595, bi-scale Kelvinlets;
// here without the part that depends on the direction]. s falls from 1 like rho⁻³, to 4 % at 2 R.
#pragma once

#include <span>

#include "server/engine/math/types.h"

namespace acus {

// The radii (m) over which a needle and a mesh spread a load.
struct LoadRadii {
  double inner = 0;  // r
  double outer = 0;  // R

  bool resolved() const { return inner >= outer; }  // by the mesh
};

struct Dent {
  Vector3 centre = Vector3::Zero();  // c (m, world)
  Vector3 move = Vector3::Zero();    // m (m, world)
  LoadRadii radii;                   // not resolved

  // s, from 0 to 1.
  double share(const Vector3& x) const;
};

// u of all of them (m) at a point of the mesh (m, world). Those further than 8 R away, which would displace it by less
// than 0.2 % of their moves, are left out.
Vector3 displacement(std::span<const Dent> dents, const Vector3& x);

// Sets the moves so that all dents together displace each centre as `wanted` (m, world) says. A move is at most twice
// as large as what is wanted: two centres at about one place cannot have two displacements.
void set_moves(std::span<const Vector3> wanted, std::span<Dent> dents);

}  // namespace acus
