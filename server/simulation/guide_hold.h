// SPDX-License-Identifier: GPL-3.0-or-later
// A guide and the needle in it: a hole with the axis a through the point G, both prescribed by commands. The needle's
// curve passes through the plane at G across a at the point Q; there it has
//
//   without play   two bilateral rows across a,      n · (Q - G) = 0
//   with play c    one unilateral row towards G,     c - |Q - G| >= 0, pushing inwards without limit
//   with friction  one friction row along a, stick-slip at mu N, N the force across that the guide bore in the last tick
//
// The guide holds the needle from outside: no row of it acts on the tissue. It bears no moment, and a needle that has
// not reached it, or has left it, is free; one that comes to it beside its axis is taken onto it within a tick. With play
// the one row pushes against where the needle is at the start of the tick.
#pragma once

#include <cstdint>

#include "server/simulation/base_motion.h"
#include "server/simulation/report.h"
#include "server/constraints/rows.h"
#include "server/simulation/views.h"

namespace acus {

class GuideHold {
 public:
  static constexpr int kMaxRows = 3;

  // `index` of the guide and of its needle in the scene; h (s).
  GuideHold(int index, int needle, const Guide& parameters, double h);
  void reset();

  int needle() const { return needle_; }
  BaseMotion& motion() { return motion_; }

  // Stage 1.
  void advance(std::uint64_t tick);
  // The tick is not taken over: the needle stays where it was, and so does the hole.
  void hold() { center_ = before_; }
  // Stage 4.
  void locate(const NeedleView& needle);
  // Stage 5; false if some rows did not fit.
  bool build_rows(const NeedleView& needle, Rows& rows) const;
  // After the solve; adds to the needle's guide_force.
  void read_forces(const Rows& rows, NeedleReport& report);

 private:
  int index_, needle_;
  const Guide& parameters_;
  BaseMotion motion_;
  Vector3 center_, before_;              // G in this tick and the last (m)
  Vector3 axis_;                         // a
  double s_ = 0;                         // m, of Q along the needle
  bool holds_ = false;                   // the needle passes through
  Vector3 across_ = Vector3::Zero();     // N, force of the last tick across the axis
  double along_ = 0;                     // N, friction of the last tick
};

}  // namespace acus
