// SPDX-License-Identifier: GPL-3.0-or-later
// What a tissue with a deferred field (deferred_field.h) keeps between ticks.
#pragma once

#include <cstdint>
#include <memory>

#include "server/engine/math/bounded.h"
#include "server/engine/math/types.h"

namespace acus {

// A node that a tick moves. Forces are in the rest frame of the node, but for `force`.
struct HeldNode {
  int free = 0;                      // its number among the free nodes
  std::uint64_t used = 0;            // tick of the field in which it was last asked for
  Vector3 x = Vector3::Zero();       // m, world
  Vector3 p = Vector3::Zero();       // N
  Vector3 sum = Vector3::Zero();     // N, of p over the window's ticks so far
  Vector3 force = Vector3::Zero();   // N, world, by the rows of the last tick

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("free", self.free);
    visit("used", self.used);
    visit("x", self.x);
    visit("p", self.p);
    visit("sum", self.sum);
    visit("force", self.force);
  }
};

// What does not change in a window: shared by all states in it. Vectors of unknowns are in the factor's order, forces in
// N; those of modes in N kg^-0.5 and m kg^0.5.
struct FieldWindow {
  std::uint64_t begun = 0;  // FieldState::ticks, when it began
  // The field when the window began, but for the motion of the window before, which is y_moved, and its modes' part.
  Matrix3X x;                         // 3 x nodes, m, world
  Matrix4X rotations;                 // of nodes, made smooth (w x y z)
  VectorX y_moved;                    // L⁻¹ of p, all of it, summed over the ticks of the window before
  VectorX modes_moved;                // e likewise
  Bounded<HeldNode> held;             // as they were
  VectorX inertia;                    // (beta/h) omega² e + (d - d⁻)/h² + (alpha/h) d

  // p of the field is, in a tick, `carried` times p and `fed` times defect (FieldShares).
  VectorX p, y, modes;                // p; L⁻¹ p; Phiᵀ p
  VectorX defect, y_defect, modes_defect;
  VectorX scheduled;                  // sum of all defects up to this one
  VectorX total;                      // what that would have been without increase
  Vector3 left = Vector3::Zero();     // N, world: sum over nodes of the defect that was found last
  double size = 0;                    // N, its root of the sum of squares
  double scale = 0;                   // N, likewise of weight and rows' forces; falls slowly
  int grown = 0;                      // windows in a row in which that has grown much
  double share = 1;                   // of defects that is fed in
  double increase = 1;                // times their last change, by which they are increased

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("begun", self.begun);
    visit("x", self.x);
    visit("rotations", self.rotations);
    visit("y_moved", self.y_moved);
    visit("modes_moved", self.modes_moved);
    visit("held", self.held);
    visit("inertia", self.inertia);
    visit("p", self.p);
    visit("y", self.y);
    visit("modes", self.modes);
    visit("defect", self.defect);
    visit("y_defect", self.y_defect);
    visit("modes_defect", self.modes_defect);
    visit("scheduled", self.scheduled);
    visit("total", self.total);
    visit("left", self.left);
    visit("size", self.size);
    visit("scale", self.scale);
    visit("grown", self.grown);
    visit("share", self.share);
    visit("increase", self.increase);
  }
};

// Of p and defect of a window, that act in a tick, and their sums over its ticks so far.
struct FieldShares {
  double carried = 0, fed = 0;
  double carried_sum = 0, fed_sum = 0;

  static FieldShares at_start() { return {.carried = 1}; }  // of a window; before the first tick of all nothing acts
  void advance(double rho, int window, bool first) {
    carried = first ? 1 : rho * carried;
    fed = rho * fed + 1.0 / window;
    carried_sum += carried;
    fed_sum += fed;
  }

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("carried", self.carried);
    visit("fed", self.fed);
    visit("carried_sum", self.carried_sum);
    visit("fed_sum", self.fed_sum);
  }
};

struct FieldState {
  std::shared_ptr<const FieldWindow> window = std::make_shared<FieldWindow>();
  int tick = 0;                       // of the window, those done
  std::uint64_t ticks = 0;            // all
  Bounded<HeldNode> held;             // in the order in which they came
  VectorX d, d_before;                // m kg^0.5, of the last tick and the one before
  VectorX modes_moved;                // e, summed over the window's ticks so far
  FieldShares shares;

  template <class Self, class Visit>
  static void fields(Self& self, Visit&& visit) {
    visit("window", self.window);
    visit("tick", self.tick);
    visit("ticks", self.ticks);
    visit("held", self.held);
    visit("d", self.d);
    visit("d_before", self.d_before);
    visit("modes_moved", self.modes_moved);
    visit("shares", self.shares);
  }
};

}  // namespace acus
