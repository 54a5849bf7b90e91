// SPDX-License-Identifier: GPL-3.0-or-later
// The deferred field: a tick moves only the nodes that needles touch, the held nodes, and the whole tissue follows once
// in a window of k ticks. With h the tick, B = alpha M + beta K, c1 = 1/h² + alpha/h, c2 = 1 + beta/h, rho = beta/(beta
// + h), and everything in the rest frame of the nodes, the tick of the matrix `turned` moves the tissue by dq:
//
//   (c1 M + c2 K) dq⁺ = (c1 M + (c2 - 1) K) dq + M (dq - dq⁻)/h² + dphi⁺
//
// dphi⁺ is what the forces on it have changed by. Without M this is a scalar filter, and where forces act is all there
// is to carry on. M matters to slow motions Phi (low_modes.h) with amplitudes d = Phiᵀ M dq; faster ones are
// overdamped:
//
//   dq = (c2 K)⁻¹ p + Phi e            p⁺ = rho p + dphi⁺            e = d - theta0 Phiᵀ p
//   d⁺ = theta1 ((d - d⁻)/h² + c1 d + (c2 - 1) omega² d + Phiᵀ dphi⁺)
//   theta0 = 1/(c2 omega²),  theta1 = 1/(c1 + c2 omega²)
//
// K is the stiffness of the rest shape, or that of the equilibrium in which the tissue begins, in the frames that its
// nodes have there: of strained tissue the first may be so far off that defects grow (below). Damping is that of K,
// too. The factor is that of c2 K = L Lᵀ, with one beta, the largest. Of held nodes, Y = L⁻¹ eᵢ (corridor.h), the tick
// is exact: their compliance is G = YᵀY - Psi Psiᵀ, Psi = Phi (theta0 - theta1)^½.
//
// The window (field_state.h) begins with a picture of where everything is. Its ticks make of it, a slice each
// (field_task.h), the whole field x, the exact corotational forces f(x) there, and the defect
//
//   eta = Rᵀ(w - f(x)) + phi - rho p - M Phi ((beta/h) omega² e + (d - d⁻)/h² + (alpha/h) d) - what is under way,
//
// which the next window feeds in as dphi, eta/k a tick, increased by what it has changed by since the window before. So
// a tissue at rest is at rest under its own corotational forces, whatever is lumped here; what k sets is how much later
// turning, stretching and differences of beta are felt.
//
// Defects grow where the tissue resists a motion with (1 + r) K and r is large. With beta 10 ms at 1 kHz a motion of
// any frequency decays up to r = 0.9, 0.45, 0.23 with windows of 8, 16, 32 ticks, and down to r = -0.58 with 32;
// without the increase, at any softness. Defects are therefore not increased where tissue begins in an equilibrium that
// is too soft to be K.
//
// Growing defects as large as all forces on the tissue stop the field: it begins anew from where it is, and a share of
// each defect is fed in, half as much each time. The share rises again slowly.
//
// [after "deferred correction", Stetter 1978; condensed modes, Craig and Bampton 1968]
#pragma once

#include "server/engine/models/field/low_modes.h"

namespace acus {

// Constant after load.
struct DeferredField {
  static constexpr int kModes = 24;
  static constexpr double kAhead = 1.5;  // windows, by which nodes that are not held are shown ahead of the field

  int window;               // k, ticks
  bool threaded;            // the work of windows has a thread of its own
  bool about_equilibrium = false;  // K is that of the equilibrium
  double increase = 1;             // times its last change, by which a defect is increased
  double h;                 // s
  double beta, alpha;       // s, 1/s
  double c1, c2, rho;
  LowModes modes;           // Phi, omega²
  VectorX theta0, theta1;   // s²
  ModeShapes stiffening;    // Psi

  // Phi a of the node at a position, and a += Phiᵀ f for a force on it. (Loops, for Eigen would ask for memory.)
  Vector3 motion(int position, const VectorX& a) const {
    const Eigen::Index count = a.size();
    const float* row = modes.shapes.row(position).data();
    double s0 = 0, s1 = 0, s2 = 0;
#pragma omp simd reduction(+ : s0, s1, s2)
    for (Eigen::Index k = 0; k < count; ++k) {
      s0 += static_cast<double>(row[k]) * a[k];
      s1 += static_cast<double>(row[k + count]) * a[k];
      s2 += static_cast<double>(row[k + 2 * count]) * a[k];
    }
    return {s0, s1, s2};
  }
  void project(int position, const Vector3& f, VectorX& a) const {
    for (int i = 0; i < 3; ++i) {
      const float* row = modes.shapes.row(position + i).data();
      for (Eigen::Index k = 0; k < a.size(); ++k) a[k] += static_cast<double>(row[k]) * f[i];
    }
  }
};

}  // namespace acus
