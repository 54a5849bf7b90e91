// SPDX-License-Identifier: GPL-3.0-or-later
// The three laws of one contact with friction, solved together: the force lambda = (n, t1, t2) on the line
// delta = W lambda + delta_bar with
//
//   n:      0 <= n <= f, delta_n = 0 between, delta_n >= 0 at 0, <= 0 at f         (unilateral, capped)
//   t:      |t| <= C + mu n, delta_t = 0 inside, delta_t = -a t with a >= 0 on the rim
//
// Row by row the sweeps may never settle: a needle that bends sideways far more easily than along itself, W_tt >> W_nn,
// and that is tilted, W_nt ~ W_nn / mu, turns a change of friction into one of the normal force as large as itself. A
// needle is about a hundred times softer sideways than along itself; a little tilted, it does not settle at mu = 0.3
// already, and the tip jumps on and off the surface.
//
// With a the multiplier of the rim, (W_tt + a I) t = -delta_t - W_tn n and W_nn n + W_nt t = -delta_n are linear in
// (n, t), with a positive definite matrix for every a >= 0. a = 0 is sticking; sliding is the a at which |t| reaches
// C + mu n, a root that is found within brackets, as a = infinity, no friction at all, lies inside the cone.
#pragma once

#include "server/engine/laws/slip_law.h"
#include "server/engine/math/types.h"

namespace acus {

struct ContactLaw {
  double limit = 0;     // f (N), may be infinite
  double friction = 0;  // mu (-)
  double cohesion = 0;  // C (N)
};

// W symmetric positive definite (m/N), rows n, t1, t2; delta_bar (m). Returns lambda (N).
Vector3 contact_force(const ContactLaw& law, const Matrix3& W, const Vector3& delta_bar);

// Friction alone, by a law that does not depend on a normal force: lambda = (t1, t2) against delta = (d1, d2). Within
// an ellipse of the half axes r T and T the point sticks; on it
//
//   (d1, d2) = -g (t1/r², t2), g >= 0,      |(t1/r, t2)| = T + c |delta| (1 + |delta|/s_t)^(n - 1).
struct DiskContact {
  Eigen::Vector2d force = Eigen::Vector2d::Zero();  // lambda (N)
  Eigen::Vector2d slip = Eigen::Vector2d::Zero();   // delta (m)
  bool slips = false;                               // on the rim
};

// On the line delta = W lambda + delta_bar; W symmetric positive definite (m/N), 2 x 2, delta_bar (m). `stretch`: r
// (-), > 0. `near`: a slip (m) that may be near the answer's, where the search begins.
DiskContact disk_contact(const SlipLaw& law, const Eigen::Matrix2d& W, const Eigen::Vector2d& delta_bar,
                         double stretch = 1, const Eigen::Vector2d& near = Eigen::Vector2d::Zero());

}  // namespace acus
