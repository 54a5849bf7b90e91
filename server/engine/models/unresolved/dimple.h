// SPDX-License-Identifier: GPL-3.0-or-later
// The dimple that a tip presses into a surface, or a border inside, before it punctures it: its depth D under the force
// f. The tip acts like a flat punch whose radius r grows with the force,
//
//   D = (1 - nu²)/(2 E) f/r,   r = (r_0⁴ + r_d⁴)^(1/4),   r_0 = 0.86 a,   r_d = (1 - nu²)/2 sqrt(beta f/E),
//
// with a the needle's radius, E, nu and beta of the region (interaction.deep_indentation). A shallow dimple is a linear
// spring, f = 2 E r_0 D/(1 - nu²) [Boussinesq 1885; Johnson, Contact Mechanics, 1985, sec. 3.2]; one that is deeper
// than the needle is thick no longer depends on the needle,
//
//   f = beta E D²              [Shojaeifard, Bacca 2025, doi 10.1039/D5SM00502G; beta grows as the tissue stiffens with
//                               strain]
//
// f is smooth in D, also at 0. Neither the puncture force nor the mesh is in it.
//
// Inside, at the border between two regions, both halves bear the tip: E/(1 - nu²) and beta E are the sums of theirs.
// Of two halves of one material, each with a free surface, that is 0.99 to 1 of what a rigid disc in it bears at nu
// from 0.45 to 0.5, 32 G a (1 - nu)/(3 - 4 nu) D [Collins 1962].
//
// r_0. Blunt needles of 1 and 2 mm on a neo-Hookean body at nu = 0.45 bear 0.83 to 0.88 of what the linear punch does,
// up to 5.5 radii deep (tests/references/indentation.py): the edge is round, and tissue is drawn down beside it.
//
// beta. 0.2 is within 10 % of that body over all of this depth. The default, 2.1, is the dimple whose radius is that of
// the force spread until linear tissue yields by as much. The loading of bovine liver by a needle of 1.27 mm [Okamura
// et al. 2004] is of this form from 2 mm to the puncture 10 mm deep, with beta E = 13 to 14 kPa.
//
// The mesh's part. Elements that bear the whole strain fold, and a mesh does not resolve a tip. So the mesh is loaded
// over a disc that is kSpread times as wide as the dimple at the force f_w, of beta = 2.1 at least, and what is missing
// to D is in series,
//
//   D - D_mesh = (1 - nu²)/(2 E) f (1/r - 1/R),   R = hypot(kSpread r(f_w), 0.69 edge),
//
// where 0.69 edge is the radius that a point of a mesh answers with (local_compliance.h). With kSpread = 2 the spring's
// stiffness is positive up to f_w on any mesh: d(f/r)/df >= 1/(2 r).
//
// f_w. The disc is laid out for the puncture force f_p. One for much more than elements bear, f_e, would be wider than
// the tissue, and one for f_p = infinity would have no end. There it follows the depth s of the tip below the mesh,
//
//   f_w = min(f_p, max(f, f(D = 3 s), f_e²/f_p, f_e/20)),   f_e = 3 (2 E/(1 - nu²)) edge²,
//
// which is f_p up to f_e, about 10 E a² (runtime/scene_warnings.cpp), and does not depend on f_p above 20 f_e. A disc
// that followed f alone would swing from tick to tick: the mesh's damping answers a change of the disc with a force. s
// is 3/4 of D where the disc is that wide. The disc for f_e/20 has the radius 0.8 edge; on a narrower one the stiffness
// changes by up to 5 % with the place in an element, on this one by 1.6 %. A wider disc leaves more of D to the spring;
// D is the same.
//
// D and f are those of tissue at rest; in tissue that relaxes f is f_r (relaxing_spring.h).
#pragma once

#include "server/engine/models/element/moduli.h"
#include "server/engine/models/unresolved/dent.h"
#include "server/engine/models/unresolved/relaxing_spring.h"

namespace acus {

// What a tip presses into: tissue behind a surface, or on both sides of a border. Sums over the sides.
struct Indented {
  double stiffness = 0;  // N/m², 2 E/(1 - nu²)
  double deep = 0;       // N/m², beta E
  double folding = 0;    // N/m², with beta = 2.1 at least

  Indented(const Moduli& moduli, double deep_indentation);
  Indented& operator+=(const Indented& other);
};

// D - D_mesh, a nonlinear spring.
class DimpleSpring : public RelaxingSpring {
 public:
  DimpleSpring() = default;
  // Under a needle of diameter d (m) on elements of the size `edge` (m), with a disc for f_w (N).
  DimpleSpring(const Indented& tissue, double edge, double d, double f_w);

  // At the force f (N), 0 <= f.
  double depth(double f) const;       // m
  double compliance(double f) const;  // m/N, of small changes, >= 0
  double energy(double f) const;      // J, stored at rest
  double whole(double f) const;       // D (m), the mesh's part with it,
  double whole_compliance(double f) const;  // m/N, likewise
  LoadRadii radii(double f) const { return {radius(at_rest(f)), mesh_}; }

 private:
  double radius(double f) const;

  double punch_ = 0;                  // (1 - nu²)/(2 E), m²/N
  double slope4_ = 0;                 // (r_d/sqrt f)⁴, m⁴/N²
  double least_ = 1;                  // r_0 (m)
  double mesh_ = 1;                   // R (m)
};

// f (N) at the depth D (m).
double dimple_force(const Indented& tissue, double d, double D);
// f_w (N), of a tip that bears f (N) at the depth s (m); f_p (N), .inf allowed.
double disc_load(const Indented& tissue, double edge, double d, double f_p, double f, double s);
// Of the dimple under f (N), r/0.925 (m), at which an even load on a disc sinks by D in the mean; of beta = 2.1 at
// least. d (m).
double dimple_radius(const Indented& tissue, double d, double f);
// The disc that bears the contact in the mesh (m): kSpread times that at f_w (N).
double contact_radius(const Indented& tissue, double d, double f_w);

}  // namespace acus
