// SPDX-License-Identifier: GPL-3.0-or-later
// The compliance around a needle of radius a that a mesh cannot resolve. A force on points of a mesh is spread over its
// elements: the mesh answers like a needle of radius c edge, edge that of a regular tetrahedron of the element's
// volume, whatever a is. So a mesh of 10 mm holds a thin needle two to four times too stiffly; it holds two points of
// one element at their distance almost rigidly, and a bevel needle whose path has vertices every 4 mm meets newtons of
// opposed lateral forces between the last of them. The displacement between a and c edge, which no element resolves, is
// added to the needle's rows. With G the shear modulus, E and nu,
//
//   across the shaft (m²/N)   (3 - 4 nu)/(8 pi G (1 - nu)) ln(c edge/a)          Kelvin's line load in plane strain
//   along the shaft (m²/N)    1/(2 pi G) ln(c edge/a)                            a line load in antiplane shear
//   ahead of the tip (m/N)    (5 - 6 nu)/(24 pi G (1 - nu)) (1/b - 1/(c edge))   a rigid sphere in an unbounded body
//   across the tip (m/N)      the same with b = a
//
// and nothing where c edge is smaller than a or, ahead of the tip, b. [Kelvin 1848; Love, Mathematical Theory of
// Elasticity, 1927, ch. 8.] What a surface lacks is in dimple.h. Compliance per length is shared out over the
// lengths that the vertices own, so it does not depend on their spacing.
//
// b. A needle's force on its bare radius would press linear tissue in by centimetres, far beyond any strain for which
// these lines hold. b is the radius at which the displacement at the force f that the row can bear is b itself,
//
//   b = max(a, sqrt(A f)),   A = (5 - 6 nu)/(24 pi G (1 - nu)),
//
// whatever the mesh is. The displacement at f is then b (1 - b/(c edge)), never more than c edge/4.
//
// Across the tip. The end of a needle bears what its length would, and about 1.5 diameters more: against a rigid needle
// of 1 mm, guided, 20, 40 and 70 mm deep in a block of 100 mm (E = 10 kPa, nu = 0.45), in a mesh that has it in it
// (tests/references/needle_in_block.py: 203, 384, 673 N/m), the sideways stiffness is off by -3 to +6 % with cells
// of 12.5 and 8.3 mm and vertices 1 to 8 mm apart, by +4 to +9 % with cells of 5 mm, where the needle runs along a row
// of nodes.
//
// c is measured: needles at many offsets from the nodes of boxes of Kuhn's tetrahedra (100 mm, sides fixed, 10 to 40
// cells across), displacement in the mesh against the closed form with the effect of the sides. It hardly depends on
// edge; it depends on nu because linear elements next to the needle lock. Mean over the offsets:
//
//   nu                 0.3     0.45    0.49
//   across the shaft   0.445   0.485   0.517    same spacing or less than 1.3 edge; kAcross = 1/2: ln(edge/d), d = 2 a
//   along the shaft    0.43    0.43    0.43     kAlong
//   on a surface       0.69    0.69    0.72     kOnSurface
//   ahead of the tip   0.53    0.57    0.60     kAhead
//
// ln c of a single line differs from its mean by 0.2 (standard deviation), 5 % of the whole compliance, most where it
// runs along a row of nodes (c = 0.17 to 0.23). Vertices further apart than 1.3 edge are points, not a line, for such a
// mesh, which is then more compliant than a line (c = 0.3 at 2.7 edge, 0.07 at 3.6 edge): 10 % too much at twice that
// spacing. Nothing here corrects that.
//
// Check: a converged square of 100 mm with a rigid core of 0.5 mm radius has 4 pi G u = 5.65, 4.37 and 3.83 under a
// unit line force at nu = 0.3, 0.45 and 0.49. Meshes of 20, 10, 5 and 2.5 mm cells have 0.99, 1.74, 2.52 and 3.28 at nu
// = 0.45, and all of them 4.38 to 4.40 with ln(edge/d) added.
#pragma once

#include "server/engine/models/element/moduli.h"
#include "server/engine/models/unresolved/dent.h"

namespace acus {

// c on a surface.
constexpr double kOnSurface = 0.69;

// The compliance that a mesh cannot resolve around a shaft of diameter d (m²/N, displacement per force per length), c =
// 1/2:
//
//   1/k = (3 - 4 nu)/(8 pi G (1 - nu)) ln(edge/d),   zero where edge <= d.
double foundation_compliance(const Moduli& moduli, double edge, double d);

double end_compliance(const Moduli& moduli, double edge, double d);            // m/N, across the tip
double axial_compliance(const Moduli& moduli, double edge, double d);          // m²/N
double tip_compliance(const Moduli& moduli, double edge, double d, double f);  // m/N

// Displacement (m) beyond the mesh's, along the shaft, where it goes through a surface and carries tissue along by q
// (N/m). What a load displaces reaches out as far as the load is long, L (m):
//
//   u = q/(2 pi G) ln(min(c edge, L)/a),   0 where L < a.
double surface_displacement(const Moduli& moduli, double edge, double d, double q, double L);
// The same at a mouth whose shaft ends at a tip, `length` (m) from the mesh's mouth: a mouth that is carried towards
// the tip, q > 0, leaves L = length - u of the shaft in the tissue. u < length.
double mouth_displacement(const Moduli& moduli, double edge, double d, double q, double length);

// Radii between which the mesh lacks the compliance: a and c edge along the shaft, b and c edge ahead of the tip.
LoadRadii shaft_radii(double edge, double d);
LoadRadii tip_radii(const Moduli& moduli, double edge, double d, double f);

}  // namespace acus
