// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/transitions/shaft_monitor.h"

#include <algorithm>
#include <cmath>

#include "server/engine/tick/insertion/held_stretch.h"
#include "server/engine/tick/insertion/transitions/transition.h"

namespace acus {

namespace {

// Whether the surface has a contact with the shaft there, at `place` of 0 at the base and 1 at the tip.
bool touches_beside(const Insertion& state, double place) {
  const auto cell = static_cast<std::size_t>(place * static_cast<double>(state.cells.size()));
  return state.cells[std::min(cell, state.cells.size() - 1)].length > 0;
}

bool is_inside(const TissueView& tissue, const Vector3& p) {
  if (!tissue.surface.near(tissue.x, p, 0)) return false;
  if (tissue.surface.closest(tissue.x, p).distance > -kUnnoticedDepth) return false;
  return find_tetrahedron(tissue.mesh, tissue.x, p) >= 0;
}

}  // namespace

void monitor_shaft(const InsertionView& at, const InsertionScratch& scratch, const Insertion& state,
                   ShaftMonitor& monitor) {
  if (at.tissue.surface.empty()) return;
  const double length = at.needle.model.length;
  const int samples = monitor_samples(length);
  const int in_tick = std::min(samples, static_cast<int>(std::ceil(samples * at.needle.h / kMonitorPeriod)));
  const HeldStretch held = held_stretch(at, scratch.located, state);
  const double step = length / samples;
  for (int i = 0; i < in_tick; ++i) {
    const double s = (monitor.next + 0.5) * step;
    const bool is_held = held.apart(s) <= kHeldBeside / 2 || touches_beside(state, s / length);
    if (!is_held && is_inside(at.tissue, curve_point(at.needle.model, at.needle.shape, s).position)) ++monitor.found;
    if (++monitor.next < samples) continue;
    monitor.unheld = monitor.found * step;
    monitor.next = monitor.found = 0;
  }
}

}  // namespace acus
