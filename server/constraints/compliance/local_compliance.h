// SPDX-License-Identifier: GPL-3.0-or-later
// What a mesh cannot give way around a needle of radius a. A force on points of a mesh is spread over its elements:
// the mesh answers like a needle as thick as c h, h the edge of a regular tetrahedron of the element's volume. Between
// a and c h lies a give that no element resolves; it is added to the needle's rows. With G the shear modulus, E and nu,
//
//   across the shaft (m²/N)   (3 - 4 nu)/(8 pi G (1 - nu)) ln(c h/a)          Kelvin's line load in plane strain
//   along the shaft (m²/N)    1/(2 pi G) ln(c h/a)                            a line load in antiplane shear
//   on a surface (m/N)        (1 - nu²)/(2 E) (1/b - 1/(c h))                 a flat punch on a half-space
//   ahead of the tip (m/N)    (5 - 6 nu)/(24 pi G (1 - nu)) (1/b - 1/(c h))   a rigid sphere in an unbounded body
//
// and nothing where c h is smaller than a or b. [Kelvin 1848; Boussinesq 1885; all in Johnson, Contact Mechanics, 1985,
// ch. 2 and 3, and Love, Mathematical Theory of Elasticity, 1927, ch. 8.] Give per length is shared out over the lengths
// that the vertices own, so it does not depend on their spacing.
//
// b. A needle's force on its bare radius would press linear tissue in by centimetres, far beyond any strain for which
// these lines hold. b is the radius at which the give at the force f that the row can bear is as deep as b itself,
//
//   b = max(a, sqrt(A f)),   A = (1 - nu²)/(2 E) on a surface, (5 - 6 nu)/(24 pi G (1 - nu)) ahead of the tip,
//
// whatever the mesh is. The give at f is then b (1 - b/(c h)), never deeper than c h/4. Where f is infinite there is
// none.
//
// c is measured: needles at many offsets from the nodes of boxes of Kuhn's tetrahedra (100 mm, sides fixed, 10 to 40
// cells across), displacement in the mesh against the closed form with the effect of the sides. Mean over the offsets:
//
//   nu                 0.3     0.45    0.49
//   across the shaft   0.445   0.485   0.517    same spacing or less than 1.3 h; kAcross = 1/2
//   along the shaft    0.43    0.43    0.43     kAlong
//   on a surface       0.69    0.69    0.72     kOnSurface
//   ahead of the tip   0.53    0.57    0.60     kAhead
//
// ln c of a single line differs from its mean by 0.2 (standard deviation), most where it runs along a row of nodes
// (c = 0.17 to 0.23). Vertices further apart than 1.3 h are points, not a line, for such a mesh, which then gives more
// than a line does: 10 % too much at twice that spacing.
#pragma once

#include "server/models/material.h"

namespace acus {

// What a mesh of edge length h cannot give way around a shaft of diameter d (m²/N, displacement per force per length):
// the force of the shaft is spread over elements, as if it were h thick. Kelvin's line load in plane strain gives
//
//   1/k = (3 - 4 nu)/(8 pi G (1 - nu)) ln(h/d),   zero where h <= d.
double foundation_compliance(const Material& material, double h, double d);

double axial_compliance(const Material& material, double h, double d);              // m²/N
double surface_compliance(const Material& material, double h, double d, double f);  // m/N
double tip_compliance(const Material& material, double h, double d, double f);      // m/N

}  // namespace acus
