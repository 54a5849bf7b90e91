// SPDX-License-Identifier: GPL-3.0-or-later
// The groove that the shaft of a needle presses into a surface: its depth D under the load q (N/m), beyond the mesh's.
// A mesh spreads the load over a width R, the needle over rho, half the width on which it bears,
//
//   D(q) - D_mesh = C q ln(1 + (R - a)/rho(q)),   C = 2 (1 - nu²)/(pi E),   rho = hypot(a, q/(2 E)),   R = c edge,
//
// and next to nothing where R <= a. Under a small load this is C q ln(R/a), what two line loads on a half-space differ
// by [Flamant 1892; Johnson, Contact Mechanics, 1985, sec. 2.3], a the needle's radius. Where the pressure on the
// needle's width would be above E, tissue is bent around the needle over a width on which it is E, and the difference
// is never above C 2 E (R - a), about the mesh's resolution: the spring's stiffness is positive at every load.
//
// Where fixed nodes bear it the mesh gives nothing: C q ln(10) is added, of a body ten times as wide as R beneath,
// times their share.
//
// c = 0.31, as the constants of local_compliance.h: rows of points 5 mm apart on meshes of 6.7 and 10 mm cells against
// a strip that those meshes resolve; 0.31, 0.31 and 0.32 at nu = 0.3, 0.45 and 0.49, 0.19 to 0.40 along single lines.
#pragma once

#include "server/engine/models/element/moduli.h"
#include "server/engine/models/unresolved/dent.h"
#include "server/engine/models/unresolved/relaxing_spring.h"

namespace acus {

// D - D_mesh of a length of shaft, a nonlinear spring. q is that of tissue at rest (relaxing_spring.h).
class GrooveSpring : public RelaxingSpring {
 public:
  // Under `length` (m) of a shaft of diameter d (m) on elements of the size `edge` (m); 0: the mesh has all of it.
  // `held`: the share of fixed nodes.
  GrooveSpring(const Moduli& moduli, double edge, double d, double length, double held = 0);

  // At the force f (N), 0 <= f.
  double depth(double f) const;       // m
  double compliance(double f) const;  // m/N, of small changes, >= 0
  double energy(double f) const;      // J, stored
  LoadRadii radii(double f) const { return {width(at_rest(f)), radius_ + more_}; }

 private:
  double width(double f) const;       // rho (m)
  double integral(double rho) const;  // of rho ln(1 + X/rho) over rho (m²)

  double line_;    // C (m²/N)
  double spread_;  // 2 E (N/m²)
  double radius_;  // a (m)
  double more_;    // X = R - a (m)
  double give_;    // added to the logarithm
  double length_;  // m
};

}  // namespace acus
