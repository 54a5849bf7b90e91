// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/shaft_monitor.h"

#include <algorithm>
#include <cmath>

#include "server/engine/tick/insertion/transition.h"

namespace acus {

namespace {

struct Stretch {
  double from, to;  // m, along the needle
};

// The stretch in the needle's path; in contact, the stretch that the tip's compliance lets reach behind the mesh's
// surface.
Stretch held_stretch(const InsertionView& at, const InsertionScratch& scratch, const Insertion& state) {
  const double length = at.needle.model.length;
  if (state.path >= 0) {
    const double end = state.phase == Phase::through ? std::min(length, state.end_s) : length;
    return {std::min(end - state.depth, state.vertices[0].s), end};
  }
  if (state.phase != Phase::contact || !scratch.located.obstacle) return {length, length};
  const double beyond = kContactMargin + scratch.located.obstacle->dimple.depth(state.tip.contact);
  return {length - 2 * beyond, length};
}

bool is_inside(const TissueView& tissue, const Vector3& p) {
  if (!tissue.surface.near(tissue.x, p, 0)) return false;
  if (tissue.surface.closest(tissue.x, p).distance > -kUnnoticed) return false;
  return find_tetrahedron(tissue.mesh, tissue.x, p) >= 0;
}

}  // namespace

void monitor_shaft(const InsertionView& at, const InsertionScratch& scratch, const Insertion& state,
                   ShaftMonitor& monitor) {
  if (at.tissue.surface.empty()) return;
  const double length = at.needle.model.length;
  const int samples = monitor_samples(length);
  const int in_tick = std::min(samples, static_cast<int>(std::ceil(samples * at.needle.h / kMonitorPeriod)));
  const Stretch held = held_stretch(at, scratch, state);
  const double step = length / samples;
  for (int i = 0; i < in_tick; ++i) {
    const double s = (monitor.next + 0.5) * step;
    const bool is_held = held.from <= s && s <= held.to;
    if (!is_held && is_inside(at.tissue, curve_point(at.needle.model, at.needle.shape, s).position)) ++monitor.found;
    if (++monitor.next < samples) continue;
    monitor.unheld = monitor.found * step;
    monitor.next = monitor.found = 0;
  }
}

}  // namespace acus
