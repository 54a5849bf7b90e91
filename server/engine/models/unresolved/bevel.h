// SPDX-License-Identifier: GPL-3.0-or-later
// How a bevel steers its needle: from its geometry, the needle's bending stiffness, and the tissue's elasticity, cutting
// force and strength.
//
// The edge of a bevel is e off the needle's axis, d/2 if its face is plane, and cuts where it goes. The tissue holds the
// shaft in the middle of the cut, like a beam on a foundation of the stiffness k per length. So behind its edge the
// needle is off the cut by e at first and comes to it over some 1/lambda, lambda = (k/4EI)^(1/4), which bends it: with
// x from the edge backwards, w the axis off the cut, away from the edge's side, the cut an arc of the curvature kappa
// towards that side,
//
//   EI w'''' + k (w - e (1 - x/l)+) = 0;   w = e,   EI (kappa - w'') = f_c e,   EI w''' = -f_c w'   at x = 0,
//
// l = d/tan(face) the length of the bevel, whose section is centred between the edge and the axis. The edge bears its
// force f_c against its motion, wherever that goes. With u = lambda l, q = f_c/(2 EI lambda²), gamma the angle at which
// the edge moves to the axis of the needle,
//
//   gamma = lambda e (1 + exp(-u) (sin u - cos u))/(u (1 + q)),
//   kappa = 2 lambda² e (exp(-u) sin(u)/u + q) - 2 lambda q gamma,
//
// about 2 e lambda² = e (k/EI)^(1/2) for a short bevel and a small f_c [Hetényi, Beams on Elastic Foundation, 1946, ch. 3].
// k is Kelvin's solution for a line load whose sign changes along the needle as it does near the tip, averaged over the
// needle's circumference,
//
//   k = 16 pi G (1 - nu)/(2 (3 - 4 nu) K0(b) + b K1(b)),   b = 2 lambda d/2.
//
// A beam held by forces along it in an unbounded body, without a foundation, has a kappa that differs by -4 to +3 %
// (tests/references/bevel_in_body.py, 14 needles). The angle of the face hardly counts, as measured [van Veen et al. 2012].
//
// Strength. Tissue beside the needle bears no more than a force t per length (tear_strength): then e = t/k where that is
// less. A needle whose edge is off by more widens its cut, and lies in it. The moment of f_c has the same e: tissue that
// bears no force sideways bears no moment.
//
// Slope. In a tick a tip cuts at a fixed angle to its axis, and its sideways rows hold its axis to the cut. Such a tip
// bends its needle by kappa = C lambda tan(angle), C = 1.07 + 2 lambda d + q: measured with 54 needles in boxes (E 5 to
// 150 kPa, nu 0.3 to 0.48, d 0.5 to 2 mm, needles of 6 to 160 GPa), which differ from it by up to 5 %. That is the angle
// of a bevel here. The needle far from its tip, and the base, feel no difference.
#pragma once

#include "server/engine/models/element/moduli.h"

namespace acus {

struct Bevel {
  double diameter;  // d (m), of the needle
  double bending;   // EI (N m²)
  double face;      // rad, of its face against the axis
  double offset;    // e (m), of its edge from the axis
};

// What a bevel cuts.
struct BevelledTissue {
  Moduli moduli;
  double cutting_force;  // f_c (N)
  double tear_strength;  // t (N/m), .inf allowed
};

struct BevelPath {
  double curvature = 0;  // kappa (1/m), >= 0, towards the side of the edge
  double slope = 0;      // tan(angle) of the cutting direction to the needle's axis, >= 0
  double thrust = 0;     // q = f_c/(k EI)^(1/2) (-)
};
// From this thrust on a needle buckles in its path, and has no arc.
inline constexpr double kBucklingThrust = 0.4;

BevelPath bevel_path(const Bevel& bevel, const BevelledTissue& tissue);

}  // namespace acus
