// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/engine/tick/insertion/shaft_watch.h"

#include <algorithm>
#include <cmath>

#include "server/engine/tick/insertion/transition.h"

namespace acus {

namespace {

struct Stretch {
  double from, to;  // m, along the needle
};

// What a path holds; in contact, what the give under the tip lets stand beyond the mesh's surface, however tilted.
Stretch held_stretch(const InsertionView& at, const InsertionWork& work, const Insertion& memory) {
  const double length = at.needle.model.length;
  if (memory.path >= 0) {
    const double end = memory.phase == Phase::through ? std::min(length, memory.end_s) : length;
    return {std::min(end - memory.depth, memory.vertices[0].s), end};
  }
  if (memory.phase != Phase::contact || !work.located.obstacle) return {length, length};
  const double beyond = kContactMargin + work.located.obstacle->compliance * memory.tip.contact;
  return {length - 2 * beyond, length};
}

bool is_inside(const TissueView& tissue, const Vector3& p) {
  if (!tissue.surface.near(tissue.x, p, 0)) return false;
  if (tissue.surface.closest(tissue.x, p).distance > -kUnnoticed) return false;
  return find_tetrahedron(tissue.mesh, tissue.x, p) >= 0;
}

}  // namespace

void watch_shaft(const InsertionView& at, const InsertionWork& work, const Insertion& memory, ShaftWatch& watch) {
  if (at.tissue.surface.empty()) return;
  const double length = at.needle.model.length;
  const int samples = watch_samples(length);
  const int in_tick = std::min(samples, static_cast<int>(std::ceil(samples * at.needle.h / kWatchPeriod)));
  const Stretch held = held_stretch(at, work, memory);
  const double step = length / samples;
  for (int i = 0; i < in_tick; ++i) {
    const double s = (watch.next + 0.5) * step;
    const bool is_held = held.from <= s && s <= held.to;
    if (!is_held && is_inside(at.tissue, curve_point(at.needle.model, at.needle.shape, s).position)) ++watch.found;
    if (++watch.next < samples) continue;
    watch.unheld = watch.found * step;
    watch.next = watch.found = 0;
  }
}

}  // namespace acus
